/* regularized_envelope.c - M_hat = L L' inside its envelope (George & Liu 1981, ch. 4), bodies in reverse
 * Cuthill-McKee order, so that a chain, a stack or a wall costs in proportion to its size. */
#include "formulations/dof_kernel.h"
#include "formulations/regularized_factor.h"

#include <cblas.h>
#include <math.h>
#include <string.h>

/* Row i of the envelope holds columns first[i] .. end of its body: equally long for one body, so
 * that its rows are a matrix. What lies above the diagonal is not used. */
void reg_envelope_plan(const contact_set *c, reg_mass *m) {
  for (int b = 0; b < c->n_body; b++) {
    int least = m->place[b];
    for (int k = m->link_start[b]; k < m->link_start[b + 1]; k++) {
      const int other = m->place[m->link[k]];
      least = (other < least) ? other : least;
    }
    const int end = m->place[b] + contact_dofs(c, b);
    for (int i = m->place[b]; i < end; i++) {
      m->first[i] = least;
      m->at[i + 1] = (size_t)(end - least);
    }
  }
  m->at[0] = 0;
  for (int i = 0; i < c->n_dof; i++) {
    m->at[i + 1] += m->at[i];
  }
}

/* Entry (i, j), j <= i. */
static double *entry(const reg_mass *m, int i, int j) {
  return m->L + m->at[i] + (j - m->first[i]);
}

void reg_envelope_mass(const contact_set *c, reg_mass *m) {
  memset(m->L, 0, m->at[c->n_dof] * sizeof *m->L);
  for (int b = 0; b < c->n_body; b++) {
    const int n = contact_dofs(c, b);
    const double *mass = c->mass + c->mass_start[b];
    for (int i = 0; i < n; i++) {
      for (int j = 0; j <= i; j++) {
        *entry(m, m->place[b] + i, m->place[b] + j) = mass[j * n + i];
      }
    }
  }
}

/* Rows of one body: as long as one another. */
static inline void add_rows(double *to, ptrdiff_t stride, const double *x, int nx, double stiffness,
                            const double *y, int ny) {
  for (int i = 0; i < nx; i++) {
    form_add_scaled(stiffness * x[i], y, to + i * stride, ny);
  }
}

/* A block on the diagonal gets what lies above it too, which nothing reads. */
void reg_envelope_add(reg_mass *m, int row, const double *x, int nx, int column, const double *y,
                      int ny, double stiffness) {
  const ptrdiff_t stride = (ptrdiff_t)(m->at[row + 1] - m->at[row]);
  FORM_WITH_DOFS(ny, add_rows, entry(m, row, column), stride, x, nx, stiffness, y);
}

/* Columns of earlier bodies in the n rows from `row`: entry (i, j) <- (entry - sum) / L_jj. Row by row the
 * sums wait for one another, column by column they do not. */
static void factor_before(reg_mass *m, int row, int n) {
  for (int j = m->first[row]; j < row; j++) {
    const int from = (m->first[row] > m->first[j]) ? m->first[row] : m->first[j];
    const double *b = entry(m, j, from);
    const double inverse = 1 / b[j - from];
    for (int i = row; i < row + n; i++) {
      double *a = entry(m, i, from);
      a[j - from] = (a[j - from] - form_dot(a, b, j - from)) * inverse;
    }
  }
}

/* The n x n block on the diagonal, over the entries before it. */
static bool factor_own(reg_mass *m, int row, int n) {
  const int from = m->first[row];
  for (int j = row; j < row + n; j++) {
    double *b = entry(m, j, from);
    const double square = b[j - from] - form_dot(b, b, j - from);
    if (!(square > 0)) {
      return false;
    }
    b[j - from] = sqrt(square);
    const double inverse = 1 / b[j - from];
    for (int i = j + 1; i < row + n; i++) {
      double *a = entry(m, i, from);
      a[j - from] = (a[j - from] - form_dot(a, b, j - from)) * inverse;
    }
  }
  return true;
}

/* L L' = M_hat in place; false if it is not positive definite. */
bool reg_envelope_factor(const contact_set *c, reg_mass *m) {
  for (int k = c->n_body - 1; k >= 0; k--) {
    const int row = m->place[m->order[k]];
    const int n = contact_dofs(c, m->order[k]);
    if (n == 0) {
      continue;
    }
    factor_before(m, row, n);
    if (!factor_own(m, row, n)) {
      return false;
    }
  }
  return true;
}

enum { FEW = 4096 }; /* products for which BLAS does not pay */

/* n rows of y, `width` long, minus L times the rows before them from y0 on. */
static void subtract_before(const double *L, ptrdiff_t stride, int n, int before, const double *y0,
                            double *y, int width) {
  if ((double)n * before * width > FEW) {
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, width, before, -1, L, (int)stride, y0,
                width, 1, y, width);
    return;
  }
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < before; j++) {
      form_add_scaled(-L[i * stride + j], y0 + (ptrdiff_t)j * width, y + (ptrdiff_t)i * width,
                      width);
    }
  }
}

/* Y <- L^-1 Y, Y row-major with `width` right sides, body by body. */
void reg_envelope_forward(const contact_set *c, reg_mass *m, int width) {
  for (int b = c->n_body - 1; b >= 0; b--) {
    const int n = contact_dofs(c, m->order[b]);
    const int at = m->place[m->order[b]];
    if (n == 0) {
      continue;
    }
    const int from = m->first[at];
    const int before = at - from;
    const double *L = entry(m, at, from);
    double *y = m->Y + (ptrdiff_t)at * width;
    subtract_before(L, before + n, n, before, m->Y + (ptrdiff_t)from * width, y, width);
    for (int i = 0; i < n; i++) {
      const double *row = L + (ptrdiff_t)i * (before + n) + before;
      double *yi = y + (ptrdiff_t)i * width;
      for (int j = 0; j < i; j++) {
        form_add_scaled(-row[j], y + (ptrdiff_t)j * width, yi, width);
      }
      const double inverse = 1 / row[i];
      for (int k = 0; k < width; k++) {
        yi[k] *= inverse;
      }
    }
  }
}

void reg_envelope_backward(reg_mass *m, int n, double *x) {
  for (int i = n - 1; i >= 0; i--) {
    const double *row = entry(m, i, m->first[i]);
    x[i] /= row[i - m->first[i]];
    for (int k = m->first[i]; k < i; k++) {
      x[k] -= row[k - m->first[i]] * x[i];
    }
  }
}
