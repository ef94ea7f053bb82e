/* Bilateral rows of a local friction problem, eliminated:
 *   u = W r + V l + q,   0 = V' r + R l + s   gives   u = (W - V R^-1 V') r + (q - V R^-1 s).
 * R must be symmetric positive definite, which it is where joints are independent. Densely: joints tie bodies
 * into chains, and R^-1 is full along a chain, so W becomes full anyway. */
#include "problems/families/triplets.h"
#include "problems/import/friction_problem.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double ENTRIES_MAX = 5e7; /* of W, V and R each, 400 MB */

/* out += A, column-major. */
static void add_sparse(const lcp_csc *A, double *out) {
  for (int j = 0; j < A->n_col; j++) {
    for (int at = A->colptr[j]; at < A->colptr[j + 1]; at++) {
      out[(size_t)j * (size_t)A->n_row + (size_t)A->rowind[at]] += A->val[at];
    }
  }
}

static base_status from_dense(const double *A, int n, lcp_csc *out, base_error *err) {
  triplets t;
  BASE_TRY(triplets_open(&t, n, n, n * n, err));
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      const double x = A[(size_t)j * (size_t)n + (size_t)i];
      if (x != 0.0) {
        triplets_add(&t, i, j, x);
      }
    }
  }
  const base_status status = triplets_to_csc(&t, out, err);
  triplets_free(&t);
  return status;
}

/* L of R = L L', in place; `diagonal` receives that of R. */
static base_status factorise(double *R, int m, double *diagonal, base_error *err) {
  const double dependent = 1e-12; /* share of a diagonal entry left after the rows before it */
  for (int j = 0; j < m; j++) {
    for (int i = 0; i < j; i++) {
      const double a = R[j * m + i], b = R[i * m + j];
      if (!(fabs(a - b) <= 1e-9 * (fabs(a) + fabs(b) + 1e-300))) {
        return BASE_FAIL(err, BASE_EINVAL, "R is not symmetric: %g and %g", a, b);
      }
    }
  }
  for (int j = 0; j < m; j++) {
    diagonal[j] = R[j * m + j];
  }
  bool good = LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', m, R, m) == 0;
  for (int j = 0; good && j < m; j++) {
    good = R[j * m + j] * R[j * m + j] > dependent * diagonal[j];
  }
  if (!good) {
    return BASE_FAIL(err, BASE_EINVAL, "R is not positive definite: joints that repeat each other");
  }
  return BASE_OK;
}

/* Y = L^-1 V', y = L^-1 s:  W = -Y' Y, exactly symmetric, q -= Y' y. */
static void eliminate(const double *L, double *Y, double *y, int m, int n, double *W, double *q) {
  (void)LAPACKE_dtrtrs(LAPACK_COL_MAJOR, 'L', 'N', 'N', m, n, L, m, Y, m);
  (void)LAPACKE_dtrtrs(LAPACK_COL_MAJOR, 'L', 'N', 'N', m, 1, L, m, y, m);
  cblas_dsyrk(CblasColMajor, CblasLower, CblasTrans, n, m, -1.0, Y, m, 0.0, W, n);
  for (size_t j = 0; j < (size_t)n; j++) {
    for (size_t i = j + 1; i < (size_t)n; i++) {
      W[i * (size_t)n + j] = W[j * (size_t)n + i];
    }
  }
  cblas_dgemv(CblasColMajor, CblasTrans, m, n, -1.0, Y, m, y, 1, 1.0, q, 1);
}

/* V' by columns: m x n. */
static void transpose(const lcp_csc *V, double *Y) {
  const size_t m = (size_t)V->n_col;
  memset(Y, 0, m * (size_t)V->n_row * sizeof *Y);
  for (int j = 0; j < V->n_col; j++) {
    for (int at = V->colptr[j]; at < V->colptr[j + 1]; at++) {
      Y[(size_t)V->rowind[at] * m + (size_t)j] = V->val[at];
    }
  }
}

static base_status reduce(friction_problem *p, double *R, double *Y, double *W, base_error *err) {
  const int n = p->rows * p->n_contact;
  memset(R, 0, (size_t)p->n_joint * (size_t)p->n_joint * sizeof *R);
  add_sparse(&p->R, R);
  BASE_TRY(factorise(R, p->n_joint, Y, err)); /* Y: scratch so far, at least one column */
  transpose(&p->V, Y);
  eliminate(R, Y, p->s, p->n_joint, n, W, p->q);
  add_sparse(&p->W, W);
  lcp_csc reduced;
  BASE_TRY(from_dense(W, n, &reduced, err));
  lcp_csc_free(&p->W);
  p->W = reduced;
  return BASE_OK;
}

