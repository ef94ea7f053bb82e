#include "lcp/lcp_islands_cut.h"

#include "lcp/base/crew.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

#include <stdlib.h>
#include <string.h>

void lcp_islands_cut_close(islands_cut *s) {
  free(s->island);
  free(s->mem);
  *s = (islands_cut){0};
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void layout(islands_cut *s, base_arena *a) {
  const size_t n = (size_t)s->cap.n + 1, nodes = n + (size_t)s->cap.n_body;
  const size_t g = (size_t)s->cap_group;
  const size_t b = (size_t)s->cap.n_body;
  int **const by_row[] = {&s->block_of, &s->row, &s->local, &s->by_size};
  for (int i = 0; i < BASE_COUNT(by_row); i++) {
    *by_row[i] = BASE_ARRAY(a, int, n);
  }
  s->root = BASE_ARRAY(a, int, nodes);
  s->number = BASE_ARRAY(a, int, nodes);
  s->place = BASE_ARRAY(a, int, b);
  s->block = BASE_ARRAY(a, lcp_block, s->cap.n_block);
  double **const real[] = {&s->q, &s->lo, &s->hi, &s->z};
  for (int i = 0; i < BASE_COUNT(real); i++) {
    *real[i] = BASE_ARRAY(a, double, n);
  }
  s->val = BASE_ARRAY(a, double, s->cap_val);
  s->rowind = BASE_ARRAY(a, int, s->cap_val);
  s->colptr = BASE_ARRAY(a, int, 2 * n);
  s->jac = BASE_ARRAY(a, double, s->cap.n_jac);
  s->weight = BASE_ARRAY(a, double, s->cap.n_weight);
  s->dof_start = BASE_ARRAY(a, int, b + n);
  s->weight_start = BASE_ARRAY(a, int, b + n);
  s->row_start = BASE_ARRAY(a, int, g + n);
  s->jac_start = BASE_ARRAY(a, int, g + n);
  s->body = BASE_ARRAY(a, int, 2 * g);
  s->jac_at = BASE_ARRAY(a, int, g);
}

static int more(int have, int need) {
  return (need > have) ? base_room(need) : have;
}

static int bodies_of(const lcp_problem *p) {
  return (p->M.factored != NULL) ? p->M.factored->n_body : 0;
}

static base_status reserve(islands_cut *s, const lcp_problem *p, base_error *err) {
  lcp_capacity need = lcp_problem_capacity(p);
  need.n_body = bodies_of(p);
  const int groups = (p->M.storage == LCP_FACTORED) ? p->M.factored->n_group : 0;
  const size_t val =
      (p->M.storage == LCP_DENSE) ? (size_t)need.n * (size_t)need.n : (size_t)need.nnz;
  if (s->mem != NULL && lcp_capacity_holds(&s->cap, &need) && groups <= s->cap_group &&
      val <= s->cap_val) {
    return BASE_OK;
  }
  s->cap = (lcp_capacity){.n = more(s->cap.n, need.n),
                          .n_block = more(s->cap.n_block, need.n_block),
                          .nnz = more(s->cap.nnz, need.nnz),
                          .n_body = more(s->cap.n_body, need.n_body),
                          .n_dof = more(s->cap.n_dof, need.n_dof),
                          .n_jac = more(s->cap.n_jac, need.n_jac),
                          .n_weight = more(s->cap.n_weight, need.n_weight)};
  s->cap_group = more(s->cap_group, groups);
  s->cap_val = (val > s->cap_val) ? base_room_of(val) : s->cap_val;
  free(s->mem);
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  s->mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (s->mem == NULL) {
    s->cap = (lcp_capacity){0};
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to cut %d rows into islands", p->M.n);
  }
  base_arena real = base_arena_over(s->mem, measure.used);
  layout(s, &real);
  return BASE_OK;
}

/* ---- who belongs together -------------------------------------------------------------------- */

static int root_of(islands_cut *s, int k) {
  while (s->root[k] != k) {
    s->root[k] = s->root[s->root[k]];
    k = s->root[k];
  }
  return k;
}

/* The earlier root stays one. Returns whether two became one. */
static bool join(islands_cut *s, int a, int b) {
  a = root_of(s, a);
  b = root_of(s, b);
  s->root[(a > b) ? a : b] = (a > b) ? b : a;
  return a != b;
}

static int blocks_of(const lcp_problem *p) {
  return (p->block != NULL) ? p->n_block : p->M.n;
}

static lcp_block block_at(const lcp_problem *p, int k) {
  return (p->block != NULL) ? p->block[k] : (lcp_block){.start = k, .size = 1, .set = LCP_ORTHANT};
}

/* Rows of a column of a stored matrix; ends where all blocks are one. */
static void join_columns(islands_cut *s, const lcp_matrix *M, int parts) {
  for (int j = 0; j < M->n && parts > 1; j++) {
    const lcp_column c = lcp_column_of(M, j);
    for (int k = 0; k < c.count && parts > 1; k++) {
      const int i = lcp_column_row(&c, k);
      if (c.val[k] != 0 && s->block_of[i] != s->block_of[j]) {
        parts -= join(s, s->block_of[i], s->block_of[j]);
      }
    }
  }
}

static bool moves(const lcp_factored *f, int b) {
  return b >= 0 && f->dof_start[b + 1] > f->dof_start[b];
}

static void join_at_bodies(islands_cut *s, const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  const int blocks = blocks_of(p);
  for (int g = 0; g < f->n_group; g++) {
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      join(s, s->block_of[f->row_start[g]], s->block_of[i]);
    }
    for (int side = 0; side < 2 && f->row_start[g + 1] > f->row_start[g]; side++) {
      const int b = f->body[2 * (ptrdiff_t)g + side];
      if (moves(f, b)) {
        join(s, s->block_of[f->row_start[g]], blocks + b);
      }
    }
  }
  for (int j = 0; f->shift != NULL && j < p->M.n; j++) {
    const lcp_column c = lcp_csc_column(f->shift, j);
    for (int k = 0; k < c.count; k++) {
      if (c.val[k] != 0) {
        join(s, s->block_of[j], s->block_of[c.row[k]]);
      }
    }
  }
}

