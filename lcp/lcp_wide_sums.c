/* lcp_wide_sums.c - M z and |M| x of a matrix in factors, and its diagonal, over all columns at once. */
#include "lcp/base/clones.h"
#include "lcp/base/crew.h"
#include "lcp/lcp_wide_inside.h"

#include <math.h>
#include <string.h>

enum { LANES = LCP_WIDE_LANES, SHARE = LCP_WIDE_SHARE };

static int dofs(const lcp_factored *f, int b) {
  return (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
}

/* Of all columns. */
typedef struct sums {
  lcp_wide_columns *c;
  const double *z;
  long double *w, *size;
  double *d;
} sums;

/* force += J_g' z on the body of one side, */
static void push(const lcp_factored *f, int g, int side, const double *z, long double *force) {
  const int n = dofs(f, f->body[2 * (ptrdiff_t)g + side]);
  double room[LCP_MIXED_MAX];
  const double *J = lcp_wide_factored_rows(f, g, side, room);
  for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++, J += n) {
    for (int k = 0; k < n && z[i] != 0; k++) {
      force[k] += (long double)J[k] * z[i];
    }
  }
}

/* w += J_g of the force there, */
static void pull(const lcp_factored *f, int g, int side, const long double *force, long double *w) {
  const int n = dofs(f, f->body[2 * (ptrdiff_t)g + side]);
  double room[LCP_MIXED_MAX];
  const double *J = lcp_wide_factored_rows(f, g, side, room);
  for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++, J += n) {
    for (int k = 0; k < n; k++) {
      w[i] += J[k] * force[k];
    }
  }
}

/* and out = W force on body b. */
static void weigh(const lcp_factored *f, int b, const long double *force, long double *out) {
  const int n = dofs(f, b);
  const double *W = f->weight + f->weight_start[b];
  for (int k = 0; k < n; k++) {
    out[k] = 0;
    for (int l = 0; l < n; l++) {
      out[k] += W[(ptrdiff_t)l * n + k] * force[l];
    }
  }
}

/* wj = W J' z of some bodies. */
static void share_forces(void *of, int part, int hand) {
  const sums *s = of;
  const lcp_wide_columns *c = s->c;
  const lcp_factored *f = c->M->factored;
  (void)hand;
  for (int b = part * SHARE; b < base_part_end(part, f->n_body, SHARE); b++) {
    long double *force = c->force + f->dof_start[b];
    for (int k = 0; k < dofs(f, b); k++) {
      force[k] = 0;
    }
    for (int k = c->group_start[b]; k < c->group_start[b + 1]; k++) {
      const int g = c->group[k];
      push(f, g, (f->body[2 * (ptrdiff_t)g] == b) ? 0 : 1, s->z, force);
    }
    weigh(f, b, force, c->wj + f->dof_start[b]);
  }
}

/* w += J wj of some groups. */
static void share_product(void *of, int part, int hand) {
  const sums *s = of;
  const lcp_factored *f = s->c->M->factored;
  (void)hand;
  for (int g = part * SHARE; g < base_part_end(part, f->n_group, SHARE); g++) {
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * (ptrdiff_t)g + side];
      if (b >= 0) {
        pull(f, g, side, s->c->wj + f->dof_start[b], s->w);
      }
    }
  }
}

void lcp_wide_factored_product(lcp_wide_columns *c, const double *z, long double *w) {
  const lcp_factored *f = c->M->factored;
  const lcp_csc *S = f->shift;
  sums s = {.c = c, .z = z, .w = w};
  base_share(base_parts(f->n_body, SHARE), share_forces, &s);
  base_share(base_parts(f->n_group, SHARE), share_product, &s);
  for (int j = 0; S != NULL && j < c->M->n; j++) {
    for (int k = S->colptr[j]; k < S->colptr[j + 1]; k++) {
      w[S->rowind[k]] += (long double)S->val[k] * z[j];
    }
  }
}

