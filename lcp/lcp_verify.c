/* lcp_verify.c - certificates checked in rational arithmetic. GMP's own allocator ends the process
 * when memory runs out; sizes are bounded (n <= 64 for the elimination, one sum at a time else).
 *
 * No header of a solver is included, and scripts/check_layers.sh holds the file to that: whatever decides here
 * was not written for the method that made the claim. */
#include "lcp/lcp_certificate.h"
#include "lcp/lcp_judge.h"
#include "lcp/lcp_wide_column.h"

#include <float.h>
#include <gmp.h>
#include <stdlib.h>

/* ---- Farkas -------------------------------------------------------------------------------- */

/* sum += a b */
static void add_product(mpq_t sum, mpq_t x, mpq_t y, double a, double b) {
  if (a != 0 && b != 0) {
    mpq_set_d(x, a);
    mpq_set_d(y, b);
    mpq_mul(x, x, y);
    mpq_add(sum, sum, x);
  }
}

static bool is_free(const lcp_problem *p, const unsigned char *set, int i) {
  return p->block != NULL && set[i] == LCP_FREE;
}

/* A row of friction of a cone, told by lcp_certificate_verify. */
static bool is_sideways(const lcp_problem *p, const unsigned char *set, int i) {
  return p->block != NULL && set[i] == LCP_CONE;
}

static const char *farkas_fault(const lcp_problem *p, const lcp_csc *M, const unsigned char *set,
                                const double *y) {
  mpq_t sum;
  mpq_t a;
  mpq_t b;
  mpq_inits(sum, a, b, NULL);
  const char *fault = NULL;
  for (int i = 0; i < p->M.n; i++) {
    add_product(sum, a, b, p->q[i], y[i]);
    fault = (y[i] < 0 && !is_free(p, set, i)) ? "y has a negative entry" : fault;
    fault = (y[i] != 0 && is_sideways(p, set, i)) ? "y has an entry in a row of friction" : fault;
  }
  fault = (mpq_sgn(sum) >= 0) ? "q'y is not negative" : fault;
  for (int j = 0; j < M->n_col && fault == NULL; j++) {
    mpq_set_si(sum, 0, 1);
    for (int k = M->colptr[j]; k < M->colptr[j + 1]; k++) {
      add_product(sum, a, b, M->val[k], y[M->rowind[k]]);
    }
    const int sign = mpq_sgn(sum);
    const bool zero = is_free(p, set, j) || is_sideways(p, set, j);
    fault = (sign > 0 || (sign < 0 && zero)) ? "M'y has an entry of the wrong sign" : NULL;
  }
  mpq_clears(sum, a, b, NULL);
  return fault;
}

/* ---- basis --------------------------------------------------------------------------------- */

typedef struct exact {
  int n, m;
  int row[LCP_CERT_EXACT_N];                       /* basic rows */
  mpq_t a[LCP_CERT_EXACT_N][LCP_CERT_EXACT_N + 1]; /* [M_BB | -q_B] */
  mpq_t M[LCP_CERT_EXACT_N][LCP_CERT_EXACT_N];
  mpq_t z[LCP_CERT_EXACT_N], t;
} exact;

static void exact_open(exact *e, const lcp_problem *p, const double *dense,
                       const unsigned char *basis) {
  e->n = p->M.n;
  e->m = 0;
  mpq_init(e->t);
  for (int i = 0; i < e->n; i++) {
    mpq_init(e->z[i]);
    e->row[e->m] = i;
    e->m += basis[i] != 0;
    for (int j = 0; j < e->n; j++) {
      mpq_init(e->M[i][j]);
      mpq_set_d(e->M[i][j], dense[(ptrdiff_t)j * e->n + i]);
    }
  }
  for (int i = 0; i < e->m; i++) {
    for (int j = 0; j <= e->m; j++) {
      mpq_init(e->a[i][j]);
      if (j < e->m) {
        mpq_set(e->a[i][j], e->M[e->row[i]][e->row[j]]);
      } else {
        mpq_set_d(e->a[i][j], -p->q[e->row[i]]);
      }
    }
  }
}

