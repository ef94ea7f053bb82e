#include "lcp/solvers/cone_body.h"

#include <string.h>

enum { DOF_MAX = 12 }; /* of one body in the small products */

base_status lcp_cone_body_check(const lcp_cone_step *s, const lcp_problem *p,
                                const lcp_cone_scaled *c, base_error *err) {
  const lcp_factored *f = p->M.factored;
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > DOF_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %d has %d velocities: need at most %d", b,
                       f->dof_start[b + 1] - f->dof_start[b], (int)DOF_MAX);
    }
  }
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    if (s->sweep.group[b->start] != s->sweep.group[b->start + b->size - 1]) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "cone at row %d spans two groups of the factored form", b->start);
    }
  }
  for (int j = 0; f->shift != NULL && j < p->M.n; j++) {
    for (int k = f->shift->colptr[j]; k < f->shift->colptr[j + 1]; k++) {
      if (s->piece_of[f->shift->rowind[k]] != s->piece_of[j] && f->shift->val[k] != 0.0) {
        return BASE_FAIL(err, BASE_EUNSUPPORTED,
                         "S couples rows %d and %d of different blocks: need storage=csc",
                         f->shift->rowind[k], j);
      }
    }
  }
  return BASE_OK;
}

size_t lcp_cone_body_pairs(const lcp_factored *f) {
  return (size_t)f->n_body + 2 * (size_t)f->n_group;
}

static int dofs(const lcp_factored *f, int b) {
  return f->dof_start[b + 1] - f->dof_start[b];
}

static bool meet(const lcp_factored *f, int g) {
  return f->body[2 * g] >= 0 && f->body[2 * g + 1] >= 0 && f->body[2 * g] != f->body[2 * g + 1];
}

size_t lcp_cone_body_entries(const lcp_factored *f) {
  size_t count = 0;
  for (int b = 0; b < f->n_body; b++) {
    count += (size_t)dofs(f, b) * (size_t)dofs(f, b);
  }
  for (int g = 0; g < f->n_group; g++) {
    count +=
        meet(f, g) ? 2 * (size_t)dofs(f, f->body[2 * g]) * (size_t)dofs(f, f->body[2 * g + 1]) : 0;
  }
  return count;
}

/* Sorts a short list and drops what is double; returns its new length. */
static int sort_unique(int *list, int count) {
  for (int i = 1; i < count; i++) {
    const int x = list[i];
    int k = i;
    for (; k > 0 && list[k - 1] > x; k--) {
      list[k] = list[k - 1];
    }
    list[k] = x;
  }
  int kept = 0;
  for (int i = 0; i < count; i++) {
    if (i == 0 || list[i] != list[kept - 1]) {
      list[kept++] = list[i];
    }
  }
  return kept;
}

/* Neighbours of every body in joined groups, itself among them, sorted. */
static void neighbours(lcp_cone_step *s, const lcp_factored *f) {
  int *start = s->near_start, *next = s->near_at; /* near_at is filled later */
  for (int b = 0; b <= f->n_body; b++) {
    start[b] = (b < f->n_body) ? 1 : 0;
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int side = 0; side < 2 && s->joined[g] && meet(f, g); side++) {
      start[f->body[2 * g + side]]++;
    }
  }
  for (int b = 0, sum = 0; b <= f->n_body; b++) {
    const int count = start[b];
    start[b] = sum;
    sum += count;
  }
  for (int b = 0; b < f->n_body; b++) {
    next[b] = start[b];
    s->near[next[b]++] = b;
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int side = 0; side < 2 && s->joined[g] && meet(f, g); side++) {
      s->near[next[f->body[2 * g + side]]++] = f->body[2 * g + 1 - side];
    }
  }
  int kept = 0;
  for (int b = 0; b < f->n_body; b++) {
    const int first = start[b], count = sort_unique(s->near + first, start[b + 1] - first);
    memmove(s->near + kept, s->near + first, (size_t)count * sizeof *s->near);
    start[b] = kept;
    kept += count;
  }
  start[f->n_body] = kept;
}

