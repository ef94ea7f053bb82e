#include "lcp/solvers/cone_body.h"

#include <string.h>

base_status lcp_cone_body_check(const lcp_cone_step *s, const lcp_problem *p,
                                const lcp_cone_scaled *c, base_error *err) {
  const lcp_factored *f = p->M.factored;
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > LIN_BLOCK_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %d has %d velocities: need at most %d", b,
                       f->dof_start[b + 1] - f->dof_start[b], (int)LIN_BLOCK_MAX);
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

/* The groups with an active piece. */
static void join(lcp_cone_step *s, const lcp_factored *f) {
  for (int g = 0; g < f->n_group; g++) {
    s->joined[g] = 0;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      s->joined[g] |= s->active[i];
    }
  }
}

/* Without slip K is symmetric, to the last bit. */
static bool is_symmetric(const lcp_cone_step *s, const lcp_cone_scaled *c) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    const double *K = c->Y + (size_t)b->start * LCP_CONE_MAX;
    for (int j = 0; j < b->size && s->active[b->start]; j++) {
      for (int i = 0; i < j; i++) {
        if (K[i + j * b->size] != K[j + i * b->size]) {
          return false;
        }
      }
    }
  }
  return true;
}

static void add_piece(lcp_cone_step *s, const lcp_factored *f, const lcp_cone_scaled *c,
                      const lcp_block *b) {
  const int n = b->size, g = s->sweep.group[b->start];
  const double *K = c->Y + (size_t)b->start * LCP_CONE_MAX, *scale = c->s + b->start;
  double scaled[LCP_CONE_MAX * LCP_CONE_MAX];
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      scaled[i + j * n] = scale[i] * K[i + j * n] * scale[j];
    }
  }
  lin_body_space_add(&s->body, f, s->sweep.G, g, b->start - f->row_start[g], n, scaled);
}

bool lcp_cone_body_factor(lcp_cone_step *s, const lcp_factored *f, lcp_cone_scaled *c,
                          double weight, base_status *status) {
  for (int k = 0; k < c->n_piece; k++) {
    if (!local(f, c, &c->piece[k], weight)) {
      return false;
    }
  }
  join(s, f);
  base_error unused;
  *status = lin_body_space_begin(&s->body, f, s->joined, is_symmetric(s, c), &unused);
  if (*status != BASE_OK) {
    return false;
  }
  for (int k = 0; k < c->n_piece; k++) {
    if (s->active[c->piece[k].start]) {
      add_piece(s, f, c, &c->piece[k]);
    }
  }
  return lin_blocks_factor(&s->body.blocks);
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
  const int n = f->row_start[f->n_group];
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
  for (int k = 0; k < c->n_piece; k++) {
    local_step(c, &c->piece[k], NULL, s->t + c->piece[k].start);
  }
  for (int i = 0; i < n; i++) {
    s->t[i] *= c->s[i];
  }
  for (int g = 0; g < f->n_group; g++) {
    lin_body_space_push(f, s->sweep.G, g, s->t + f->row_start[g], s->v);
  }
  lin_blocks_solve(&s->body.blocks, s->v);
  for (int g = 0; g < f->n_group; g++) {
    lin_body_space_pull(f, s->sweep.G, g, s->v, s->t + f->row_start[g]);
  }
  for (int i = 0; i < n; i++) {
    s->t[i] *= c->s[i];
  }
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    local_step(c, b, s->t + b->start, dx + b->start);
  }
}