static void exact_close(exact *e) {
  for (int i = 0; i < e->n; i++) {
    mpq_clear(e->z[i]);
    for (int j = 0; j < e->n; j++) {
      mpq_clear(e->M[i][j]);
    }
  }
  for (int i = 0; i < e->m; i++) {
    for (int j = 0; j <= e->m; j++) {
      mpq_clear(e->a[i][j]);
    }
  }
  mpq_clear(e->t);
}

/* Row i -= f times row k, f = a_ic / a_kc. */
static void eliminate(exact *e, int i, int k, int c) {
  if (mpq_sgn(e->a[i][c]) == 0) {
    return;
  }
  mpq_t f;
  mpq_init(f);
  mpq_div(f, e->a[i][c], e->a[k][c]);
  for (int j = c; j <= e->m; j++) {
    mpq_mul(e->t, f, e->a[k][j]);
    mpq_sub(e->a[i][j], e->a[i][j], e->t);
  }
  mpq_clear(f);
}

/* Gauss-Jordan; unknowns of dependent columns stay zero. False: no solution. */
static bool exact_solve(exact *e) {
  int lead[LCP_CERT_EXACT_N];
  int rank = 0;
  for (int c = 0; c < e->m && rank < e->m; c++) {
    int r = rank;
    while (r < e->m && mpq_sgn(e->a[r][c]) == 0) {
      r++;
    }
    if (r == e->m) {
      continue;
    }
    for (int j = 0; j <= e->m; j++) {
      mpq_swap(e->a[r][j], e->a[rank][j]);
    }
    for (int i = 0; i < e->m; i++) {
      if (i != rank) {
        eliminate(e, i, rank, c);
      }
    }
    lead[rank++] = c;
  }
  for (int i = rank; i < e->m; i++) {
    if (mpq_sgn(e->a[i][e->m]) != 0) {
      return false;
    }
  }
  for (int i = 0; i < rank; i++) {
    mpq_div(e->z[e->row[lead[i]]], e->a[i][e->m], e->a[i][lead[i]]);
  }
  return true;
}

static const char *basis_fault(exact *e, const lcp_problem *p, const unsigned char *basis,
                               const unsigned char *set) {
  if (!exact_solve(e)) {
    return "M_BB z = -q_B has no solution";
  }
  mpq_t w;
  mpq_init(w);
  const char *fault = NULL;
  for (int i = 0; i < e->n && fault == NULL; i++) {
    mpq_set_d(w, p->q[i]);
    for (int j = 0; j < e->n; j++) {
      mpq_mul(e->t, e->M[i][j], e->z[j]);
      mpq_add(w, w, e->t);
    }
    const bool free_row = is_free(p, set, i);
    if (mpq_sgn(e->z[i]) < 0 && !free_row) {
      fault = "a basic z is negative";
    } else if (mpq_sgn(w) < 0 || (free_row && mpq_sgn(w) != 0) || (basis[i] && mpq_sgn(w) != 0)) {
      fault = "a w has the wrong sign";
    }
  }
  mpq_clear(w);
  return fault;
}

static base_status verify_basis(const lcp_problem *p, const unsigned char *basis, const double *z,
                                const unsigned char *set, lcp_certificate_verdict *out,
                                base_error *err) {
  lcp_verdict v;
  BASE_TRY(lcp_judge(p, z, &v, err));
  const bool small = lcp_judged_small(&v, LCP_VERIFY_EXACT) && v.noise <= 1e-3;
  out->residual = v.rho;
  out->holds = v.rho <= LCP_VERIFY_EXACT && small;
  out->why = small ? "rho of z in extended precision"
                   : "z is so large that rho means nothing: w is not small against q";
  if (p->M.n > LCP_CERT_EXACT_N) {
    return BASE_OK;
  }
  double *dense = malloc(((size_t)p->M.n * (size_t)p->M.n + 1) * sizeof *dense);
  exact *e = malloc(sizeof *e);
  if (dense == NULL || e == NULL) {
    free(dense);
    free(e);
    return BASE_FAIL(err, BASE_ENOMEM, "certificate: no memory for %d rows", p->M.n);
  }
  lcp_matrix_to_dense(&p->M, dense);
  exact_open(e, p, dense, basis);
  const char *fault = basis_fault(e, p, basis, set);
  exact_close(e);
  free(e);
  free(dense);
  out->exact = fault == NULL;
  out->holds = out->holds || (out->exact && v.rho <= LCP_VERIFY_EXACT);
  if (out->exact) {
    out->why = "the basis solves the problem in rational arithmetic";
  } else if (!out->holds) {
    out->why = fault;
  }
  return BASE_OK;
}