/* Counts the islands; s->number of every block. */
static void find(islands_cut *s, const lcp_problem *p) {
  const int blocks = blocks_of(p);
  s->n_node = blocks + bodies_of(p);
  for (int k = 0; k < s->n_node; k++) {
    s->root[k] = k;
  }
  for (int k = 0; k < blocks; k++) {
    const lcp_block b = block_at(p, k);
    for (int i = b.start; i < b.start + b.size; i++) {
      s->block_of[i] = k;
    }
  }
  if (p->M.factored != NULL) { /* where they stand beside a stored matrix they are read faster */
    join_at_bodies(s, p);
  } else {
    join_columns(s, &p->M, blocks);
  }
  s->count = 0;
  for (int k = 0; k < blocks; k++) { /* roots come first in their islands */
    const int root = root_of(s, k);
    s->number[k] = (root == k) ? s->count++ : s->number[root];
  }
}

/* ---- cutting out ----------------------------------------------------------------------------- */

/* Rows by island, and the parts' sizes. */
static void list_rows(islands_cut *s, const lcp_problem *p) {
  for (int k = 0; k < s->count; k++) {
    s->island[k].p = (lcp_problem){.traits = p->traits};
  }
  for (int i = 0; i < p->M.n; i++) {
    islands_part *part = &s->island[s->number[s->block_of[i]]];
    s->local[i] = part->p.M.n++;
  }
  for (int k = 0, at = 0; k < s->count; at += s->island[k++].p.M.n) {
    s->island[k].row = s->row + at;
    s->island[k].z = s->z + at;
    s->island[k].p.q = s->q + at;
    s->island[k].p.lo = (p->lo != NULL) ? s->lo + at : NULL;
    s->island[k].p.hi = (p->hi != NULL) ? s->hi + at : NULL;
  }
}

