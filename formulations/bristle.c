#include "formulations/bristle.h"

#include <math.h>

form_bristle_turn form_bristle_turn_of(const contact_set *c, int g) {
  if (c->spin == NULL) {
    return (form_bristle_turn){.cosine = 1};
  }
  const double *n = c->frame + 9 * (ptrdiff_t)g;
  const double *w = c->spin + 3 * (ptrdiff_t)g;
  const double angle = c->h * (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]);
  return (form_bristle_turn){.cosine = cos(angle), .sine = sin(angle)};
}

void form_bristle_to_frame(const contact_set *c, int g, form_bristle_turn by, const double *vector,
                           double *out) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  const double x = t1[0] * vector[0] + t1[1] * vector[1] + t1[2] * vector[2];
  const double y = t2[0] * vector[0] + t2[1] * vector[1] + t2[2] * vector[2];
  const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  const double now = sqrt(x * x + y * y);
  const double scale = (now > 0) ? length / now : 0;
  out[0] = scale * (by.cosine * x - by.sine * y);
  out[1] = scale * (by.sine * x + by.cosine * y);
}

void form_bristle_remember(const contact_set *c, int g, int dim, const double *in, double *vector) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  if (dim == 1) {
    vector[0] = in[0];
    return;
  }
  for (int k = 0; k < 3; k++) {
    vector[k] = in[0] * t1[k] + in[1] * t2[k];
  }
}

int form_bristle_rows(contact_rows rows, int kind, int *first) {
  *first = 1 + ((kind > 0) ? rows.tangent : 0) + ((kind > 1) ? rows.torsion : 0);
  return (kind == 0) ? rows.tangent : ((kind == 1) ? rows.torsion : rows.rolling);
}
