/* solver_enumerate.c - all 2^n complementary bases, n <= 16, in long double (Murty 1988, chapter 1: the
 * definition, made a method). The only one here that can say how many solutions there are, and
 * that there is none although a feasible point exists.
 *
 * A nonsingular basis holds at most one solution; it is counted where its support is the basis, so
 * that degenerate points count once. Bases with M_BB singular hold none, or a face of solutions:
 * they are asked, by phase one of the simplex method (lemke/phase_one.h), only when the others hold none. `variant`
 * tells "isolated" (all bases that matter were nonsingular), "faces" (a singular basis was
 * consistent, further solutions are possible) and "no_solution". */
#include "lcp/base/clock.h"
#include "lcp/lcp_farkas.h"
#include "lcp/lcp_solver.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/lemke/proof.h"

enum { N_MAX = 16 };

typedef long double real;

typedef struct options {
  lcp_stop stop;
} options;

typedef struct enumerate {
  lcp_stop_state stop;
  int n;
  real M[N_MAX][N_MAX], q[N_MAX]; /* R M C, R q: powers of two */
  double row[N_MAX], col[N_MAX];
  int row_exp[N_MAX], col_exp[N_MAX]; /* their exponents */
  real z[N_MAX];                      /* of the basis at hand, scaled */
  double answer[N_MAX], farkas[N_MAX], dense[N_MAX * N_MAX];
  unsigned char basis[N_MAX];
  long solutions, faces;
  lemke_path path; /* phase one of the simplex method, as the next two */
  lemke_table table;
  lemke_system system;
} enumerate;

/* Shares of the terms of a sum below which it is zero: 64-bit mantissas, condition up to 1e5 spare. */
static const real zero_share = 1e-14L;
static const real singular_below = 1e-15L;

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  enumerate *s = state;
  const int n = (cap->n < N_MAX) ? cap->n : N_MAX;
  lcp_stop_layout(&s->stop, cap, a);
  lemke_path_layout(&s->path, n, a);
  lemke_table_layout(&s->table, n, a);
}

static int power_below(double x) {
  int e = 0;
  (void)frexp(x, &e);
  return (x > 0) ? -e : 0;
}

/* Rows, then columns, to a largest entry in [1/2, 1). */
static base_status prepare(void *state, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  enumerate *s = state;
  const int n = p->M.n;
  if (n > N_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "enumerate: n = %d, at most %d", n, N_MAX);
  }
  s->n = n;
  lcp_matrix_to_dense(&p->M, s->dense);
  for (int i = 0; i < n; i++) {
    double top = 0;
    for (int j = 0; j < n; j++) {
      top = fmax(top, fabs(s->dense[j * n + i]));
    }
    s->row_exp[i] = power_below(top);
    s->row[i] = ldexp(1, s->row_exp[i]);
    s->q[i] = (real)p->q[i] * s->row[i];
  }
  for (int j = 0; j < n; j++) {
    double top = 0;
    for (int i = 0; i < n; i++) {
      top = fmax(top, fabs(s->dense[j * n + i]) * s->row[i]);
    }
    s->col_exp[j] = power_below(top);
    s->col[j] = ldexp(1, s->col_exp[j]);
    for (int i = 0; i < n; i++) {
      s->M[i][j] = (real)s->dense[j * n + i] * s->row[i] * s->col[j];
    }
  }
  return BASE_OK;
}

typedef enum kind { REGULAR, INCONSISTENT, FACE } kind;

/* [M_BB | -q_B] under complete pivoting; bound: size of the terms the right-hand side is made of. */
typedef struct elimination {
  real a[N_MAX][N_MAX + 1], bound[N_MAX];
  int col[N_MAX], m;
} elimination;

static void load(elimination *e, const enumerate *s, const int *b, int m) {
  e->m = m;
  for (int i = 0; i < m; i++) {
    for (int j = 0; j < m; j++) {
      e->a[i][j] = s->M[b[i]][b[j]];
    }
    e->a[i][m] = -s->q[b[i]];
    e->bound[i] = fabsl(e->a[i][m]);
    e->col[i] = i;
  }
}