static void copy_rows(islands_cut *s, const lcp_problem *p, const double *z) {
  for (int i = 0; i < p->M.n; i++) {
    const islands_part *part = &s->island[s->number[s->block_of[i]]];
    const ptrdiff_t at = (part->row - s->row) + s->local[i];
    s->row[at] = i;
    s->q[at] = p->q[i];
    s->z[at] = z[i];
    if (p->lo != NULL && p->hi != NULL) {
      s->lo[at] = p->lo[i];
      s->hi[at] = p->hi[i];
    }
  }
}

static void copy_blocks(islands_cut *s, const lcp_problem *p) {
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    s->island[s->number[k]].p.n_block++;
  }
  for (int k = 0, at = 0; p->block != NULL && k < s->count; k++) {
    s->island[k].p.block = s->block + at;
    at += s->island[k].p.n_block;
    s->island[k].p.n_block = 0;
  }
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    islands_part *part = &s->island[s->number[k]];
    lcp_block *to = s->block + (part->p.block - s->block) + part->p.n_block++;
    *to = p->block[k];
    to->start = (to->size > 0) ? s->local[p->block[k].start] : 0;
  }
}

/* Columns of the rows of a part, at `at`; returns the end. */
static int copy_columns(islands_cut *s, const islands_part *part, const lcp_csc *m, int *colptr,
                        int at) {
  const int first = at;
  for (int j = 0; j < part->p.M.n; j++) {
    const lcp_column c = lcp_csc_column(m, part->row[j]);
    colptr[j] = at - first;
    for (int k = 0; k < c.count; k++) {
      if (c.val[k] != 0) { /* a zero may lead to another island */
        s->rowind[at] = s->local[c.row[k]];
        s->val[at++] = c.val[k];
      }
    }
  }
  colptr[part->p.M.n] = at - first;
  return at;
}

static void cut_sparse(islands_cut *s, const lcp_csc *m) {
  int at = 0, *colptr = s->colptr;
  for (int k = 0; k < s->count; k++) {
    islands_part *part = &s->island[k];
    const int n = part->p.M.n, first = at;
    at = copy_columns(s, part, m, colptr, at);
    part->p.M = (lcp_matrix){
        .storage = LCP_CSC, .n = n, .csc = {n, n, colptr, s->rowind + first, s->val + first}};
    colptr += n + 1;
  }
}

static void cut_dense(islands_cut *s, const lcp_matrix *M) {
  double *out = s->val;
  for (int k = 0; k < s->count; k++) {
    islands_part *part = &s->island[k];
    const int n = part->p.M.n;
    part->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = n, .val = out};
    for (int j = 0; j < n; j++) {
      const double *column = M->val + (ptrdiff_t)part->row[j] * M->n;
      for (int i = 0; i < n; i++) {
        *out++ = column[part->row[i]];
      }
    }
  }
}

/* The island of body b: that of the blocks at it; -1 where there are none. */
static int island_of_body(islands_cut *s, int blocks, int b) {
  const int root = root_of(s, blocks + b);
  return (root < blocks) ? s->number[root] : -1;
}

static void count_bodies(islands_cut *s, const lcp_factored *f, int blocks) {
  for (int k = 0; k < s->count; k++) {
    s->island[k].factored = (lcp_factored){0};
  }
  for (int b = 0; b < f->n_body; b++) {
    const int k = moves(f, b) ? island_of_body(s, blocks, b) : -1;
    s->place[b] = (k >= 0) ? s->island[k].factored.n_body++ : -1;
  }
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    if (rows > 0) {
      s->island[s->number[s->block_of[f->row_start[g]]]].factored.n_group++;
    }
  }
}