static void pattern(lcp_cone_step *s, const lcp_factored *f) {
  neighbours(s, f);
  int at = 0;
  for (int b = 0; b < f->n_body; b++) {
    int height = 0;
    for (int k = s->near_start[b]; k < s->near_start[b + 1]; k++) {
      s->near_at[k] = height;
      height += dofs(f, s->near[k]);
    }
    for (int j = f->dof_start[b]; j < f->dof_start[b + 1]; j++) {
      s->colptr[j] = at;
      for (int k = s->near_start[b]; k < s->near_start[b + 1]; k++) {
        for (int i = f->dof_start[s->near[k]]; i < f->dof_start[s->near[k] + 1]; i++) {
          s->rowind[at++] = i;
        }
      }
    }
  }
  s->colptr[f->dof_start[f->n_body]] = at;
  s->entries = (size_t)at;
}

void lcp_cone_body_begin(lcp_cone_step *s, const lcp_factored *f) {
  memset(s->joined, 0, (size_t)f->n_group);
  pattern(s, f);
}

/* Groups come and go with their contacts: a new pattern where that happened. */
static void join(lcp_cone_step *s, const lcp_factored *f) {
  bool changed = false;
  for (int g = 0; g < f->n_group; g++) {
    unsigned char now = 0;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      now |= s->active[i];
    }
    changed = changed || now != s->joined[g];
    s->joined[g] = now;
  }
  if (changed) {
    pattern(s, f);
  }
}

/* First row of body a in the columns of body b. */
static int row_at(const lcp_cone_step *s, int a, int b) {
  int low = s->near_start[b], high = s->near_start[b + 1] - 1;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (s->near[mid] < a) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  return s->near_at[low];
}

/* Undoes on the columns of an inverse the exchanges of rows k and row[k] that made it, the last one first. */
static void columns_back(int n, const int *row, double *A) {
  for (int k = n - 1; k >= 0; k--) {
    for (int i = 0; i < n && row[k] != k; i++) {
      const double x = A[i + k * n];
      A[i + k * n] = A[i + row[k] * n];
      A[i + row[k] * n] = x;
    }
  }
}

/* A (n x n, column-major) -> its inverse by Gauss-Jordan with row pivoting. False: singular. */
static bool invert(int n, double *A) {
  int row[LCP_CONE_MAX];
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++) {
      p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
    }
    const double pivot = A[p + k * n];
    if (!(fabs(pivot) > 0.0)) {
      return false;
    }
    row[k] = p;
    for (int j = 0; j < n; j++) {
      const double x = A[p + j * n];
      A[p + j * n] = A[k + j * n];
      A[k + j * n] = ((j == k) ? 1.0 : x) / pivot;
    }
    for (int i = 0; i < n; i++) {
      const double x = A[i + k * n];
      if (i != k) {
        A[i + k * n] = 0.0;
        for (int j = 0; j < n; j++) {
          A[i + j * n] -= x * A[k + j * n];
        }
      }
    }
  }
  columns_back(n, row, A);
  return true;
}

/* X <- T^-1, Y <- K of one piece. */
static bool local(const lcp_factored *f, const lcp_cone_scaled *c, const lcp_block *b,
                  double weight) {
  const int n = b->size;
  double *X = c->X + (size_t)b->start * LCP_CONE_MAX, *Y = c->Y + (size_t)b->start * LCP_CONE_MAX;
  double D[LCP_CONE_MAX * LCP_CONE_MAX] = {0}, K[LCP_CONE_MAX * LCP_CONE_MAX];
  for (int j = 0; j < n; j++) {
    const int col = b->start + j;
    D[j + j * n] = weight;
    for (int k = (f->shift != NULL) ? f->shift->colptr[col] : 0;
         f->shift != NULL && k < f->shift->colptr[col + 1]; k++) {
      const int i = f->shift->rowind[k] - b->start;
      if (i >= 0 && i < n) {
        D[i + j * n] += c->s[b->start + i] * f->shift->val[k] * c->s[col];
      }
    }
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < n; k++) {
        X[i + j * n] += Y[i + k * n] * D[k + j * n];
      }
    }
  }
  if (!invert(n, X)) {
    return false;
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      K[i + j * n] = 0.0;
      for (int k = 0; k < n; k++) {
        K[i + j * n] += X[i + k * n] * Y[k + j * n];
      }
    }
  }
  memcpy(Y, K, (size_t)(n * n) * sizeof *Y);
  return true;
}