/* The groups at the bodies of group g, each once, and g itself where it has none; returns how many. */
static int neighbours(const lcp_wide_columns *c, int g, lcp_wide_neighbour *to) {
  const lcp_factored *f = c->M->factored;
  const int *at[2], *end[2];
  int count = 0;
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    at[side] = (b >= 0) ? c->group + c->group_start[b] : NULL;
    end[side] = (b >= 0) ? c->group + c->group_start[b + 1] : NULL;
  }
  while (at[0] < end[0] || at[1] < end[1]) {
    const int h = (at[1] >= end[1] || (at[0] < end[0] && *at[0] <= *at[1])) ? *at[0] : *at[1];
    lcp_wide_neighbour *near = &to[count++];
    *near = (lcp_wide_neighbour){
        .group = h, .first = f->row_start[h], .rows = f->row_start[h + 1] - f->row_start[h]};
    for (int side = 0; side < 2; side++) {
      for (; at[side] < end[side] && *at[side] == h; at[side]++) {
        near->jac[side] = lcp_wide_stored_on(f, h, f->body[2 * g + side]);
      }
    }
  }
  if (count == 0) { /* S acts alone */
    to[count++] = (lcp_wide_neighbour){
        .group = g, .first = f->row_start[g], .rows = f->row_start[g + 1] - f->row_start[g]};
  }
  return count;
}

static double dot(const double *x, const double *y, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++) {
    sum += x[k] * y[k];
  }
  return sum;
}

/* W J' of the stored rows of group g, to columns of `out`, which has `stride` of them: dofs of both sides x rows, row-major. */
static void weigh_group(const lcp_factored *f, int g, int stride, double *out) {
  const int rows = lcp_factored_stored(f, g);
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * (ptrdiff_t)g + side], n = dofs(f, b);
    const double *J = (b >= 0) ? lcp_wide_stored_on(f, g, b) : NULL;
    const double *W = (b >= 0) ? f->weight + f->weight_start[b] : NULL;
    for (int k = 0; k < n; k++, out += stride) {
      for (int j = 0; j < rows; j++) {
        out[j] = dot(W + (ptrdiff_t)k * n, J + (ptrdiff_t)j * n, n);
      }
    }
  }
}

/* entry += J_i wj for LANES columns of wj. */
static inline void add_entries(const double *ji, const double *wj, int n, int stride,
                               double entry[LANES]) {
  for (int k = 0; k < n; k++, wj += stride) {
    for (int j = 0; j < LANES; j++) {
      entry[j] += ji[k] * wj[j];
    }
  }
}

/* entry += S of column i, where it lies in the rows from `first` on. */
static void add_shift(const lcp_csc *S, int i, int first, double entry[LANES]) {
  for (int k = S->colptr[i]; k < S->colptr[i + 1]; k++) {
    const int j = S->rowind[k] - first;
    if (j >= 0 && j < LANES) {
      entry[j] += S->val[k];
    }
  }
}

/* Entries of stored row k with LANES stored columns of the group, whose W J' begins at wj and has this stride. */
BASE_INLINE void stored_entries(const double *const jac[2], const int dof[2], int k,
                                const double *wj, int stride, double entry[LANES]) {
  double sum[LANES] = {0};
  for (int side = 0; side < 2; side++, wj += (ptrdiff_t)dof[0] * stride) {
    const int n = dof[side];
    if (jac[side] != NULL && n == 6) {
      add_entries(jac[side] + (ptrdiff_t)k * 6, wj, 6, stride, sum);
    } else if (jac[side] != NULL) {
      add_entries(jac[side] + (ptrdiff_t)k * n, wj, n, stride, sum);
    }
  }
  for (int j = 0; j < LANES; j++) {
    entry[j] = sum[j];
  }
}

/* The same of row i, mixed of those of `part`. */
BASE_INLINE void mixed_entries(const lcp_mixture *m, int i, double part[][LANES],
                               double entry[LANES]) {
  double sum[LANES] = {0};
  for (int k = 0; k < m->stored; k++) {
    const double c = m->c[i * m->stored + k];
    for (int j = 0; j < LANES; j++) {
      sum[j] += c * part[k][j];
    }
  }
  for (int j = 0; j < LANES; j++) {
    entry[j] = sum[j];
  }
}

