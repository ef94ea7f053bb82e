#include "lcp/linear/blocks.h"

#include "lcp/base/arena.h"
#include "lcp/base/clones.h"

#include <suitesparse/amd.h>

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const double singular = 1e-15; /* least pivot over the largest */

void lin_blocks_close(lin_blocks *s) {
  free(s->mem);
  free(s->row);
  free(s->at);
  free(s->value_mem);
  free(s->inverse_mem);
  free(s->pair);
  *s = (lin_blocks){0};
}

/* ---- pattern --------------------------------------------------------------------------------- */

static int rows(const lin_blocks *s, int place) {
  const int b = s->order[place];
  return s->first[b + 1] - s->first[b];
}

static void layout_blocks(lin_blocks *s, base_arena *a) {
  const int n = s->cap_n;
  s->first = BASE_ARRAY(a, int, n + 1);
  s->place = BASE_ARRAY(a, int, n);
  s->order = BASE_ARRAY(a, int, n);
  s->column = BASE_ARRAY(a, int, n + 1);
  s->at_diag = BASE_ARRAY(a, size_t, n + 1);
  s->swap = BASE_ARRAY(a, int, s->cap_rows);
}

static void layout_values(lin_blocks *s, base_arena *a) {
  s->low = BASE_ARRAY(a, double, s->cap_low);
  s->up = BASE_ARRAY(a, double, s->cap_low);
  s->diag = BASE_ARRAY(a, double, s->cap_diag);
}

static void layout_inverse(lin_blocks *s, base_arena *a) {
  s->inverse_low = BASE_ARRAY(a, double, s->cap_low);
  s->inverse_diag = BASE_ARRAY(a, double, s->cap_diag);
}

/* One block of memory for a layout; what stood there before is lost. */
static base_status memory(lin_blocks *s, void **mem, void (*layout)(lin_blocks *, base_arena *),
                          base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a factor of %d blocks", s->cap_n);
  }
  base_arena real = base_arena_over(*mem, measure.used);
  layout(s, &real);
  return BASE_OK;
}

static bool is_planned(const lin_blocks *s, int n, const int *first, const int *pair,
                       size_t n_pair) {
  return s->mem != NULL && s->n == n && s->n_pair == n_pair &&
         memcmp(s->first, first, ((size_t)n + 1) * sizeof *first) == 0 &&
         (n_pair == 0 || memcmp(s->pair, pair, 2 * n_pair * sizeof *pair) == 0);
}

static base_status keep_pattern(lin_blocks *s, int n, const int *first, const int *pair,
                                size_t n_pair, base_error *err) {
  if (s->mem == NULL || n > s->cap_n || first[n] > s->cap_rows) {
    s->cap_n = n + n / 2;
    s->cap_rows = first[n] + first[n] / 2;
    BASE_TRY(memory(s, &s->mem, layout_blocks, err));
  }
  if (s->pair == NULL || n_pair > s->cap_pair) {
    free(s->pair);
    s->cap_pair = n_pair + n_pair / 2 + 1;
    s->pair = base_alloc(2 * s->cap_pair * sizeof *s->pair);
    if (s->pair == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu pairs of blocks", n_pair);
    }
  }
  s->n = n;
  s->n_pair = n_pair;
  memcpy(s->first, first, ((size_t)n + 1) * sizeof *first);
  if (n_pair > 0) {
    memcpy(s->pair, pair, 2 * n_pair * sizeof *pair);
  }
  return BASE_OK;
}

