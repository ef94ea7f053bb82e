#include "lcp/lcp_share_bodies.h"

#include "lcp/lcp_column.h"

#include <stdlib.h>
#include <string.h>

enum { SOLUTIONS = 8 }; /* most, with corrections: delta costs seven to ten digits of each */

void lcp_share_bodies_close(share_bodies *s) {
  lin_body_space_close(&s->space);
  free(s->mem);
  free(s->matrix_mem);
  *s = (share_bodies){0};
}

static int group_rows(const lcp_factored *f, int g) {
  return f->row_start[g + 1] - f->row_start[g];
}

bool lcp_share_bodies_take(const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > LIN_BLOCK_MAX) {
      return false;
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    if (group_rows(f, g) > LIN_GROUP_MAX) {
      return false;
    }
    for (int j = f->row_start[g]; j < f->row_start[g + 1]; j++) {
      const lcp_column c = lcp_csc_column(f->shift, j);
      for (int k = 0; k < c.count; k++) {
        if (c.val[k] != 0 && (c.row[k] < f->row_start[g] || c.row[k] >= f->row_start[g + 1])) {
          return false;
        }
      }
    }
  }
  return true;
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void layout(share_bodies *s, base_arena *a) {
  s->L = BASE_ARRAY(a, double, s->cap_weight);
  s->G = BASE_ARRAY(a, double, s->cap_jac);
  s->joined = BASE_ARRAY(a, unsigned char, s->cap_group);
  s->wide = BASE_ARRAY(a, int, s->cap_group);
  s->at = BASE_ARRAY(a, size_t, (size_t)s->cap_group + 1);
  s->scratch = BASE_ARRAY(a, double, s->cap_scratch);
  s->v = BASE_ARRAY(a, double, s->cap_dof);
  s->x = BASE_ARRAY(a, double, s->cap_n);
  s->w = BASE_ARRAY(a, double, s->cap_n);
  s->off = BASE_ARRAY(a, double, s->cap_n);
  s->sum = BASE_ARRAY(a, double, s->cap_n);
}

static void layout_matrices(share_bodies *s, base_arena *a) {
  s->T = BASE_ARRAY(a, double, s->cap_matrices);
  s->K = BASE_ARRAY(a, double, s->cap_matrices);
}

static base_status memory(share_bodies *s, void **mem, void (*lay)(share_bodies *, base_arena *),
                          base_error *err) {
  base_arena measure = base_arena_measuring();
  lay(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to share %d impulses", s->cap_n);
  }
  base_arena real = base_arena_over(*mem, measure.used);
  lay(s, &real);
  return BASE_OK;
}

static size_t larger(size_t have, size_t need) {
  return (need > have) ? need + need / 2 : have;
}

base_status lcp_share_bodies_begin(share_bodies *s, const lcp_problem *p, base_error *err) {
  const lcp_factored *f = p->M.factored;
  const size_t weight = (size_t)f->weight_start[f->n_body], jac = (size_t)f->jac_start[f->n_group];
  const size_t scratch = lcp_matrix_scratch(&p->M);
  const int dof = f->dof_start[f->n_body];
  s->p = p;
  if (s->mem == NULL || weight > s->cap_weight || jac > s->cap_jac || scratch > s->cap_scratch ||
      f->n_group > s->cap_group || dof > s->cap_dof || p->M.n > s->cap_n) {
    s->cap_weight = larger(s->cap_weight, weight);
    s->cap_jac = larger(s->cap_jac, jac);
    s->cap_scratch = larger(s->cap_scratch, scratch);
    s->cap_group = (int)larger((size_t)s->cap_group, (size_t)f->n_group);
    s->cap_dof = (int)larger((size_t)s->cap_dof, (size_t)dof);
    s->cap_n = (int)larger((size_t)s->cap_n, (size_t)p->M.n);
    BASE_TRY(memory(s, &s->mem, layout, err));
  }
  return lin_weigh(f, s->L, s->G, err);
}

/* ---- products -------------------------------------------------------------------------------- */