enum { MIXED_PADDED = (LCP_MIXED_ROWS + LANES - 1) / LANES * LANES };

/* How the rows of a group are mixed, one stored row after the other, padded with zeros. */
typedef struct mixed_rows {
  int rows, stored; /* rows 0: they are not */
  double c[LCP_STORED_MAX][MIXED_PADDED];
} mixed_rows;

static void turn_mixture(const lcp_mixture *m, mixed_rows *to) {
  to->rows = (m != NULL) ? m->rows : 0;
  to->stored = (m != NULL) ? m->stored : 0;
  for (int l = 0; l < to->stored; l++) {
    for (int j = 0; j < lcp_wide_padded(to->rows); j++) {
      to->c[l][j] = (j < to->rows) ? m->c[j * to->stored + l] : 0;
    }
  }
}

/* size_j += |M_ji| x of row i over the rows j of a group that are mixed, of the entries of those stored. S: of that group, or NULL. */
BASE_INLINE void add_mixed(const mixed_rows *m, const double entry[LANES], const lcp_csc *S, int i,
                           int first, double x, double *restrict size) {
  double all[MIXED_PADDED];
  for (int from = 0; from < m->rows; from += LANES) {
    double sum[LANES] = {0};
    for (int l = 0; l < m->stored; l++) {
      for (int j = 0; j < LANES; j++) {
        sum[j] += m->c[l][from + j] * entry[l];
      }
    }
    for (int j = 0; j < LANES; j++) {
      all[from + j] = sum[j];
    }
  }
  for (int k = (S != NULL) ? S->colptr[i] : 0; S != NULL && k < S->colptr[i + 1]; k++) {
    const int j = S->rowind[k] - first;
    if (j >= 0 && j < m->rows) {
      all[j] += S->val[k];
    }
  }
  for (int from = 0; from < m->rows; from += LANES) {
    for (int j = from; j < from + LANES; j++) {
      size[j] += fabs(all[j]) * x;
    }
  }
}

_Static_assert((int)LCP_STORED_MAX <= (int)LANES,
               "stored rows of a group that is mixed lie side by side");

/* Groups that lie between the same two bodies and are summed together; first of their rows, and how many with zeros behind them. */
typedef struct together {
  int group, end, first, stride;
} together;

/* Entries side by side; as a type of its own they stay in registers. */
typedef double lanes __attribute__((vector_size(LANES * sizeof(double))));
typedef double lanes_at __attribute__((vector_size(LANES * sizeof(double)), aligned(8), may_alias));

/* The rows of a neighbour on one of their bodies, with W J' of what is summed there. */
typedef struct side_rows {
  const double *jac, *weighed;
  int dof; /* 0: it is not there */
} side_rows;

/* sum += row r of a side over LANES columns from `at` on. */
BASE_INLINE void add_lanes(const side_rows *s, int r, int at, int stride, lanes *sum) {
  const double *row = s->jac + (ptrdiff_t)r * s->dof, *wj = s->weighed + at;
  for (int k = 0; k < s->dof; k++, wj += stride) {
    *sum += row[k] * *(const lanes_at *)wj;
  }
}

/* size_j += |M_ji| x_i for the rows j of such groups and the rows i of a neighbour, J W J' being symmetric; S is added inside a
 * group, where all of it is. Rows that are not mixed, */
BASE_INLINE void add_rows(const together *of, const lcp_wide_neighbour *near, side_rows one,
                          side_rows two, const lcp_csc *S, const double *x, double *size) {
  for (int r = 0; r < near->rows; r++) {
    const int i = near->first + r;
    for (int at = 0; at < of->stride && x[i] != 0; at += LANES) {
      lanes sum = {0};
      add_lanes(&one, r, at, of->stride, &sum);
      add_lanes(&two, r, at, of->stride, &sum);
      double entry[LANES];
      memcpy(entry, &sum, sizeof entry);
      if (S != NULL) {
        add_shift(S, i, of->first + at, entry);
      }
      for (int j = 0; j < LANES; j++) {
        size[at + j] += fabs(entry[j]) * x[i];
      }
    }
  }
}

