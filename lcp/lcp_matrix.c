/* lcp_matrix.c - products and copies of the three storages. The factored form is handled through
 * body velocities: y = J (W (J' x)) + S x, linear in the number of groups. */
#include "lcp/base/clones.h"
#include "lcp/base/crew.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

#include <string.h>

/* y += what M stores times x. */
static void stored_apply_add(const lcp_matrix *M, const double *x, double *y) {
  for (int j = 0; j < M->n; j++) {
    if (x[j] != 0.0) { /* else the impulse of an open contact: a finite column changes nothing */
      lcp_column_add(lcp_column_of(M, j), x[j], y);
    }
  }
}

/* out[rows] += A x, or out[cols] += A' x, of the block of one side of a group: inline, so that six and three columns, a body in
 * space and in the plane, are loops without a counter. */
BASE_INLINE void times(const double *A, int rows, int cols, const double *x, double *out) {
  for (int r = 0; r < rows; r++) {
    double sum = 0.0;
    for (int c = 0; c < cols; c++) {
      sum += A[r * cols + c] * x[c];
    }
    out[r] += sum;
  }
}

BASE_INLINE void times_transposed(const double *A, int rows, int cols, const double *x,
                                  double *restrict out) {
  for (int r = 0; r < rows; r++) {
    for (int c = 0; c < cols; c++) {
      out[c] += A[r * cols + c] * x[r];
    }
  }
}

BASE_INLINE void side_times(const double *A, int rows, int cols, const double *x, double *out) {
  if (cols == 6) {
    times(A, rows, 6, x, out);
  } else if (cols == 3) {
    times(A, rows, 3, x, out);
  } else {
    times(A, rows, cols, x, out);
  }
}

BASE_INLINE void side_times_transposed(const double *A, int rows, int cols, const double *x,
                                       double *out) {
  if (cols == 6) {
    times_transposed(A, rows, 6, x, out);
  } else if (cols == 3) {
    times_transposed(A, rows, 3, x, out);
  } else {
    times_transposed(A, rows, cols, x, out);
  }
}

/* The same of rows that are mixed of those in A: three of six in space as a constant. */
BASE_INLINE void mixed_times(const lcp_mixture *m, const double *A, int cols, const double *x,
                             double *out) {
  double stored[LCP_STORED_MAX] = {0};
  if (m->stored == 3) {
    side_times(A, 3, cols, x, stored);
  } else {
    side_times(A, m->stored, cols, x, stored);
  }
  lcp_mixture_spread(m, stored, out);
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

enum { SHARE = 512 }; /* groups of one part of the work */

typedef struct velocities {
  const lcp_factored *f;
  const double *v;
  double *y;
} velocities;

/* y += J v of the groups from .. end-1. */
BASE_CLONES static void rows_times(const lcp_factored *f, int from, int end, const double *v,
                                   double *y) {
  for (int g = from; g < end; g++) {
    const int stored = lcp_factored_stored(f, g);
    const lcp_mixture *m = lcp_mixture_of(f, g);
    const double *A = f->jac + lcp_factored_at(f, g);
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side], n = (b >= 0) ? body_dofs(f, b) : 0;
      if (b >= 0 && m != NULL) {
        mixed_times(m, A, n, v + f->dof_start[b], y + f->row_start[g]);
      } else if (b >= 0) {
        side_times(A, stored, n, v + f->dof_start[b], y + f->row_start[g]);
      }
      A += stored * n;
    }
  }
}

static void share_rows(void *of, int part, int hand) {
  const velocities *u = of;
  const int from = part * SHARE, n = u->f->n_group;
  (void)hand;
  rows_times(u->f, from, base_part_end(part, n, SHARE), u->v, u->y);
}

/* y += J W J' x. */
BASE_CLONES static void factored_apply_add(const lcp_factored *f, const double *x, double *y,
                                           double *scratch) {
  const int dofs = f->dof_start[f->n_body];
  double *force = scratch, *v = scratch + dofs;
  memset(force, 0, (size_t)dofs * sizeof *force);
  for (int g = 0; g < f->n_group; g++) {
    const int stored = lcp_factored_stored(f, g);
    const lcp_mixture *m = lcp_mixture_of(f, g);
    const double *A = f->jac + lcp_factored_at(f, g), *given = x + f->row_start[g];
    double of_stored[LCP_STORED_MAX];
    if (m != NULL) {
      lcp_mixture_gather(m, given, of_stored);
      given = of_stored;
    }
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side], n = (b >= 0) ? body_dofs(f, b) : 0;
      if (b >= 0 && stored == 3) {
        side_times_transposed(A, 3, n, given, force + f->dof_start[b]);
      } else if (b >= 0) {
        side_times_transposed(A, stored, n, given, force + f->dof_start[b]);
      }
      A += stored * n;
    }
  }
  weight_times(f, force, v);
  velocities u = {.f = f, .v = v};
  u.y = y;
  base_share(base_parts(f->n_group, SHARE), share_rows, &u);
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
  if (M->storage == LCP_FACTORED) {
    factored_apply_add(M->factored, x, y, scratch);
  }
  if (M->storage != LCP_FACTORED || M->factored->shift != NULL) {
    stored_apply_add(M, x, y);
  }
}
