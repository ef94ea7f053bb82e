/* regularized_envelope.c - M_hat = L L' inside its envelope (George & Liu 1981, ch. 4), bodies in reverse
 * Cuthill-McKee order, so that a chain, a stack or a wall costs in proportion to its size. */
#include "formulations/dof_kernel.h"
#include "formulations/regularized/regularized_factor.h"
#include "lcp/base/clones.h"

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

/* out += s x + t y */
static inline void add_two(double s, const double *restrict x, double t, const double *restrict y,
                           double *restrict out, int n) {
  for (int k = 0; k < n; k++) {
    out[k] = (out[k] + s * x[k]) + t * y[k];
  }
}

/* Rows of side x, which are as long as one another. */
static inline void add_rows(const reg_springs *s, int x, int y, double *to, ptrdiff_t stride,
                            int n) {
  for (int i = 0; i < s->n[x]; i++, to += stride) {
    const double *ex = s->e[x] + i;
    const double *ey = s->e[y];
    int r = 0;
    for (; r + 2 <= s->rank; r += 2, ex += 2 * (ptrdiff_t)s->n[x], ey += 2 * (ptrdiff_t)n) {
      add_two(s->stiffness[r] * ex[0], ey, s->stiffness[r + 1] * ex[s->n[x]], ey + n, to, n);
    }
    if (r < s->rank) {
      form_add_scaled(s->stiffness[r] * ex[0], ey, to, n);
    }
  }
}

/* A block on the diagonal gets what lies above it too, which nothing reads. */
BASE_CLONES void reg_envelope_add(reg_mass *m, const reg_springs *s, int x, int y) {
  const int row = s->place[x];
  const ptrdiff_t stride = (ptrdiff_t)(m->at[row + 1] - m->at[row]);
  FORM_WITH_DOFS(s->n[y], add_rows, s, x, y, entry(m, row, s->place[y]), stride);
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

/* y -= sum_j l_j y_j over m rows `stride` apart, three of them in a sweep. */
static inline void subtract_rows(const double *l, int m, const double *restrict rows,
                                 ptrdiff_t stride, double *restrict y, int n) {
  int j = 0;
  for (; j + 3 <= m; j += 3, rows += 3 * stride) {
    const double *restrict b = rows + stride;
    const double *restrict c = b + stride;
    for (int k = 0; k < n; k++) {
      y[k] = ((y[k] - l[j] * rows[k]) - l[j + 1] * b[k]) - l[j + 2] * c[k];
    }
  }
  for (; j < m; j++, rows += stride) {
    form_add_scaled(-l[j], rows, y, n);
  }
}

/* The n rows y of one body, `width` columns of them: `before` rows above are done. */
BASE_CLONES static void forward_body(const double *L, int n, int before, double *y, int width,
                                     int all) {
  const double *above = y - (ptrdiff_t)before * all;
  const bool many = (double)n * before * width > FEW;
  if (many) {
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, width, before, -1, L, before + n,
                above, all, 1, y, all);
  }
  for (int i = 0; i < n; i++) {
    const double *l = L + (ptrdiff_t)i * (before + n);
    double *yi = y + (ptrdiff_t)i * all;
    const int done = many ? before : 0;
    subtract_rows(l + done, before - done + i, above + (ptrdiff_t)done * all, all, yi, width);
    const double inverse = 1 / l[before + i];
    for (int k = 0; k < width; k++) {
      yi[k] *= inverse;
    }
  }
}

/* The same of one vector, whose part before y is done. */
static void forward_vector(const double *L, int n, int before, double *y) {
  for (int i = 0; i < n; i++) {
    const double *l = L + (ptrdiff_t)i * (before + n);
    y[i] = (y[i] - form_dot(l, y - before, before + i)) / l[before + i];
  }
}

/* Body by body. A column is zero above the first body that it touches, so that only the columns which have
 * begun are passed: half of them in a stack. */
void reg_envelope_forward(const contact_set *c, reg_mass *m, int p, int sets, int all) {
  int from = p;
  int to = 0;
  for (int k = c->n_body - 1; k >= 0; k--) {
    const int b = m->order[k];
    const int n = contact_dofs(c, b);
    if (n == 0) {
      continue;
    }
    const int at = m->place[b];
    const int before = at - m->first[at];
    const double *L = entry(m, at, m->first[at]);
    double *y = m->Y + (ptrdiff_t)at * all;
    from = (m->from[b] < from) ? m->from[b] : from;
    to = (m->to[b] > to) ? m->to[b] : to;
    forward_vector(L, n, before, m->c + at);
    for (int i = 0; i < n; i++) {
      y[(ptrdiff_t)i * all] = m->c[at + i];
    }
    for (int set = 0; set < sets && from < to; set++) {
      forward_body(L, n, before, y + 1 + (ptrdiff_t)set * p + from, to - from, all);
    }
    const int rest = 1 + sets * p;
    if (rest < all) {
      forward_body(L, n, before, y + rest, all - rest, all);
    }
  }
}

/* y += s a + t b + u c */
static inline void add_three(const double *s, ptrdiff_t stride, const double *restrict rows,
                             double *restrict y, int n) {
  const double *restrict b = rows + stride;
  const double *restrict c = b + stride;
  for (int k = 0; k < n; k++) {
    y[k] = ((y[k] + s[0] * rows[k]) + s[stride] * b[k]) + s[2 * stride] * c[k];
  }
}

/* Columns `from` .. `to`-1 of A, of length p, get the share of the n rows y of one body: sum of y_i y_(j+slip),
 * `slip` columns on. */
BASE_CLONES static void multiply_body(const double *y, int n, int all, int from, int to, int slip,
                                      double *A, int p) {
  for (int j = from; j < to; j++) {
    const int first = (slip == 0) ? j : from;
    double *a = A + (ptrdiff_t)j * p + first;
    const double *right = y + slip + j;
    const double *left = y + first;
    int r = 0;
    for (; r + 3 <= n; r += 3, left += 3 * (ptrdiff_t)all, right += 3 * (ptrdiff_t)all) {
      add_three(right, all, left, a, to - first);
    }
    for (; r < n; r++, left += all, right += all) {
      form_add_scaled(right[0], left, a, to - first);
    }
  }
}

void reg_envelope_multiply(const contact_set *c, const reg_mass *m, int p, bool slip, int all,
                           double *A) {
  int from = p;
  int to = 0;
  memset(A, 0, (size_t)p * (size_t)p * sizeof *A);
  for (int k = c->n_body - 1; k >= 0; k--) {
    const int b = m->order[k];
    from = (m->from[b] < from) ? m->from[b] : from;
    to = (m->to[b] > to) ? m->to[b] : to;
    multiply_body(m->Y + (ptrdiff_t)m->place[b] * all + 1, contact_dofs(c, b), all, from, to,
                  slip ? p : 0, A, p);
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
