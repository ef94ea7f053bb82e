/* polyhedral_factored.c - the matrix of polyhedral.h as J W J' + S. */
#include "formulations/dof_kernel.h"
#include "formulations/polyhedral_matrix.h"

#include <string.h>

size_t poly_jac_size(const polyhedral *s) {
  const contact_set *c = s->a.set;
  size_t size = 0;
  for (int i = 0; i < s->a.n_group; i++) {
    const int g = s->a.group[i];
    size += (size_t)poly_width(s, i) *
            (size_t)(contact_dofs(c, c->body[2 * g]) + contact_dofs(c, c->body[2 * g + 1]));
  }
  return size;
}

/* The rows f' J of both sides of group i, one for each unknown; those of the sigmas are zero. */
static double *put_group(const polyhedral *s, int i, double *out) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  const int width = poly_width(s, i);
  const int n[2] = {contact_dofs(c, c->body[2 * g]), contact_dofs(c, c->body[2 * g + 1])};
  const double *first = c->jac + c->jac_start[g];
  const double *jac[2] = {first, first + (ptrdiff_t)(c->row_start[g + 1] - c->row_start[g]) * n[0]};
  double *to[2] = {out, out + (ptrdiff_t)width * n[0]};
  double *end = to[1] + (ptrdiff_t)width * n[1];
  memset(out, 0, sizeof *out * (size_t)(end - out));
  for (int b = 0; b < poly_columns(s, i); b++) {
    double f[POLY_ROWS_MAX];
    poly_direction(s, i, b, f);
    for (int r = 0; r < form_rows_of(&s->a, i); r++) {
      for (int side = 0; side < 2 && f[r] != 0; side++) {
        form_add_scaled(f[r], jac[side] + (ptrdiff_t)r * n[side], to[side] + (ptrdiff_t)b * n[side],
                        n[side]);
      }
    }
  }
  return end;
}

static void fill_shift(polyhedral *s) {
  int at = 0;
  int column = 0;
  for (int j = 0; j < s->a.n_group; j++) {
    for (int b = 0; b < poly_columns(s, j); b++) {
      s->s.colptr[column++] = at;
      at = poly_put_cone_rows(s, &s->s, at, j, b);
    }
    for (int p = 0; p < poly_parts(s, j); p++) {
      s->s.colptr[column++] = at;
      at = poly_put_sigma_column(s, &s->s, at, j, p);
    }
  }
  s->s.colptr[column] = at;
  s->shift = (lcp_csc){s->n, s->n, s->s.colptr, s->s.rowind, s->s.val};
}

void poly_fill_factored(polyhedral *s) {
  const contact_set *c = s->a.set;
  double *out = s->jac;
  for (int i = 0; i < s->a.n_group; i++) {
    s->jac_start[i] = (int)(out - s->jac);
    memcpy(s->body + 2 * (ptrdiff_t)i, c->body + 2 * (ptrdiff_t)s->a.group[i], 2 * sizeof *s->body);
    out = put_group(s, i, out);
  }
  s->jac_start[s->a.n_group] = (int)(out - s->jac);
  fill_shift(s);
  s->factored = (lcp_factored){.n_body = c->n_body,
                               .dof_start = c->dof_start,
                               .weight_start = c->mass_start,
                               .weight = c->inv_mass,
                               .n_group = s->a.n_group,
                               .row_start = s->first,
                               .body = s->body,
                               .jac_start = s->jac_start,
                               .jac = s->jac,
                               .shift = (s->s.colptr[s->n] > 0) ? &s->shift : NULL};
}
