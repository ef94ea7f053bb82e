/* loop_rho.c - rho as the judge defines it, in double, for orthants, boxes and free rows. */
#include "lcp/solvers/loop_rho.h"

/* Columns of what is stored: M, or S of the factored form (n_col = 0 where there is none). */
static int column(const lcp_matrix *M, int j, const double **val, const int **row) {
  static const double none = 0.0;
  *row = NULL;
  if (M->storage == LCP_DENSE) {
    *val = M->val + (size_t)j * (size_t)M->n;
    return M->n;
  }
  const lcp_csc *c = (M->storage == LCP_CSC) ? &M->csc : M->factored->shift;
  if (c == NULL) {
    *val = &none;
    return 0;
  }
  *val = c->val + c->colptr[j];
  *row = c->rowind + c->colptr[j];
  return c->colptr[j + 1] - c->colptr[j];
}

void lcp_loop_magnitudes(const lcp_problem *p, const double *x, double *out) {
  for (int i = 0; i < p->M.n; i++) {
    out[i] = fabs(p->q[i]);
  }
  for (int j = 0; j < p->M.n; j++) {
    const double *val;
    const int *row;
    const int count = column(&p->M, j, &val, &row);
    const double xj = fabs(x[j]);
    for (int k = 0; k < count; k++) {
      out[(row != NULL) ? row[k] : k] += fabs(val[k]) * xj;
    }
  }
}

static double reference(const lcp_matrix *M, int i, double d, const double *tau0) {
  if (d != 0.0) {
    return tau0[i] / fabs(d);
  }
  const double *val;
  const int *row;
  const int count = column(M, i, &val, &row);
  double ref = -1.0;
  for (int k = 0; k < count; k++) {
    if (val[k] != 0.0) {
      ref = fmax(ref, tau0[(row != NULL) ? row[k] : k] / fabs(val[k]));
    }
  }
  return (ref < 0.0) ? 1.0 : ref;
}

static double over(double x, double scale) {
  return (scale > 0.0) ? x / scale : ((x == 0.0) ? 0.0 : copysign(HUGE_VAL, x));
}

static double row_rho(const lcp_problem *p, lcp_set set, int i, double z, double w, double zref,
                      double tau) {
  const double x = over(z, zref), y = over(w, tau);
  if (set == LCP_FREE) {
    return fabs(y);
  }
  if (set == LCP_BOX) {
    return fabs(x - fmin(fmax(x - y, over(p->lo[i], zref)), over(p->hi[i], zref)));
  }
  return fabs(fmin(x, y));
}

double lcp_loop_rho(lcp_stop_state *s, const lcp_problem *p, const double *z, double *tau0) {
  const int n = p->M.n;
  const bool factored = p->M.storage == LCP_FACTORED;
  const lcp_block whole = {.start = 0, .size = n, .set = LCP_ORTHANT};
  const lcp_block *block = (p->block != NULL) ? p->block : &whole;
  const int n_block = (p->block != NULL) ? p->n_block : 1;
  lcp_loop_magnitudes(p, z, tau0);
  for (int i = 0; i < n; i++) { /* J W J' of the factored form by the triangle inequality */
    tau0[i] = factored ? fmax(tau0[i], s->tau[i] - fabs(p->q[i])) : tau0[i];
  }
  for (int i = 0; i < n; i++) {
    s->zref[i] = reference(&p->M, i, s->d[i], tau0);
  }
  lcp_loop_magnitudes(p, s->zref, s->tau);
  double worst = 0.0;
  for (int b = 0; b < n_block; b++) {
    if (block[b].set == LCP_CONE) {
      return HUGE_VAL;
    }
    for (int i = block[b].start; i < block[b].start + block[b].size; i++) {
      const double tau = factored ? fmax(s->tau[i], fabs(p->q[i]) + tau0[i]) : s->tau[i];
      const double r = row_rho(p, block[b].set, i, z[i], s->w[i], s->zref[i], tau);
      worst = (r > worst || r != r) ? r : worst;
    }
  }
  return worst;
}
