/* regularized_joint.c - joints in the mass form: M_hat^-1 gives way to its projection (MATHEMATICS 2.1, 2.3.2),
 *
 *   P = M_hat^-1 - M_hat^-1 J_b' S^-1 J_b M_hat^-1,   S = J_b M_hat^-1 J_b'
 *
 * in terms of Y = L^-1 [c | J_n' | J' B | J_b']: S = Y_b' Y_b by a pivoted Cholesky factorisation, whose
 * rank leaves out joints that say the same twice, and W = S^-1 Y_b' Y. */
#include "formulations/regularized/regularized_factor.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

static void layout(void *state, base_arena *a) {
  reg_joint *j = state;
  const size_t n = (size_t)j->cap_n;
  j->S = BASE_ARRAY(a, double, n *n);
  j->x = BASE_ARRAY(a, double, n);
  j->y = BASE_ARRAY(a, double, n);
  j->work = BASE_ARRAY(a, double, 2 * n);
  j->pivot = BASE_ARRAY(a, int, n);
  j->W = BASE_ARRAY(a, double, n *(size_t)j->cap_width);
  j->own = BASE_ARRAY(a, double, j->cap_width);
}

base_status reg_joint_begin(regularized *s, int width, base_error *err) {
  reg_joint *j = &s->mass.joint;
  j->n = s->a.n_row - s->a.row[s->a.n_contact];
  if (j->n > j->cap_n || (j->n > 0 && width > j->cap_width)) {
    j->cap_n = (j->n > j->cap_n) ? base_room(j->n) : j->cap_n;
    j->cap_width = (width > j->cap_width) ? base_room(width) : j->cap_width;
    BASE_TRY(form_memory(&j->mem, layout, j, err));
  }
  return BASE_OK;
}

/* x <- S^-1 x, zero where S is dependent. */
static void solve(const reg_joint *j, double *x) {
  for (int k = 0; k < j->rank; k++) {
    j->y[k] = x[j->pivot[k] - 1];
  }
  cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, j->rank, j->S, j->n, j->y, 1);
  cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, j->rank, j->S, j->n, j->y, 1);
  memset(x, 0, (size_t)j->n * sizeof *x);
  for (int k = 0; k < j->rank; k++) {
    x[j->pivot[k] - 1] = j->y[k];
  }
}

/* Y is column-major (width + n) x n_dof, the joints last: S, W and x = S^-1 r_b; c takes up what the joints'
 * own velocity r_b asks for. */
bool reg_joint_factor(regularized *s, int width) {
  reg_joint *j = &s->mass.joint;
  const int n = j->n, all = width + n, n_dof = s->a.set->n_dof;
  double *Y = s->mass.Y, *Yb = Y + width;
  lapack_int rank = 0;
  double trace = 0;
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, n_dof, 1, Yb, all, 0, j->S, n);
  for (int k = 0; k < n;
       k++) { /* not a number where an entry of Y_b is none: LAPACK would call it dependent */
    trace += j->S[(ptrdiff_t)k * (n + 1)];
  }
  if (trace != trace ||
      LAPACKE_dpstrf_work(LAPACK_COL_MAJOR, 'L', n, j->S, n, j->pivot, &rank, -1, j->work) < 0) {
    return false;
  }
  j->rank = (int)rank;
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, n, width, n_dof, 1, Yb, all, Y, all, 0, j->W,
              n);
  for (int k = 0; k < width; k++) {
    solve(j, j->W + (ptrdiff_t)k * n);
  }
  memcpy(j->x, s->a.r + s->a.row[s->a.n_contact], (size_t)n * sizeof *j->x);
  solve(j, j->x);
  for (int k = 0; k < n; k++) {
    j->y[k] = j->x[k] - j->W[k];
  }
  cblas_dgemv(CblasColMajor, CblasTrans, n, n_dof, 1, Yb, all, j->y, 1, 1, Y, all);
  return true;
}

/* Column k of Y, which is row-major with `all` columns: its square. */
static double square(const double *Y, int k, int all, int n_dof) {
  return cblas_ddot(n_dof, Y + k, all, Y + k, all);
}

static void clear(double *Y, int k, int all, int n_dof) {
  for (ptrdiff_t d = 0; d < n_dof; d++) {
    Y[d * all + k] = 0;
  }
}

/* A normal that the joints block has a zero row, computed with some roundings of what was taken away, and the velocity
 * that sides and joints drift with (assembly_blocked.c): exact zeros in their place, and a bias that asks for nothing
 * unless it is driven to approach. */
static void unblock(regularized *s, int i, int all) {
  const reg_joint *j = &s->mass.joint;
  const contact_set *c = s->a.set;
  const int g = s->a.group[i], first = c->row_start[c->n_contact];
  const double *w = j->W + (ptrdiff_t)(1 + i) * j->n;
  double *Y = s->mass.Y;
  double size = sqrt(j->own[1 + i]), u = c->u_drift[c->row_start[g]], u_size = fabs(u);
  for (int k = 0; k < j->n; k++) {
    const double moved = w[k] * c->u_drift[first + k];
    size += fabs(w[k]) * sqrt(square(Y, all - j->n + k, all, c->n_dof));
    u -= moved;
    u_size += fabs(moved);
  }
  if (square(Y, 1 + i, all, c->n_dof) > 4 * DBL_EPSILON * (j->n + 8) * size * size) {
    return;
  }
  clear(Y, 1 + i, all, c->n_dof);
  if (s->any_slip) {
    clear(Y, 1 + s->a.n_contact + i, all, c->n_dof);
  }
  const double apart = u + fmax(s->a.bias[g], 0);
  s->b[i] = (apart < -1e-9 * u_size) ? apart : 0;
}

/* The columns of the contacts without what the joints take up. */
void reg_joint_project(regularized *s, int width) {
  reg_joint *j = &s->mass.joint;
  const int n = j->n, all = width + n, n_dof = s->a.set->n_dof;
  double *Y = s->mass.Y;
  for (int i = 0; i < s->a.n_contact; i++) {
    j->own[1 + i] = square(Y, 1 + i, all, n_dof);
  }
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, width - 1, s->a.set->n_dof, n, -1, j->W + n,
              n, Y + width, all, 1, Y + 1, all);
  for (int i = 0; i < s->a.n_contact; i++) {
    if (square(Y, 1 + i, all, n_dof) <= 1e-6 * j->own[1 + i]) {
      unblock(s, i, all);
    }
  }
}

/* lambda_b = W_c - x - W_B lambda_n, B in the columns from `first`. */
void reg_joint_impulses(const regularized *s, int first, const double *lambda_n, double *lambda) {
  const reg_joint *j = &s->mass.joint;
  double *out = lambda + s->a.row[s->a.n_contact];
  for (int k = 0; k < j->n; k++) {
    out[k] = j->W[k] - j->x[k];
  }
  cblas_dgemv(CblasColMajor, CblasNoTrans, j->n, s->a.n_contact, -1, j->W + (ptrdiff_t)first * j->n,
              j->n, lambda_n, 1, 1, out, 1);
}
