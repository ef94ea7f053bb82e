/* blocks_fronts.c - factors by dense matrices, for graphs whose factor is wide.
 *
 * Columns that follow one another with the same blocks below, but for themselves, are a front: one dense matrix of their
 * blocks, what is below and right of them, and what the fronts below have left there. Its columns are eliminated by products of dense
 * matrices, and what is left of the rest is handed on (Duff & Reid 1983, Liu 1992). The factor goes to where blocks.c has it. */
#include "lcp/linear/blocks_inside.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  PANEL = 8,     /* blocks that are eliminated before the rest of a front follows */
  WIDEST = 30000 /* rows of a front: 7 GB */
};

/* A front while it is factored. */
typedef struct front {
  double *F;       /* size x size, column-major; symmetric: its lower triangle */
  int first, last; /* places of its columns */
  int wide, size;  /* rows of these; of the whole */
} front;

/* ---- plan ------------------------------------------------------------------------------------ */

static int parent_of(const lin_blocks *s, int p) {
  return (s->column[p + 1] > s->column[p]) ? s->row[s->column[p]] : -1;
}

static bool continues(const lin_blocks *s, int p) {
  return parent_of(s, p) == p + 1 &&
         s->column[p + 2] - s->column[p + 1] == s->column[p + 1] - s->column[p] - 1;
}

static size_t rows_below(const lin_blocks *s, int p) {
  size_t sum = 0;
  for (int k = s->column[p]; k < s->column[p + 1]; k++) {
    sum += (size_t)lin_blocks_rows(s, s->row[k]);
  }
  return sum;
}

/* Fronts, and where each leaves its rest: on a stack, from which the front that follows takes those of its own. False: the
 * order is not one in which that can be done. */
static bool find_fronts(lin_blocks *s, size_t *stack, size_t *widest) {
  size_t top = 0;
  int waiting = 0; /* rests on the stack */
  s->n_front = 0;
  *stack = *widest = 0;
  for (int p = 0; p < s->n;) {
    lin_front_plan *f = &s->front[s->n_front];
    size_t wide = (size_t)lin_blocks_rows(s, p);
    int q = p;
    while (q + 1 < s->n && continues(s, q)) {
      wide += (size_t)lin_blocks_rows(s, ++q);
    }
    const size_t left = rows_below(s, q);
    *f = (lin_front_plan){.first = p, .parent = parent_of(s, q)};
    while (waiting > 0 && s->front[s->pending[waiting - 1]].parent <= q) {
      if (s->front[s->pending[waiting - 1]].parent < p) {
        return false;
      }
      top = s->front[s->pending[--waiting]].at;
      f->children++;
    }
    f->at = top;
    if (f->parent >= 0) {
      top += left * left;
      s->pending[waiting++] = s->n_front;
    }
    *stack = (top > *stack) ? top : *stack;
    *widest = (wide + left > *widest) ? wide + left : *widest;
    s->n_front++;
    p = q + 1;
  }
  return waiting == 0;
}

static void layout_plan(lin_blocks *s, base_arena *a) {
  s->front = BASE_ARRAY(a, lin_front_plan, s->cap_n + 1);
  s->pending = BASE_ARRAY(a, int, s->cap_n);
  s->offset = BASE_ARRAY(a, int, s->cap_n);
}

static void layout_numbers(lin_blocks *s, base_arena *a) {
  s->rest = BASE_ARRAY(a, double, s->cap_rest);
  s->dense = BASE_ARRAY(a, double, s->cap_dense);
}

