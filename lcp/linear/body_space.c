#include "lcp/linear/body_space.h"

#include "lcp/base/arena.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* ---- W = L L', G = J L ------------------------------------------------------------------------- */

static bool cholesky(int n, const double *W, double *L) {
  memcpy(L, W, (size_t)(n * n) * sizeof *L);
  for (int k = 0; k < n; k++) {
    double pivot = L[k + k * n];
    for (int j = 0; j < k; j++) {
      pivot -= L[k + j * n] * L[k + j * n];
    }
    if (pivot < -1e-12 * fabs(W[k + k * n])) {
      return false;
    }
    const double root = (pivot > 0.0) ? sqrt(pivot) : 0.0;
    for (int i = 0; i < n; i++) {
      double v = (i < k) ? 0.0 : L[i + k * n];
      for (int j = 0; i >= k && j < k; j++) {
        v -= L[i + j * n] * L[k + j * n];
      }
      L[i + k * n] = (root > 0.0) ? v / root : 0.0;
    }
    L[k + k * n] = root;
  }
  return true;
}

/* G = J L of one group. */
static void weigh_group(const lcp_factored *f, int g, const double *L, double *G) {
  double *out = G + f->jac_start[g];
  const int rows = f->row_start[g + 1] - f->row_start[g];
  for (int k = 0; k < 2; k++) {
    const lin_side s = lin_side_of(f, f->jac, g, k);
    const double *own = L + ((s.body >= 0) ? f->weight_start[s.body] : 0);
    const double *jac = s.jac;
    for (int r = 0; r < rows; r++, jac += s.dof, out += s.dof) {
      for (int j = 0; j < s.dof; j++) { /* (J L)_j = sum_i>=j J_i L_ij */
        out[j] = 0.0;
        for (int i = j; i < s.dof; i++) {
          out[j] += jac[i] * own[i + j * s.dof];
        }
      }
    }
  }
}

base_status lin_weigh(const lcp_factored *f, double *L, double *G, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    if (!cholesky(n, f->weight + f->weight_start[b], L + f->weight_start[b])) {
      return BASE_FAIL(err, BASE_EINVAL, "weight of body %d: not positive semidefinite", b);
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    weigh_group(f, g, L, G);
  }
  return BASE_OK;
}

/* ---- the rows of the system -------------------------------------------------------------------- */

void lin_body_space_close(lin_body_space *s) {
  lin_blocks_close(&s->blocks);
  free(s->mem);
  free(s->matrix_mem);
  *s = (lin_body_space){0};
}

static void layout(lin_body_space *s, base_arena *a) {
  s->first = BASE_ARRAY(a, int, s->cap_group + 1);
  s->at = BASE_ARRAY(a, size_t, s->cap_group + 1);
  s->pair = BASE_ARRAY(a, int, 2 * (size_t)s->cap_group);
  s->joined = BASE_ARRAY(a, unsigned char, s->cap_group);
  s->row = BASE_ARRAY(a, int, s->cap_n);
  s->v = BASE_ARRAY(a, double, s->cap_dof);
}

static void layout_matrices(lin_body_space *s, base_arena *a) {
  s->T = BASE_ARRAY(a, double, s->cap_matrices);
  s->Y = BASE_ARRAY(a, double, s->cap_matrices);
}

static base_status memory(void **mem, lin_body_space *s,
                          void (*lay)(lin_body_space *, base_arena *), base_error *err) {
  base_arena measure = base_arena_measuring();
  lay(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a system of %d groups", s->cap_group);
  }
  base_arena real = base_arena_over(*mem, measure.used);
  lay(s, &real);
  return BASE_OK;
}

/* S couples no rows of different groups. */
static base_status admit_shift(const lcp_factored *f, int g, base_error *err) {
  for (int j = f->row_start[g]; j < f->row_start[g + 1]; j++) {
    for (int k = f->shift->colptr[j]; k < f->shift->colptr[j + 1]; k++) {
      const int i = f->shift->rowind[k];
      if (f->shift->val[k] != 0.0 && (i < f->row_start[g] || i >= f->row_start[g + 1])) {
        return BASE_FAIL(err, BASE_EUNSUPPORTED,
                         "S couples rows %d and %d of different groups: need storage=csc", i, j);
      }
    }
  }
  return BASE_OK;
}