static int compare(const void *a, const void *b) {
  const int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static void sort(int *list, int count) {
  if (count > 32) {
    qsort(list, (size_t)count, sizeof *list, compare);
    return;
  }
  for (int i = 1; i < count; i++) {
    const int x = list[i];
    int k = i;
    for (; k > 0 && list[k - 1] > x; k--) {
      list[k] = list[k - 1];
    }
    list[k] = x;
  }
}

/* Sorts a list and drops what is double; returns its new length. */
static int sort_unique(int *list, int count) {
  sort(list, count);
  int kept = 0;
  for (int i = 0; i < count; i++) {
    if (i == 0 || list[i] != list[kept - 1]) {
      list[kept++] = list[i];
    }
  }
  return kept;
}

/* Neighbours of every block, sorted, each once: start[n+1], near[2 n_pair]. */
static void neighbours(const lin_blocks *s, int *start, int *near, int *next) {
  memset(start, 0, ((size_t)s->n + 1) * sizeof *start);
  for (size_t k = 0; k < 2 * s->n_pair; k += 2) {
    if (s->pair[k] != s->pair[k + 1]) {
      start[s->pair[k]]++;
      start[s->pair[k + 1]]++;
    }
  }
  for (int b = 0, sum = 0; b <= s->n; b++) {
    const int count = (b < s->n) ? start[b] : 0;
    start[b] = sum;
    sum += count;
  }
  memcpy(next, start, (size_t)s->n * sizeof *next);
  for (size_t k = 0; k < 2 * s->n_pair; k += 2) {
    if (s->pair[k] != s->pair[k + 1]) {
      near[next[s->pair[k]]++] = s->pair[k + 1];
      near[next[s->pair[k + 1]]++] = s->pair[k];
    }
  }
  int kept = 0;
  for (int b = 0; b < s->n; b++) {
    const int first = start[b], count = sort_unique(near + first, start[b + 1] - first);
    memmove(near + kept, near + first, (size_t)count * sizeof *near);
    start[b] = kept;
    kept += count;
  }
  start[s->n] = kept;
}

/* What the analysis needs while it runs. */
typedef struct graph {
  int *start, *near;           /* n+1, 2 n_pair: neighbours of every block, sorted, each once */
  int *mark, *child, *sibling; /* n */
} graph;

static void layout_graph(graph *g, size_t n, size_t n_pair, base_arena *a) {
  g->start = BASE_ARRAY(a, int, n + 1);
  g->near = BASE_ARRAY(a, int, 2 * n_pair);
  g->mark = BASE_ARRAY(a, int, n);
  g->child = BASE_ARRAY(a, int, n);
  g->sibling = BASE_ARRAY(a, int, n);
}

static base_status reserve_row(lin_blocks *s, size_t need, base_error *err) {
  if (need <= s->cap_below) {
    return BASE_OK;
  }
  const size_t cap = need + need / 2;
  int *more = (cap <= INT32_MAX) ? realloc(s->row, cap * sizeof *more) : NULL;
  if (more == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a factor of %zu blocks", need);
  }
  s->row = more;
  s->cap_below = cap;
  return BASE_OK;
}

/* Appends q to column p, which ends at `count`, unless it is there. */
static int meet(lin_blocks *s, graph *g, int p, int q, int count) {
  if (q > p && g->mark[q] != p) {
    g->mark[q] = p;
    s->row[count++] = q;
  }
  return count;
}

/* Blocks below the diagonal of L: in each column those of A and of the columns whose first block below stands here. */
static base_status find_fill(lin_blocks *s, graph *g, base_error *err) {
  int count = 0;
  for (int p = 0; p < s->n; p++) {
    g->mark[p] = g->child[p] = -1;
  }
  for (int p = 0; p < s->n; p++) {
    const int begin = count, b = s->order[p];
    size_t most = (size_t)count + (size_t)(g->start[b + 1] - g->start[b]);
    for (int c = g->child[p]; c >= 0; c = g->sibling[c]) {
      most += (size_t)(s->column[c + 1] - s->column[c]);
    }
    BASE_TRY(reserve_row(s, most, err));
    s->column[p] = begin;
    for (int k = g->start[b]; k < g->start[b + 1]; k++) {
      count = meet(s, g, p, s->place[g->near[k]], count);
    }
    for (int c = g->child[p]; c >= 0; c = g->sibling[c]) {
      for (int k = s->column[c]; k < s->column[c + 1]; k++) {
        count = meet(s, g, p, s->row[k], count);
      }
    }
    s->column[p + 1] = count;
    sort(s->row + begin, count - begin);
    if (count > begin) {
      const int parent = s->row[begin];
      g->sibling[p] = g->child[parent];
      g->child[parent] = p;
    }
  }
  return BASE_OK;
}

/* Where the numbers of each block stand. */
static base_status place_values(lin_blocks *s, base_error *err) {
  size_t low = 0, diag = 0;
  const size_t below = (size_t)s->column[s->n];
  size_t *at = realloc(s->at, (below + 1) * sizeof *at);
  if (at == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a factor of %zu blocks", below);
  }
  s->at = at;
  for (int p = 0; p < s->n; p++) {
    const size_t n = (size_t)rows(s, p);
    s->at_diag[p] = diag;
    diag += n * n;
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      s->at[k] = low;
      low += n * (size_t)rows(s, s->row[k]);
    }
  }
  s->at_diag[s->n] = diag;
  if (s->value_mem == NULL || low > s->cap_low || diag > s->cap_diag) {
    s->cap_low = low + low / 2;
    s->cap_diag = diag + diag / 2;
    free(s->inverse_mem);
    s->inverse_mem = NULL;
    BASE_TRY(memory(s, &s->value_mem, layout_values, err));
  }
  return BASE_OK;
}