/* Bodies of all islands, each in its own numbers. */
static void copy_bodies(islands_cut *s, const lcp_factored *f, int blocks) {
  int at = 0;
  double *weight = s->weight;
  for (int k = 0; k < s->count; k++) {
    lcp_factored *own = &s->island[k].factored;
    own->dof_start = s->dof_start + at;
    own->weight_start = s->weight_start + at;
    s->dof_start[at] = s->weight_start[at] = 0;
    at += own->n_body + 1;
  }
  for (int b = 0; b < f->n_body; b++) { /* sizes, each behind its place */
    if (s->place[b] >= 0) {
      const lcp_factored *own = &s->island[island_of_body(s, blocks, b)].factored;
      const ptrdiff_t to = (own->dof_start - s->dof_start) + s->place[b];
      s->dof_start[to + 1] = s->dof_start[to] + f->dof_start[b + 1] - f->dof_start[b];
      s->weight_start[to + 1] = s->weight_start[to] + f->weight_start[b + 1] - f->weight_start[b];
    }
  }
  for (int k = 0; k < s->count; k++) {
    lcp_factored *own = &s->island[k].factored;
    own->weight = weight;
    weight += own->weight_start[own->n_body];
  }
  for (int b = 0; b < f->n_body; b++) {
    if (s->place[b] >= 0) {
      const lcp_factored *own = &s->island[island_of_body(s, blocks, b)].factored;
      memcpy(s->weight + (own->weight - s->weight) + own->weight_start[s->place[b]],
             f->weight + f->weight_start[b],
             (size_t)(f->weight_start[b + 1] - f->weight_start[b]) * sizeof *weight);
    }
  }
}

static int jac_size(const lcp_factored *f, int g) {
  return f->jac_start[g + 1] - f->jac_start[g];
}

/* Whose rows are copied where. */
typedef struct group_copies {
  islands_cut *s;
  const lcp_factored *f;
} group_copies;

enum { SHARE = 64 }; /* groups of one part of the work */

/* J of some groups. */
static void share_groups(void *of, int part, int hand) {
  const group_copies *c = of;
  const lcp_factored *f = c->f;
  (void)hand;
  for (int g = part * SHARE; g < base_part_end(part, f->n_group, SHARE); g++) {
    if (f->row_start[g + 1] > f->row_start[g]) {
      double room[LCP_MIXED_MAX];
      memcpy(c->s->jac + c->s->jac_at[g], lcp_factored_rows(f, g, room),
             (size_t)jac_size(f, g) * sizeof *c->s->jac);
    }
  }
}

/* Groups that have rows; places of their arrays first, by island. */
static void copy_groups(islands_cut *s, const lcp_factored *f) {
  int at = 0, pairs = 0, size = 0;
  for (int k = 0; k < s->count; k++) {
    lcp_factored *own = &s->island[k].factored;
    own->row_start = s->row_start + at;
    own->jac_start = s->jac_start + at;
    own->body = s->body + pairs;
    s->row_start[at] = s->jac_start[at] = 0;
    at += own->n_group + 1;
    pairs += 2 * own->n_group;
    own->n_group = 0;
  }
  for (int g = 0; g < f->n_group; g++) {
    if (f->row_start[g + 1] == f->row_start[g]) {
      continue;
    }
    lcp_factored *own = &s->island[s->number[s->block_of[f->row_start[g]]]].factored;
    const ptrdiff_t to = (own->row_start - s->row_start) + own->n_group;
    s->jac_at[g] = s->jac_start[to]; /* in its island */
    s->row_start[to + 1] = s->row_start[to] + f->row_start[g + 1] - f->row_start[g];
    s->jac_start[to + 1] = s->jac_start[to] + jac_size(f, g);
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * (ptrdiff_t)g + side];
      s->body[(own->body - s->body) + 2 * (ptrdiff_t)own->n_group + side] =
          moves(f, b) ? s->place[b] : -1;
    }
    own->n_group++;
  }
  for (int k = 0; k < s->count; k++) {
    lcp_factored *own = &s->island[k].factored;
    own->jac = s->jac + size;
    size += own->jac_start[own->n_group];
  }
  for (int g = 0; g < f->n_group; g++) {
    if (f->row_start[g + 1] > f->row_start[g]) {
      const islands_part *part = &s->island[s->number[s->block_of[f->row_start[g]]]];
      s->jac_at[g] += (int)(part->factored.jac - s->jac);
    }
  }
  group_copies c = {s, f};
  base_share(base_parts(f->n_group, SHARE), share_groups, &c);
}

