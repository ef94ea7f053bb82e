/* regularized_sides.c - what the contacts put into M_hat and into the right sides of regularized_mass.c, and
 * the motion of their rows: one pass over the contacts each. */
#include "formulations/dof_kernel.h"
#include "formulations/regularized_factor.h"

#include <string.h>

enum { MOST_ROWS = 8 };

/* One side of a group: its Jacobian, rows x n, and where the n dofs of its body stand. */
typedef struct group_side {
  const double *jac;
  int n, place;
} group_side;

static void sides_of(const regularized *s, int i, group_side out[2]) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  const double *jac = c->jac + c->jac_start[g];
  for (int k = 0; k < 2; k++) {
    const int b = c->body[2 * g + k];
    const int n = contact_dofs(c, b);
    out[k] = (group_side){.jac = jac, .n = n, .place = (n > 0) ? s->mass.place[b] : 0};
    jac += (ptrdiff_t)(c->row_start[g + 1] - c->row_start[g]) * n;
  }
}

/* out += s x, a vector of dofs with the given stride. */
static void add_column(double s, const double *x, int n, double *out, ptrdiff_t stride) {
  for (int k = 0; k < n; k++) {
    out[k * stride] += s * x[k];
  }
}

/* J' f of one group into a column of Y. */
static void put_column(const group_side side[2], int rows, const double *f, double *out,
                       ptrdiff_t stride) {
  for (int k = 0; k < 2; k++) {
    const int n = side[k].n;
    for (int r = 0; r < rows; r++) {
      if (f[r] != 0) {
        add_column(f[r], side[k].jac + (ptrdiff_t)r * n, n, out + side[k].place * stride, stride);
      }
    }
  }
}

/* The direction of compliant row q on one side: its Jacobian row where it is an axis, else in scratch. */
static const double *direction(const reg_row *q, int row, const group_side *side, double *scratch) {
  const double *jac = side->jac + (ptrdiff_t)row * side->n;
  if (q->n == 1 && q->c[0] == 1) {
    return jac;
  }
  for (int k = 0; k < side->n; k++) {
    scratch[k] = q->c[0] * jac[k] + ((q->n == 2) ? q->c[1] * jac[side->n + k] : 0);
  }
  return scratch;
}

/* M_hat += e e' / g and c += e (e' r + o) / g of one compliant direction; row: its first in the group. */
static void put_spring(regularized *s, const reg_row *q, int row, const group_side side[2],
                       ptrdiff_t all) {
  reg_mass *m = &s->mass;
  double *scratch[2] = {m->delta, m->delta + side[0].n};
  const double *e[2] = {direction(q, row, &side[0], scratch[0]),
                        direction(q, row, &side[1], scratch[1])};
  int n[2] = {side[0].n, side[1].n};
  if (n[0] > 0 && n[1] > 0 && side[0].place == side[1].place) { /* two sides of one body */
    for (int k = 0; k < n[0]; k++) {
      scratch[0][k] = e[0][k] + e[1][k];
    }
    e[0] = scratch[0];
    n[1] = 0;
  }
  const double *r = s->a.r + q->row;
  const double force = (reg_along(q, r) + q->offset) * q->stiffness;
  const reg_add add = m->by_sparse ? reg_sparse_add : reg_envelope_add;
  for (int k = 0; k < 2; k++) {
    if (n[k] > 0) {
      const int at = side[k].place;
      add(m, at, e[k], n[k], at, e[k], n[k], q->stiffness);
      add_column(force, e[k], n[k], m->Y + at * all, all);
    }
  }
  if (n[0] > 0 && n[1] > 0) {
    const int lower = side[1].place > side[0].place;
    add(m, side[lower].place, e[lower], n[lower], side[!lower].place, e[!lower], n[!lower],
        q->stiffness);
  }
}

static void put_joints(regularized *s, double *column, int all) {
  const form_assembly *a = &s->a;
  for (int i = a->n_contact; i < a->n_group; i++) {
    group_side side[2];
    sides_of(s, i, side);
    for (int k = 0; k < form_rows_of(a, i); k++) {
      double f[MOST_ROWS] = {0};
      f[k] = 1;
      put_column(side, form_rows_of(a, i), f, column++, all);
    }
  }
}

void reg_sides_fill(regularized *s, int all) {
  const form_assembly *a = &s->a;
  reg_mass *m = &s->mass;
  memset(m->Y, 0, (size_t)a->set->n_dof * (size_t)all * sizeof *m->Y);
  for (int i = 0; i < a->n_contact; i++) {
    group_side side[2];
    sides_of(s, i, side);
    for (int k = s->row_of[i]; k < s->row_of[i + 1]; k++) {
      put_spring(s, &s->rows[k], s->rows[k].row - a->row[i], side, all);
    }
    for (int k = 0; k < 2; k++) {
      add_column(1, side[k].jac, side[k].n, m->Y + side[k].place * (ptrdiff_t)all + 1 + i, all);
    }
    if (s->any_slip) {
      double f[MOST_ROWS];
      reg_slip_column(s, i, f);
      put_column(side, form_rows_of(a, i), f, m->Y + 1 + a->n_contact + i, all);
    }
  }
  put_joints(s, m->Y + all - m->joint.n, all);
}

/* u += J d over the rows of one side. */
static inline void add_motion(const double *jac, const double *d, int rows, double *u, int n) {
  for (int r = 0; r < rows; r++) {
    u[r] += form_dot(jac + (ptrdiff_t)r * n, d, n);
  }
}

void reg_sides_motion(const regularized *s, const double *delta, double *u) {
  memcpy(u, s->a.r, (size_t)s->a.n_row * sizeof *u);
  for (int i = 0; i < s->a.n_contact; i++) {
    group_side side[2];
    sides_of(s, i, side);
    for (int k = 0; k < 2; k++) {
      const int n = side[k].n;
      FORM_WITH_DOFS(n, add_motion, side[k].jac, delta + side[k].place, form_rows_of(&s->a, i),
                     u + s->a.row[i]);
    }
  }
}