static base_status analyse(lin_blocks *s, graph *g, base_error *err) {
  neighbours(s, g->start, g->near, g->mark);
  const int done = (s->n > 0) ? amd_order(s->n, g->start, g->near, s->order, NULL, NULL) : AMD_OK;
  if (done != AMD_OK) {
    return BASE_FAIL(err, BASE_ENOMEM, "AMD status %d on %d blocks", done, s->n);
  }
  for (int p = 0; p < s->n; p++) {
    s->place[s->order[p]] = p;
  }
  s->column[0] = 0;
  s->analyses++;
  BASE_TRY(find_fill(s, g, err));
  return place_values(s, err);
}

base_status lin_blocks_plan(lin_blocks *s, int n, const int *first, const int *pair, size_t n_pair,
                            base_error *err) {
  if (is_planned(s, n, first, pair, n_pair)) {
    return BASE_OK;
  }
  BASE_TRY(keep_pattern(s, n, first, pair, n_pair, err));
  graph g;
  base_arena measure = base_arena_measuring();
  layout_graph(&g, (size_t)n, n_pair, &measure);
  void *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (mem == NULL) {
    s->n_pair = SIZE_MAX; /* no pattern */
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to order %d blocks", n);
  }
  base_arena real = base_arena_over(mem, measure.used);
  layout_graph(&g, (size_t)n, n_pair, &real);
  const base_status done = analyse(s, &g, err);
  free(mem);
  if (done != BASE_OK) {
    s->n_pair = SIZE_MAX;
  }
  return done;
}

void lin_blocks_clear(lin_blocks *s, bool symmetric) {
  const int n = s->n;
  const size_t low = (s->column[n] > 0) ? s->at[s->column[n] - 1] : 0;
  const size_t last = (s->column[n] > 0) ? (size_t)LIN_BLOCK_MAX * LIN_BLOCK_MAX : 0;
  const size_t count = (low + last < s->cap_low) ? low + last : s->cap_low;
  s->symmetric = symmetric;
  memset(s->diag, 0, s->at_diag[n] * sizeof *s->diag);
  memset(s->low, 0, count * sizeof *s->low);
  if (!symmetric) {
    memset(s->up, 0, count * sizeof *s->up);
  }
}

/* Where block row i of column j < i stands, by places. */
static int find(const lin_blocks *s, int i, int j) {
  int low = s->column[j], high = s->column[j + 1] - 1;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (s->row[mid] < i) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  assert(s->row[low] == i);
  return low;
}

