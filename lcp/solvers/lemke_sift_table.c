/* Rounds of sifting on a tableau: the problem of the set is formed contact by contact from J, and only there. */
#include "lcp/solvers/lemke_sift.h"

#include <math.h>
#include <string.h>

/* A tableau whose w = M z + q disagree by more than this [scaled, 1] has piled up too much round-off. */
static const double drift = 1e-8;

static bool share_body(const lcp_factored *f, int g, int h) {
  const int *a = f->body + 2 * (ptrdiff_t)g;
  const int *b = f->body + 2 * (ptrdiff_t)h;
  return (a[0] >= 0 && (a[0] == b[0] || a[0] == b[1])) ||
         (a[1] >= 0 && (a[1] == b[0] || a[1] == b[1]));
}

/* Velocity that a unit of z_j gives, into u. Scaled row r reads  d u_r + (W J' z)_r = 0, d a power of two. */
static void push(const lemke_system *s, int j, double *u) {
  for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
    const int r = s->rowind[p];
    if (r >= s->n) {
      u[r - s->n] = -s->val[p] / s->val[s->colptr[r + 1] - 1];
    }
  }
}

/* w_i of a row moved by z_j alone, where `back` holds row i of J over the diagonals, negative. */
static double pull(const lemke_system *s, int j, const double *back) {
  double w = 0;
  for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
    w += (s->rowind[p] >= s->n) ? s->val[p] * back[s->rowind[p] - s->n] : 0;
  }
  return w;
}

/* Entries of S between row i and the rows of its contact that are in the set already. */
static void add_shift(lemke_sift *k, const lemke_system *s, int g, int i) {
  for (int j = k->f->row_start[g]; j <= i; ++j) {
    for (int p = s->colptr[j]; p < s->colptr[j + 1] && s->rowind[p] < s->n; ++p) {
      const int h = s->rowind[p];
      if (h == i) {
        k->entry_row[k->local[j]] += s->val[p];
      }
      if (j == i && h <= i) {
        k->entry_column[k->local[h]] += s->val[p];
      }
    }
  }
}

/* Column and row i of M over the set, i last. */
static void form_entries(lemke_sift *k, const lemke_system *s, int g, int i) {
  const int n = k->sub.n;
  for (int p = s->jptr[i]; p < s->jptr[i + 1]; ++p) {
    const int c = s->n + s->jdof[p];
    k->back[s->jdof[p]] = -s->jval[p] / s->val[s->colptr[c + 1] - 1];
  }
  push(s, i, k->reply);
  for (int l = 0; l <= n; ++l) {
    const bool near = share_body(k->f, g, k->group[l]);
    k->entry_column[l] = near ? lemke_row_speed(s, k->row[l], k->reply) : 0;
    k->entry_row[l] = near ? pull(s, k->row[l], k->back) : 0;
  }
  if (k->f->shift != NULL) {
    add_shift(k, s, g, i);
  }
  for (int p = s->jptr[i]; p < s->jptr[i + 1]; ++p) {
    k->back[s->jdof[p]] = 0;
  }
  for (int p = s->colptr[i]; p < s->colptr[i + 1]; ++p) {
    if (s->rowind[p] >= s->n) {
      k->reply[s->rowind[p] - s->n] = 0;
    }
  }
}

void lemke_sift_open_table(lemke_sift *k, lemke_path *t, const lemke_system *s) {
  memset(k->reply, 0, sizeof *k->reply * (size_t)(s->rows - s->n));
  memset(k->back, 0, sizeof *k->back * (size_t)(s->rows - s->n));
  k->sub.n = 0;
  k->sub.rows = 0;
  lemke_table_clear(t);
}

