#include "problems/broad_phase.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

void broad_close(broad_phase *bp) {
  free(bp->ball);
  free(bp->pair);
  free(bp->head);
  free(bp->next);
  free(bp->cell);
  free(bp->large);
  *bp = (broad_phase){0};
}

static base_status resize(void **p, size_t bytes, base_error *err) {
  void *q = realloc(*p, bytes);
  if (q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "broad phase: no memory for %zu bytes", bytes);
  }
  *p = q;
  return BASE_OK;
}

base_status broad_reserve(broad_phase *bp, int n, base_error *err) {
  bp->n = n;
  if (n <= bp->cap) {
    return BASE_OK;
  }
  const size_t m = (size_t)n;
  int buckets = 16;
  while (buckets < 2 * n) {
    buckets *= 2;
  }
  BASE_TRY(resize((void **)&bp->ball, m * sizeof *bp->ball, err));
  BASE_TRY(resize((void **)&bp->head, (size_t)buckets * sizeof *bp->head, err));
  BASE_TRY(resize((void **)&bp->next, m * sizeof *bp->next, err));
  BASE_TRY(resize((void **)&bp->cell, 3 * m * sizeof *bp->cell, err));
  BASE_TRY(resize((void **)&bp->large, m * sizeof *bp->large, err));
  bp->cap_bucket = buckets;
  bp->cap = n;
  return BASE_OK;
}

static base_status test_pair(broad_phase *bp, int i, int j, base_error *err) {
  const broad_ball *a = &bp->ball[i], *b = &bp->ball[j];
  const double reach = a->r + b->r;
  const double d[3] = {a->x[0] - b->x[0], a->x[1] - b->x[1], a->x[2] - b->x[2]};
  if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > reach * reach) {
    return BASE_OK;
  }
  if (bp->n_pair == bp->cap_pair) {
    const int cap = (bp->cap_pair > 0) ? 2 * bp->cap_pair : 64;
    BASE_TRY(resize((void **)&bp->pair, (size_t)cap * sizeof *bp->pair, err));
    bp->cap_pair = cap;
  }
  bp->pair[bp->n_pair++] = (broad_pair){(i < j) ? i : j, (i < j) ? j : i};
  return BASE_OK;
}

static unsigned bucket_of(const broad_phase *bp, const int *c) {
  const uint32_t h = (uint32_t)c[0] * 73856093u ^ (uint32_t)c[1] * 19349663u ^
                     (uint32_t)c[2] * 83492791u; /* Teschner et al. 2003 */
  return h & (unsigned)(bp->cap_bucket - 1);
}

/* Balls below i in the chain of cell c that really are in it, against ball i. */
static base_status test_cell(broad_phase *bp, int i, const int *c, base_error *err) {
  for (int j = bp->head[bucket_of(bp, c)]; j >= 0; j = bp->next[j]) {
    const int *at = &bp->cell[(ptrdiff_t)3 * j];
    const bool same = at[0] == c[0] && at[1] == c[1] && at[2] == c[2];
    const base_status status = same ? test_pair(bp, i, j, err) : BASE_OK;
    if (status != BASE_OK) {
      return status;
    }
  }
  return BASE_OK;
}

static base_status test_neighbours(broad_phase *bp, int i, int dim, base_error *err) {
  const int *own = &bp->cell[(ptrdiff_t)3 * i];
  const int first = (dim == 3) ? 0 : 9, end = (dim == 3) ? 27 : 18; /* planar: own layer only */
  for (int k = first; k < end; k++) {
    const int c[3] = {own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1};
    BASE_TRY(test_cell(bp, i, c, err));
  }
  return BASE_OK;
}

/* Balls above the returned radius are compared with everybody. Four times the mean keeps cells
 * near the size of the common balls; at most a quarter of the balls can exceed it. */
static double split_radius(const broad_phase *bp) {
  double sum = 0.0;
  for (int i = 0; i < bp->n; i++) {
    sum += bp->ball[i].r;
  }
  return 4.0 * sum / bp->n;
}

/* Lists the large balls and returns the radius of the widest other one. */
static base_status classify(broad_phase *bp, double limit, int *n_large, double *widest,
                            base_error *err) {
  *n_large = 0;
  *widest = 0.0;
  for (int i = 0; i < bp->n; i++) {
    const broad_ball *b = &bp->ball[i];
    if (!isfinite(b->r + b->x[0] + b->x[1] + b->x[2])) {
      return BASE_FAIL(err, BASE_EINVAL, "body %d: position or speed is not finite", i);
    }
    if (b->r > limit) {
      bp->large[(*n_large)++] = i;
    } else {
      *widest = fmax(*widest, b->r);
    }
  }
  return BASE_OK;
}

/* Ball i against the large ones; two large ones meet once. */
static base_status test_large(broad_phase *bp, int i, bool is_large, int n_large, base_error *err) {
  for (int k = 0; k < n_large; k++) {
    const int j = bp->large[k];
    if (j == i || (is_large && j > i)) {
      continue;
    }
    BASE_TRY(test_pair(bp, i, j, err));
  }
  return BASE_OK;
}

base_status broad_find(broad_phase *bp, int dim, base_error *err) {
  bp->n_pair = 0;
  if (bp->n < 2) {
    return BASE_OK;
  }
  const double limit = split_radius(bp);
  double widest;
  int n_large;
  BASE_TRY(classify(bp, limit, &n_large, &widest, err));
  const double inv = (widest > 0.0) ? 0.5 / widest : 1.0;
  for (int i = 0; i < bp->cap_bucket; i++) {
    bp->head[i] = -1;
  }
  for (int i = 0; i < bp->n; i++) {
    const bool is_large = bp->ball[i].r > limit;
    BASE_TRY(test_large(bp, i, is_large, n_large, err));
    if (is_large) {
      continue;
    }
    int *cell = &bp->cell[(ptrdiff_t)3 * i];
    for (int k = 0; k < 3; k++) { /* beyond 2^30 cells all share the last one: slow, not wrong */
      cell[k] = (int)fmin(fmax(floor(bp->ball[i].x[k] * inv), -0x1p30), 0x1p30);
    }
    BASE_TRY(test_neighbours(bp, i, dim, err));
    const unsigned b = bucket_of(bp, cell);
    bp->next[i] = bp->head[b];
    bp->head[b] = i;
  }
  return BASE_OK;
}
