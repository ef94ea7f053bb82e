#include "lcp/share/lcp_share_bodies.h"

#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"

#include <stdlib.h>
#include <string.h>

void lcp_share_bodies_close(share_bodies *s) {
  lin_body_space_close(&s->space);
  free(s->mem);
  *s = (share_bodies){0};
}

void lcp_share_bodies_rest(share_bodies *s) {
  lin_body_space_rest(&s->space);
  free(s->mem);
  s->mem = NULL;
}

static int group_rows(const lcp_factored *f, int g) {
  return f->row_start[g + 1] - f->row_start[g];
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void layout(share_bodies *s, base_arena *a) {
  s->L = BASE_ARRAY(a, double, s->cap_weight);
  s->G = BASE_ARRAY(a, double, s->cap_jac);
  s->scratch = BASE_ARRAY(a, double, s->cap_scratch);
  s->v = BASE_ARRAY(a, double, s->cap_dof);
  s->member = BASE_ARRAY(a, unsigned char, s->cap_n);
}

static base_status memory(share_bodies *s, base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  free(s->mem);
  s->mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (s->mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to share %d impulses", s->cap_n);
  }
  base_arena real = base_arena_over(s->mem, measure.used);
  layout(s, &real);
  return BASE_OK;
}

static size_t larger(size_t have, size_t need) {
  return (need > have) ? base_room_of(need) : have;
}

base_status lcp_share_bodies_begin(share_bodies *s, const lcp_problem *p, base_error *err) {
  const lcp_factored *f = p->M.factored;
  const size_t weight = (size_t)f->weight_start[f->n_body], jac = lin_stored_length(f);
  const size_t scratch = lcp_matrix_scratch(&p->M);
  const int dof = f->dof_start[f->n_body];
  s->p = p;
  if (s->mem == NULL || weight > s->cap_weight || jac > s->cap_jac || scratch > s->cap_scratch ||
      dof > s->cap_dof || p->M.n > s->cap_n) {
    s->cap_weight = larger(s->cap_weight, weight);
    s->cap_jac = larger(s->cap_jac, jac);
    s->cap_scratch = larger(s->cap_scratch, scratch);
    s->cap_dof = (int)larger((size_t)s->cap_dof, (size_t)dof);
    s->cap_n = (int)larger((size_t)s->cap_n, (size_t)p->M.n);
    BASE_TRY(memory(s, err));
  }
  BASE_TRY(lin_weigh_bodies(f, s->L, err));
  lin_weigh_stored(f, s->L, s->G);
  return BASE_OK;
}

/* ---- products -------------------------------------------------------------------------------- */

/* v += |A|' |x|, and y += |A| v, of `rows` rows. */
BASE_INLINE void gather(int rows, int dof, const double *A, const double *x, double *restrict v) {
  for (int r = 0; r < rows; r++) {
    const double most = fabs(x[r]);
    for (int i = 0; i < dof; i++) {
      v[i] += fabs(A[r * dof + i]) * most;
    }
  }
}

BASE_INLINE void spread(int rows, int dof, const double *A, const double *v, double *restrict y) {
  for (int r = 0; r < rows; r++) {
    double sum = 0;
    for (int i = 0; i < dof; i++) {
      sum += fabs(A[r * dof + i]) * v[i];
    }
    y[r] += sum;
  }
}

/* G of all rows of group g on one side. */
BASE_INLINE lin_side made(const lcp_factored *f, const double *G, int g, int which,
                          double room[LCP_MIXED_MAX]) {
  const lin_side a = lin_stored_side(f, G, g, which);
  const lcp_mixture *m = lcp_mixture_of(f, g);
  if (m == NULL || a.dof == 0) {
    return a;
  }
  lcp_mixture_side(m, a.dof, a.jac, room);
  return (lin_side){room, a.body, a.dof};
}

/* |z| of the rows of a group as those that it has stored make it up, and back: |c| in the place of c. */
static void gather_mixed(const lcp_mixture *m, const double *z, double *stored) {
  memset(stored, 0, LCP_STORED_MAX * sizeof *stored);
  for (int i = 0; i < m->rows; i++) {
    for (int k = 0; k < m->stored && z[i] != 0; k++) {
      stored[k] += fabs(m->c[i * m->stored + k] * z[i]);
    }
  }
}

static void spread_mixed(const lcp_mixture *m, const double *stored, double *size) {
  for (int i = 0; i < m->rows; i++) {
    for (int k = 0; k < m->stored; k++) {
      size[i] += fabs(m->c[i * m->stored + k]) * stored[k];
    }
  }
}

/* v += |G|' |z| of group g, */
BASE_INLINE void gather_group(share_bodies *s, int g, const double *z) {
  const lcp_factored *f = s->p->M.factored;
  const lcp_mixture *m = lcp_mixture_of(f, g);
  const int rows = lcp_factored_stored(f, g);
  double mixed[LCP_STORED_MAX];
  if (m != NULL) {
    gather_mixed(m, z, mixed);
    z = mixed;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_stored_side(f, s->G, g, k);
    double *v = s->v + ((a.dof > 0) ? f->dof_start[a.body] : 0);
    if (a.dof == 6) {
      gather(rows, 6, a.jac, z, v);
    } else {
      gather(rows, a.dof, a.jac, z, v);
    }
  }
}

/* and size += |G| v. */
BASE_INLINE void spread_group(const share_bodies *s, int g, double *size) {
  const lcp_factored *f = s->p->M.factored;
  const lcp_mixture *m = lcp_mixture_of(f, g);
  const int rows = lcp_factored_stored(f, g);
  double mixed[LCP_STORED_MAX] = {0}, *to = (m != NULL) ? mixed : size;
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_stored_side(f, s->G, g, k);
    const double *v = s->v + ((a.dof > 0) ? f->dof_start[a.body] : 0);
    if (a.dof == 6) {
      spread(rows, 6, a.jac, v, to);
    } else {
      spread(rows, a.dof, a.jac, v, to);
    }
  }
  if (m != NULL) {
    spread_mixed(m, mixed, size);
  }
}