/* Moves the largest remaining entry to (k, k); its size. */
static real bring(elimination *e, int k) {
  int r = k;
  int c = k;
  for (int i = k; i < e->m; i++) {
    for (int j = k; j < e->m; j++) {
      if (fabsl(e->a[i][j]) > fabsl(e->a[r][c])) {
        r = i;
        c = j;
      }
    }
  }
  for (int j = 0; j <= e->m; j++) {
    const real t = e->a[r][j];
    e->a[r][j] = e->a[k][j];
    e->a[k][j] = t;
  }
  const real bound = e->bound[r];
  e->bound[r] = e->bound[k];
  e->bound[k] = bound;
  for (int i = 0; i < e->m; i++) {
    const real t = e->a[i][c];
    e->a[i][c] = e->a[i][k];
    e->a[i][k] = t;
  }
  const int label = e->col[c];
  e->col[c] = e->col[k];
  e->col[k] = label;
  return fabsl(e->a[k][k]);
}

static void clear_below(elimination *e, int k) {
  for (int i = k + 1; i < e->m; i++) {
    const real f = e->a[i][k] / e->a[k][k];
    for (int j = k; j <= e->m; j++) {
      e->a[i][j] -= f * e->a[k][j];
    }
    e->bound[i] += fabsl(f) * e->bound[k];
  }
}

/* Solves M_BB z = -q_B. FACE: singular and consistent. */
static kind solve_basis(const enumerate *s, const int *b, int m, real *z) {
  elimination e;
  load(&e, s, b, m);
  int rank = 0;
  while (rank < m && bring(&e, rank) > singular_below) {
    clear_below(&e, rank++);
  }
  for (int i = rank; i < m; i++) {
    if (fabsl(e.a[i][m]) > zero_share * e.bound[i]) {
      return INCONSISTENT;
    }
  }
  if (rank < m) {
    return FACE;
  }
  for (int i = m - 1; i >= 0; i--) {
    real sum = e.a[i][m];
    for (int j = i + 1; j < m; j++) {
      sum -= e.a[i][j] * z[e.col[j]];
    }
    z[e.col[i]] = sum / e.a[i][i];
  }
  return REGULAR;
}

/* z by unknown: in K and with w >= 0, up to round-off? *interior: no z_B at zero. */
static bool feasible(const enumerate *s, const int *b, int m, const real *zb, bool *interior) {
  real top = 0;
  *interior = true;
  for (int k = 0; k < m; k++) {
    top = fmaxl(top, fabsl(zb[k]));
  }
  for (int k = 0; k < m; k++) {
    if (zb[k] < -zero_share * top) {
      return false;
    }
    *interior = *interior && zb[k] > zero_share * top;
  }
  for (int i = 0; i < s->n; i++) {
    real w = s->q[i];
    real bound = fabsl(w);
    for (int k = 0; k < m; k++) {
      w += s->M[i][b[k]] * zb[k];
      bound += fabsl(s->M[i][b[k]] * zb[k]);
    }
    if (w < -zero_share * bound) {
      return false;
    }
  }
  return true;
}

static void keep(enumerate *s, const int *b, int m, const real *zb) {
  for (int i = 0; i < s->n; i++) {
    s->answer[i] = 0;
    s->basis[i] = 0;
  }
  for (int k = 0; k < m; k++) {
    s->answer[b[k]] = (double)fmaxl(zb[k], 0) * s->col[b[k]];
    s->basis[b[k]] = 1;
  }
}

static bool pose(enumerate *s, const lcp_problem *p) {
  return lemke_system_over(&s->system, s->n, p->M.val, p->q, s->row_exp, s->col_exp);
}

static bool face_solution(enumerate *s, const lcp_problem *p, unsigned mask) {
  const int n = s->n;
  lemke_engine *e = &s->table.engine;
  unsigned char allowed[2 * N_MAX];
  double proof[N_MAX];
  for (int i = 0; i < n; i++) {
    s->basis[i] = ((mask >> i) & 1u) != 0;
    allowed[i] = !s->basis[i];
    allowed[n + i] = s->basis[i];
  }
  if (!pose(s, p) || lemke_phase_one(&s->path, &s->table, &s->system,
                                     (lemke_phase){.allowed = allowed}, proof) != LEMKE_SOLVED) {
    return false;
  }
  lemke_path_refine(&s->path, e, &s->system);
  for (int i = 0; i < n; i++) {
    const int at = e->where[n + i];
    const double z = (at < 0) ? 0 : fmax(e->x[at], 0);
    s->answer[i] = ldexp(z, s->system.q_exp + s->col_exp[i]);
  }
  return true;
}

