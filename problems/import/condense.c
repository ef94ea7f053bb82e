/* W = H' M^-1 H and q = H' M^-1 f + w by sparse Cholesky of M (CHOLMOD). */
#include "lcp/linear/cholmod_library.h"
#include "problems/import/friction_problem.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Inertia matrices that other codes rotated or printed are symmetric to five or six digits only. */
static const double ASYMMETRY_MAX = 1e-5;

/* Largest |M_ij - M_ji| over the largest entry; M has sorted columns. */
static double asymmetry(const lcp_csc *M) {
  double worst = 0.0, scale = 0.0;
  for (int j = 0; j < M->n_col; j++) {
    for (int at = M->colptr[j]; at < M->colptr[j + 1]; at++) {
      const int i = M->rowind[at];
      int lo = M->colptr[i], hi = M->colptr[i + 1];
      while (lo < hi) { /* row j in column i */
        const int mid = lo + (hi - lo) / 2;
        if (M->rowind[mid] < j) {
          lo = mid + 1;
        } else {
          hi = mid;
        }
      }
      const double twin = (lo < M->colptr[i + 1] && M->rowind[lo] == j) ? M->val[lo] : 0.0;
      worst = fmax(worst, fabs(M->val[at] - twin));
      scale = fmax(scale, fabs(M->val[at]));
    }
  }
  return (scale > 0.0) ? worst / scale : 0.0;
}

/* A heap copy that CHOLMOD owns, with both triangles. */
static cholmod_sparse *copy_in(const lcp_csc *A, cholmod_session *c) {
  const size_t nnz = (size_t)A->colptr[A->n_col];
  cholmod_sparse *B = c->of.cholmod_allocate_sparse((size_t)A->n_row, (size_t)A->n_col, nnz, 1, 1,
                                                    0, CHOLMOD_REAL, &c->common);
  if (B != NULL) {
    memcpy(B->p, A->colptr, ((size_t)A->n_col + 1) * sizeof(int));
    memcpy(B->i, A->rowind, nnz * sizeof(int));
    memcpy(B->x, A->val, nnz * sizeof(double));
  }
  return B;
}

/* (B + B')/2 as an owned matrix: rounding must not make a symmetric problem nonsymmetric. */
static cholmod_sparse *symmetrised(cholmod_sparse *B, cholmod_session *c) {
  double half[2] = {0.5, 0.0};
  cholmod_sparse *T = (B != NULL) ? c->of.cholmod_transpose(B, 1, &c->common) : NULL;
  cholmod_sparse *S = (T != NULL) ? c->of.cholmod_add(B, T, half, half, 1, 1, &c->common) : NULL;
  c->of.cholmod_free_sparse(&T, &c->common);
  return S;
}

static base_status copy_out(const cholmod_sparse *A, lcp_csc *out, base_error *err) {
  const int *p = A->p;
  const size_t nnz = (size_t)p[A->ncol];
  int *colptr = malloc((A->ncol + 1) * sizeof *colptr);
  int *rowind = malloc((nnz + 1) * sizeof *rowind);
  double *val = malloc((nnz + 1) * sizeof *val);
  if (colptr == NULL || rowind == NULL || val == NULL) {
    free(colptr);
    free(rowind);
    free(val);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu entries of W", nnz);
  }
  memcpy(colptr, p, (A->ncol + 1) * sizeof *colptr);
  memcpy(rowind, A->i, nnz * sizeof *rowind);
  memcpy(val, A->x, nnz * sizeof *val);
  *out = (lcp_csc){(int)A->nrow, (int)A->ncol, colptr, rowind, val};
  return BASE_OK;
}

typedef struct pieces {
  cholmod_sparse *M, *H, *X, *HT, *W, *S;
  cholmod_factor *L;
  cholmod_dense *f, *v;
} pieces;

static void release(pieces *k, cholmod_session *c) {
  c->of.cholmod_free_sparse(&k->M, &c->common);
  c->of.cholmod_free_sparse(&k->H, &c->common);
  c->of.cholmod_free_sparse(&k->X, &c->common);
  c->of.cholmod_free_sparse(&k->HT, &c->common);
  c->of.cholmod_free_sparse(&k->W, &c->common);
  c->of.cholmod_free_sparse(&k->S, &c->common);
  c->of.cholmod_free_factor(&k->L, &c->common);
  c->of.cholmod_free_dense(&k->f, &c->common);
  c->of.cholmod_free_dense(&k->v, &c->common);
}

