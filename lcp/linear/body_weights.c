/* body_weights.c - W = L L', G = J L. */
#include "lcp/linear/body_space_inside.h"

#include <math.h>
#include <string.h>

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

/* out = J L of `rows` rows: (J L)_j = sum_i>=j J_i L_ij. */
static void weigh_rows(int rows, int dof, const double *jac, const double *L, double *out) {
  for (int r = 0; r < rows; r++) {
    for (int j = 0; j < dof; j++) {
      double sum = 0;
      for (int i = j; i < dof; i++) {
        sum += jac[r * dof + i] * L[i + j * dof];
      }
      out[r * dof + j] = sum;
    }
  }
}

/* The same of a body in space, as sums of the rows of L. */
BASE_INLINE void weigh_six(int rows, const double *restrict jac, const double *L,
                           double *restrict out) {
  double row[36];
  for (int i = 0; i < 36; i++) {
    row[i] = L[i / 6 + i % 6 * 6];
  }
  for (int r = 0; r < rows; r++) {
    for (int j = 0; j < 6; j++) {
      out[r * 6 + j] = jac[r * 6] * row[j];
    }
    for (int i = 1; i < 6; i++) {
      for (int j = 0; j < 6; j++) {
        out[r * 6 + j] += jac[r * 6 + i] * row[i * 6 + j];
      }
    }
  }
}

/* out = J L of `rows` rows of group g. */
BASE_INLINE void weigh_group(const lcp_factored *f, int g, int rows, const double *jac,
                             const double *L, double *out) {
  for (int k = 0; k < 2; k++) {
    const int b = f->body[2 * (ptrdiff_t)g + k], dof = lcp_factored_dof(f, g, k);
    const double *own = L + ((b >= 0) ? f->weight_start[b] : 0);
    if (dof == 6) {
      weigh_six(rows, jac, own, out);
    } else {
      weigh_rows(rows, dof, jac, own, out);
    }
    jac += (ptrdiff_t)rows * dof;
    out += (ptrdiff_t)rows * dof;
  }
}

BASE_CLONES static void weigh_groups(const lcp_factored *f, const double *L, double *G) {
  for (int g = 0; g < f->n_group; g++) {
    double room[LCP_MIXED_MAX];
    const double *jac = lcp_factored_rows(f, g, room);
    weigh_group(f, g, f->row_start[g + 1] - f->row_start[g], jac, L, G + f->jac_start[g]);
  }
}

BASE_CLONES static void weigh_stored(const lcp_factored *f, const double *L, double *G) {
  for (int g = 0; g < f->n_group; g++) {
    const int at = lcp_factored_at(f, g);
    weigh_group(f, g, lcp_factored_stored(f, g), f->jac + at, L, G + at);
  }
}

base_status lin_weigh_bodies(const lcp_factored *f, double *L, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    if (!cholesky(n, f->weight + f->weight_start[b], L + f->weight_start[b])) {
      return BASE_FAIL(err, BASE_EINVAL, "weight of body %d: not positive semidefinite", b);
    }
  }
  return BASE_OK;
}

void lin_weigh_rows(const lcp_factored *f, const double *L, double *G) {
  weigh_groups(f, L, G);
}

void lin_weigh_stored(const lcp_factored *f, const double *L, double *G) {
  weigh_stored(f, L, G);
}

size_t lin_stored_length(const lcp_factored *f) {
  size_t most = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int dof = lcp_factored_dof(f, g, 0) + lcp_factored_dof(f, g, 1);
    const size_t end =
        (size_t)lcp_factored_at(f, g) + (size_t)lcp_factored_stored(f, g) * (size_t)dof;
    most = (end > most) ? end : most;
  }
  return most;
}