/* size += |G| |G|' |z|: what the rows are made of at most, by degrees of freedom. */
BASE_CLONES static void add_sizes(share_bodies *s, const double *z, double *size) {
  const lcp_factored *f = s->p->M.factored;
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
  for (int g = 0; g < f->n_group; g++) {
    gather_group(s, g, z + f->row_start[g]);
  }
  for (int g = 0; g < f->n_group; g++) {
    spread_group(s, g, size + f->row_start[g]);
  }
}

void lcp_share_bodies_product(share_bodies *s, const double *z, double *w, double *size) {
  const lcp_problem *p = s->p;
  const lcp_factored *f = p->M.factored;
  lcp_matrix_apply(&p->M, z, p->q, w, s->scratch);
  if (size == NULL) {
    return;
  }
  for (int i = 0; i < p->M.n; i++) {
    size[i] = fabs(p->q[i]);
  }
  add_sizes(s, z, size);
  for (int j = 0; f->shift != NULL && j < p->M.n; j++) {
    if (z[j] != 0) {
      lcp_column_add_size(lcp_csc_column(f->shift, j), z[j], size);
    }
  }
}

void lcp_share_bodies_diagonal(const share_bodies *s, double *d) {
  const lcp_factored *f = s->p->M.factored;
  for (int g = 0; g < f->n_group; g++) {
    double room[2][LCP_MIXED_MAX];
    const lin_side a = made(f, s->G, g, 0, room[0]), b = made(f, s->G, g, 1, room[1]);
    for (int r = 0; r < group_rows(f, g); r++) {
      double sum = 0;
      for (int i = 0; i < a.dof; i++) {
        sum += a.jac[r * a.dof + i] * a.jac[r * a.dof + i];
      }
      for (int i = 0; i < b.dof; i++) {
        sum += b.jac[r * b.dof + i] * b.jac[r * b.dof + i];
      }
      d[f->row_start[g] + r] = sum;
    }
  }
  for (int j = 0; f->shift != NULL && j < s->p->M.n; j++) {
    const lcp_column c = lcp_csc_column(f->shift, j);
    for (int k = 0; k < c.count; k++) {
      d[j] += (c.row[k] == j) ? c.val[k] : 0;
    }
  }
}

