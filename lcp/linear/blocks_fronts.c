/* blocks_fronts.c - factors by dense matrices, for graphs whose factor is wide.
 *
 * Columns that follow one another with the same blocks below, but for themselves, are a front: one dense matrix of their
 * blocks, what is below and right of them, and what the fronts below have left there. Its columns are eliminated by products of dense
 * matrices, and what is left of the rest is handed on (Duff & Reid 1983, Liu 1992). The factor goes to where blocks.c has it.
 *
 * Limbs of the forest of fronts (blocks_fronts_plan.c) are shared out to the crew whole; of the fronts above them, which are few and
 * wide, the columns are, in strips that do not depend on who takes them. */
#include "lcp/base/crew.h"
#include "lcp/linear/blocks_inside.h"

#include <cblas.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
  PANEL = 8,   /* blocks that are eliminated before the rest of a front follows */
  STRIP = 192, /* columns of the rest that follow in one part */
  CARRIED = 32 /* blocks that are moved in one part */
};

/* A front while it is factored. */
typedef struct front {
  lin_blocks *s;
  int *offset;     /* of a place */
  double *F;       /* size x size, column-major; symmetric: its lower triangle */
  int first, last; /* places of its columns */
  int wide, size;  /* rows of these; of the whole */
  size_t at;       /* of its rest on the stack */
} front;