void lin_blocks_add(lin_blocks *s, int a, int b, const double *B) {
  const int i = s->place[a], j = s->place[b], m = rows(s, i), n = rows(s, j);
  if (i < j) { /* above: kept transposed, as B stands */
    double *to = s->up + (s->symmetric ? 0 : s->at[find(s, j, i)]);
    for (int k = 0; !s->symmetric && k < m * n; k++) {
      to[k] += B[k];
    }
    return;
  }
  double *to = (i == j) ? s->diag + s->at_diag[i] : s->low + s->at[find(s, i, j)];
  for (int r = 0; r < m; r++) {
    for (int c = 0; c < n; c++) {
      to[r + c * m] += B[r * n + c];
    }
  }
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Smallest and largest pivot so far. */
typedef struct span {
  double low, high;
} span;

/* A = L L' in the lower triangle. */
static bool cholesky(int n, double *A, span *pivots) {
  for (int k = 0; k < n; k++) {
    double pivot = A[k + k * n];
    for (int j = 0; j < k; j++) {
      pivot -= A[k + j * n] * A[k + j * n];
    }
    if (!(pivot > 0)) {
      return false;
    }
    pivots->low = fmin(pivots->low, pivot);
    pivots->high = fmax(pivots->high, pivot);
    const double root = sqrt(pivot);
    A[k + k * n] = root;
    for (int i = k + 1; i < n; i++) {
      double v = A[i + k * n];
      for (int j = 0; j < k; j++) {
        v -= A[i + j * n] * A[k + j * n];
      }
      A[i + k * n] = v / root;
    }
  }
  return true;
}

/* P A = L U in place, L with a unit diagonal; swap[k]: row exchanged with row k. */
static bool lu(int n, double *A, int *swap, span *pivots) {
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++) {
      p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
    }
    swap[k] = p;
    for (int j = 0; j < n && p != k; j++) {
      const double x = A[p + j * n];
      A[p + j * n] = A[k + j * n];
      A[k + j * n] = x;
    }
    const double pivot = A[k + k * n];
    if (!(fabs(pivot) > 0)) {
      return false;
    }
    pivots->low = fmin(pivots->low, fabs(pivot));
    pivots->high = fmax(pivots->high, fabs(pivot));
    for (int i = k + 1; i < n; i++) {
      A[i + k * n] /= pivot;
    }
    for (int j = k + 1; j < n; j++) {
      for (int i = k + 1; i < n; i++) {
        A[i + j * n] -= A[i + k * n] * A[k + j * n];
      }
    }
  }
  return true;
}

/* X <- X T^-1 for X of m rows, column after column: T upper triangular is T(d, c) = t[d * across + c * down]. */
static void divide(int m, int n, const double *t, int across, int down, bool unit, double *X) {
  for (int c = 0; c < n; c++) {
    double *x = X + c * m;
    for (int d = 0; d < c; d++) {
      const double f = t[d * across + c * down];
      for (int r = 0; r < m && f != 0; r++) {
        x[r] -= X[r + d * m] * f;
      }
    }
    for (int r = 0; r < m && !unit; r++) {
      x[r] /= t[c * across + c * down];
    }
  }
}

/* C -= X Y', C m x n, X m x k, Y n x k, all by columns. */
static inline void subtract_of(double *restrict C, const double *restrict X,
                               const double *restrict Y, int m, int n, int k) {
  for (int j = 0; j < n; j++) {
    for (int c = 0; c < k; c++) {
      const double f = Y[j + c * n];
      for (int i = 0; i < m; i++) {
        C[i + j * m] -= X[i + c * m] * f;
      }
    }
  }
}

BASE_CLONES static void subtract(double *C, const double *X, const double *Y, int m, int n, int k) {
  if (m == 6 && n == 6 && k == 6) {
    subtract_of(C, X, Y, 6, 6, 6);
  } else if (m == 3 && n == 3 && k == 3) {
    subtract_of(C, X, Y, 3, 3, 3);
  } else {
    subtract_of(C, X, Y, m, n, k);
  }
}

static void swap_columns(int m, int n, const int *swap, double *X) {
  for (int k = 0; k < n; k++) {
    for (int r = 0; r < m && swap[k] != k; r++) {
      const double x = X[r + k * m];
      X[r + k * m] = X[r + swap[k] * m];
      X[r + swap[k] * m] = x;
    }
  }
}

/* Factors the diagonal block of column p and divides the blocks below and right of it. */
static bool pivot_on(lin_blocks *s, int p, span *pivots) {
  const int n = rows(s, p);
  double *D = s->diag + s->at_diag[p];
  int *swap = s->swap + s->first[s->order[p]];
  if (!(s->symmetric ? cholesky(n, D, pivots) : lu(n, D, swap, pivots))) {
    return false;
  }
  for (int k = s->column[p]; k < s->column[p + 1]; k++) {
    const int m = rows(s, s->row[k]);
    if (s->symmetric) {
      divide(m, n, D, n, 1, false, s->low + s->at[k]); /* by L', L'(d, c) = L(c, d) */
      continue;
    }
    divide(m, n, D, 1, n, false, s->low + s->at[k]); /* by U */
    swap_columns(m, n, swap, s->up + s->at[k]);
    divide(m, n, D, n, 1, true, s->up + s->at[k]); /* by L' */
  }
  return true;
}

