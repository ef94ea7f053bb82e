#include "lcp/solvers/lemke/sift.h"

#include <math.h>
#include <string.h>

enum { SIFT_PRICED = -1 }; /* helper: w_i >= 0 must come from the velocities */
enum { SIFT_HELPER = -2 }; /* the row of a helper */

static const double drift =
    1e-8; /* w = M z + q and a tableau apart by this: too much round-off [scaled, 1] */

void lemke_sift_layout(lemke_sift *k, const lcp_capacity *cap, int table, base_arena *a) {
  const bool factored = cap->n_dof > 0;
  const size_t n = factored ? (size_t)cap->n : 0;
  const size_t rows = factored ? n + (size_t)cap->n_dof : 0;
  const size_t nnz = factored ? (size_t)cap->nnz + 2 * (size_t)cap->n_jac + (size_t)cap->n_dof : 0;
  *k = (lemke_sift){0};
  k->helper = BASE_ARRAY(a, int, n);
  k->gain = BASE_ARRAY(a, double, n);
  k->u = BASE_ARRAY(a, double, cap->n_dof);
  k->worst = BASE_ARRAY(a, int, cap->n_body);
  k->depth = BASE_ARRAY(a, double, cap->n_body);
  k->inside = BASE_ARRAY(a, unsigned char, n); /* a group has a row at least */
  k->chosen = BASE_ARRAY(a, unsigned char, n);
  k->row = BASE_ARRAY(a, int, n);
  k->local = BASE_ARRAY(a, int, n);
  k->table_rows = table;
  k->group = BASE_ARRAY(a, int, table);
  k->entry_column = BASE_ARRAY(a, double, table);
  k->entry_row = BASE_ARRAY(a, double, table);
  k->defect = BASE_ARRAY(a, double, table);
  k->reply = BASE_ARRAY(a, double, cap->n_dof);
  k->back = BASE_ARRAY(a, double, cap->n_dof);
  k->store.colptr = BASE_ARRAY(a, int, rows + 1);
  k->store.rowind = BASE_ARRAY(a, int, nnz);
  k->store.val = BASE_ARRAY(a, double, nnz);
  k->store.q = BASE_ARRAY(a, double, rows);
  k->store.is_free = BASE_ARRAY(a, unsigned char, rows);
  k->sub = (lemke_system){.colptr = k->store.colptr,
                          .rowind = k->store.rowind,
                          .val = k->store.val,
                          .q = k->store.q,
                          .is_free = k->store.is_free};
}

/* ---- what a contact outside the set needs --------------------------------------------------- */

static bool has_entry(const lemke_system *s, int j, int row) {
  for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
    if (s->rowind[p] == row) {
      return true;
    }
  }
  return false;
}

/* True when z_j moves no body and may take any value at no cost while the rest of its contact rests
 * at zero (w_j = 0 there), and can only raise w elsewhere: the slip speed of a polyhedral cone. */
static bool is_helper(const lemke_system *s, int j) {
  bool helps = !s->is_free[j] && s->q[j] == 0 && s->colptr[j] < s->colptr[j + 1];
  for (int p = s->colptr[j]; helps && p < s->colptr[j + 1]; ++p) {
    const int i = s->rowind[p];
    helps = i < s->n && i != j && s->val[p] > 0 && !s->is_free[i] && has_entry(s, i, j);
  }
  return helps;
}

static void find_helpers(lemke_sift *k, const lemke_system *s) {
  k->one_by_one = false;
  for (int i = 0; i < s->n; ++i) {
    k->helper[i] = SIFT_PRICED;
  }
  for (int j = 0; j < s->n; ++j) {
    if (!is_helper(s, j)) {
      continue;
    }
    k->one_by_one = true;
    k->helper[j] = SIFT_HELPER;
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      k->helper[s->rowind[p]] = j;
      k->gain[s->rowind[p]] = s->val[p];
    }
  }
}

/* S joins rows of one contact only. */
static bool contacts_are_closed(const lemke_system *s, const lcp_factored *f) {
  for (int g = 0; g < f->n_group; ++g) {
    for (int j = f->row_start[g]; j < f->row_start[g + 1]; ++j) {
      for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
        const int i = s->rowind[p];
        if (i < s->n && (i < f->row_start[g] || i >= f->row_start[g + 1])) {
          return false;
        }
      }
    }
  }
  return true;
}

/* Where sifting was measured to pay: with friction from as many contacts as velocities on, without
 * from twice as many. */
static bool bodies_are_few(const lemke_sift *k, int n_dof) {
  return (k->one_by_one ? 2 : 1) * (long)k->f->n_group > 2 * (long)n_dof;
}