/* Where each place stands in the front; returns how many rows there are. */
static int set_offsets(const front *f) {
  const lin_blocks *s = f->s;
  int at = 0;
  for (int p = f->first; p <= f->last; p++) {
    f->offset[p] = at;
    at += lin_blocks_rows(s, p);
  }
  for (int k = s->column[f->last]; k < s->column[f->last + 1]; k++) {
    f->offset[s->row[k]] = at;
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
static void exchange_block(const front *f, int p, int k, bool out) {
  const lin_blocks *s = f->s;
  const int n = lin_blocks_rows(s, p), m = lin_blocks_rows(s, s->row[k]);
  const int o = f->offset[p], i = f->offset[s->row[k]];
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
static void exchange(const front *f, int part, bool out) {
  const lin_blocks *s = f->s;
  const int end = f->first + base_part_end(part, f->last + 1 - f->first, CARRIED);
  for (int p = f->first + part * CARRIED; p < end; p++) {
    const int n = lin_blocks_rows(s, p), o = f->offset[p];
    for (int c = 0; c < n; c++) {
      carry(entry(f, o, o + c), s->diag + s->at_diag[p] + c * n, n, out);
    }
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      exchange_block(f, p, k, out);
    }
  }
}

static void carry_in(void *of, int part, int hand) {
  (void)hand;
  exchange(of, part, false);
}

static void carry_out(void *of, int part, int hand) {
  (void)hand;
  exchange(of, part, true);
}

static void clear(void *of, int part, int hand) {
  const front *f = of;
  const int begin = part * STRIP, end = base_part_end(part, f->size, STRIP);
  (void)hand;
  memset(entry(f, 0, begin), 0, (size_t)(end - begin) * (size_t)f->size * sizeof *f->F);
}

/* What the front of a child has left, rows by blocks below its last column. */
typedef struct handed {
  const front *to;
  const int *row; /* count */
  int count;
  size_t left; /* rows */
  const double *C;
} handed;

static void take_blocks(void *of, int part, int hand) {
  const handed *h = of;
  const front *f = h->to;
  const lin_blocks *s = f->s;
  const int end = base_part_end(part, h->count, CARRIED);
  const double *C = h->C;
  (void)hand;
  for (int j = 0; j < end; j++) {
    const int wide = lin_blocks_rows(s, h->row[j]);
    if (j < part * CARRIED) {
      C += (size_t)wide * h->left;
      continue;
    }
    for (int c = 0; c < wide; c++, C += h->left) {
      double *to = f->F + (size_t)(f->offset[h->row[j]] + c) * (size_t)f->size;
      const double *from = C;
      for (int i = 0; i < h->count; i++) {
        const int high = lin_blocks_rows(s, h->row[i]);
        double *block = to + f->offset[h->row[i]];
        for (int r = 0; r < high && !(s->symmetric && i < j); r++) {
          block[r] += from[r];
        }
        from += high;
      }
    }
  }
}

/* Adds what the front of `child` has left. */
static void take_in(const front *f, int child) {
  const lin_blocks *s = f->s;
  const int last = s->front[child + 1].first - 1;
  handed h = {.to = f,
              .row = s->row + s->column[last],
              .count = s->column[last + 1] - s->column[last],
              .left = lin_blocks_rows_below(s, last),
              .C = s->rest + s->front[child].at};
  base_share(base_parts(h.count, CARRIED), take_blocks, &h);
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
static bool pivot_column(const front *f, int p, lin_span *pivots) {
  const lin_blocks *s = f->s;
  const int n = lin_blocks_rows(s, p), o = f->offset[p], below = f->size - o - n;
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
static void pivot_row(const front *f, int p, int from, int count) {
  const lin_blocks *s = f->s;
  const int n = lin_blocks_rows(s, p), o = f->offset[p];
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

/* Places p .. q-1 while they are eliminated. */
typedef struct panel {
  const front *f;
  int p, q, begin, end; /* rows begin .. end-1 */
} panel;

/* Columns of the rest from `from` on. */
static void follow(void *of, int part, int hand) {
  const panel *e = of;
  const front *f = e->f;
  const int from = e->end + part * STRIP, wide = e->end - e->begin;
  const int count = base_part_end(part, f->size - e->end, STRIP) - part * STRIP,
            below = from + count;
  (void)hand;
  if (f->s->symmetric) {
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, count, wide, -1.0,
                entry(f, from, e->begin), f->size, 1.0, entry(f, from, from), f->size);
    subtract(f, below, from, f->size - below, count, e->begin, wide, true);
    return;
  }
  for (int k = e->p; k < e->q; k++) {
    const int o = f->offset[k];
    subtract(f, o, from, lin_blocks_rows(f->s, k), count, e->begin, o - e->begin, false);
    pivot_row(f, k, from, count);
  }
  subtract(f, e->end, from, f->size - e->end, count, e->begin, wide, false);
}

/* Eliminates places p .. q-1. */
static bool eliminate_panel(const front *f, int p, int q, lin_span *pivots) {
  const lin_blocks *s = f->s;
  const int begin = f->offset[p];
  const int end = f->offset[q - 1] + lin_blocks_rows(s, q - 1);
  for (int k = p; k < q; k++) {
    const int o = f->offset[k], next = o + lin_blocks_rows(s, k);
    if (!pivot_column(f, k, pivots)) {
      return false;
    }
    if (!s->symmetric) {
      pivot_row(f, k, next, end - next);
    }
    subtract(f, next, next, f->size - next, end - next, o, next - o, s->symmetric);
  }
  panel e = {f, p, q, begin, end};
  base_share((end > begin) ? base_parts(f->size - end, STRIP) : 0, follow, &e);
  return true;
}

static void leave_columns(void *of, int part, int hand) {
  const front *f = of;
  const size_t left = (size_t)(f->size - f->wide);
  const int end = base_part_end(part, f->size - f->wide, STRIP);
  double *C = f->s->rest + f->at;
  (void)hand;
  for (int j = part * STRIP; j < end; j++) {
    memmove(C + (size_t)j * left, entry(f, f->wide, f->wide + j), left * sizeof *C);
  }
}

static bool factor_front(lin_blocks *s, int k, int hand, lin_span *pivots) {
  const lin_front_plan *plan = &s->front[k];
  front f = {.s = s,
             .offset = s->offset + (size_t)hand * (size_t)s->n,
             .F = s->dense + (size_t)hand * s->apart,
             .at = plan->at,
             .first = plan->first,
             .last = s->front[k + 1].first - 1};
  f.size = set_offsets(&f);
  f.wide = f.size - (int)lin_blocks_rows_below(s, f.last);
  base_share(base_parts(f.size, STRIP), clear, &f);
  base_share(base_parts(f.last + 1 - f.first, CARRIED), carry_in, &f);
  for (int c = plan->child; c >= 0; c = s->front[c].sibling) {
    take_in(&f, c);
  }
  for (int p = f.first; p <= f.last; p += PANEL) {
    const int q = (p + PANEL <= f.last + 1) ? p + PANEL : f.last + 1;
    if (!eliminate_panel(&f, p, q, pivots)) {
      return false;
    }
  }
  base_share(base_parts(f.last + 1 - f.first, CARRIED), carry_out, &f);
  if (plan->parent >= 0) {
    base_share(base_parts(f.size - f.wide, STRIP), leave_columns, &f);
  }
  return true;
}

/* ---- limbs, and what is above them ------------------------------------------------------------- */

typedef struct limbs {
  lin_blocks *s;
  lin_span pivots[BASE_THREADS_MAX]; /* of each hand */
  atomic_bool failed;
} limbs;

static void factor_limb(void *of, int part, int hand) {
  limbs *l = of;
  const lin_limb *limb = &l->s->limb[part];
  for (int k = limb->first; k < limb->end; k++) {
    if (!factor_front(l->s, k, hand, &l->pivots[hand])) {
      atomic_store(&l->failed, true);
      return;
    }
  }
}

/* By no more hands than it was planned for. */
static bool factor_limbs(lin_blocks *s, lin_span *pivots) {
  limbs l = {.s = s};
  for (int h = 0; h < s->hands; h++) {
    l.pivots[h] = *pivots;
  }
  if (base_crew_size() <= s->hands) {
    base_share(s->n_limb, factor_limb, &l);
  } else {
    base_crew *crew = base_crew_take_up(NULL);
    base_share(s->n_limb, factor_limb, &l);
    (void)base_crew_take_up(crew);
  }
  for (int h = 0; h < s->hands; h++) {
    pivots->low = fmin(pivots->low, l.pivots[h].low);
    pivots->high = fmax(pivots->high, l.pivots[h].high);
  }
  return !atomic_load(&l.failed);
}

bool lin_blocks_factor_fronts(lin_blocks *s, lin_span *pivots) {
  if (s->n_limb > 0 && !factor_limbs(s, pivots)) {
    return false;
  }
  for (int k = 0; k < s->n_front; k++) {
    if (lin_blocks_is_above(s, k) && !factor_front(s, k, 0, pivots)) {
      return false;
    }
  }
  return true;
}
