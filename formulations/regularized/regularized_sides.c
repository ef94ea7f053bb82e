/* regularized_sides.c - what the contacts put into M_hat and into the right sides of regularized_mass.c, and
 * the motion of their rows: one pass over the contacts each. */
#include "formulations/dof_kernel.h"
#include "formulations/regularized/regularized_factor.h"

#include <string.h>

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

/* The directions are rows of the Jacobian as they stand. */
static bool are_axes(const reg_row *q, int rank) {
  bool axes = true;
  for (int r = 0; r < rank; r++) {
    axes = axes && q[r].n == 1 && q[r].c[0] == 1 && q[r].row == q[0].row + r;
  }
  return axes;
}

static void combine(const reg_row *q, int rank, const double *jac, int n, double *e) {
  for (int r = 0; r < rank; r++, e += n) {
    const double *row = jac + (ptrdiff_t)(q[r].row - q[0].row) * n;
    for (int k = 0; k < n; k++) {
      e[k] = q[r].c[0] * row[k] + ((q[r].n == 2) ? q[r].c[1] * row[n + k] : 0);
    }
  }
}

static void directions(const regularized *s, int i, const group_side side[2], reg_springs *out) {
  const reg_row *q = &s->rows[s->row_of[i]];
  const int rank = s->row_of[i + 1] - s->row_of[i];
  const bool same = side[0].n > 0 && side[1].n > 0 && side[0].place == side[1].place;
  double *scratch[2] = {s->mass.e, s->mass.e + (ptrdiff_t)rank * side[0].n};
  const bool axes = !same && are_axes(q, rank);
  *out = (reg_springs){.rank = rank};
  for (int r = 0; r < rank; r++) {
    out->stiffness[r] = q[r].stiffness;
  }
  for (int k = 0; k < 2; k++) {
    const int n = side[k].n;
    const double *jac = side[k].jac + (ptrdiff_t)(q[0].row - s->a.row[i]) * n;
    if (!axes) {
      combine(q, rank, jac, n, scratch[k]);
    }
    out->n[k] = n;
    out->place[k] = side[k].place;
    out->e[k] = axes ? jac : scratch[k];
  }
  if (same) {
    form_add_scaled(1, scratch[1], scratch[0], rank * side[0].n);
    out->n[1] = 0;
  }
}

/* M_hat += e' e / g and c += e' (e' r + o) / g over the compliant directions e of contact i. */
static void put_springs(regularized *s, int i, const group_side side[2]) {
  reg_mass *m = &s->mass;
  const reg_add add = m->by_sparse ? reg_sparse_add : reg_envelope_add;
  reg_springs p;
  directions(s, i, side, &p);
  for (int k = 0; k < 2; k++) {
    const int at = p.place[k];
    if (p.n[k] > 0) {
      add(m, &p, k, k);
    }
    for (int r = 0; r < p.rank; r++) {
      const reg_row *q = &s->rows[s->row_of[i] + r];
      const double force = (reg_along(q, s->a.r + q->row) + q->offset) * q->stiffness;
      FORM_WITH_DOFS(p.n[k], form_add_scaled, force, p.e[k] + (ptrdiff_t)r * p.n[k], m->c + at);
    }
  }
  if (p.n[0] > 0 && p.n[1] > 0) {
    const int low = p.place[1] > p.place[0];
    add(m, &p, low, !low);
  }
}

/* The columns that begin at each body. */
static void note_columns(reg_mass *m, const int *body, const group_side side[2], int i) {
  const bool second = side[0].n == 0 || (side[1].n > 0 && side[1].place < side[0].place);
  const int b = body[second];
  if (side[second].n > 0) {
    m->from[b] = (i < m->from[b]) ? i : m->from[b];
    m->to[b] = i + 1;
  }
}

static void put_joints(regularized *s, double *column, int all) {
  const form_assembly *a = &s->a;
  for (int i = a->n_contact; i < a->n_group; i++) {
    group_side side[2];
    sides_of(s, i, side);
    for (int k = 0; k < form_rows_of(a, i); k++) {
      double f[REG_ROWS_MAX] = {0};
      f[k] = 1;
      put_column(side, form_rows_of(a, i), f, column++, all);
    }
  }
}

static void clear(regularized *s, int all) {
  const contact_set *c = s->a.set;
  reg_mass *m = &s->mass;
  memset(m->Y, 0, (size_t)c->n_dof * (size_t)all * sizeof *m->Y);
  memset(m->c, 0, (size_t)c->n_dof * sizeof *m->c);
  for (int b = 0; b < c->n_body; b++) {
    m->from[b] = s->a.n_contact;
    m->to[b] = 0;
  }
}

void reg_sides_fill(regularized *s, int all) {
  const form_assembly *a = &s->a;
  reg_mass *m = &s->mass;
  clear(s, all);
  for (int i = 0; i < a->n_contact; i++) {
    group_side side[2];
    sides_of(s, i, side);
    note_columns(m, a->set->body + 2 * (ptrdiff_t)a->group[i], side, i);
    if (s->row_of[i] < s->row_of[i + 1]) {
      put_springs(s, i, side);
    }
    for (int k = 0; k < 2; k++) {
      add_column(1, side[k].jac, side[k].n, m->Y + side[k].place * (ptrdiff_t)all + 1 + i, all);
    }
    if (s->any_slip) {
      double f[REG_ROWS_MAX];
      reg_slip_column(s, i, f);
      put_column(side, form_rows_of(a, i), f, m->Y + 1 + a->n_contact + i, all);
    }
  }
  for (int k = 0; k < a->set->n_dof; k++) {
    m->Y[k * (ptrdiff_t)all] = m->c[k];
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
