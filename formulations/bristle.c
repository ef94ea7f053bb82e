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

void form_bristle_pull(const contact_set *c, int g, int kind, const double *past, double h_old,
                       double out[2]) {
  int first;
  const int dim = form_bristle_rows(c->rows[g], kind, &first);
  const double *kept = past + PAST_PULL + (ptrdiff_t)BRISTLE_NUMBERS * kind;
  out[0] = out[1] = 0;
  if (past[PAST_SPRUNG] > 0 && dim == 2) {
    form_bristle_to_frame(c, g, form_bristle_turn_of(c, g), kept, out);
    return;
  }
  for (int m = 0; m < dim; m++) {
    out[m] = (past[PAST_SPRUNG] > 0) ? kept[m] : -past[PAST_IMPULSE + first + m] / h_old;
  }
}

static bool same_bodies(const contact_set *c, int g, int k) {
  return c->body[2 * g] == c->body[2 * k] && c->body[2 * g + 1] == c->body[2 * k + 1];
}

/* The point of a contact shows in its rows where one of the bodies has all of its dofs. */
static bool shows_point(const contact_set *c, int g) {
  const int all = (c->dim == 2) ? 3 : 6;
  return contact_dofs(c, c->body[2 * g]) == all || contact_dofs(c, c->body[2 * g + 1]) == all;
}

/* Rows of contacts between the same bodies agree to rounding. */
static bool same_rows(const contact_set *c, int g, int k) {
  static const double rounding = 1e-12;
  const int n = c->jac_start[g + 1] - c->jac_start[g];
  const double *a = c->jac + c->jac_start[g], *b = c->jac + c->jac_start[k];
  double largest = 0;
  bool same = n == c->jac_start[k + 1] - c->jac_start[k];
  for (int m = 0; m < n; m++) {
    largest = fmax(largest, fabs(a[m]));
  }
  for (int m = 0; m < n && same; m++) {
    same = fabs(a[m] - b[m]) <= rounding * largest;
  }
  return same;
}

void form_bristle_copies(const contact_set *c, int n, const int *group, bool extreme, int *out) {
  for (int i = 0; i < n; i++) {
    out[i] = 1;
  }
  for (int i = 0; i < n && !extreme; i++) { /* contacts of a pair of bodies follow each other */
    for (int j = i + 1; j < n && same_bodies(c, group[i], group[j]); j++) {
      const int g = group[i], k = group[j];
      const bool listed = c->id[g] >> CONTACT_COPY_BITS == c->id[k] >> CONTACT_COPY_BITS;
      const bool same = (listed || shows_point(c, g)) && same_rows(c, g, k);
      out[i] += same;
      out[j] += same;
    }
  }
}