base_status lin_blocks_plan_fronts(lin_blocks *s, base_error *err) {
  size_t stack, widest;
  BASE_TRY(lin_blocks_memory(s, &s->front_mem, layout_plan, err));
  if (!find_fronts(s, &stack, &widest) || widest > WIDEST) {
    s->n_front = 0;
    return BASE_OK;
  }
  s->front[s->n_front].first = s->n;
  if (s->dense_mem == NULL || stack > s->cap_rest || widest * widest > s->cap_dense) {
    s->cap_rest = stack;
    s->cap_dense = widest * widest;
    return lin_blocks_memory(s, &s->dense_mem, layout_numbers, err);
  }
  return BASE_OK;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Where each place stands in the front; returns how many rows there are. */
static int set_offsets(lin_blocks *s, const front *f) {
  int at = 0;
  for (int p = f->first; p <= f->last; p++) {
    s->offset[p] = at;
    at += lin_blocks_rows(s, p);
  }
  for (int k = s->column[f->last]; k < s->column[f->last + 1]; k++) {
    s->offset[s->row[k]] = at;
    at += lin_blocks_rows(s, s->row[k]);
  }
  return at;
}

static double *entry(const front *f, int i, int j) {
  return f->F + (size_t)j * (size_t)f->size + i;
}

/* n numbers from the front, or into it. */
static void carry(double *wide, double *block, int n, bool out) {
  memcpy(out ? block : wide, out ? wide : block, (size_t)n * sizeof *block);
}

/* Block k below the diagonal block of place p, and the one right of it, which stands transposed. */
static void exchange_block(lin_blocks *s, const front *f, int p, int k, bool out) {
  const int n = lin_blocks_rows(s, p), m = lin_blocks_rows(s, s->row[k]);
  const int o = s->offset[p], i = s->offset[s->row[k]];
  double *low = s->low + s->at[k], *up = s->up + s->at[k];
  for (int c = 0; c < n; c++) {
    carry(entry(f, i, o + c), low + c * m, m, out);
  }
  for (int r = 0; r < m && !s->symmetric; r++) {
    for (int c = 0; c < n; c++) {
      carry(entry(f, o + c, i + r), up + r + c * m, 1, out);
    }
  }
}

/* The blocks of its columns: between where blocks.c has them and the front. */
static void exchange(lin_blocks *s, const front *f, bool out) {
  for (int p = f->first; p <= f->last; p++) {
    const int n = lin_blocks_rows(s, p), o = s->offset[p];
    for (int c = 0; c < n; c++) {
      carry(entry(f, o, o + c), s->diag + s->at_diag[p] + c * n, n, out);
    }
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      exchange_block(s, f, p, k, out);
    }
  }
}

/* Adds what the front of `child` has left. */
static void take_in(lin_blocks *s, const front *f, int child) {
  const int last = s->front[child + 1].first - 1;
  const int *row = s->row + s->column[last], count = s->column[last + 1] - s->column[last];
  const double *C = s->rest + s->front[child].at;
  const size_t left = rows_below(s, last);
  for (int j = 0; j < count; j++) {
    const int wide = lin_blocks_rows(s, row[j]);
    for (int c = 0; c < wide; c++, C += left) {
      double *to = f->F + (size_t)(s->offset[row[j]] + c) * (size_t)f->size;
      const double *from = C;
      for (int i = 0; i < count; i++) {
        const int high = lin_blocks_rows(s, row[i]);
        double *block = to + s->offset[row[i]];
        for (int r = 0; r < high && !(s->symmetric && i < j); r++) {
          block[r] += from[r];
        }
        from += high;
      }
    }
  }
}

/* C -= A B, or A B': parts of the front from (i, j), m x n, over k. */
static void subtract(const front *f, int i, int j, int m, int n, int from, int k, bool symmetric) {
  if (m > 0 && n > 0 && k > 0) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, symmetric ? CblasTrans : CblasNoTrans, m, n, k, -1.0,
                entry(f, i, from), f->size, symmetric ? entry(f, j, from) : entry(f, from, j),
                f->size, 1.0, entry(f, i, j), f->size);
  }
}

