#include "problems/import/friction_problem.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void friction_free(friction_problem *p) {
  lcp_csc_free(&p->W);
  lcp_csc_free(&p->M);
  lcp_csc_free(&p->H);
  lcp_csc_free(&p->V);
  lcp_csc_free(&p->R);
  lcp_csc_free(&p->G);
  free(p->s);
  free(p->b);
  free(p->q);
  free(p->f);
  free(p->w);
  free(p->mu);
  free(p->mu_r);
  memset(p, 0, sizeof *p);
}

static base_status check_vector(const char *what, const double *x, int n, double least,
                                base_error *err) {
  if (x == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is missing", what);
  }
  for (int i = 0; i < n; i++) {
    if (!isfinite(x[i]) || x[i] < least) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: entry %d is %g: need a finite number%s", what, i + 1,
                       x[i], (least == 0.0) ? " >= 0" : "");
    }
  }
  return BASE_OK;
}

static base_status check_matrix(const char *what, const lcp_csc *A, int n_row, int n_col,
                                base_error *err) {
  if (A->colptr == NULL || A->n_row != n_row || A->n_col != n_col) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is %d x %d: need %d x %d", what, A->n_row, A->n_col,
                     n_row, n_col);
  }
  for (int i = 0; i < A->colptr[n_col]; i++) {
    if (!isfinite(A->val[i])) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: an entry of row %d is %g", what, A->rowind[i] + 1,
                       A->val[i]);
    }
  }
  return BASE_OK;
}

static base_status check_joints(const friction_problem *p, base_error *err) {
  const int m = p->n_joint;
  if (m == 0) {
    return BASE_OK;
  }
  if (p->global) {
    BASE_TRY(check_matrix("G", &p->G, p->M.n_row, m, err));
    return check_vector("b", p->b, m, -HUGE_VAL, err);
  }
  BASE_TRY(check_matrix("V", &p->V, p->rows * p->n_contact, m, err));
  BASE_TRY(check_matrix("R", &p->R, m, m, err));
  return check_vector("s", p->s, m, -HUGE_VAL, err);
}

base_status friction_check(const friction_problem *p, base_error *err) {
  if (p->rows != 2 && p->rows != 3 && p->rows != 5) {
    return BASE_FAIL(err, BASE_EINVAL, "%d rows a contact: need 2, 3, or 5 with rolling", p->rows);
  }
  const int n = p->rows * p->n_contact, any = p->global ? p->M.n_row : 0;
  BASE_TRY(check_vector("mu", p->mu, p->n_contact, 0.0, err));
  if (p->rows == 5) {
    BASE_TRY(check_vector("mu_r", p->mu_r, p->n_contact, 0.0, err));
  }
  if (p->global) {
    BASE_TRY(check_matrix("M", &p->M, any, any, err));
    BASE_TRY(check_matrix("H", &p->H, any, n, err));
    BASE_TRY(check_vector("f", p->f, any, -HUGE_VAL, err));
    BASE_TRY(check_vector("w", p->w, n, -HUGE_VAL, err));
    return check_joints(p, err);
  }
  BASE_TRY(check_matrix("W", &p->W, n, n, err));
  BASE_TRY(check_vector("q", p->q, n, -HUGE_VAL, err));
  return check_joints(p, err);
}