base_status friction_eliminate_joints(friction_problem *p, base_error *err) {
  const double n = (double)p->rows * p->n_contact, m = p->n_joint;
  if (p->n_joint == 0) {
    return BASE_OK;
  }
  if (n * n > ENTRIES_MAX || n * m > ENTRIES_MAX || m * m > ENTRIES_MAX) {
    return BASE_FAIL(err, BASE_EINVAL, "%d joint rows beside %d contacts: too many to eliminate",
                     p->n_joint, p->n_contact);
  }
  double *R = malloc((size_t)(m * m) * sizeof *R), *Y = malloc((size_t)(n * m) * sizeof *Y);
  double *W = malloc((size_t)(n * n) * sizeof *W);
  const base_status status = (R == NULL || Y == NULL || W == NULL)
                                 ? BASE_FAIL(err, BASE_ENOMEM, "no memory for joints")
                                 : reduce(p, R, Y, W, err);
  free(R);
  free(Y);
  free(W);
  if (status == BASE_OK) {
    lcp_csc_free(&p->V);
    lcp_csc_free(&p->R);
    free(p->s);
    p->s = NULL;
    p->n_joint = 0;
  }
  return status;
}

/* Rows r0 .. r0+m-1 and columns c0 .. c0+n-1 of A. */
static base_status part(const lcp_csc *A, int r0, int m, int c0, int n, lcp_csc *out,
                        base_error *err) {
  triplets t;
  BASE_TRY(triplets_open(&t, m, n, A->colptr[c0 + n] - A->colptr[c0], err));
  for (int j = 0; j < n; j++) {
    for (int at = A->colptr[c0 + j]; at < A->colptr[c0 + j + 1]; at++) {
      const int i = A->rowind[at] - r0;
      if (i >= 0 && i < m) {
        triplets_add(&t, i, j, A->val[at]);
      }
    }
  }
  const base_status status = triplets_to_csc(&t, out, err);
  triplets_free(&t);
  return status;
}

base_status friction_split_joints(friction_problem *p, base_error *err) {
  const int n = p->rows * p->n_contact, m = p->n_joint;
  lcp_csc W = p->W;
  if (m == 0) {
    return BASE_OK;
  }
  p->W = (lcp_csc){0};
  base_status status = part(&W, 0, n, 0, n, &p->W, err);
  if (status == BASE_OK) {
    status = part(&W, 0, n, n, m, &p->V, err);
  }
  if (status == BASE_OK) {
    status = part(&W, n, m, n, m, &p->R, err);
  }
  lcp_csc_free(&W);
  p->s = malloc((size_t)m * sizeof *p->s);
  if (status == BASE_OK && p->s == NULL) {
    status = BASE_FAIL(err, BASE_ENOMEM, "no memory for %d joint rows", m);
  }
  if (status == BASE_OK) {
    memcpy(p->s, p->q + n, (size_t)m * sizeof *p->s);
  }
  return status;
}

base_status friction_join_joints(friction_problem *p, base_error *err) {
  const int n = p->H.n_col, m = p->n_joint, dofs = p->H.n_row;
  if (m == 0) {
    return BASE_OK;
  }
  triplets t;
  lcp_csc both;
  BASE_TRY(triplets_open(&t, dofs, n + m, p->H.colptr[n] + p->G.colptr[m], err));
  const lcp_csc *const side[2] = {&p->H, &p->G};
  for (int k = 0; k < 2; k++) {
    for (int j = 0; j < side[k]->n_col; j++) {
      for (int at = side[k]->colptr[j]; at < side[k]->colptr[j + 1]; at++) {
        triplets_add(&t, side[k]->rowind[at], (k == 0) ? j : n + j, side[k]->val[at]);
      }
    }
  }
  const base_status status = triplets_to_csc(&t, &both, err);
  triplets_free(&t);
  BASE_TRY(status);
  double *w = realloc(p->w, (size_t)(n + m) * sizeof *w);
  if (w == NULL) {
    lcp_csc_free(&both);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d joint rows", m);
  }
  memcpy(w + n, p->b, (size_t)m * sizeof *w);
  p->w = w;
  lcp_csc_free(&p->H);
  lcp_csc_free(&p->G);
  free(p->b);
  p->b = NULL;
  p->H = both;
  return BASE_OK;
}