/* ---- all kinds ----------------------------------------------------------------------------- */

/* *still: J'y = 0 in rational arithmetic. M'y is then S'y, where the rounded entries of J W J' would not
 * cancel. */
static base_status moves_nothing(const lcp_factored *f, const double *y, bool *still,
                                 base_error *err) {
  const int n_dof = f->dof_start[f->n_body];
  mpq_t *force = malloc(((size_t)n_dof + 2) * sizeof *force);
  if (force == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "certificate: no memory for %d velocities", n_dof);
  }
  for (int c = 0; c < n_dof + 2; c++) {
    mpq_init(force[c]);
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      const int dof = (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
      double room[LCP_MIXED_MAX] = {0};
      const double *jac = (b < 0) ? NULL : lcp_wide_factored_rows(f, g, side, room);
      for (int i = f->row_start[g]; i < f->row_start[g + 1] && b >= 0; i++, jac += dof) {
        for (int c = 0; c < dof; c++) {
          add_product(force[f->dof_start[b] + c], force[n_dof], force[n_dof + 1], jac[c], y[i]);
        }
      }
    }
  }
  *still = true;
  for (int c = 0; c < n_dof + 2; c++) {
    *still = *still && (c >= n_dof || mpq_sgn(force[c]) == 0);
    mpq_clear(force[c]);
  }
  free(force);
  return BASE_OK;
}

/* What M'y is the product of: M, or S alone where that is exact. */
static base_status farkas_matrix(const lcp_problem *p, const double *y, lcp_csc *own,
                                 const lcp_csc **M, base_error *err) {
  static const lcp_csc nothing = {0};
  bool still = false;
  if (p->M.storage == LCP_FACTORED) {
    BASE_TRY(moves_nothing(p->M.factored, y, &still, err));
  }
  if (still) {
    *M = (p->M.factored->shift != NULL) ? p->M.factored->shift : &nothing;
    return BASE_OK;
  }
  *M = own;
  return lcp_matrix_to_csc(&p->M, own, err);
}

static base_status verify_farkas(const lcp_problem *p, const double *y, const unsigned char *set,
                                 lcp_certificate_verdict *out, base_error *err) {
  lcp_csc own = {0};
  const lcp_csc *M;
  BASE_TRY(farkas_matrix(p, y, &own, &M, err));
  const char *fault = farkas_fault(p, M, set, y);
  lcp_csc_free(&own);
  long double gain = 0;
  long double size = 0;
  for (int i = 0; i < p->M.n; i++) {
    gain += (long double)p->q[i] * y[i];
    size += fabsl((long double)p->q[i] * y[i]);
  }
  out->residual = (size > 0) ? (double)(gain / size) : 0;
  out->holds = fault == NULL;
  out->exact = fault == NULL;
  out->why = (fault == NULL) ? "y >= 0, M'y <= 0, q'y < 0 in rational arithmetic" : fault;
  return BASE_OK;
}

/* max over i of v_i (Mv)_i / (v_i (|M||v|)_i), or of |..| in free rows; HUGE_VAL unless v >= 0 elsewhere
 * and v != 0. */
