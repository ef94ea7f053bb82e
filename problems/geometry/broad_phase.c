#include "problems/geometry/broad_phase.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

void broad_close(broad_phase *bp) {
  free(bp->ball);
  free(bp->pair);
  free(bp->head);
  free(bp->next);
  free(bp->cell);
  free(bp->order);
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
  BASE_TRY(resize((void **)&bp->cell, m * sizeof *bp->cell, err));
  BASE_TRY(resize((void **)&bp->order, m * sizeof *bp->order, err));
  bp->cap_bucket = buckets;
  bp->cap = n;
  return BASE_OK;
}

static base_status test_pair(broad_phase *bp, int i, int j, base_error *err) {
  const broad_ball *a = &bp->ball[i], *b = &bp->ball[j];
  const double reach = a->r + b->r;
  bp->tested++;
  const double d[3] = {a->x[0] - b->x[0], a->x[1] - b->x[1], a->x[2] - b->x[2]};
  if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > reach * reach) {
    return BASE_OK;
  }
  if (bp->n_pair == bp->cap_pair) {
    if (bp->cap_pair > INT_MAX / 2) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "broad phase: more than %d pairs overlap",
                       bp->cap_pair);
    }
    const int cap = (bp->cap_pair > 0) ? 2 * bp->cap_pair : 64;
    BASE_TRY(resize((void **)&bp->pair, (size_t)cap * sizeof *bp->pair, err));
    bp->cap_pair = cap;
  }
  bp->pair[bp->n_pair++] = (broad_pair){(i < j) ? i : j, (i < j) ? j : i};
  return BASE_OK;
}

static unsigned bucket_of(const broad_phase *bp, const broad_cell *c) {
  const uint32_t h = (uint32_t)c->at[0] * 73856093u ^ (uint32_t)c->at[1] * 19349663u ^
                     (uint32_t)c->at[2] * 83492791u ^
                     (uint32_t)c->level * 2654435761u; /* Teschner et al. 2003 */
  return h & (unsigned)(bp->cap_bucket - 1);
}

/* Balls that are in cell c already, against ball i. */
static base_status test_cell(broad_phase *bp, int i, const broad_cell *c, base_error *err) {
  for (int j = bp->head[bucket_of(bp, c)]; j >= 0; j = bp->next[j]) {
    const broad_cell *o = &bp->cell[j];
    const bool same = o->at[0] == c->at[0] && o->at[1] == c->at[1] && o->at[2] == c->at[2] &&
                      o->level == c->level;
    const base_status status = same ? test_pair(bp, i, j, err) : BASE_OK;
    if (status != BASE_OK) {
      return status;
    }
  }
  return BASE_OK;
}

static broad_cell cell_of(const broad_phase *bp, int i, int level) {
  broad_cell c = {.level = level};
  for (int k = 0; k < 3; k++) { /* beyond 2^30 cells all share the last one: slow, not wrong */
    const double at = floor(bp->ball[i].x[k] * bp->level[level].per_width);
    c.at[k] = (int)fmin(fmax(at, -0x1p30), 0x1p30);
  }
  return c;
}

static base_status test_neighbours(broad_phase *bp, int i, const broad_cell *own, int dim,
                                   base_error *err) {
  const int first = (dim == 3) ? 0 : 9, end = (dim == 3) ? 27 : 18; /* planar: own layer only */
  for (int k = first; k < end; k++) {
    const broad_cell c = {
        {own->at[0] + k % 3 - 1, own->at[1] + k / 3 % 3 - 1, own->at[2] + k / 9 - 1}, own->level};
    BASE_TRY(test_cell(bp, i, &c, err));
  }
  return BASE_OK;
}

/* The level of radius r under the largest: a factor four each, what is smaller than all of them in the
 * last. */
static int level_of(double r, double largest) {
  int level = 0;
  double least = 0.25 * largest;
  while (r <= least && level < BROAD_LEVELS - 1) {
    level++;
    least *= 0.25;
  }
  return level;
}

static base_status largest_radius(const broad_phase *bp, double *largest, base_error *err) {
  *largest = 0.0;
  for (int i = 0; i < bp->n; i++) {
    const broad_ball *b = &bp->ball[i];
    if (!isfinite(b->r + b->x[0] + b->x[1] + b->x[2])) {
      return BASE_FAIL(err, BASE_EINVAL, "body %d: position or speed is not finite", i);
    }
    *largest = fmax(*largest, b->r);
  }
  return BASE_OK;
}

/* Orders the balls by level, large ones first, and finds the width of each level's cells. */
static void sort_levels(broad_phase *bp, double largest) {
  int next[BROAD_LEVELS];
  double widest[BROAD_LEVELS] = {0.0};
  for (int k = 0; k < BROAD_LEVELS; k++) {
    bp->level[k] = (broad_level){0};
  }
  for (int i = 0; i < bp->n; i++) {
    const int k = bp->cell[i].level = level_of(bp->ball[i].r, largest);
    bp->level[k].n++;
    widest[k] = fmax(widest[k], bp->ball[i].r);
  }
  for (int k = 0, first = 0; k < BROAD_LEVELS; k++) {
    bp->level[k].first = next[k] = first;
    bp->level[k].per_width = (widest[k] > 0.0) ? 0.5 / widest[k] : 1.0;
    first += bp->level[k].n;
  }
  for (int i = 0; i < bp->n; i++) {
    bp->order[next[bp->cell[i].level]++] = i;
  }
}

/* Ball i, number `rank` in order, against the balls of a level that come before it: one by one where they are
 * no more than cells would be. */
static base_status test_level(broad_phase *bp, int i, int rank, int level, int dim,
                              base_error *err) {
  const broad_level *l = &bp->level[level];
  const broad_cell c = cell_of(bp, i, level);
  if (l->n > BROAD_FEW) {
    return test_neighbours(bp, i, &c, dim, err);
  }
  for (int k = l->first; k < l->first + l->n && k < rank; k++) {
    BASE_TRY(test_pair(bp, i, bp->order[k], err));
  }
  return BASE_OK;
}

/* Compares ball i, number `rank` in order, with what came before, then puts it into its cell. */
static base_status take_ball(broad_phase *bp, int i, int rank, int dim, base_error *err) {
  const int own = bp->cell[i].level;
  for (int k = 0; k <= own; k++) {
    if (bp->level[k].n > 0) {
      BASE_TRY(test_level(bp, i, rank, k, dim, err));
    }
  }
  bp->cell[i] = cell_of(bp, i, own);
  const unsigned b = bucket_of(bp, &bp->cell[i]);
  bp->next[i] = bp->head[b];
  bp->head[b] = i;
  return BASE_OK;
}

base_status broad_find(broad_phase *bp, int dim, base_error *err) {
  double largest;
  bp->n_pair = 0;
  bp->tested = 0;
  if (bp->n < 2) {
    return BASE_OK;
  }
  BASE_TRY(largest_radius(bp, &largest, err));
  sort_levels(bp, largest);
  for (int i = 0; i < bp->cap_bucket; i++) {
    bp->head[i] = -1;
  }
  for (int rank = 0; rank < bp->n; rank++) {
    BASE_TRY(take_ball(bp, bp->order[rank], rank, dim, err));
  }
  return BASE_OK;
}