void lemke_sift_prepare(lemke_sift *k, const lemke_system *s, const lcp_problem *p) {
  k->f = (p->M.storage == LCP_FACTORED) ? p->M.factored : NULL;
  if (k->f == NULL) {
    return;
  }
  find_helpers(k, s);
  k->joined = memchr(s->is_free, 1, (size_t)s->n) != NULL;
  if (!bodies_are_few(k, s->rows - s->n) || !contacts_are_closed(s, k->f)) {
    k->f = NULL;
    return;
  }
}

/* w_i of a row outside the set, helpers at zero. */
static double speed(const lemke_sift *k, const lemke_system *s, int i) {
  return s->q[i] + lemke_row_speed(s, i, k->u);
}

/* Basis of a contact at rest outside: where some w_i < 0 a helper comes in, against the row that needs
 * most of it. */
static void choose_helpers(lemke_sift *k, const lemke_system *s, int g) {
  const int first = k->f->row_start[g];
  const int last = k->f->row_start[g + 1];
  for (int h = first; h < last; ++h) {
    int most = -1;
    double value = 0;
    for (int i = first; i < last && k->helper[h] == SIFT_HELPER; ++i) {
      const double need = (k->helper[i] == h) ? -speed(k, s, i) / k->gain[i] : 0;
      most = (need > value) ? i : most;
      value = (need > value) ? need : value;
    }
    k->chosen[h] = k->chosen[h] || most >= 0;
    if (most >= 0) {
      k->chosen[most] = 1;
    }
  }
}

/* ---- the set as a system of its own ---------------------------------------------------------- */

/* Impulse columns of the set, in the numbering of the set. */
static int sub_impulses(lemke_sift *k, const lemke_system *s) {
  const lemke_system *sub = &k->sub;
  lemke_store *m = &k->store;
  int at = 0;
  for (int l = 0; l < sub->n; ++l) {
    const int j = k->row[l];
    m->colptr[l] = at;
    m->q[l] = s->q[j];
    m->is_free[l] = s->is_free[j];
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      const int i = s->rowind[p];
      m->rowind[at] = (i < s->n) ? k->local[i] : i - s->n + sub->n;
      m->val[at++] = s->val[p];
    }
  }
  return at;
}

static void sub_velocities(lemke_sift *k, const lemke_system *s, int at) {
  const lemke_system *sub = &k->sub;
  lemke_store *m = &k->store;
  const int n_dof = s->rows - s->n;
  int *next = m->colptr + sub->n + 1; /* shifted by one: counts, then ends */
  memset(next, 0, sizeof(int) * (size_t)n_dof);
  for (int l = 0; l < sub->n; ++l) {
    for (int p = s->jptr[k->row[l]]; p < s->jptr[k->row[l] + 1]; ++p) {
      next[s->jdof[p]]++;
    }
  }
  for (int c = 0; c < n_dof; ++c) {
    const int last = s->colptr[s->n + c + 1] - 1;
    const int count = next[c];
    next[c] = at;
    at += count + 1;
    m->rowind[at - 1] = sub->n + c;
    m->val[at - 1] = s->val[last];
    m->q[sub->n + c] = s->q[s->n + c];
    m->is_free[sub->n + c] = 1;
  }
  for (int l = 0; l < sub->n; ++l) {
    for (int p = s->jptr[k->row[l]]; p < s->jptr[k->row[l] + 1]; ++p) {
      const int to = next[s->jdof[p]]++;
      m->rowind[to] = l;
      m->val[to] = s->jval[p];
    }
  }
  for (int c = 0; c < n_dof; ++c) { /* past the diagonal */
    next[c]++;
  }
}

static void build_sub(lemke_sift *k, const lemke_system *s) {
  lemke_system *sub = &k->sub;
  sub->edition++;
  sub->any_free = true;
  sub->n = 0;
  for (int g = 0; g < k->f->n_group; ++g) {
    for (int i = k->f->row_start[g]; i < k->f->row_start[g + 1] && k->inside[g]; ++i) {
      k->local[i] = sub->n;
      k->row[sub->n++] = i;
    }
  }
  sub->rows = sub->n + s->rows - s->n;
  const int at = sub_impulses(k, s);
  k->store.colptr[sub->n] = at;
  sub_velocities(k, s, at);
}

/* ---- the set on the table -------------------------------------------------------------------- */

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

static void open_table(lemke_sift *k, const lemke_system *s) {
  memset(k->reply, 0, sizeof *k->reply * (size_t)(s->rows - s->n));
  memset(k->back, 0, sizeof *k->back * (size_t)(s->rows - s->n));
  k->sub.n = 0;
  k->sub.rows = 0;
  k->sub.any_free = false;
  lemke_table_clear(k->table);
}