void lcp_share_bodies_product(share_bodies *s, const double *z, double *w, double *size) {
  const lcp_problem *p = s->p;
  const lcp_factored *f = p->M.factored;
  lcp_matrix_apply(&p->M, z, p->q, w, s->scratch);
  if (size == NULL) {
    return;
  }
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
  for (int g = 0; g < f->n_group; g++) {
    for (int k = 0; k < 2; k++) {
      const lin_side a = lin_side_of(f, s->G, g, k);
      for (int r = 0; r < group_rows(f, g) && a.body >= 0; r++) {
        const double x = fabs(z[f->row_start[g] + r]);
        for (int i = 0; i < a.dof && x > 0; i++) {
          s->v[f->dof_start[a.body] + i] += fabs(a.jac[r * a.dof + i]) * x;
        }
      }
    }
  }
  for (int i = 0; i < p->M.n; i++) {
    size[i] = fabs(p->q[i]);
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int k = 0; k < 2; k++) {
      const lin_side a = lin_side_of(f, s->G, g, k);
      for (int r = 0; r < group_rows(f, g) && a.body >= 0; r++) {
        for (int i = 0; i < a.dof; i++) {
          size[f->row_start[g] + r] += fabs(a.jac[r * a.dof + i]) * s->v[f->dof_start[a.body] + i];
        }
      }
    }
  }
  for (int j = 0; f->shift != NULL && j < p->M.n; j++) {
    if (z[j] != 0) {
      lcp_column_add_size(lcp_csc_column(f->shift, j), z[j], size);
    }
  }
}

void lcp_share_bodies_right(share_bodies *s, const share_rows *r, const double *z, double *right) {
  for (int i = 0; i < s->p->M.n; i++) {
    s->x[i] = (r->kind[i] == SHARE_FIXED) ? z[i] : 0;
  }
  lcp_matrix_apply(&s->p->M, s->x, s->p->q, right, s->scratch);
}

/* ---- the system ------------------------------------------------------------------------------ */

/* Rows of group g in the system; returns how many. */
static int unknowns(const lcp_factored *f, const share_rows *r, int g, int *row) {
  int n = 0;
  for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
    if (r->kind[i] != SHARE_FIXED) {
      row[n++] = i;
    }
  }
  return n;
}

static base_status place_matrices(share_bodies *s, const share_rows *r, base_error *err) {
  const lcp_factored *f = s->p->M.factored;
  size_t at = 0;
  int row[LIN_GROUP_MAX];
  for (int g = 0; g < f->n_group; g++) {
    s->wide[g] = unknowns(f, r, g, row);
    s->joined[g] = s->wide[g] > 0;
    s->at[g] = at;
    at += (size_t)s->wide[g] * (size_t)s->wide[g];
  }
  s->at[f->n_group] = at;
  if (s->matrix_mem == NULL || at > s->cap_matrices) {
    s->cap_matrices = larger(s->cap_matrices, at);
    return memory(s, &s->matrix_mem, layout_matrices, err);
  }
  return BASE_OK;
}

/* T and Y of the n unknowns `row` of one group, n x n by columns: row i is T_i x + Y_i (J W J' x). Returns whether both are
 * symmetric. */
static bool local(const share_bodies *s, const share_rows *r, const int *row, int n, double *T,
                  double *Y) {
  const lcp_csc *shift = s->p->M.factored->shift;
  int place[LIN_GROUP_MAX];
  const int first = (n > 0) ? row[0] : 0;
  bool symmetric = true;
  memset(T, 0, (size_t)(n * n) * sizeof *T);
  memset(Y, 0, (size_t)(n * n) * sizeof *Y);
  for (int i = 0, k = 0; n > 0 && i <= row[n - 1] - first; i++) {
    place[i] = (row[k] == first + i) ? k++ : -1;
  }
  for (int k = 0; k < n; k++) {
    const int i = row[k];
    if (r->kind[i] == SHARE_ACTIVE) {
      Y[k + k * n] = 1;
      T[k + k * n] += r->delta[i];
      for (int m = i + 1; m < r->slips[i]; m++) {
        if (r->kind[m] == SHARE_SLIP) {
          T[place[m - first] + k * n] += r->pull[m];
        }
      }
      continue;
    }
    symmetric = false;
    T[k + k * n] += r->own[i];
    for (int m = 0; m < r->part_dim[i] && r->part_dim[i] == 2; m++) {
      Y[k + place[r->part[i] + m - first] * n] = r->gain[2 * i + m];
    }
  }
  for (int k = 0; k < n && shift != NULL; k++) { /* T += Y S */
    const lcp_column c = lcp_csc_column(shift, row[k]);
    for (int e = 0; e < c.count; e++) {
      const int i = c.row[e] - first;
      const int at = (i >= 0 && c.row[e] <= row[n - 1]) ? place[i] : -1;
      for (int m = 0; m < n && at >= 0; m++) {
        T[m + k * n] += Y[m + at * n] * c.val[e];
      }
    }
  }
  for (int k = 0; k < n; k++) {
    for (int m = 0; m < k; m++) {
      symmetric = symmetric && T[m + k * n] == T[k + m * n];
    }
  }
  return symmetric;
}