BASE_CLONES static void add_sizes(const lcp_wide_columns *c, const together *of,
                                  const lcp_wide_neighbour *near, const double *weighed,
                                  double *size) {
  const lcp_factored *f = c->M->factored;
  const bool inside = near->group >= of->group && near->group < of->end;
  const lcp_csc *S = inside ? f->shift : NULL;
  side_rows on[2] = {{weighed, weighed, 0}, {weighed, weighed, 0}};
  for (int side = 0, bodies = 0; side < 2; side++) {
    const int n = lcp_factored_dof(f, of->group, side);
    if (near->jac[side] != NULL) {
      on[bodies++] = (side_rows){near->jac[side], weighed, n};
    }
    weighed += (ptrdiff_t)n * of->stride;
  }
  if (on[0].dof == 6 && on[1].dof == 0) { /* the two commonest: the compiler knows how many */
    on[0].dof = 6;
    on[1].dof = 0;
    add_rows(of, near, on[0], on[1], S, c->x, size);
  } else if (on[0].dof == 6 && on[1].dof == 6) {
    on[0].dof = on[1].dof = 6;
    add_rows(of, near, on[0], on[1], S, c->x, size);
  } else {
    add_rows(of, near, on[0], on[1], S, c->x, size);
  }
}

/* and those of which a side is. */
BASE_CLONES static void add_mixed_sizes(const lcp_wide_columns *c, int g,
                                        const lcp_wide_neighbour *near, const double *weighed,
                                        const mixed_rows *own, double *restrict size) {
  const lcp_factored *f = c->M->factored;
  const int first = f->row_start[g], stride = lcp_wide_padded(lcp_factored_stored(f, g));
  const lcp_csc *S = (near->first == first) ? f->shift : NULL;
  double part[LCP_STORED_MAX][LANES], entry[LANES];
  const int n[2] = {lcp_factored_dof(f, g, 0), lcp_factored_dof(f, g, 1)};
  const lcp_mixture *m = lcp_mixture_of(f, near->group);
  for (int from = 0; from < stride; from += LANES) {
    for (int k = 0; m != NULL && k < m->stored; k++) {
      stored_entries(near->jac, n, k, weighed + from, stride, part[k]);
    }
    for (int i = 0; i < near->rows; i++) {
      const double x = c->x[near->first + i];
      if (x == 0) {
        continue;
      }
      if (m != NULL) {
        mixed_entries(m, i, part, entry);
      } else {
        stored_entries(near->jac, n, i, weighed + from, stride, entry);
      }
      if (own->rows > 0) {
        add_mixed(own, entry, S, near->first + i, first, x, size);
        continue;
      }
      if (S != NULL) {
        add_shift(S, near->first + i, first + from, entry);
      }
      for (int j = 0; j < LANES; j++) {
        size[from + j] += fabs(entry[j]) * x;
      }
    }
  }
}

/* Can column j be summed in double, group by group? Not where x has no room there, or S couples rows of several groups. */
static bool fits(const lcp_wide_columns *c, const long double *x, int j) {
  const lcp_csc *S = c->M->factored->shift;
  bool fit = x[j] == 0 || (x[j] > 1e-200L && x[j] < 1e200L);
  for (int k = (S != NULL) ? S->colptr[j] : 0; S != NULL && fit && k < S->colptr[j + 1]; k++) {
    fit = c->group_of[S->rowind[k]] == c->group_of[j];
  }
  return fit;
}

/* The groups from g on, up to `end`, that lie between the same two bodies; those with mixed rows are taken one by one. */
static together beside(const lcp_factored *f, int g, int end) {
  const int *body = f->body + 2 * (ptrdiff_t)g;
  int to = g + 1;
  while (to < end && f->mixture == NULL && (body[0] >= 0 || body[1] >= 0) &&
         f->body[2 * (ptrdiff_t)to] == body[0] && f->body[2 * (ptrdiff_t)to + 1] == body[1]) {
    to++;
  }
  const int rows = (to == g + 1) ? lcp_factored_stored(f, g) : f->row_start[to] - f->row_start[g];
  return (together){g, to, f->row_start[g], lcp_wide_padded(rows)};
}

