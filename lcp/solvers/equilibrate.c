#include "lcp/solvers/equilibrate.h"

#include "lcp/lcp_column.h"
#include "lcp/solvers/sets.h"

enum { ROUNDS = 20 };

/* c_j <- sum_i r_i |M_ij| where `columns`, else r_i <- sum_j |M_ij| c_j; the result is inverted. */
static void round_of(const lcp_matrix *M, bool columns, const double *from, double *to) {
  const int n = M->n;
  for (int i = 0; i < n; i++) {
    to[i] = 0.0;
  }
  for (int j = 0; j < n; j++) {
    const lcp_column c = lcp_column_of(M, j);
    for (int k = 0; k < c.count; k++) {
      const int i = lcp_column_row(&c, k);
      to[columns ? j : i] += fabs(c.val[k]) * from[columns ? i : j];
    }
  }
  for (int i = 0; i < n; i++) {
    to[i] = (to[i] > 0.0) ? 1.0 / to[i] : 1.0;
  }
}

void lcp_equilibrate(const lcp_matrix *M, const double *d, double *r, double *c) {
  lcp_set_scaling(M, d, c);
  if (M->storage == LCP_FACTORED) {
    for (int i = 0; i < M->n; i++) {
      r[i] = c[i];
    }
    return;
  }
  for (int k = 0; k < ROUNDS; k++) {
    round_of(M, false, c, r);
    round_of(M, true, r, c);
  }
}