/* A (n x n, by columns) -> its inverse by Gauss-Jordan with row pivoting; B <- A^-1 B. False: singular. */
static bool invert(int n, double *A, double *B) {
  double copy[LIN_GROUP_MAX];
  int from[LIN_GROUP_MAX];
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++) {
      p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
    }
    from[k] = p;
    const double pivot = A[p + k * n];
    if (!(fabs(pivot) > 0)) {
      return false;
    }
    for (int j = 0; j < n; j++) {
      const double a = A[p + j * n], b = B[p + j * n];
      A[p + j * n] = A[k + j * n];
      B[p + j * n] = B[k + j * n];
      A[k + j * n] = ((j == k) ? 1.0 : a) / pivot;
      B[k + j * n] = b / pivot;
    }
    for (int i = 0; i < n; i++) {
      copy[i] = (i == k) ? 0 : A[i + k * n];
      A[i + k * n] = (i == k) ? A[i + k * n] : 0;
    }
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        A[i + j * n] -= copy[i] * A[k + j * n];
        B[i + j * n] -= copy[i] * B[k + j * n];
      }
    }
  }
  for (int k = n - 1; k >= 0; k--) {
    for (int i = 0; i < n && from[k] != k; i++) {
      const double x = A[i + k * n];
      A[i + k * n] = A[i + from[k] * n];
      A[i + from[k] * n] = x;
    }
  }
  return true;
}

static void mirror(int n, double *K) {
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < j; i++) {
      K[i + j * n] = K[j + i * n] = 0.5 * (K[i + j * n] + K[j + i * n]);
    }
  }
}

/* G'KG of one group, K as wide as its unknowns. */
static void add_group(share_bodies *s, const share_rows *r, int g) {
  const lcp_factored *f = s->p->M.factored;
  int row[LIN_GROUP_MAX];
  const int n = unknowns(f, r, g, row);
  const double *K = s->K + s->at[g];
  if (n == 0) {
    return;
  }
  if (row[n - 1] - row[0] == n - 1) {
    lin_body_space_add(&s->space, f, s->G, g, row[0] - f->row_start[g], n, K);
    return;
  }
  double spread[LIN_GROUP_MAX * LIN_GROUP_MAX];
  const int wide = row[n - 1] - row[0] + 1;
  memset(spread, 0, (size_t)(wide * wide) * sizeof *spread);
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      spread[row[i] - row[0] + (row[j] - row[0]) * wide] = K[i + j * n];
    }
  }
  lin_body_space_add(&s->space, f, s->G, g, row[0] - f->row_start[g], wide, spread);
}

base_status lcp_share_bodies_factor(share_bodies *s, const share_rows *r, bool *regular,
                                    base_error *err) {
  const lcp_factored *f = s->p->M.factored;
  bool symmetric = true;
  *regular = false;
  BASE_TRY(place_matrices(s, r, err));
  for (int g = 0; g < f->n_group; g++) {
    int row[LIN_GROUP_MAX];
    const int n = unknowns(f, r, g, row);
    double *T = s->T + s->at[g], *K = s->K + s->at[g];
    symmetric = local(s, r, row, n, T, K) && symmetric;
    if (!invert(n, T, K)) {
      return BASE_OK;
    }
  }
  for (int g = 0; g < f->n_group && symmetric; g++) {
    mirror(s->wide[g], s->K + s->at[g]);
  }
  BASE_TRY(lin_body_space_begin(&s->space, f, s->joined, symmetric, err));
  for (int g = 0; g < f->n_group; g++) {
    add_group(s, r, g);
  }
  *regular = lin_blocks_factor(&s->space.blocks);
  return BASE_OK;
}

/* The rank is the sum of what each row adds, k g (I + G'KG)^-1 g': one for each direction that M sees, and delta over it
 * for what it does not see. */
