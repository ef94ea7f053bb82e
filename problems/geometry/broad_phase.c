#include "problems/geometry/broad_phase.h"

#include "lcp/base/crew.h"

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
  base_gather_close(&bp->found);
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

/* What one part of the balls, in their order, looks for. */
typedef struct search {
  broad_phase *bp;
  int dim, part;
  long tested;
} search;

static void test_pair(search *s, int i, int j) {
  const broad_ball *a = &s->bp->ball[i], *b = &s->bp->ball[j];
  const double reach = a->r + b->r;
  s->tested++;
  const double d[3] = {a->x[0] - b->x[0], a->x[1] - b->x[1], a->x[2] - b->x[2]};
  if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > reach * reach) {
    return;
  }
  broad_pair *found = base_gather_add(&s->bp->found, s->part);
  if (found != NULL) {
    *found = (broad_pair){(i < j) ? i : j, (i < j) ? j : i};
  }
}

static unsigned bucket_of(const broad_phase *bp, const broad_cell *c) {
  const uint32_t h = (uint32_t)c->at[0] * 73856093u ^ (uint32_t)c->at[1] * 19349663u ^
                     (uint32_t)c->at[2] * 83492791u ^
                     (uint32_t)c->level * 2654435761u; /* Teschner et al. 2003 */
  return h & (unsigned)(bp->cap_bucket - 1);
}

/* Ball i against those of cell c, of which only the ones before it where the cell is its own. */
static void test_cell(search *s, int i, const broad_cell *c, bool own) {
  const broad_phase *bp = s->bp;
  for (int j = bp->head[bucket_of(bp, c)]; j >= 0; j = bp->next[j]) {
    const broad_cell *o = &bp->cell[j];
    const bool same = o->at[0] == c->at[0] && o->at[1] == c->at[1] && o->at[2] == c->at[2] &&
                      o->level == c->level;
    if (same && (!own || j < i)) {
      test_pair(s, i, j);
    }
  }
}

static broad_cell cell_of(const broad_phase *bp, int i, int level) {
  broad_cell c = {.level = level};
  for (int k = 0; k < 3; k++) { /* beyond 2^30 cells all share the last one: slow, not wrong */
    const double at = floor(bp->ball[i].x[k] * bp->level[level].per_width);
    c.at[k] = (int)fmin(fmax(at, -0x1p30), 0x1p30);
  }
  return c;
}

/* Ball i against the balls around cell c of a grid. Two cells of its own grid see each other once, from the one before. */
static void test_neighbours(search *s, int i, const broad_cell *c, bool own) {
  const int middle = 13;
  const int first = own ? middle : ((s->dim == 3) ? 0 : 9);
  const int end = (s->dim == 3) ? 27 : 18; /* planar: own layer only */
  for (int k = first; k < end; k++) {
    const broad_cell at = {{c->at[0] + k % 3 - 1, c->at[1] + k / 3 % 3 - 1, c->at[2] + k / 9 - 1},
                           c->level};
    test_cell(s, i, &at, own && k == middle);
  }
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
static void test_level(search *s, int i, int rank, int level) {
  const broad_phase *bp = s->bp;
  const broad_level *l = &bp->level[level];
  const bool own = level == bp->cell[i].level;
  if (l->n > BROAD_FEW) {
    const broad_cell c = own ? bp->cell[i] : cell_of(bp, i, level);
    test_neighbours(s, i, &c, own);
    return;
  }
  for (int k = l->first; k < l->first + l->n && k < rank; k++) {
    test_pair(s, i, bp->order[k]);
  }
}

enum { SHARE = 1024 }; /* balls of one part of the work */

/* A ball meets those of its own level and of larger balls. */
static void search_part(void *of, int part, int hand) {
  broad_phase *bp = ((const search *)of)->bp;
  search s = {.bp = bp, .dim = ((const search *)of)->dim, .part = part};
  (void)hand;
  for (int rank = part * SHARE; rank < base_part_end(part, bp->n, SHARE); rank++) {
    const int i = bp->order[rank];
    for (int k = 0; k <= bp->cell[i].level; k++) {
      if (bp->level[k].n > 0) {
        test_level(&s, i, rank, k);
      }
    }
  }
  atomic_fetch_add(&bp->tested, s.tested);
}

/* Puts every ball into the cell of its own level. */
static void fill_cells(broad_phase *bp) {
  for (int i = 0; i < bp->cap_bucket; i++) {
    bp->head[i] = -1;
  }
  for (int i = 0; i < bp->n; i++) {
    bp->cell[i] = cell_of(bp, i, bp->cell[i].level);
    const unsigned b = bucket_of(bp, &bp->cell[i]);
    bp->next[i] = bp->head[b];
    bp->head[b] = i;
  }
}

/* What the parts have found, as one list. */
static base_status join(broad_phase *bp, base_error *err) {
  int n = 0;
  BASE_TRY(base_gather_count(&bp->found, "pairs of bodies that are near", &n, err));
  if (n > bp->cap_pair) {
    const int cap = base_room(n);
    BASE_TRY(resize((void **)&bp->pair, (size_t)cap * sizeof *bp->pair, err));
    bp->cap_pair = cap;
  }
  base_gather_join(&bp->found, bp->pair);
  bp->n_pair = n;
  return BASE_OK;
}

base_status broad_find(broad_phase *bp, int dim, base_error *err) {
  double largest;
  bp->n_pair = 0;
  atomic_store(&bp->tested, 0);
  if (bp->n < 2) {
    return BASE_OK;
  }
  BASE_TRY(largest_radius(bp, &largest, err));
  sort_levels(bp, largest);
  fill_cells(bp);
  const int parts = base_parts(bp->n, SHARE);
  BASE_TRY(base_gather_begin(&bp->found, parts, sizeof *bp->pair, err));
  search s = {.bp = bp, .dim = dim};
  base_share(parts, search_part, &s);
  return join(bp, err);
}