static double reversal_fault(const lcp_problem *p, const unsigned char *set, const double *v,
                             lcp_wide_columns *columns, long double *product, long double *size) {
  bool zero = true;
  for (int j = 0; j < p->M.n; j++) {
    if (v[j] < 0 && !is_free(p, set, j)) {
      return HUGE_VAL;
    }
    const lcp_wide_column c = lcp_wide_columns_at(columns, j);
    for (int k = 0; k < c.count; k++) {
      product[c.row[k]] += c.val[k] * v[j];
      size[c.row[k]] += fabsl(c.val[k] * v[j]);
    }
    zero = zero && v[j] == 0;
  }
  double worst = zero ? HUGE_VAL : 0;
  for (int i = 0; i < p->M.n; i++) {
    const long double sign = is_free(p, set, i) ? copysignl(1, product[i]) : 1;
    const bool counts = (v[i] != 0 || is_free(p, set, i)) && size[i] > 0;
    worst = counts ? fmax(worst, (double)(sign * product[i] / size[i])) : worst;
  }
  return worst;
}

static base_status verify_ray(const lcp_problem *p, const double *ray, const unsigned char *set,
                              lcp_certificate_verdict *out, base_error *err) {
  lcp_wide_columns columns;
  BASE_TRY(lcp_wide_columns_open(&columns, &p->M, err));
  long double *sums = calloc(2 * (size_t)p->M.n + 1, sizeof *sums);
  if (sums == NULL) {
    lcp_wide_columns_close(&columns);
    return BASE_FAIL(err, BASE_ENOMEM, "certificate: no memory for %d rows", p->M.n);
  }
  out->residual = reversal_fault(p, set, ray, &columns, sums, sums + p->M.n);
  out->holds = out->residual <= LCP_CERT_RAY_TOL;
  out->why = out->holds ? "M reverses the sign of a ray: no P-matrix, nothing more"
                        : "no ray: v >= 0, v != 0, v_i (Mv)_i <= 0 fails";
  free(sums);
  lcp_wide_columns_close(&columns);
  return BASE_OK;
}

static bool all_finite(const double *x, int n) {
  bool good = true;
  for (int i = 0; i < n; i++) {
    good = good && isfinite(x[i]);
  }
  return good;
}

base_status lcp_certificate_verify(const lcp_problem *p, const lcp_certificate *c, const double *z,
                                   lcp_certificate_verdict *out, base_error *err) {
  *out = (lcp_certificate_verdict){.why = ""};
  const unsigned unchecked = (1u << LCP_BOX) | ((c->kind == LCP_CERT_FARKAS) ? 0 : 1u << LCP_CONE);
  if ((lcp_problem_sets(p) & unchecked) != 0) {
    return BASE_FAIL(
        err, BASE_EINVAL,
        "certificate: only orthant and free rows, and of cones only Farkas vectors, are checked");
  }
  if (c->kind == LCP_CERT_BASIS ? c->basis == NULL
                                : c->vector == NULL || !all_finite(c->vector, p->M.n)) {
    out->why = "the solver handed over no finite numbers";
    return BASE_OK;
  }
  unsigned char *set = calloc((size_t)p->M.n + 1, 1);
  if (set == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "certificate: no memory for %d rows", p->M.n);
  }
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    for (int i = 0; i < p->block[k].size; i++) {
      const bool normal = p->block[k].set == LCP_CONE && i == 0;
      set[p->block[k].start + i] = (unsigned char)(normal ? LCP_ORTHANT : p->block[k].set);
    }
  }
  base_status status = BASE_OK;
  if (c->kind == LCP_CERT_BASIS) {
    status = verify_basis(p, c->basis, z, set, out, err);
  } else if (c->kind == LCP_CERT_FARKAS) {
    status = verify_farkas(p, c->vector, set, out, err);
  } else {
    status = verify_ray(p, c->vector, set, out, err);
  }
  free(set);
  return status;
}

base_status lcp_certificate_file_verify(const lcp_problem *p, const lcp_certificate_file *f,
                                        lcp_certificate_verdict *out, base_error *err) {
  const lcp_certificate c = {f->kind, f->basis, f->vector};
  if (f->n != p->M.n) {
    *out = (lcp_certificate_verdict){.why = ""};
    return BASE_FAIL(err, BASE_EINVAL, "certificate: %d rows, the problem has %d", f->n, p->M.n);
  }
  return lcp_certificate_verify(p, &c, f->vector, out, err);
}
