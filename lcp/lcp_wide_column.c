#include "lcp/base/crew.h"
#include "lcp/lcp_wide_inside.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Entries of J, its rows padded, of as many groups between the same two bodies as one part of the work may have. */
static int largest_jac(const lcp_factored *f) {
  int rows = 0, dof = 0, longest = 0, run = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int *body = f->body + 2 * (ptrdiff_t)g;
    const int here = f->row_start[g + 1] - f->row_start[g];
    const int both = lcp_factored_dof(f, g, 0) + lcp_factored_dof(f, g, 1);
    run = (g > 0 && body[0] == body[-2] && body[1] == body[-1]) ? run + 1 : 1;
    longest = (run > longest && run <= LCP_WIDE_SHARE) ? run : longest;
    rows = (here > rows) ? here : rows;
    dof = (both > dof) ? both : dof;
  }
  return dof * lcp_wide_padded(longest * rows);
}

static void carve(lcp_wide_columns *c, base_arena *a) {
  const size_t n = (size_t)c->M->n;
  c->row = BASE_ARRAY(a, int, n);
  c->val = BASE_ARRAY(a, long double, n);
  if (c->M->storage == LCP_FACTORED) {
    const lcp_factored *f = c->M->factored;
    c->group_start = BASE_ARRAY(a, int, f->n_body + 2);
    c->group = BASE_ARRAY(a, int, 2 * (size_t)f->n_group);
    c->group_of = BASE_ARRAY(a, int, n);
    c->marked = BASE_ARRAY(a, unsigned char, n);
    c->sum = BASE_ARRAY(a, long double, n);
    c->wj = BASE_ARRAY(a, long double, f->dof_start[f->n_body]);
    c->force = BASE_ARRAY(a, long double, f->dof_start[f->n_body]);
    c->x = BASE_ARRAY(a, double, n);
    lcp_wide_scratch *of = BASE_ARRAY(a, lcp_wide_scratch, c->hands), unused;
    for (int h = 0; h < c->hands; h++) {
      lcp_wide_scratch *own = (of != NULL) ? &of[h] : &unused;
      own->entry = BASE_ARRAY(a, double, n + LCP_WIDE_LANES);
      own->weighed = BASE_ARRAY(a, double, largest_jac(f));
      own->near = BASE_ARRAY(a, lcp_wide_neighbour, f->n_group);
    }
    c->of = of;
  }
}

/* Counting sort of the groups by body. */
static void list_groups(lcp_wide_columns *c) {
  const lcp_factored *f = c->M->factored;
  for (int b = 0; b < f->n_body + 2; b++) {
    c->group_start[b] = 0;
  }
  for (int k = 0; k < 2 * f->n_group; k++) {
    if (f->body[k] >= 0) {
      c->group_start[f->body[k] + 2]++;
    }
  }
  for (int b = 2; b < f->n_body + 2; b++) {
    c->group_start[b] += c->group_start[b - 1];
  }
  for (int k = 0; k < 2 * f->n_group; k++) {
    if (f->body[k] >= 0) {
      c->group[c->group_start[f->body[k] + 1]++] = k / 2;
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      c->group_of[i] = g;
      c->marked[i] = 0;
      c->sum[i] = 0;
    }
  }
}

base_status lcp_wide_columns_open(lcp_wide_columns *c, const lcp_matrix *M, base_error *err) {
  *c = (lcp_wide_columns){.M = M, .hands = base_crew_size()};
  base_arena need = base_arena_measuring();
  carve(c, &need);
  void *mem = need.overflow ? NULL : base_alloc(need.used);
  if (mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "matrix columns: scratch for %d rows", M->n);
  }
  base_arena a = base_arena_over(mem, need.used);
  carve(c, &a);
  c->mem = mem;
  if (M->storage == LCP_FACTORED) {
    list_groups(c);
  }
  return BASE_OK;
}

void lcp_wide_columns_close(lcp_wide_columns *c) {
  free(c->mem);
  *c = (lcp_wide_columns){0};
}

const double *lcp_wide_stored_on(const lcp_factored *f, int g, int b) {
  const double *jac = f->jac + lcp_factored_at(f, g);
  const bool first = f->body[2 * (ptrdiff_t)g] == b;
  return first ? jac : jac + (ptrdiff_t)lcp_factored_stored(f, g) * lcp_factored_dof(f, g, 0);
}

/* Row i of a mixture of rows of n numbers. */
static void mix_row(const lcp_mixture *m, int i, int n, const double *stored, double *out) {
  for (int d = 0; d < n; d++) {
    double sum = 0;
    for (int k = 0; k < m->stored; k++) {
      sum += m->c[i * m->stored + k] * stored[k * n + d];
    }
    out[d] = sum;
  }
}

/* The rows themselves, made in `room` where they are mixed. */
static const double *rows_on(const lcp_factored *f, int g, int b, double *room) {
  const double *stored = lcp_wide_stored_on(f, g, b);
  const lcp_mixture *m = lcp_mixture_of(f, g);
  if (m == NULL) {
    return stored;
  }
  const int n = f->dof_start[b + 1] - f->dof_start[b];
  for (int i = 0; i < m->rows; i++) {
    mix_row(m, i, n, stored, room + (ptrdiff_t)i * n);
  }
  return room;
}