base_status lin_body_space_admits(const lcp_factored *f, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > LIN_BLOCK_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %d has %d velocities: need at most %d", b,
                       f->dof_start[b + 1] - f->dof_start[b], (int)LIN_BLOCK_MAX);
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    if (f->row_start[g + 1] - f->row_start[g] > LIN_GROUP_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "group %d has %d rows: need at most %d", g,
                       f->row_start[g + 1] - f->row_start[g], (int)LIN_GROUP_MAX);
    }
    if (f->shift != NULL) {
      BASE_TRY(admit_shift(f, g, err));
    }
  }
  return BASE_OK;
}

base_status lin_body_space_begin(lin_body_space *s, const lcp_factored *f, const double *G,
                                 const double *scale, const unsigned char *member,
                                 base_error *err) {
  const int n = f->row_start[f->n_group], dof = f->dof_start[f->n_body];
  assert(lin_body_space_admits(f, NULL) == BASE_OK);
  if (s->mem == NULL || f->n_group > s->cap_group || n > s->cap_n || dof > s->cap_dof) {
    s->cap_group = (f->n_group > s->cap_group) ? f->n_group + f->n_group / 2 : s->cap_group;
    s->cap_n = (n > s->cap_n) ? n + n / 2 : s->cap_n;
    s->cap_dof = (dof > s->cap_dof) ? dof + dof / 2 : s->cap_dof;
    BASE_TRY(memory(&s->mem, s, layout, err));
  }
  s->f = f;
  s->G = G;
  s->scale = scale;
  int count = 0;
  size_t at = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int before = count;
    s->first[g] = count;
    s->at[g] = at;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      s->row[count] = i;
      count += member[i] != 0;
    }
    s->joined[g] = count > before;
    at += (size_t)(count - before) * (size_t)(count - before);
  }
  s->first[f->n_group] = count;
  s->at[f->n_group] = at;
  if (s->matrix_mem == NULL || at > s->cap_matrices) {
    s->cap_matrices = at + at / 2;
    BASE_TRY(memory(&s->matrix_mem, s, layout_matrices, err));
  }
  memset(s->T, 0, at * sizeof *s->T);
  memset(s->Y, 0, at * sizeof *s->Y);
  return BASE_OK;
}

/* ---- I + G'KG ---------------------------------------------------------------------------------- */

/* The row from k on with the largest entry of column k. */
static int pivot_row(int n, const double *A, int k) {
  int p = k;
  for (int i = k + 1; i < n; i++) {
    p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
  }
  return p;
}

/* Column k was swapped with from[k], k going up; goes back. */
static void swap_back(int n, const int *from, double *A) {
  for (int k = n - 1; k >= 0; k--) {
    for (int i = 0; i < n && from[k] != k; i++) {
      const double x = A[i + k * n];
      A[i + k * n] = A[i + from[k] * n];
      A[i + from[k] * n] = x;
    }
  }
}

/* A (n x n, by columns) -> its inverse by Gauss-Jordan with row pivoting; B <- A^-1 B. False: singular. */
static bool invert(int n, double *A, double *B) {
  double copy[LIN_GROUP_MAX];
  int from[LIN_GROUP_MAX];
  for (int k = 0; k < n; k++) {
    const int p = from[k] = pivot_row(n, A, k);
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
  swap_back(n, from, A);
  return true;
}

static void mirror(int n, double *K) {
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < j; i++) {
      K[i + j * n] = K[j + i * n] = 0.5 * (K[i + j * n] + K[j + i * n]);
    }
  }
}

/* Q = K A, rows x n, A's rows that many. */
static void multiply(int rows, int n, const double *K, const double *A, double *Q) {
  memset(Q, 0, (size_t)(rows * n) * sizeof *Q);
  for (int r = 0; r < rows; r++) {
    for (int i = 0; i < rows; i++) {
      const double factor = K[r + i * rows];
      for (int j = 0; j < n && factor != 0.0; j++) {
        Q[r * n + j] += factor * A[i * n + j];
      }
    }
  }
}

