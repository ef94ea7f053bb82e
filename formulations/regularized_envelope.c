/* regularized_envelope.c - M_hat = L L' inside its envelope (George & Liu 1981, ch. 4), bodies in reverse
 * Cuthill-McKee order, so that a chain, a stack or a wall costs in proportion to its size. */
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

/* Lower part of x y' / compliance into the rows of one body and the columns of another. */
void reg_envelope_add(reg_mass *m, int row, const double *x, int nx, int column, const double *y,
                      int ny, double compliance) {
  for (int i = 0; i < nx; i++) {
    double *to = entry(m, row + i, column);
    const double scaled = x[i] / compliance;
    const int end = (row == column) ? i + 1 : ny;
    for (int j = 0; j < end; j++) {
      to[j] += scaled * y[j];
    }
  }
}

/* L L' = M_hat in place; false if it is not positive definite. */
bool reg_envelope_factor(reg_mass *m, int n) {
  for (int i = 0; i < n; i++) {
    double *row = entry(m, i, m->first[i]);
    for (int j = m->first[i]; j <= i; j++) {
      const int from = (m->first[i] > m->first[j]) ? m->first[i] : m->first[j];
      const double *a = entry(m, i, from);
      const double *b = entry(m, j, from);
      double sum = row[j - m->first[i]];
      for (int k = 0; k < j - from; k++) {
        sum -= a[k] * b[k];
      }
      if (j < i) {
        row[j - m->first[i]] = sum / *entry(m, j, j);
      } else if (sum > 0) {
        row[j - m->first[i]] = sqrt(sum);
      } else {
        return false;
      }
    }
  }
  return true;
}

/* Y <- L^-1 Y, Y row-major with `width` right sides, body by body. */
void reg_envelope_forward(const contact_set *c, reg_mass *m, int width) {
  for (int k = c->n_body - 1; k >= 0; k--) {
    const int n = contact_dofs(c, m->order[k]);
    const int at = m->place[m->order[k]];
    if (n == 0) {
      continue;
    }
    const int from = m->first[at];
    const int before = at - from;
    const double *L = entry(m, at, from);
    double *y = m->Y + (ptrdiff_t)at * width;
    if (before > 0) {
      cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, width, before, -1, L, before + n,
                  m->Y + (ptrdiff_t)from * width, width, 1, y, width);
    }
    for (int i = 0; i < n; i++) { /* dtrsm does not pay for so few rows */
      const double *row = L + (ptrdiff_t)i * (before + n) + before;
      for (int j = 0; j < i; j++) {
        cblas_daxpy(width, -row[j], y + (ptrdiff_t)j * width, 1, y + (ptrdiff_t)i * width, 1);
      }
      cblas_dscal(width, 1 / row[i], y + (ptrdiff_t)i * width, 1);
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