bool lemke_sift_append(lemke_sift *k, lemke_path *t, const lemke_system *s, int g) {
  lemke_system *sub = &k->sub;
  const int first = k->f->row_start[g];
  const int last = k->f->row_start[g + 1];
  for (int i = first; i < last; ++i) {
    if (s->is_free[i] || sub->n == k->table_rows) {
      return false;
    }
    k->row[sub->n] = i;
    k->local[i] = sub->n;
    k->group[sub->n] = g;
    form_entries(k, s, g, i);
    sub->q[sub->n] = s->q[i];
    sub->is_free[sub->n] = 0;
    lemke_table_append(t, k->entry_column, k->entry_row, s->q[i]);
    sub->n++;
    sub->rows++;
  }
  for (int i = first; i < last; ++i) {
    k->chosen[i] = k->chosen[i] && lemke_path_take(t, sub, k->local[i]);
  }
  return true;
}

/* Velocities and w = M z + q of the set from the z of the table, in extended precision, into s->w: w by
 * row of the set, velocities from s->n on. */
static void set_speeds(const lemke_sift *k, const lemke_path *t, const lemke_system *s) {
  const int n = k->sub.n;
  long double *w = s->w;
  long double *u = s->w + s->n;
  memset(u, 0, sizeof *u * (size_t)(s->rows - s->n));
  for (int l = 0; l < n; ++l) {
    w[l] = (long double)k->sub.q[l];
  }
  for (int l = 0; l < n; ++l) {
    const int at = t->basis.where[n + l];
    for (int p = s->colptr[k->row[l]]; at >= 0 && p < s->colptr[k->row[l] + 1]; ++p) {
      const int r = s->rowind[p];
      const long double term = (long double)s->val[p] * (long double)t->x[at];
      if (r < s->n) {
        w[k->local[r]] += term;
      } else {
        u[r - s->n] -= term / (long double)s->val[s->colptr[r + 1] - 1];
      }
    }
  }
  for (int l = 0; l < n; ++l) {
    for (int p = s->jptr[k->row[l]]; p < s->jptr[k->row[l] + 1]; ++p) {
      w[l] += (long double)s->jval[p] * u[s->jdof[p]];
    }
  }
}

bool lemke_sift_follow_table(lemke_sift *k, lemke_path *t, const lemke_system *s,
                             lemke_tolerance tol) {
  const int n = k->sub.n;
  if (lemke_path_run_table(t, &k->sub, tol) != LEMKE_SOLVED) {
    return false;
  }
  set_speeds(k, t, s);
  const double noise = drift * lemke_larger(1, lemke_largest(t->x, n));
  for (int l = 0; l < n; ++l) {
    const int at = t->basis.where[l];
    const double w = (at < 0) ? 0 : t->x[at];
    if (!(fabs((double)s->w[l] - w) <= noise)) {
      return false;
    }
    k->chosen[k->row[l]] = t->in_z[l];
  }
  for (int c = 0; c < s->rows - s->n; ++c) {
    k->u[c] = (double)s->w[s->n + c];
  }
  return true;
}

/* z -= M_AA^-1 w_A: the columns of the nonbasic w are -M_AA^-1 in the rows of the basic z. */
static void correct(const lemke_sift *k, lemke_path *t, const lemke_system *s) {
  const int n = k->sub.n;
  for (int b = 0; b < n; ++b) {
    if (t->basis.where[b] >= 0) {
      continue;
    }
    const double *column = lemke_path_column(t, b);
    const double w = (double)s->w[b];
    for (int r = 0; r < n; ++r) {
      t->x[r] += (t->basis.head[r] >= n) ? w * column[r] : 0;
    }
  }
}

void lemke_sift_point(lemke_sift *k, lemke_path *t, const lemke_system *s, double *z) {
  const int n = k->sub.n;
  for (int pass = 0; pass < 2; ++pass) {
    set_speeds(k, t, s);
    correct(k, t, s);
  }
  memset(z, 0, sizeof *z * (size_t)s->n);
  for (int l = 0; l < n; ++l) {
    const int at = t->basis.where[n + l];
    z[k->row[l]] = (at < 0) ? 0 : lemke_larger(t->x[at], 0);
  }
}