/* Adds G_a' Q to the rows of body a in the columns of body b, Q = s K s G_b: size x dofs, row-major. */
static void add_block(lcp_cone_step *s, const lcp_factored *f, int size, const lcp_sweep_side *a,
                      const lcp_sweep_side *b, const double *Q) {
  const int first = s->colptr[f->dof_start[b->body]],
            height = s->colptr[f->dof_start[b->body] + 1] - first;
  double *to = s->val + first + row_at(s, a->body, b->body);
  for (int j = 0; j < b->dof; j++, to += height) {
    for (int r = 0; r < size; r++) {
      const double q = Q[r * b->dof + j];
      for (int i = 0; i < a->dof; i++) {
        to[i] += a->g[r * a->dof + i] * q;
      }
    }
  }
}

static void add_piece(lcp_cone_step *s, const lcp_factored *f, const lcp_cone_scaled *c,
                      const lcp_block *b) {
  const int n = b->size;
  const double *K = c->Y + (size_t)b->start * LCP_CONE_MAX, *scale = c->s + b->start;
  lcp_sweep_side side[2];
  for (int k = 0; k < 2; k++) {
    side[k] = lcp_sweep_side_of(&s->sweep, f, b->start, k);
  }
  for (int k = 0; k < 2; k++) {
    if (side[k].body < 0) {
      continue;
    }
    double Q[LCP_CONE_MAX * DOF_MAX] = {0};
    for (int r = 0; r < n; r++) {
      for (int i = 0; i < n; i++) {
        const double factor = scale[r] * K[r + i * n] * scale[i];
        for (int j = 0; j < side[k].dof && factor != 0.0; j++) {
          Q[r * side[k].dof + j] += factor * side[k].g[i * side[k].dof + j];
        }
      }
    }
    for (int l = 0; l < 2; l++) {
      if (side[l].body >= 0) {
        add_block(s, f, n, &side[l], &side[k], Q);
      }
    }
  }
}

bool lcp_cone_body_fill(lcp_cone_step *s, const lcp_factored *f, lcp_cone_scaled *c,
                        double weight) {
  join(s, f);
  memset(s->val, 0, s->entries * sizeof *s->val);
  for (int b = 0; b < f->n_body; b++) {
    const int at = row_at(s, b, b);
    for (int j = f->dof_start[b]; j < f->dof_start[b + 1]; j++) {
      s->val[s->colptr[j] + at + j - f->dof_start[b]] = 1.0;
    }
  }
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    if (!local(f, c, b, weight)) {
      return false;
    }
    if (s->active[b->start]) {
      add_piece(s, f, c, b);
    }
  }
  return true;
}

/* out = -T^-1 F of a piece, and out -= K t where t is given. */
static void local_step(const lcp_cone_scaled *c, const lcp_block *b, const double *t, double *out) {
  const int n = b->size;
  const double *X = c->X + (size_t)b->start * LCP_CONE_MAX;
  const double *K = c->Y + (size_t)b->start * LCP_CONE_MAX;
  memset(out, 0, (size_t)n * sizeof *out);
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      out[i] -= X[i + j * n] * c->F[b->start + j] + ((t != NULL) ? K[i + j * n] * t[j] : 0.0);
    }
  }
}

void lcp_cone_body_solve(lcp_cone_step *s, const lcp_factored *f, const lcp_cone_scaled *c,
                         double *dx) {
  memset(s->v, 0, (size_t)s->rows * sizeof *s->v);
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    double out[LCP_CONE_MAX];
    local_step(c, b, NULL, out);
    for (int r = 0; r < b->size; r++) {
      for (int l = 0; l < 2; l++) {
        const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, b->start + r, l);
        for (int i = 0; i < a.dof; i++) {
          s->v[f->dof_start[a.body] + i] += a.g[i] * c->s[b->start + r] * out[r];
        }
      }
    }
  }
  lcp_direct_solve(&s->direct, s->rows, s->v);
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    double t[LCP_CONE_MAX];
    for (int r = 0; r < b->size; r++) {
      t[r] = 0.0;
      for (int l = 0; l < 2; l++) {
        const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, b->start + r, l);
        for (int i = 0; i < a.dof; i++) {
          t[r] += a.g[i] * s->v[f->dof_start[a.body] + i];
        }
      }
      t[r] *= c->s[b->start + r];
    }
    local_step(c, b, t, dx + b->start);
  }
}