/* B = A' Q, m x n, over `rows` rows. */
static inline void cross(int rows, const double *A, const double *Q, double *B, int m, int n) {
  for (int r = 0; r < rows; r++) {
    for (int i = 0; i < m; i++) {
      for (int j = 0; j < n; j++) {
        B[i * n + j] += A[r * m + i] * Q[r * n + j];
      }
    }
  }
}

static void add_sides(lin_body_space *s, int count, const lin_side *a, const lin_side *b,
                      const double *Q) {
  double B[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
  if (a->dof == 6 && b->dof == 6) {
    cross(count, a->jac, Q, B, 6, 6);
  } else {
    cross(count, a->jac, Q, B, a->dof, b->dof);
  }
  lin_blocks_add(&s->blocks, a->body, b->body, B);
}

/* K of group g, scaled, over the span of its rows; returns how wide that is. */
static int spread(const lin_body_space *s, int g, double *out) {
  const int *row;
  const int n = lin_body_space_rows(s, g, &row), wide = row[n - 1] - row[0] + 1;
  const double *K = s->Y + s->at[g];
  memset(out, 0, (size_t)(wide * wide) * sizeof *out);
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      const double unit = (s->scale != NULL) ? s->scale[row[i]] * s->scale[row[j]] : 1;
      out[row[i] - row[0] + (row[j] - row[0]) * wide] = unit * K[i + j * n];
    }
  }
  return wide;
}

/* Adds G'KG of a group with rows in the system. */
static void add_group(lin_body_space *s, int g) {
  double K[LIN_GROUP_MAX * LIN_GROUP_MAX];
  const lcp_factored *f = s->f;
  const int wide = spread(s, g, K), skip = s->row[s->first[g]] - f->row_start[g];
  lin_side side[2];
  for (int k = 0; k < 2; k++) {
    side[k] = lin_side_of(f, s->G, g, k);
    side[k].jac += skip * side[k].dof;
  }
  for (int k = 0; k < 2; k++) {
    double Q[LIN_GROUP_MAX * LIN_BLOCK_MAX];
    const lin_side *b = &side[k];
    if (b->body < 0 || b->dof == 0) {
      continue;
    }
    multiply(wide, b->dof, K, b->jac, Q);
    for (int l = 0; l < 2; l++) {
      const lin_side *a = &side[l];
      const bool above = a->body >= 0 && s->blocks.place[a->body] < s->blocks.place[b->body];
      if (a->body >= 0 && a->dof > 0 && !(above && s->blocks.symmetric)) {
        add_sides(s, wide, a, b, Q);
      }
    }
  }
}

/* The pairs of bodies that meet in groups of the system: contacts of two bodies follow one another, one pair for them. */
static size_t find_pairs(lin_body_space *s) {
  const lcp_factored *f = s->f;
  size_t n = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int a = f->body[2 * (ptrdiff_t)g], b = f->body[2 * (ptrdiff_t)g + 1];
    if (s->joined[g] && a >= 0 && b >= 0 && a != b) {
      const bool again = n > 0 && s->pair[2 * n - 2] == a && s->pair[2 * n - 1] == b;
      s->pair[2 * n] = a;
      s->pair[2 * n + 1] = b;
      n += !again;
    }
  }
  return n;
}