/* Groups from .. end-1. */
BASE_CLONES static void sizes_by_groups(const lcp_wide_columns *c, const lcp_wide_scratch *own,
                                        int from, int end, long double *size) {
  const lcp_factored *f = c->M->factored;
  for (int g = from; g < end;) {
    const together of = beside(f, g, end);
    const int rows = f->row_start[of.end] - of.first;
    const int count = neighbours(c, g, own->near);
    const int dof = lcp_factored_dof(f, g, 0) + lcp_factored_dof(f, g, 1);
    mixed_rows mixed;
    turn_mixture(lcp_mixture_of(f, g), &mixed);
    memset(own->weighed, 0, (size_t)dof * (size_t)of.stride * sizeof *own->weighed);
    for (; g < of.end; g++) {
      weigh_group(f, g, of.stride, own->weighed + (f->row_start[g] - of.first));
    }
    memset(own->entry, 0, (size_t)lcp_wide_padded(rows) * sizeof *own->entry);
    for (int k = 0; k < count; k++) {
      if (f->mixture == NULL) {
        add_sizes(c, &of, &own->near[k], own->weighed, own->entry);
      } else {
        add_mixed_sizes(c, of.group, &own->near[k], own->weighed, &mixed, own->entry);
      }
    }
    for (int j = 0; j < rows; j++) {
      size[of.first + j] += own->entry[j];
    }
  }
}

static void share_sizes(void *of, int part, int hand) {
  const sums *s = of;
  sizes_by_groups(s->c, &s->c->of[hand], part * SHARE,
                  base_part_end(part, s->c->M->factored->n_group, SHARE), s->size);
}

void lcp_wide_factored_sizes(lcp_wide_columns *c, const long double *x, long double *size) {
  sums s = {.c = c, .size = size};
  bool all = true;
  for (int j = 0; j < c->M->n; j++) {
    const bool fit = fits(c, x, j);
    c->x[j] = fit ? (double)x[j] : 0;
    all = all && fit;
  }
  base_share(base_parts(c->M->factored->n_group, SHARE), share_sizes, &s);
  for (int j = 0; !all && j < c->M->n; j++) {
    if (x[j] == 0 || fits(c, x, j)) {
      continue;
    }
    const lcp_wide_column col = lcp_wide_columns_at(c, j);
    for (int k = 0; k < col.count; k++) {
      size[col.row[k]] += fabsl(col.val[k]) * x[j];
    }
  }
}

/* Of the rows of some groups. */
static void share_diagonal(void *of, int part, int hand) {
  const lcp_wide_columns *c = ((const sums *)of)->c;
  double *d = ((const sums *)of)->d;
  const lcp_factored *f = c->M->factored;
  const lcp_csc *S = f->shift;
  const int from = part * SHARE, end = base_part_end(part, f->n_group, SHARE);
  (void)hand;
  for (int j = f->row_start[from]; j < f->row_start[end]; j++) {
    long double sum = 0;
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * c->group_of[j] + side];
      double room[LCP_MIXED_MAX];
      const double *jj = (b >= 0) ? lcp_wide_moved_by(c, j, b, room) : NULL;
      const int n = (jj != NULL) ? dofs(f, b) : 0;
      for (int k = 0; k < n * n; k++) {
        sum += (long double)jj[k / n] * f->weight[f->weight_start[b] + k] * jj[k % n];
      }
    }
    for (int k = (S != NULL) ? S->colptr[j] : 0; S != NULL && k < S->colptr[j + 1]; k++) {
      sum += (S->rowind[k] == j) ? S->val[k] : 0;
    }
    d[j] = (double)sum;
  }
}

void lcp_wide_factored_diagonal(lcp_wide_columns *c, double *d) {
  sums s = {.c = c};
  s.d = d;
  base_share(base_parts(c->M->factored->n_group, SHARE), share_diagonal, &s);
}
