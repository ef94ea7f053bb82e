#include "lcp/linear/blocks_inside.h"
#include "lcp/linear/cholmod_library.h"

#include <suitesparse/amd.h>

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Products of blocks of six rows a block beyond which nested dissection is tried, too: it takes the time of some hundred of them. */
static const double dense_work = 200;
static const double product = 6 * 6 * 6;

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

static bool is_planned(const lin_blocks *s, int n, const int *first, const int *pair,
                       size_t n_pair) {
  return s->mem != NULL && s->n == n && s->n_pair == n_pair &&
         memcmp(s->first, first, ((size_t)n + 1) * sizeof *first) == 0 &&
         (n_pair == 0 || memcmp(s->pair, pair, 2 * n_pair * sizeof *pair) == 0);
}

static base_status keep_pattern(lin_blocks *s, int n, const int *first, const int *pair,
                                size_t n_pair, base_error *err) {
  if (s->mem == NULL || n > s->cap_n || first[n] > s->cap_rows) {
    s->cap_n = base_room(n);
    s->cap_rows = first[n] + first[n] / 2;
    BASE_TRY(lin_blocks_memory(s, &s->mem, layout_blocks, err));
  }
  if (s->pair == NULL || n_pair > s->cap_pair) {
    free(s->pair);
    s->cap_pair = base_room_of(n_pair) + 1;
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
  const size_t cap = base_room_of(need);
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
    const size_t n = (size_t)lin_blocks_rows(s, p);
    s->at_diag[p] = diag;
    diag += n * n;
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      s->at[k] = low;
      low += n * (size_t)lin_blocks_rows(s, s->row[k]);
    }
  }
  s->at_diag[s->n] = diag;
  if (s->value_mem == NULL || low > s->cap_low || diag > s->cap_diag) {
    s->cap_low = base_room_of(low);
    s->cap_diag = base_room_of(diag);
    free(s->inverse_mem);
    s->inverse_mem = NULL;
    BASE_TRY(lin_blocks_memory(s, &s->value_mem, layout_values, err));
  }
  return BASE_OK;
}

/* The fill of s->order; *work: products of blocks that a factor takes. */
static base_status follow_order(lin_blocks *s, graph *g, double *work, base_error *err) {
  for (int p = 0; p < s->n; p++) {
    s->place[s->order[p]] = p;
  }
  s->column[0] = 0;
  BASE_TRY(find_fill(s, g, err));
  *work = 0;
  for (int p = 0; p < s->n; p++) {
    const double below = (double)lin_blocks_rows_below(s, p);
    *work += below * below * lin_blocks_rows(s, p) / product;
  }
  return BASE_OK;
}

static base_status order_by_degree(lin_blocks *s, graph *g, double *work, base_error *err) {
  const int done = (s->n > 0) ? amd_order(s->n, g->start, g->near, s->order, NULL, NULL) : AMD_OK;
  if (done != AMD_OK) {
    return BASE_FAIL(err, BASE_ENOMEM, "AMD status %d on %d blocks", done, s->n);
  }
  return follow_order(s, g, work, err);
}

/* *done: false where it could not be made. */
static base_status dissect(lin_blocks *s, graph *g, bool *done, base_error *err) {
  cholmod_session c;
  cholmod_sparse a = {.nrow = (size_t)s->n,
                      .ncol = (size_t)s->n,
                      .nzmax = (size_t)g->start[s->n],
                      .p = g->start,
                      .i = g->near,
                      .stype = 0,
                      .itype = CHOLMOD_INT,
                      .xtype = CHOLMOD_PATTERN,
                      .dtype = CHOLMOD_DOUBLE,
                      .sorted = 1,
                      .packed = 1};
  BASE_TRY(cholmod_begin(&c, err));
  cholmod_sparse *lower =
      c.of.cholmod_copy(&a, -1, 0, &c.common); /* symmetric, of the lower triangle */
  *done = lower != NULL && c.of.cholmod_metis(lower, NULL, 0, 1, s->order, &c.common) != 0;
  c.of.cholmod_free_sparse(&lower, &c.common);
  c.of.cholmod_finish(&c.common);
  return BASE_OK;
}

static base_status analyse(lin_blocks *s, graph *g, base_error *err) {
  double work;
  double other;
  bool dissected = false;
  neighbours(s, g->start, g->near, g->mark);
  s->analyses++;
  BASE_TRY(order_by_degree(s, g, &work, err));
  if (work > dense_work * s->n) {
    BASE_TRY(dissect(s, g, &dissected, err));
  }
  if (dissected) {
    BASE_TRY(follow_order(s, g, &other, err));
    if (!(other < work)) {
      BASE_TRY(order_by_degree(s, g, &work, err));
    }
  }
  s->n_front = 0;
  BASE_TRY(place_values(s, err));
  return (work > dense_work * s->n) ? lin_blocks_plan_fronts(s, err) : BASE_OK;
}

/* The numbers of a plan that stands, where they were given back. */
static base_status room_again(lin_blocks *s, base_error *err) {
  if (s->value_mem != NULL) {
    return BASE_OK;
  }
  BASE_TRY(lin_blocks_memory(s, &s->value_mem, layout_values, err));
  return (s->n_front > 0) ? lin_blocks_plan_fronts(s, err) : BASE_OK;
}

base_status lin_blocks_plan(lin_blocks *s, int n, const int *first, const int *pair, size_t n_pair,
                            base_error *err) {
  if (is_planned(s, n, first, pair, n_pair)) {
    return room_again(s, err);
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