static void cut_factors(islands_cut *s, const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  const int blocks = blocks_of(p);
  int at = 0, *colptr = s->colptr;
  count_bodies(s, f, blocks);
  copy_bodies(s, f, blocks);
  copy_groups(s, f);
  for (int k = 0; k < s->count; k++) {
    islands_part *part = &s->island[k];
    const int n = part->p.M.n, first = at;
    part->p.M = (lcp_matrix){.storage = LCP_FACTORED, .n = n, .factored = &part->factored};
    if (f->shift == NULL) {
      continue;
    }
    at = copy_columns(s, part, f->shift, colptr, at);
    part->shift = (lcp_csc){n, n, colptr, s->rowind + first, s->val + first};
    part->factored.shift = (at > first) ? &part->shift : NULL;
    colptr += n + 1;
  }
}

/* The largest first; of equals the earlier. */
static void order_by_size(islands_cut *s) {
  for (int k = 0; k < s->count; k++) {
    s->by_size[k] = k;
  }
  for (int gap = s->count / 2; gap > 0; gap /= 2) {
    for (int k = gap; k < s->count; k++) {
      const int own = s->by_size[k], n = s->island[own].p.M.n;
      int m = k;
      for (; m >= gap && s->island[s->by_size[m - gap]].p.M.n < n; m -= gap) {
        s->by_size[m] = s->by_size[m - gap];
      }
      s->by_size[m] = own;
    }
  }
}

static base_status room_for_islands(islands_cut *s, base_error *err) {
  if (s->count > s->cap_island) {
    free(s->island);
    s->cap_island = 2 * s->count;
    s->island = malloc((size_t)s->cap_island * sizeof *s->island);
    if (s->island == NULL) {
      s->cap_island = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d islands", s->count);
    }
  }
  return BASE_OK;
}

base_status lcp_islands_cut_problem(islands_cut *s, const lcp_problem *p, bool by_factors,
                                    double *z, base_error *err) {
  lcp_problem of = *p;
  if (by_factors && p->M.storage == LCP_CSC && p->M.factored != NULL) {
    of.M = lcp_matrix_in_factors(&p->M);
  }
  BASE_TRY(reserve(s, &of, err));
  find(s, &of);
  s->count = (s->count > 0) ? s->count : 1; /* no rows: one island without any */
  BASE_TRY(room_for_islands(s, err));
  if (s->count == 1) {
    s->by_size[0] = 0;
    s->island[0] = (islands_part){.p = *p, .z = z};
    return BASE_OK;
  }
  list_rows(s, &of);
  copy_rows(s, &of, z);
  copy_blocks(s, &of);
  if (of.M.storage == LCP_FACTORED) {
    cut_factors(s, &of);
  } else if (of.M.storage == LCP_CSC) {
    cut_sparse(s, &of.M.csc);
  } else {
    cut_dense(s, &of.M);
  }
  order_by_size(s);
  return BASE_OK;
}

void lcp_islands_cut_out(const islands_cut *s, int k, const double *from, double *to) {
  const islands_part *part = &s->island[k];
  for (int i = 0; i < part->p.M.n; i++) {
    to[part->row[i]] = from[i];
  }
}