static void add_one(lin_body_space *s) {
  const lcp_factored *f = s->f;
  for (int b = 0; b < f->n_body; b++) {
    double one[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    for (int k = 0; k < n; k++) {
      one[k + k * n] = 1;
    }
    lin_blocks_add(&s->blocks, b, b, one);
  }
}

base_status lin_body_space_factor(lin_body_space *s, bool symmetric, bool *regular,
                                  base_error *err) {
  const lcp_factored *f = s->f;
  *regular = false;
  for (int g = 0; g < f->n_group; g++) {
    const int n = s->first[g + 1] - s->first[g];
    if (!invert(n, s->T + s->at[g], s->Y + s->at[g])) {
      return BASE_OK;
    }
    if (symmetric) {
      mirror(n, s->Y + s->at[g]);
    }
  }
  BASE_TRY(lin_blocks_plan(&s->blocks, f->n_body, f->dof_start, s->pair, find_pairs(s), err));
  lin_blocks_clear(&s->blocks, symmetric);
  add_one(s);
  for (int g = 0; g < f->n_group; g++) {
    if (s->joined[g]) {
      add_group(s, g);
    }
  }
  *regular = lin_blocks_factor(&s->blocks);
  return BASE_OK;
}

/* ---- solutions ------------------------------------------------------------------------------- */

static double unit_of(const lin_body_space *s, int i) {
  return (s->scale != NULL) ? s->scale[i] : 1;
}

/* v += G' s x over the rows of group g in the system. */
static void push(lin_body_space *s, int g, const double *x) {
  const int *row;
  const int n = lin_body_space_rows(s, g, &row);
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_side_of(s->f, s->G, g, k);
    double *to = s->v + ((a.body >= 0) ? s->f->dof_start[a.body] : 0);
    for (int m = 0; m < n; m++) {
      const double *G = a.jac + (ptrdiff_t)(row[m] - s->f->row_start[g]) * a.dof;
      const double f = unit_of(s, row[m]) * x[row[m]];
      for (int i = 0; i < a.dof; i++) {
        to[i] += G[i] * f;
      }
    }
  }
}

/* y_m = s G v of row m of group g in the system. */
static void pull(const lin_body_space *s, int g, double *y) {
  const int *row;
  const int n = lin_body_space_rows(s, g, &row);
  memset(y, 0, (size_t)n * sizeof *y);
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_side_of(s->f, s->G, g, k);
    const double *from = s->v + ((a.body >= 0) ? s->f->dof_start[a.body] : 0);
    for (int m = 0; m < n; m++) {
      const double *G = a.jac + (ptrdiff_t)(row[m] - s->f->row_start[g]) * a.dof;
      double sum = 0;
      for (int i = 0; i < a.dof; i++) {
        sum += G[i] * from[i];
      }
      y[m] += unit_of(s, row[m]) * sum;
    }
  }
}

void lin_body_space_solve(lin_body_space *s, const double *r, double *x) {
  const lcp_factored *f = s->f;
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
  memset(x, 0, (size_t)f->row_start[f->n_group] * sizeof *x);
  for (int g = 0; g < f->n_group; g++) {
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    const double *T = s->T + s->at[g];
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        x[row[i]] += T[i + j * n] * r[row[j]];
      }
    }
    push(s, g, x);
  }
  lin_blocks_solve(&s->blocks, s->v);
  for (int g = 0; g < f->n_group; g++) {
    double y[LIN_GROUP_MAX];
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    const double *K = s->Y + s->at[g];
    pull(s, g, y);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        x[row[i]] -= K[i + j * n] * y[j];
      }
    }
  }
}

base_status lin_body_space_deficit(lin_body_space *s, int *deficit, base_error *err) {
  const lcp_factored *f = s->f;
  double left = 0;
  BASE_TRY(lin_blocks_invert(&s->blocks, err));
  for (int g = 0; g < f->n_group; g++) {
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    for (int k = 0; k < n; k++) {
      const double unit = unit_of(s, row[k]);
      const int at = row[k] - f->row_start[g];
      double form = 0;
      for (int a = 0; a < 4; a++) {
        const lin_side x = lin_side_of(f, s->G, g, a / 2), y = lin_side_of(f, s->G, g, a % 2);
        if (x.body >= 0 && y.body >= 0) {
          form += lin_blocks_inverse_form(&s->blocks, x.body, x.jac + at * x.dof, y.body,
                                          y.jac + at * y.dof);
        }
      }
      left += 1 - s->Y[s->at[g] + (size_t)(k + k * n)] * unit * unit * form;
    }
  }
  *deficit = (int)lround(left);
  return BASE_OK;
}
