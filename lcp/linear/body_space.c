#include "lcp/linear/body_space.h"

#include "lcp/base/arena.h"

#include <stdlib.h>
#include <string.h>

/* ---- W = L L', G = J L ------------------------------------------------------------------------- */

static bool cholesky(int n, const double *W, double *L) {
  memcpy(L, W, (size_t)(n * n) * sizeof *L);
  for (int k = 0; k < n; k++) {
    double pivot = L[k + k * n];
    for (int j = 0; j < k; j++) {
      pivot -= L[k + j * n] * L[k + j * n];
    }
    if (pivot < -1e-12 * fabs(W[k + k * n])) {
      return false;
    }
    const double root = (pivot > 0.0) ? sqrt(pivot) : 0.0;
    for (int i = 0; i < n; i++) {
      double v = (i < k) ? 0.0 : L[i + k * n];
      for (int j = 0; i >= k && j < k; j++) {
        v -= L[i + j * n] * L[k + j * n];
      }
      L[i + k * n] = (root > 0.0) ? v / root : 0.0;
    }
    L[k + k * n] = root;
  }
  return true;
}

/* G = J L of one group. */
static void weigh_group(const lcp_factored *f, int g, const double *L, double *G) {
  double *out = G + f->jac_start[g];
  const int rows = f->row_start[g + 1] - f->row_start[g];
  for (int k = 0; k < 2; k++) {
    const lin_side s = lin_side_of(f, f->jac, g, k);
    const double *own = L + ((s.body >= 0) ? f->weight_start[s.body] : 0);
    const double *jac = s.jac;
    for (int r = 0; r < rows; r++, jac += s.dof, out += s.dof) {
      for (int j = 0; j < s.dof; j++) { /* (J L)_j = sum_i>=j J_i L_ij */
        out[j] = 0.0;
        for (int i = j; i < s.dof; i++) {
          out[j] += jac[i] * own[i + j * s.dof];
        }
      }
    }
  }
}

base_status lin_weigh(const lcp_factored *f, double *L, double *G, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    if (!cholesky(n, f->weight + f->weight_start[b], L + f->weight_start[b])) {
      return BASE_FAIL(err, BASE_EINVAL, "weight of body %d: not positive semidefinite", b);
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    weigh_group(f, g, L, G);
  }
  return BASE_OK;
}

/* ---- I + G'KG ---------------------------------------------------------------------------------- */

void lin_body_space_close(lin_body_space *s) {
  lin_blocks_close(&s->blocks);
  free(s->pair);
  *s = (lin_body_space){0};
}

base_status lin_body_space_begin(lin_body_space *s, const lcp_factored *f,
                                 const unsigned char *joined, bool symmetric, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > LIN_BLOCK_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %d has %d velocities: need at most %d", b,
                       f->dof_start[b + 1] - f->dof_start[b], (int)LIN_BLOCK_MAX);
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    if (f->row_start[g + 1] - f->row_start[g] > LIN_GROUP_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "group %d has %d rows: need at most %d", g,
                       f->row_start[g + 1] - f->row_start[g], (int)LIN_GROUP_MAX);
    }
  }
  if ((size_t)f->n_group > s->cap_pair || s->pair == NULL) {
    free(s->pair);
    s->cap_pair = (size_t)f->n_group + (size_t)f->n_group / 2 + 1;
    s->pair = base_alloc(2 * s->cap_pair * sizeof *s->pair);
    if (s->pair == NULL) {
      s->cap_pair = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d pairs of bodies", f->n_group);
    }
  }
  size_t n_pair = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int a = f->body[2 * (ptrdiff_t)g], b = f->body[2 * (ptrdiff_t)g + 1];
    if (joined[g] && a >= 0 && b >= 0 && a != b) {
      const bool again = n_pair > 0 && s->pair[2 * n_pair - 2] == a && s->pair[2 * n_pair - 1] == b;
      s->pair[2 * n_pair] =
          a; /* contacts of two bodies follow one another: one pair for all of them */
      s->pair[2 * n_pair + 1] = b;
      n_pair += !again;
    }
  }
  BASE_TRY(lin_blocks_plan(&s->blocks, f->n_body, f->dof_start, s->pair, n_pair, err));
  lin_blocks_clear(&s->blocks, symmetric);
  for (int b = 0; b < f->n_body; b++) {
    double one[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    for (int k = 0; k < n; k++) {
      one[k + k * n] = 1;
    }
    lin_blocks_add(&s->blocks, b, b, one);
  }
  return BASE_OK;
}