/* Takes column p out of the blocks that its rows span. */
static void update(lin_blocks *s, int p) {
  const int n = rows(s, p);
  for (int k = s->column[p]; k < s->column[p + 1]; k++) {
    const int j = s->row[k], width = rows(s, j);
    const double *left = s->low + s->at[k];
    const double *right = s->symmetric ? left : s->up + s->at[k];
    subtract(s->diag + s->at_diag[j], left, right, width, width, n);
    int to = s->column[j];
    for (int m = k + 1; m < s->column[p + 1]; m++) {
      const int height = rows(s, s->row[m]);
      while (s->row[to] < s->row[m]) {
        to++;
      }
      subtract(s->low + s->at[to], s->low + s->at[m], right, height, width, n);
      if (!s->symmetric) {
        subtract(s->up + s->at[to], s->up + s->at[m], left, height, width, n);
      }
    }
  }
}

bool lin_blocks_factor(lin_blocks *s) {
  span pivots = {HUGE_VAL, 0};
  for (int p = 0; p < s->n; p++) {
    if (!pivot_on(s, p, &pivots)) {
      return false;
    }
    update(s, p);
  }
  return s->n == 0 || !(pivots.low <= singular * pivots.high);
}

/* x <- the solution with the first factor of a diagonal block. */
static void forward(const lin_blocks *s, int n, const double *D, const int *swap, double *x) {
  for (int k = 0; k < n; k++) {
    if (!s->symmetric && swap[k] != k) {
      const double t = x[k];
      x[k] = x[swap[k]];
      x[swap[k]] = t;
    }
  }
  for (int k = 0; k < n; k++) {
    x[k] /= s->symmetric ? D[k + k * n] : 1.0;
    for (int i = k + 1; i < n; i++) {
      x[i] -= D[i + k * n] * x[k];
    }
  }
}

static void backward(const lin_blocks *s, int n, const double *D, double *x) {
  for (int k = n - 1; k >= 0; k--) {
    for (int i = k + 1; i < n; i++) {
      x[k] -= (s->symmetric ? D[i + k * n] : D[k + i * n]) * x[i];
    }
    x[k] /= D[k + k * n];
  }
}

/* Rows stay where the caller has them: block p works on its own part of x. */
void lin_blocks_solve(const lin_blocks *s, double *x) {
  for (int p = 0; p < s->n; p++) {
    const int at = s->first[s->order[p]], n = rows(s, p);
    forward(s, n, s->diag + s->at_diag[p], s->swap + at, x + at);
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      const int m = rows(s, s->row[k]);
      double *to = x + s->first[s->order[s->row[k]]];
      const double *L = s->low + s->at[k];
      for (int c = 0; c < n; c++) {
        for (int r = 0; r < m; r++) {
          to[r] -= L[r + c * m] * x[at + c];
        }
      }
    }
  }
  for (int p = s->n - 1; p >= 0; p--) {
    const int at = s->first[s->order[p]], n = rows(s, p);
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      const int m = rows(s, s->row[k]);
      const double *from = x + s->first[s->order[s->row[k]]];
      const double *U = (s->symmetric ? s->low : s->up) + s->at[k];
      for (int c = 0; c < n; c++) {
        double sum = 0;
        for (int r = 0; r < m; r++) {
          sum += U[r + c * m] * from[r];
        }
        x[at + c] -= sum;
      }
    }
    backward(s, n, s->diag + s->at_diag[p], x + at);
  }
}

/* ---- parts of the inverse -------------------------------------------------------------------- */

