/* lcp_matrix.c - products and copies of the three storages. The factored form is handled through
 * body velocities: y = J (W (J' x)) + S x, linear in the number of groups. */
#include "lcp/lcp_problem.h"

#include <string.h>

static void csc_apply_add(const lcp_csc *m, const double *x, double *y) {
  for (int j = 0; j < m->n_col; j++) {
    const double xj = x[j];
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      y[m->rowind[k]] += m->val[k] * xj;
    }
  }
}

static void dense_apply_add(const lcp_matrix *M, const double *x, double *y) {
  const size_t n = (size_t)M->n;
  for (size_t j = 0; j < n; j++) {
    const double xj = x[j];
    const double *col = M->val + j * n;
    if (xj == 0.0) {
      continue; /* impulses of open contacts; a finite column changes nothing */
    }
    for (size_t i = 0; i < n; i++) {
      y[i] += col[i] * xj;
    }
  }
}

/* out[rows] += A x, or out[cols] += A' x, of the block of one side of a group. */
static void side_times(const double *A, int rows, int cols, const double *x, double *out) {
  for (int r = 0; r < rows; r++) {
    double sum = 0.0;
    for (int c = 0; c < cols; c++) {
      sum += A[r * cols + c] * x[c];
    }
    out[r] += sum;
  }
}

static void side_times_transposed(const double *A, int rows, int cols, const double *x,
                                  double *out) {
  for (int r = 0; r < rows; r++) {
    for (int c = 0; c < cols; c++) {
      out[c] += A[r * cols + c] * x[r];
    }
  }
}

static int body_dofs(const lcp_factored *f, int b) {
  return f->dof_start[b + 1] - f->dof_start[b];
}

/* v = W f, block by block. */
static void weight_times(const lcp_factored *f, const double *force, double *v) {
  for (int b = 0; b < f->n_body; b++) {
    const int first = f->dof_start[b], n = body_dofs(f, b);
    const double *W = f->weight + f->weight_start[b];
    for (int i = 0; i < n; i++) {
      double sum = 0.0;
      for (int j = 0; j < n; j++) {
        sum += W[j * n + i] * force[first + j];
      }
      v[first + i] = sum;
    }
  }
}

static void factored_apply_add(const lcp_factored *f, const double *x, double *y, double *scratch) {
  const int m = f->dof_start[f->n_body];
  double *force = scratch, *v = scratch + m;
  memset(force, 0, (size_t)m * sizeof *force);
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    const double *A = f->jac + f->jac_start[g];
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      if (b >= 0) {
        side_times_transposed(A, rows, body_dofs(f, b), x + f->row_start[g],
                              force + f->dof_start[b]);
        A += rows * body_dofs(f, b);
      }
    }
  }
  weight_times(f, force, v);
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    const double *A = f->jac + f->jac_start[g];
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      if (b >= 0) {
        side_times(A, rows, body_dofs(f, b), v + f->dof_start[b], y + f->row_start[g]);
        A += rows * body_dofs(f, b);
      }
    }
  }
  if (f->shift != NULL) {
    csc_apply_add(f->shift, x, y);
  }
}

size_t lcp_matrix_scratch(const lcp_matrix *M) {
  return (M->storage == LCP_FACTORED) ? 2 * (size_t)M->factored->dof_start[M->factored->n_body] : 0;
}

void lcp_matrix_apply(const lcp_matrix *M, const double *x, const double *b, double *y,
                      double *scratch) {
  if (b != NULL) {
    memcpy(y, b, (size_t)M->n * sizeof *y);
  } else {
    memset(y, 0, (size_t)M->n * sizeof *y);
  }
  switch (M->storage) {
  case LCP_DENSE:
    dense_apply_add(M, x, y);
    break;
  case LCP_CSC:
    csc_apply_add(&M->csc, x, y);
    break;
  case LCP_FACTORED:
    factored_apply_add(M->factored, x, y, scratch);
    break;
  }
}