/* Q = K A, rows x n, A's rows that many. */
static void multiply(int rows, int n, const double *K, const double *A, double *Q) {
  memset(Q, 0, (size_t)(rows * n) * sizeof *Q);
  for (int r = 0; r < rows; r++) {
    for (int i = 0; i < rows; i++) {
      const double factor = K[r + i * rows];
      for (int j = 0; j < n && factor != 0.0; j++) {
        Q[r * n + j] += factor * A[i * n + j];
      }
    }
  }
}

/* B = A' Q, m x n, over `rows` rows. */
static inline void cross(int rows, const double *A, const double *Q, double *B, int m, int n) {
  for (int r = 0; r < rows; r++) {
    for (int i = 0; i < m; i++) {
      for (int j = 0; j < n; j++) {
        B[i * n + j] += A[r * m + i] * Q[r * n + j];
      }
    }
  }
}

static void add_sides(lin_body_space *s, int count, const lin_side *a, const lin_side *b,
                      const double *Q) {
  double B[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
  if (a->dof == 6 && b->dof == 6) {
    cross(count, a->jac, Q, B, 6, 6);
  } else {
    cross(count, a->jac, Q, B, a->dof, b->dof);
  }
  lin_blocks_add(&s->blocks, a->body, b->body, B);
}

void lin_body_space_add(lin_body_space *s, const lcp_factored *f, const double *G, int group,
                        int row, int count, const double *K) {
  lin_side side[2];
  for (int k = 0; k < 2; k++) {
    side[k] = lin_side_of(f, G, group, k);
    side[k].jac += row * side[k].dof;
  }
  for (int k = 0; k < 2; k++) {
    double Q[LIN_GROUP_MAX * LIN_BLOCK_MAX];
    const lin_side *b = &side[k];
    if (b->body < 0 || b->dof == 0) {
      continue;
    }
    multiply(count, b->dof, K, b->jac, Q);
    for (int l = 0; l < 2; l++) {
      const lin_side *a = &side[l];
      const bool above = a->body >= 0 && s->blocks.place[a->body] < s->blocks.place[b->body];
      if (a->body >= 0 && a->dof > 0 && !(above && s->blocks.symmetric)) {
        add_sides(s, count, a, b, Q);
      }
    }
  }
}

void lin_body_space_push(const lcp_factored *f, const double *G, int group, const double *x,
                         double *v) {
  const int rows = f->row_start[group + 1] - f->row_start[group];
  for (int k = 0; k < 2; k++) {
    const lin_side s = lin_side_of(f, G, group, k);
    double *to = v + ((s.body >= 0) ? f->dof_start[s.body] : 0);
    for (int r = 0; r < rows; r++) {
      for (int i = 0; i < s.dof && x[r] != 0.0; i++) {
        to[i] += s.jac[r * s.dof + i] * x[r];
      }
    }
  }
}

void lin_body_space_pull(const lcp_factored *f, const double *G, int group, const double *v,
                         double *y) {
  const int rows = f->row_start[group + 1] - f->row_start[group];
  for (int r = 0; r < rows; r++) {
    y[r] = 0;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side s = lin_side_of(f, G, group, k);
    const double *from = v + ((s.body >= 0) ? f->dof_start[s.body] : 0);
    for (int r = 0; r < rows; r++) {
      for (int i = 0; i < s.dof; i++) {
        y[r] += s.jac[r * s.dof + i] * from[i];
      }
    }
  }
}
