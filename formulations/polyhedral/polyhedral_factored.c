/* polyhedral_factored.c - the matrix of polyhedral.h as J W J' + S. */
#include "formulations/dof_kernel.h"
#include "formulations/polyhedral_matrix.h"

#include <string.h>

static int group_dofs(const polyhedral *s, int i) {
  const contact_set *c = s->a.set;
  const int *body = c->body + 2 * (ptrdiff_t)s->a.group[i];
  return contact_dofs(c, body[0]) + contact_dofs(c, body[1]);
}

/* Rows that the set has of group i. */
static int set_rows(const polyhedral *s, int i) {
  const int *row = s->a.set->row_start + s->a.group[i];
  return row[1] - row[0];
}

size_t poly_jac_size(const polyhedral *s) {
  size_t size = 0;
  for (int i = 0; i < s->a.n_group; i++) {
    size += (size_t)poly_width(s, i) * (size_t)group_dofs(s, i);
  }
  return size;
}

bool poly_jac_is_shared(const polyhedral *s) {
  bool any = false;
  for (int i = 0; i < s->a.n_group; i++) {
    const poly_shape *shape = s->shape_of[i];
    const int rows = form_rows_of(&s->a, i), stored = set_rows(s, i);
    const bool same = shape->n_part == 0 && rows == stored; /* the rows themselves */
    const bool made = stored <= POLY_MIXED_ROWS &&
                      ((shape->n_part == 0 && rows == 1) ||
                       (shape->n_part == 1 && rows == stored && shape->part_kind[0] == 0));
    if (!same && !made) {
      return false;
    }
    any = any || shape->n_part > 0;
  }
  return any;
}

/* The facets of a contact with `stored` rows, and nothing of its sigma. */
static const lcp_mixture *facets_of(polyhedral *s, const poly_shape *shape, int stored) {
  poly_mixture *m = &s->mixed[stored - 1];
  if (m->facets.rows == 0) {
    for (int b = 0; b < shape->n_column; b++) {
      for (int k = 0; k < shape->column[b].n; k++) {
        m->c[b * stored + shape->column[b].row + k] = shape->column[b].c[k];
      }
    }
    m->facets = (lcp_mixture){shape->n_column + shape->n_part, stored, m->c};
  }
  return &m->facets;
}

/* How the rows of group i are made of those of the set; NULL: they are these. */
static const lcp_mixture *mixture_of(polyhedral *s, int i) {
  static const double first[POLY_MIXED_ROWS] = {1};
  static const lcp_mixture normal[POLY_MIXED_ROWS] = {{1, 1, first}, {1, 2, first}, {1, 3, first}};
  const int stored = set_rows(s, i);
  if (s->shape_of[i]->n_part > 0) {
    return facets_of(s, s->shape_of[i], stored);
  }
  return (form_rows_of(&s->a, i) < stored) ? &normal[stored - 1] : NULL;
}

/* The rows f' J of both sides of group i, one for each unknown; those of the sigmas are zero. */
static void put_group(const polyhedral *s, int i, double *out) {
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

void poly_fill_factored(polyhedral *s, bool shared) {
  const contact_set *c = s->a.set;
  s->jac_start[0] = 0;
  for (int i = 0; i < s->a.n_group; i++) {
    const int g = s->a.group[i], at = s->jac_start[i];
    s->jac_start[i + 1] = at + poly_width(s, i) * group_dofs(s, i);
    memcpy(s->body + 2 * (ptrdiff_t)i, c->body + 2 * (ptrdiff_t)g, 2 * sizeof *s->body);
    if (shared) {
      s->stored_start[i] = c->jac_start[g];
      s->mixture[i] = mixture_of(s, i);
    } else {
      put_group(s, i, s->jac + at);
    }
  }
  fill_shift(s);
  s->factored = (lcp_factored){.n_body = c->n_body,
                               .dof_start = c->dof_start,
                               .weight_start = c->mass_start,
                               .weight = c->inv_mass,
                               .n_group = s->a.n_group,
                               .row_start = s->first,
                               .body = s->body,
                               .jac_start = s->jac_start,
                               .jac = shared ? c->jac : s->jac,
                               .shift = (s->s.colptr[s->n] > 0) ? &s->shift : NULL,
                               .stored_start = shared ? s->stored_start : NULL,
                               .mixture = shared ? s->mixture : NULL};
}