/* Takes contact g into the table, with the z that are `chosen` basic where independent. False, with the table lost, when
 * it does not fit. */
static bool append(lemke_sift *k, lemke_path *t, const lemke_system *s, int g) {
  lemke_system *sub = &k->sub;
  lemke_engine *e = &k->table->engine;
  const int first = k->f->row_start[g];
  const int last = k->f->row_start[g + 1];
  for (int i = first; i < last; ++i) {
    if (sub->n == k->table_rows) {
      return false;
    }
    k->row[sub->n] = i;
    k->local[i] = sub->n;
    k->group[sub->n] = g;
    form_entries(k, s, g, i);
    k->store.q[sub->n] = s->q[i];
    e->kind->append(e, k->entry_column, k->entry_row, s->q[i]);
    sub->n++;
    sub->rows++;
  }
  for (int i = first; i < last; ++i) {
    k->chosen[i] = k->chosen[i] && lemke_path_take(t, e, k->local[i]);
  }
  return true;
}

/* Velocities and w = M z + q of the set from the z of the table, in extended precision, into s->w: w by
 * row of the set, velocities from s->n on. */
static void set_speeds(const lemke_sift *k, const lemke_system *s) {
  const lemke_engine *e = &k->table->engine;
  const int n = k->sub.n;
  long double *w = s->w;
  long double *u = s->w + s->n;
  memset(u, 0, sizeof *u * (size_t)(s->rows - s->n));
  for (int l = 0; l < n; ++l) {
    w[l] = (long double)k->sub.q[l];
  }
  for (int l = 0; l < n; ++l) {
    const int at = e->where[n + l];
    for (int p = s->colptr[k->row[l]]; at >= 0 && p < s->colptr[k->row[l] + 1]; ++p) {
      const int r = s->rowind[p];
      const long double term = (long double)s->val[p] * (long double)e->x[at];
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

/* A path on the table; chosen and u follow. False when it did not end in a solution, or in one with too much
 * round-off. */
static bool follow_table(lemke_sift *k, lemke_path *t, const lemke_system *s, lemke_tolerance tol) {
  lemke_engine *e = &k->table->engine;
  const int n = k->sub.n;
  if (lemke_path_go_on(t, e, &k->sub, tol) != LEMKE_SOLVED) {
    return false;
  }
  set_speeds(k, s);
  const double noise = drift * lemke_larger(1, lemke_largest(e->x, n));
  for (int l = 0; l < n; ++l) {
    const double w = (e->where[l] < 0) ? 0 : e->x[e->where[l]];
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

/* ---- rounds --------------------------------------------------------------------------------- */

/* The set goes on on the factored basis. */
static void leave_table(lemke_sift *k) {
  k->retreats += k->tabular;
  k->tabular = false;
}

static void admit(lemke_sift *k, lemke_path *t, const lemke_system *s, int g) {
  if (!k->inside[g]) {
    k->inside[g] = 1;
    k->set_groups++;
    choose_helpers(k, s, g);
    if (k->tabular && !append(k, t, s, g)) {
      leave_table(k);
    }
  }
}

/* The first set: contacts with an impulse in the start basis, joints, and what moves no body. */
static void begin(lemke_sift *k, lemke_path *t, const lemke_system *s, const unsigned char *in_z) {
  k->set_groups = 0;
  k->tabular = !k->one_by_one && !k->joined && k->table_rows > 0;
  open_table(k, s);
  memset(k->u, 0, sizeof *k->u * (size_t)(s->rows - s->n));
  memset(k->inside, 0, (size_t)k->f->n_group);
  memset(k->chosen, 0, (size_t)s->n);
  for (int g = 0; g < k->f->n_group; ++g) {
    bool taken = k->f->body[2 * g] < 0 && k->f->body[2 * g + 1] < 0;
    for (int i = k->f->row_start[g]; i < k->f->row_start[g + 1]; ++i) {
      taken = taken || s->is_free[i] || (in_z[i] && k->helper[i] == SIFT_PRICED);
    }
    k->inside[g] = taken;
    k->set_groups += taken;
    for (int i = k->f->row_start[g]; i < k->f->row_start[g + 1] && taken; ++i) {
      k->chosen[i] = in_z[i];
    }
    if (k->tabular && taken && !append(k, t, s, g)) {
      leave_table(k);
    }
  }
}

/* Path on the set from the basis chosen, or from its origin. Velocities go to u. */
static bool follow_set(lemke_sift *k, lemke_path *t, lemke_tolerance tol, bool origin) {
  const lemke_system *sub = &k->sub;
  for (int l = 0; l < sub->rows; ++l) {
    t->in_z[l] = sub->is_free[l] || (!origin && k->chosen[k->row[l]]);
  }
  const lemke_engine *e = &k->basis->engine;
  if (lemke_path_run(t, &k->basis->engine, sub, tol) != LEMKE_SOLVED) {
    return false;
  }
  for (int l = 0; l < sub->n; ++l) {
    k->chosen[k->row[l]] = t->in_z[l];
  }
  for (int c = 0; c < sub->rows - sub->n; ++c) {
    const int at = e->where[sub->rows + sub->n + c];
    k->u[c] = (at < 0) ? 0 : e->x[at];
  }
  return true;
}

/* The contact outside that is violated most, or -1. */
static int worst_of_all(const lemke_sift *k) {
  int best = -1;
  for (int b = 0; b < k->f->n_body; ++b) {
    if (k->worst[b] >= 0 && (best < 0 || k->depth[b] < k->depth[best])) {
      best = b;
    }
  }
  return (best < 0) ? -1 : k->worst[best];
}

/* From an advanced basis the covering vector B 1 has negative entries, and where M is not symmetric the
 * path may end on a ray where one from the origin does not. */
static bool solve_set(lemke_sift *k, lemke_path *t, const lemke_system *s, lemke_tolerance tol) {
  if (k->tabular && follow_table(k, t, s, tol)) {
    return true;
  }
  leave_table(k);
  build_sub(k, s);
  return follow_set(k, t, tol, false) || follow_set(k, t, tol, true);
}

/* Finds, for every body, the contact outside that is violated most. */
static void price(lemke_sift *k, const lemke_system *s, double noise) {
  const lcp_factored *f = k->f;
  for (int b = 0; b < f->n_body; ++b) {
    k->worst[b] = -1;
    k->depth[b] = -noise;
  }
  for (int g = 0; g < f->n_group; ++g) {
    for (int i = f->row_start[g]; i < f->row_start[g + 1] && !k->inside[g]; ++i) {
      const double w = (k->helper[i] == SIFT_PRICED) ? speed(k, s, i) : 0;
      for (int side = 0; side < 2; ++side) {
        const int b = f->body[2 * g + side];
        if (b >= 0 && w < k->depth[b]) {
          k->depth[b] = w;
          k->worst[b] = g;
        }
      }
    }
  }
}

/* Takes in what is violated; false when nothing is. */
static bool widen(lemke_sift *k, lemke_path *t, const lemke_system *s, double noise) {
  price(k, s, noise);
  const int worst = worst_of_all(k);
  for (int b = 0; b < k->f->n_body && worst >= 0; ++b) {
    if (k->worst[b] >= 0 && (!k->one_by_one || k->worst[b] == worst)) {
      admit(k, t, s, k->worst[b]);
    }
  }
  return worst >= 0;
}

lemke_sift_end lemke_sift_run(lemke_sift *k, lemke_path *t, lemke_table *table, lemke_basis *basis,
                              const lemke_system *s, lemke_tolerance tol) {
  const lcp_factored *f = k->f;
  k->table = table;
  k->basis = basis;
  k->retreats = 0;
  begin(k, t, s, t->in_z);
  bool solved = k->set_groups == 0 || solve_set(k, t, s, tol);
  bool done = false;
  while (solved && !done && 2 * k->set_groups <= f->n_group) {
    done = !widen(k, t, s, tol.tie);
    solved = done || solve_set(k, t, s, tol);
  }
  for (int g = 0; g < f->n_group && solved; ++g) {
    if (!k->inside[g]) {
      choose_helpers(k, s, g);
    }
  }
  for (int i = 0; i < s->rows && solved; ++i) {
    t->in_z[i] = (i >= s->n) || k->chosen[i];
  }
  return !solved ? LEMKE_SIFT_FAILED : done ? LEMKE_SIFT_DONE : LEMKE_SIFT_WIDE;
}

void lemke_sift_point(lemke_sift *k, const lemke_system *s, double *z) {
  lemke_engine *e = &k->table->engine;
  const int n = k->sub.n;
  for (int pass = 0; pass < 2; ++pass) {
    set_speeds(k, s);
    for (int l = 0; l < n; ++l) { /* the values of basic w are not needed */
      k->defect[l] = (e->where[l] < 0) ? (double)s->w[l] : 0;
    }
    e->kind->settle(e, k->defect);
  }
  memset(z, 0, sizeof *z * (size_t)s->n);
  for (int l = 0; l < n; ++l) {
    const int at = e->where[n + l];
    z[k->row[l]] = (at < 0) ? 0 : lemke_larger(e->x[at], 0);
  }
}