/* The diagonal block of place p, and the blocks below it. */
static bool pivot_column(lin_blocks *s, const front *f, int p, lin_span *pivots) {
  const int n = lin_blocks_rows(s, p), o = s->offset[p], below = f->size - o - n;
  double D[LIN_BLOCK_MAX * LIN_BLOCK_MAX];
  for (int c = 0; c < n; c++) {
    memcpy(D + c * n, entry(f, o, o + c), (size_t)n * sizeof *D);
  }
  if (!lin_blocks_pivot(s, n, D, s->swap + s->first[s->order[p]], pivots)) {
    return false;
  }
  for (int c = 0; c < n; c++) {
    memcpy(entry(f, o, o + c), D + c * n, (size_t)n * sizeof *D);
  }
  if (below > 0 && n > 0) {
    cblas_dtrsm(CblasColMajor, CblasRight, s->symmetric ? CblasLower : CblasUpper,
                s->symmetric ? CblasTrans : CblasNoTrans, CblasNonUnit, below, n, 1.0, D, n,
                entry(f, o + n, o), f->size);
  }
  return true;
}

/* The blocks right of place p in columns from .. from+count-1: exchanged, and divided by L. */
static void pivot_row(const lin_blocks *s, const front *f, int p, int from, int count) {
  const int n = lin_blocks_rows(s, p), o = s->offset[p];
  const int *swap = s->swap + s->first[s->order[p]];
  if (count <= 0 || n == 0) {
    return;
  }
  for (int k = 0; k < n; k++) {
    if (swap[k] != k) {
      cblas_dswap(count, entry(f, o + k, from), f->size, entry(f, o + swap[k], from), f->size);
    }
  }
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasUnit, n, count, 1.0,
              entry(f, o, o), f->size, entry(f, o, from), f->size);
}

/* Eliminates places p .. q-1. */
static bool eliminate_panel(lin_blocks *s, const front *f, int p, int q, lin_span *pivots) {
  const int begin = s->offset[p];
  const int end = s->offset[q - 1] + lin_blocks_rows(s, q - 1), after = f->size - end;
  for (int k = p; k < q; k++) {
    const int o = s->offset[k], next = o + lin_blocks_rows(s, k);
    if (!pivot_column(s, f, k, pivots)) {
      return false;
    }
    if (!s->symmetric) {
      pivot_row(s, f, k, next, end - next);
    }
    subtract(f, next, next, f->size - next, end - next, o, next - o, s->symmetric);
  }
  if (s->symmetric) {
    if (after > 0 && end > begin) {
      cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, after, end - begin, -1.0,
                  entry(f, end, begin), f->size, 1.0, entry(f, end, end), f->size);
    }
    return true;
  }
  for (int k = p; k < q; k++) {
    const int o = s->offset[k];
    subtract(f, o, end, lin_blocks_rows(s, k), after, begin, o - begin, false);
    pivot_row(s, f, k, end, after);
  }
  subtract(f, end, end, after, after, begin, end - begin, false);
  return true;
}

static void leave_rest(const front *f, double *C) {
  const size_t left = (size_t)(f->size - f->wide);
  for (size_t j = 0; j < left; j++) {
    memmove(C + j * left, entry(f, f->wide, f->wide + (int)j), left * sizeof *C);
  }
}

bool lin_blocks_factor_fronts(lin_blocks *s, lin_span *pivots) {
  int waiting = 0;
  for (int k = 0; k < s->n_front; k++) {
    const lin_front_plan *plan = &s->front[k];
    front f = {.F = s->dense, .first = plan->first, .last = s->front[k + 1].first - 1};
    f.size = set_offsets(s, &f);
    f.wide = f.size - (int)rows_below(s, f.last);
    memset(f.F, 0, (size_t)f.size * (size_t)f.size * sizeof *f.F);
    exchange(s, &f, false);
    for (int c = 0; c < plan->children; c++) {
      take_in(s, &f, s->pending[--waiting]);
    }
    for (int p = f.first; p <= f.last; p += PANEL) {
      const int q = (p + PANEL <= f.last + 1) ? p + PANEL : f.last + 1;
      if (!eliminate_panel(s, &f, p, q, pivots)) {
        return false;
      }
    }
    exchange(s, &f, true);
    if (plan->parent >= 0) {
      leave_rest(&f, s->rest + plan->at);
      s->pending[waiting++] = k;
    }
  }
  return true;
}