const double *lcp_wide_moved_by(const lcp_wide_columns *c, int j, int b, double *room) {
  const lcp_factored *f = c->M->factored;
  const int d = f->dof_start[b + 1] - f->dof_start[b];
  const int g = c->group_of[j], r = j - f->row_start[g];
  const lcp_mixture *m = lcp_mixture_of(f, g);
  const double *jj = lcp_wide_stored_on(f, g, b);
  if (m != NULL) {
    mix_row(m, r, d, jj, room);
    jj = room;
  } else {
    jj += (ptrdiff_t)r * d;
  }
  for (int k = 0; k < d; k++) {
    if (jj[k] != 0) {
      return jj;
    }
  }
  return NULL;
}

const double *lcp_wide_factored_rows(const lcp_factored *f, int g, int side, double *room) {
  return rows_on(f, g, f->body[2 * (ptrdiff_t)g + side], room);
}

static int mark(lcp_wide_columns *c, int i, int count) {
  if (!c->marked[i]) {
    c->marked[i] = 1;
    c->row[count++] = i;
  }
  return count;
}

static int ascending(const void *a, const void *b) {
  const int x = *(const int *)a;
  const int y = *(const int *)b;
  return (x > y) - (x < y);
}

/* Puts row[0..count) in order where it is not, and takes the marks away. */
static void sort_rows(lcp_wide_columns *c, int count, bool mixed) {
  if (mixed) {
    qsort(c->row, (size_t)count, sizeof *c->row, ascending);
  }
  for (int k = 0; k < count; k++) {
    c->marked[c->row[k]] = 0;
  }
}

/* Groups at a body that row j of J moves: views of the list, empty where there is none. */
static void groups_of(const lcp_wide_columns *c, int j, int side, const int **at, const int **end) {
  const int b = c->M->factored->body[2 * c->group_of[j] + side];
  double room[LCP_MIXED_MAX];
  const bool moves = b >= 0 && lcp_wide_moved_by(c, j, b, room) != NULL;
  *at = moves ? c->group + c->group_start[b] : NULL;
  *end = moves ? c->group + c->group_start[b + 1] : NULL;
}

/* The lists of groups at a body ascend, and so do the rows of their union. Rows of S beside them are sorted in. */
int lcp_wide_columns_rows(lcp_wide_columns *c, int j) {
  const lcp_factored *f = c->M->factored;
  const lcp_csc *S = f->shift;
  const int *x, *x_end, *y, *y_end;
  int count = 0;
  groups_of(c, j, 0, &x, &x_end);
  groups_of(c, j, 1, &y, &y_end);
  while (x < x_end || y < y_end) {
    const int g = (y >= y_end || (x < x_end && *x <= *y)) ? *x : *y;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      count = mark(c, i, count);
    }
    for (; x < x_end && *x == g; x++) {
    }
    for (; y < y_end && *y == g; y++) {
    }
  }
  const int of_groups = count;
  for (int k = (S != NULL) ? S->colptr[j] : 0; S != NULL && k < S->colptr[j + 1]; k++) {
    count = mark(c, S->rowind[k], count);
  }
  sort_rows(c, count, count > of_groups);
  return count;
}

/* sum += J W J_j' over the groups that touch body b. */
static void add_body(lcp_wide_columns *c, int j, int b) {
  const lcp_factored *f = c->M->factored;
  const int d = f->dof_start[b + 1] - f->dof_start[b];
  double room[2][LCP_MIXED_MAX];
  const double *jj = lcp_wide_moved_by(c, j, b, room[0]);
  const double *w = f->weight + f->weight_start[b];
  for (int k = 0; jj != NULL && k < d; k++) {
    c->wj[k] = 0;
    for (int l = 0; l < d; l++) {
      c->wj[k] += (long double)w[(ptrdiff_t)l * d + k] * jj[l];
    }
  }
  for (int s = c->group_start[b]; jj != NULL && s < c->group_start[b + 1]; s++) {
    const int g = c->group[s];
    const double *ji = rows_on(f, g, b, room[1]);
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++, ji += d) {
      long double sum = 0;
      for (int k = 0; k < d; k++) {
        sum += ji[k] * c->wj[k];
      }
      c->sum[i] += sum;
    }
  }
}

static lcp_wide_column factored_at(lcp_wide_columns *c, int j) {
  const lcp_factored *f = c->M->factored;
  const lcp_csc *S = f->shift;
  const int count = lcp_wide_columns_rows(c, j);
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * c->group_of[j] + side];
    if (b >= 0) {
      add_body(c, j, b);
    }
  }
  for (int k = (S != NULL) ? S->colptr[j] : 0; S != NULL && k < S->colptr[j + 1]; k++) {
    c->sum[S->rowind[k]] += S->val[k];
  }
  for (int k = 0; k < count; k++) {
    const int i = c->row[k];
    c->val[k] = c->sum[i];
    c->sum[i] = 0;
  }
  return (lcp_wide_column){count, c->row, c->val};
}

lcp_wide_column lcp_wide_columns_at(lcp_wide_columns *c, int j) {
  const lcp_matrix *M = c->M;
  if (M->storage == LCP_FACTORED) {
    return factored_at(c, j);
  }
  int count = 0;
  if (M->storage == LCP_DENSE) {
    for (count = 0; count < M->n; count++) {
      c->row[count] = count;
      c->val[count] = M->val[(ptrdiff_t)j * M->n + count];
    }
  } else {
    for (int k = M->csc.colptr[j]; k < M->csc.colptr[j + 1]; k++, count++) {
      c->row[count] = M->csc.rowind[k];
      c->val[count] = M->csc.val[k];
    }
  }
  return (lcp_wide_column){count, c->row, c->val};
}
