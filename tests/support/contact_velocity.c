#include "tests/support/contact_velocity.h"

#include <string.h>

/* p += J' impulse of group g. */
static void add_impulse(const contact_set *c, int g, const double *impulse, double *p) {
  const int first = c->row_start[g], rows = c->row_start[g + 1] - first;
  const double *jac = c->jac + c->jac_start[g];
  for (int s = 0; s < 2; s++) {
    const int b = c->body[2 * g + s];
    if (b < 0) {
      continue;
    }
    const int n = c->dof_start[b + 1] - c->dof_start[b];
    double *pb = p + c->dof_start[b];
    for (int r = 0; r < rows; r++) {
      for (int k = 0; k < n; k++) {
        pb[k] += jac[k] * impulse[first + r];
      }
      jac += n;
    }
  }
}

void contact_velocity(const contact_set *c, const double *impulse, double *v_next,
                      double *scratch) {
  memset(scratch, 0, (size_t)c->n_dof * sizeof *scratch);
  for (int g = 0; g < c->n_group; g++) {
    add_impulse(c, g, impulse, scratch);
  }
  for (int b = 0; b < c->n_body; b++) {
    const int d = c->dof_start[b], n = c->dof_start[b + 1] - d;
    const double *W = c->inv_mass + c->mass_start[b];
    for (int i = 0; i < n; i++) {
      double sum = 0.0;
      for (int j = 0; j < n; j++) {
        sum += W[j * n + i] * scratch[d + j];
      }
      v_next[d + i] = c->v_free[d + i] + sum;
    }
  }
}