static bool infeasible(enumerate *s, const lcp_problem *p) {
  return pose(s, p) && lemke_search_proof(&s->path, &s->table, &s->system, p, s->farkas);
}

static int members(unsigned mask, int n, int *b) {
  int m = 0;
  for (int i = 0; i < n; i++) {
    if (((mask >> i) & 1u) != 0) {
      b[m++] = i;
    }
  }
  return m;
}

/* False: out of time or iterations. */
static bool visit_all(enumerate *s, const lcp_stop *stop, bool *found, lcp_result *res) {
  for (unsigned mask = 0; mask < 1u << s->n; mask++) {
    if (res->work.iterations >= stop->max_iter) {
      res->outcome = LCP_MAX_ITER;
      return false;
    }
    if (mask % 256 == 255 && base_seconds() - s->stop.started > stop->max_seconds) {
      res->outcome = LCP_TIME_LIMIT;
      return false;
    }
    int b[N_MAX];
    const int m = members(mask, s->n, b);
    const kind k = solve_basis(s, b, m, s->z);
    res->work.iterations++;
    res->work.factorizations++;
    s->faces += k == FACE;
    bool interior = false;
    if (k != REGULAR || !feasible(s, b, m, s->z, &interior)) {
      continue;
    }
    s->solutions += interior;
    if (!*found) {
      keep(s, b, m, s->z);
      *found = true;
    }
  }
  return true;
}

static bool search_faces(enumerate *s, const lcp_problem *p, lcp_work *work) {
  for (unsigned mask = 0; mask < 1u << s->n; mask++) {
    int b[N_MAX];
    const int m = members(mask, s->n, b);
    if (solve_basis(s, b, m, s->z) == FACE) {
      work->fallbacks++;
      if (face_solution(s, p, mask)) {
        return true;
      }
    }
  }
  return false;
}

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* a search has no residual */
  enumerate *s = state;
  const lcp_stop *stop = &((const options *)opt)->stop;
  bool found = false;
  lcp_stop_begin(&s->stop, p);
  s->path.pivots = 0;
  s->path.pivot_limit = stop->max_iter;
  s->path.deadline = s->stop.started + stop->max_seconds;
  s->solutions = 0;
  s->faces = 0;
  for (int i = 0; i < s->n; i++) {
    z[i] = 0;
  }
  if (!visit_all(s, stop, &found, res)) {
    return BASE_OK;
  }
  found = found || (s->faces > 0 && search_faces(s, p, &res->work));
  res->variant = (s->faces > 0) ? "faces" : "isolated";
  res->solutions = (found && s->solutions == 0) ? 1 : s->solutions;
  if (!found && infeasible(s, p)) {
    res->outcome = LCP_INFEASIBLE;
    res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = s->farkas};
    return BASE_OK;
  }
  if (!found) {
    res->variant = "no_solution";
    res->outcome = LCP_STALLED;
    return BASE_OK;
  }
  for (int i = 0; i < s->n; i++) {
    z[i] = s->answer[i];
  }
  double r[N_MAX], tau0[N_MAX];
  const bool met = lcp_stop_met(&s->stop, stop->tol, p, z, res) &&
                   lcp_data_met(p, stop->tol, &s->stop, z, r, tau0, &res->work);
  res->outcome = met ? LCP_SOLVED : LCP_NUMERICAL;
  if (res->outcome == LCP_SOLVED) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->basis};
  }
  return BASE_OK;
}

static const base_field fields[] = {LCP_STOP_FIELDS(options, 1e-10, 65536)};

const lcp_solver lcp_solver_enumerate = {
    .name = "enumerate",
    .title = "enumeration",
    .cite = "murty1988, chapter 1",
    .words = "Tries every case.",
    .when = "At most some sixteen unknowns, where all solutions are asked for.",
    .sets = 1u << LCP_ORTHANT,
    .storages = 1u << LCP_DENSE,
    .exact = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(enumerate),
};