/* First column without a positive pivot, or n. CHOLMOD's simplicial L D L' stops at a zero of D only. */
static size_t indefinite_at(const cholmod_factor *L) {
  const int *p = L->p;
  const double *x = L->x;
  for (size_t j = 0; j < L->minor && !L->is_super && !L->is_ll; j++) {
    if (!(x[p[j]] > 0.0)) {
      return j;
    }
  }
  return L->minor;
}

static base_status factorise(const friction_problem *p, pieces *k, cholmod_session *c,
                             base_error *err) {
  cholmod_sparse *M = copy_in(&p->M, c), *S = symmetrised(M, c);
  k->M = (S != NULL) ? c->of.cholmod_copy(S, 1, 1, &c->common)
                     : NULL; /* upper triangle of the symmetric part */
  c->of.cholmod_free_sparse(&M, &c->common);
  c->of.cholmod_free_sparse(&S, &c->common);
  k->H = copy_in(&p->H, c);
  k->L = (k->M != NULL) ? c->of.cholmod_analyze(k->M, &c->common) : NULL;
  if (k->H == NULL || k->L == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "M of %d dofs: no memory to analyse", p->M.n_col);
  }
  (void)c->of.cholmod_factorize(k->M, k->L, &c->common);
  if (c->common.status < CHOLMOD_OK) {
    return BASE_FAIL(err, BASE_ENOMEM, "M of %d dofs: no memory to factorise", p->M.n_col);
  }
  const size_t bad = indefinite_at(k->L);
  if (c->common.status != CHOLMOD_OK || bad < k->L->n) {
    return BASE_FAIL(err, BASE_EINVAL, "M is not positive definite (pivot %zu)", bad + 1);
  }
  return BASE_OK;
}

static base_status solve(const friction_problem *p, pieces *k, cholmod_session *c, lcp_csc *W,
                         double *q, base_error *err) {
  const size_t n_dof = (size_t)p->M.n_col;
  k->X = c->of.cholmod_spsolve(CHOLMOD_A, k->L, k->H, &c->common);
  k->HT = c->of.cholmod_transpose(k->H, 1, &c->common);
  k->W = (k->X != NULL && k->HT != NULL) ? c->of.cholmod_ssmult(k->HT, k->X, 0, 1, 1, &c->common)
                                         : NULL;
  k->S = symmetrised(k->W, c);
  k->f = c->of.cholmod_allocate_dense(n_dof, 1, n_dof, CHOLMOD_REAL, &c->common);
  if (k->S == NULL || k->f == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for W");
  }
  (void)c->of.cholmod_sort(k->S, &c->common);
  memcpy(k->f->x, p->f, n_dof * sizeof(double));
  k->v = c->of.cholmod_solve(CHOLMOD_A, k->L, k->f, &c->common);
  if (k->v == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the free velocity");
  }
  const double *v = k->v->x;
  for (int j = 0; j < p->H.n_col; j++) {
    q[j] = p->w[j];
    for (int at = p->H.colptr[j]; at < p->H.colptr[j + 1]; at++) {
      q[j] += p->H.val[at] * v[p->H.rowind[at]];
    }
  }
  return copy_out(k->S, W, err);
}

/* A global problem whose joints stand beside its contacts in H and w. */
static base_status condense(friction_problem *p, base_error *err) {
  const double skew = asymmetry(&p->M);
  if (!(skew <= ASYMMETRY_MAX)) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "M is not symmetric: relative difference %.2g", skew);
  }
  cholmod_session c;
  pieces k = {0};
  lcp_csc W = {0};
  BASE_TRY(cholmod_begin(&c, err));
  double *q = malloc(((size_t)p->H.n_col + 1) * sizeof *q);
  base_status status =
      (q != NULL) ? factorise(p, &k, &c, err) : BASE_FAIL(err, BASE_ENOMEM, "no memory for q");
  if (status == BASE_OK) {
    status = solve(p, &k, &c, &W, q, err);
  }
  release(&k, &c);
  (void)c.of.cholmod_finish(&c.common);
  if (status != BASE_OK) {
    free(q);
    return status;
  }
  lcp_csc_free(&p->M);
  lcp_csc_free(&p->H);
  free(p->f);
  free(p->w);
  p->f = p->w = NULL;
  p->W = W;
  p->q = q;
  p->global = false;
  return BASE_OK;
}

base_status friction_condense(friction_problem *p, base_error *err) {
  if (p->global) {
    BASE_TRY(friction_join_joints(p, err));
    BASE_TRY(condense(p, err));
    BASE_TRY(friction_split_joints(p, err));
  }
  return friction_eliminate_joints(p, err);
}