/* X <- X L^-1 for X of m rows, L lower triangular. */
static void divide_lower(int m, int n, const double *L, double *X) {
  for (int c = n - 1; c >= 0; c--) {
    double *x = X + c * m;
    for (int d = c + 1; d < n; d++) {
      const double f = L[d + c * n];
      for (int r = 0; r < m && f != 0; r++) {
        x[r] -= X[r + d * m] * f;
      }
    }
    for (int r = 0; r < m; r++) {
      x[r] /= L[c + c * n];
    }
  }
}

/* to = X', X m x n, by columns. */
static const double *transpose(int m, int n, const double *X, double *to) {
  for (int c = 0; c < n; c++) {
    for (int r = 0; r < m; r++) {
      to[c + r * n] = X[r + c * m];
    }
  }
  return to;
}

/* Blocks of the inverse in column p below the diagonal: -Z V, V = L_Rp L_pp^-1; `own`: room for V', in the order of the
 * column. */
static void invert_below(lin_blocks *s, int p, double *own) {
  const int n = rows(s, p), begin = s->column[p], end = s->column[p + 1];
  double turned[LIN_BLOCK_MAX * LIN_BLOCK_MAX];
  const size_t first = (begin < end) ? s->at[begin] : 0;
  for (int k = begin; k < end; k++) {
    const int m = rows(s, s->row[k]);
    double *V = s->inverse_low + s->at[k];
    memcpy(V, s->low + s->at[k], (size_t)(m * n) * sizeof *V);
    divide_lower(m, n, s->diag + s->at_diag[p], V);
    (void)transpose(m, n, V, own + (s->at[k] - first));
    memset(V, 0, (size_t)(m * n) * sizeof *V);
  }
  for (int k = begin; k < end; k++) {
    const int i = s->row[k], height = rows(s, i);
    const double *V = own + (s->at[k] - first);
    double *to = s->inverse_low + s->at[k];
    subtract(to, s->inverse_diag + s->at_diag[i], V, height, n, height);
    int from = s->column[i];
    for (int m = k + 1; m < end; m++) { /* Z of the later block j and this one: both ways */
      const int j = s->row[m], wide = rows(s, j);
      while (s->row[from] < j) {
        from++;
      }
      const double *Z = s->inverse_low + s->at[from];
      subtract(to, transpose(wide, height, Z, turned), own + (s->at[m] - first), height, n, wide);
      subtract(s->inverse_low + s->at[m], Z, V, wide, n, height);
    }
  }
  for (int k = begin; k < end; k++) {
    const int m = rows(s, s->row[k]);
    subtract(s->inverse_diag + s->at_diag[p], own + (s->at[k] - first),
             transpose(m, n, s->inverse_low + s->at[k], turned), n, n, m);
  }
}

base_status lin_blocks_invert(lin_blocks *s, base_error *err) {
  assert(s->symmetric);
  if (s->inverse_mem == NULL) {
    BASE_TRY(memory(s, &s->inverse_mem, layout_inverse, err));
  }
  for (int p = s->n - 1; p >= 0; p--) {
    const int n = rows(s, p);
    const double *L = s->diag + s->at_diag[p];
    double *Z = s->inverse_diag + s->at_diag[p], half[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    for (int k = 0; k < n; k++) {
      half[k + k * n] = 1;
    }
    divide_lower(n, n, L, half); /* L^-1 */
    memset(Z, 0, (size_t)(n * n) * sizeof *Z);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        for (int k = (i > j) ? i : j; k < n; k++) {
          Z[i + j * n] += half[k + i * n] * half[k + j * n];
        }
      }
    }
    invert_below(s, p, s->up); /* free while the matrix is symmetric */
  }
  return BASE_OK;
}

double lin_blocks_inverse_form(const lin_blocks *s, int a, const double *x, int b,
                               const double *y) {
  const bool later = s->place[a] > s->place[b];
  const int i = s->place[later ? a : b], j = s->place[later ? b : a];
  const double *left = later ? x : y, *right = later ? y : x;
  const double *Z =
      (i == j) ? s->inverse_diag + s->at_diag[i] : s->inverse_low + s->at[find(s, i, j)];
  const int m = rows(s, i), n = rows(s, j);
  double sum = 0;
  for (int c = 0; c < n; c++) {
    for (int r = 0; r < m; r++) {
      sum += left[r] * Z[r + c * m] * right[c];
    }
  }
  return sum;
}