base_status lcp_share_bodies_deficit(share_bodies *s, const share_rows *r, int *deficit,
                                     base_error *err) {
  const lcp_factored *f = s->p->M.factored;
  double left = 0;
  BASE_TRY(lin_blocks_invert(&s->space.blocks, err));
  for (int g = 0; g < f->n_group; g++) {
    int row[LIN_GROUP_MAX];
    const int n = unknowns(f, r, g, row);
    for (int k = 0; k < n; k++) {
      const double weight = s->K[s->at[g] + (size_t)(k + k * n)];
      double form = 0;
      for (int a = 0; a < 4; a++) {
        const lin_side x = lin_side_of(f, s->G, g, a / 2), y = lin_side_of(f, s->G, g, a % 2);
        const int at = row[k] - f->row_start[g];
        form += (x.body < 0 || y.body < 0)
                    ? 0
                    : lin_blocks_inverse_form(&s->space.blocks, x.body, x.jac + at * x.dof, y.body,
                                              y.jac + at * y.dof);
      }
      left += 1 - weight * form;
    }
  }
  *deficit = (int)lround(left);
  return BASE_OK;
}

/* out = A y over the unknowns of group g. */
static void times(const share_bodies *s, const double *A, int g, const int *row, const double *y,
                  double *out) {
  const int n = s->wide[g];
  for (int k = 0; k < n; k++) {
    out[row[k]] = 0;
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      out[row[i]] += A[i + j * n] * y[row[j]];
    }
  }
}

/* s->x = the solution for s->off, zero outside the system. */
static void solve_once(share_bodies *s, const share_rows *r) {
  const lcp_factored *f = s->p->M.factored;
  int row[LIN_GROUP_MAX];
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
  memset(s->x, 0, (size_t)s->p->M.n * sizeof *s->x);
  for (int g = 0; g < f->n_group; g++) {
    if (s->wide[g] > 0) {
      (void)unknowns(f, r, g, row);
      times(s, s->T + s->at[g], g, row, s->off, s->x);
      lin_body_space_push(f, s->G, g, s->x + f->row_start[g], s->v);
    }
  }
  lin_blocks_solve(&s->space.blocks, s->v);
  for (int g = 0; g < f->n_group; g++) {
    if (s->wide[g] > 0) {
      double y[LIN_GROUP_MAX], back[LIN_GROUP_MAX];
      const int first = f->row_start[g], n = unknowns(f, r, g, row);
      for (int k = 0; k < n; k++) {
        row[k] -= first;
      }
      lin_body_space_pull(f, s->G, g, s->v, y);
      times(s, s->K + s->at[g], g, row, y, back);
      for (int k = 0; k < n; k++) {
        s->x[first + row[k]] -= back[row[k]];
      }
    }
  }
}

/* s->off = right less the system's rows at z; z is zero outside the system. */
static void residual(share_bodies *s, const share_rows *r, const double *right, const double *z) {
  const int n = s->p->M.n;
  lcp_matrix_apply(&s->p->M, z, NULL, s->w, s->scratch);
  for (int i = 0; i < n; i++) {
    s->off[i] = 0;
    if (r->kind[i] == SHARE_ACTIVE) {
      s->off[i] = right[i] - s->w[i] - r->delta[i] * z[i];
    } else if (r->kind[i] == SHARE_SLIP) {
      s->off[i] = right[i] - r->own[i] * z[i];
      for (int m = 0; m < r->part_dim[i] && r->part_dim[i] == 2; m++) {
        s->off[i] -= r->gain[2 * i + m] * s->w[r->part[i] + m];
      }
    }
  }
  for (int i = 0; i < n; i++) {
    for (int m = i + 1; r->kind[i] == SHARE_ACTIVE && m < r->slips[i]; m++) {
      s->off[m] -= (r->kind[m] == SHARE_SLIP) ? r->pull[m] * z[i] : 0;
    }
  }
}

int lcp_share_bodies_solve(share_bodies *s, const share_rows *r, const double *right, double *z) {
  const int n = s->p->M.n;
  memcpy(s->off, right, (size_t)n * sizeof *right);
  memset(s->sum, 0, (size_t)n * sizeof *s->sum);
  int count = 0;
  for (double last = HUGE_VAL, step = 0; count < SOLUTIONS && (count < 3 || step < 0.5 * last);) {
    last = (count > 0) ? step : last;
    if (count++ > 0) {
      residual(s, r, right, s->sum);
    }
    solve_once(s, r);
    step = 0;
    for (int i = 0; i < n; i++) {
      s->sum[i] += s->x[i];
      step = fmax(step, fabs(s->x[i]));
    }
  }
  for (int i = 0; i < n; i++) {
    z[i] = (r->kind[i] != SHARE_FIXED) ? s->sum[i] : z[i];
  }
  return count;
}