/* ---- the system ------------------------------------------------------------------------------ */

/* The n > 0 rows of a group that are in the system, rising, and T and Y (n x n, by columns) over them. */
typedef struct group_system {
  int n;
  const int *row;
  int place[LIN_GROUP_MAX]; /* by row - row[0]: which of the n, -1: none */
  double *T, *Y;
} group_system;

static group_system system_of(const share_bodies *s, int g) {
  group_system a = {.T = s->space.T + s->space.at[g], .Y = s->space.Y + s->space.at[g]};
  a.n = lin_body_space_rows(&s->space, g, &a.row);
  for (int i = 0, k = 0; a.n > 0 && i <= a.row[a.n - 1] - a.row[0]; i++) {
    a.place[i] = (a.row[k] == a.row[0] + i) ? k++ : -1;
  }
  return a;
}

static void set_active(const group_system *a, const share_rows *r, int k) {
  const int i = a->row[k];
  a->Y[k + k * a->n] = 1;
  a->T[k + k * a->n] += r->delta[i];
  for (int m = i + 1; m < share_slips(r, i); m++) {
    if (r->kind[m] == SHARE_SLIP) {
      a->T[a->place[m - a->row[0]] + k * a->n] += r->pull[m];
    }
  }
}

static void set_slip(const group_system *a, const share_rows *r, int k) {
  const int i = a->row[k];
  for (int m = 0; m < r->part_dim[i]; m++) {
    const int at = share_first(r, i) + m, place = a->place[at - a->row[0]];
    a->T[k + place * a->n] += r->own[2 * i + m] + r->gain[2 * i + m] * r->delta[at];
    a->Y[k + place * a->n] = r->gain[2 * i + m];
  }
}

/* T += Y S, of S what is in the system. */
static void add_shift(const group_system *a, const lcp_csc *shift) {
  for (int k = 0; k < a->n; k++) {
    const lcp_column c = lcp_csc_column(shift, a->row[k]);
    for (int e = 0; e < c.count; e++) {
      const int i = c.row[e] - a->row[0];
      const int at = (i >= 0 && c.row[e] <= a->row[a->n - 1]) ? a->place[i] : -1;
      for (int m = 0; m < a->n && at >= 0; m++) {
        a->T[m + k * a->n] += a->Y[m + at * a->n] * c.val[e];
      }
    }
  }
}

/* T and Y of group g, where row i of the system is T_i x + Y_i (J W J' x). Returns whether both are symmetric. */
static bool local(share_bodies *s, const share_rows *r, int g) {
  const group_system a = system_of(s, g);
  bool symmetric = true;
  for (int k = 0; k < a.n; k++) {
    const bool active = r->kind[a.row[k]] == SHARE_ACTIVE;
    (active ? set_active : set_slip)(&a, r, k);
    symmetric = symmetric && active;
  }
  if (s->p->M.factored->shift == NULL) {
    return symmetric; /* diagonal, where nothing slips */
  }
  add_shift(&a, s->p->M.factored->shift);
  for (int k = 0; k < a.n; k++) {
    for (int m = 0; m < k; m++) {
      symmetric = symmetric && a.T[m + k * a.n] == a.T[k + m * a.n];
    }
  }
  return symmetric;
}

base_status lcp_share_bodies_factor(share_bodies *s, const share_rows *r, bool *regular,
                                    base_error *err) {
  const lcp_factored *f = s->p->M.factored;
  bool symmetric = true;
  for (int i = 0; i < s->p->M.n; i++) {
    s->member[i] = r->kind[i] != SHARE_FIXED;
  }
  BASE_TRY(lin_body_space_begin(&s->space, f, s->G, true, NULL, s->member, err));
  for (int g = 0; g < f->n_group; g++) {
    symmetric = local(s, r, g) && symmetric;
  }
  return lin_body_space_factor(&s->space, symmetric, regular, err);
}
