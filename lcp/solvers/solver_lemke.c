/* solver_lemke.c - Lemke's method (Lemke 1965; Cottle, Pang & Stone 1992, algorithms 4.4.5 and 4.9.3):
 * covering vector, complementary pivots, lexicographic ratio test. See README.md, "lemke". */
#include "lcp/lcp_solver.h"
#include "lcp/solvers/lemke/proof.h"
#include "lcp/solvers/lemke/sift.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct lemke_options {
  lcp_stop stop;
  int start;    /* START_* */
  int restarts; /* first bases tried after a ray that proves nothing */
  int table;    /* rows of a sifted set */
} lemke_options;

enum { START_SIFT, START_ORIGIN, START_SLIDING };

static const base_field field_table[] = {
    LCP_STOP_FIELDS(lemke_options, 1e-9, 1e7),
    BASE_FIELD_CHOICE(lemke_options, start, "sift|origin|sliding", START_SIFT,
                      "first basis: of a growing set of contacts where they are many on few bodies "
                      "in factored form; else, where z is zero, all w; or every contact sliding"),
    BASE_FIELD(lemke_options, restarts, BASE_INT, "1", 4, 0, 1000,
               "other first bases tried after a ray that proves nothing"),
    BASE_FIELD(lemke_options, table, BASE_INT, "1", 1000, 0, 10000,
               "rows up to which a sifted set without friction is solved on a tableau"),
};

typedef struct lemke_state {
  lemke_system system; /* a view of a small problem, until it has to be built */
  lemke_store store;
  lemke_path path;
  lemke_table table; /* the two engines */
  lemke_basis basis;
  lemke_sift sift;
  double *best;                    /* n: point with the smallest residual so far */
  double *trial;                   /* rows, scaled */
  double *proof;                   /* n: Farkas vector or ray */
  unsigned char *used, *ray_basis; /* n */
  unsigned char *answer;           /* n: basis of `best` */
  bool small;                      /* a cold path runs on the table */
  bool rescaled;                   /* the system has its rows scaled since an attempt failed */
} lemke_state;

/* Tried in turn until a point passes the residual test: the data's own rows, unless they are far apart; rows scaled like the
 * columns; blunt tolerances for where round-off has piled up. */
typedef struct lemke_attempt {
  const char *word; /* in `variant`; NULL: the engine's */
  bool scaled_rows;
  lemke_tolerance tol;
} lemke_attempt;

static const lemke_attempt attempts[] = {{NULL, false, {1e-11, 1e-12, false}},
                                         {"scaled", true, {1e-11, 1e-12, false}},
                                         {"blunter", true, {1e-8, 1e-10, false}}};

/* From the basis that a path ended in; the second also takes the pivots of nearly parallel contacts. */
static const lemke_tolerance polishing[] = {{1e-11, 1e-15, true}, {1e-14, 1e-15, false}};

/* The residual of a right basis is round-off; more means a neighbouring basis, worth another try
 * even where the tolerance is met (two contacts parallel up to 2^-40). */
static const double round_off = 1e-14;

/* Round-off in w must be small against q, not only against M z: a basis singular but for rounding
 * gives z so large that rho, relative to M z, would pass anything. */
static const double data_share = 1e-3;

/* The values of a table of so few rows, after at most two pivots a row, are mostly right as they stand: to a few roundings of
 * their terms no correction is asked for. After a small pivot, as of a heavy body on a light one, that says little of the values
 * themselves, and they are corrected. */
enum { FEW = 16 };
static const double large_pivot = 1e-3;
static const double few_roundings = 4 * DBL_EPSILON;

/* Rows up to which a cold path is faster on a tableau, where M has many zeros and where it has few. */
enum { SMALL = 64, SMALL_FULL = 256 };

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  lemke_state *k = state;
  const size_t n = (size_t)cap->n;
  const int sifted = lemke_sift_table_rows(cap, ((const lemke_options *)opt)->table);
  const int small = (cap->n < SMALL_FULL) ? cap->n : SMALL_FULL;
  const int rows = cap->n + cap->n_dof;
  lemke_system_layout(&k->system, &k->store, cap, a);
  lemke_path_layout(&k->path, rows, a);
  lemke_table_layout(&k->table, (sifted > small) ? sifted : small, a);
  lemke_basis_layout(&k->basis, rows, cap->nnz + 2 * cap->n_jac + cap->n_dof, a);
  lemke_sift_layout(&k->sift, cap, sifted, a);
  k->best = BASE_ARRAY(a, double, n);
  k->trial = BASE_ARRAY(a, double, rows);
  k->proof = BASE_ARRAY(a, double, n);
  k->used = BASE_ARRAY(a, unsigned char, n);
  k->ray_basis = BASE_ARRAY(a, unsigned char, n);
  k->answer = BASE_ARRAY(a, unsigned char, n);
}

static bool is_orthant(const lcp_problem *p) {
  bool orthant = true;
  for (int b = 0; b < p->n_block && p->block != NULL; ++b) {
    orthant = orthant && p->block[b].set == LCP_ORTHANT;
  }
  return orthant;
}

/* The path from the basis of all w is faster on a tableau: few rows, none of them free. */
static bool is_small(const lcp_problem *p) {
  const lcp_matrix *M = &p->M;
  const size_t n = (size_t)M->n;
  const bool full = M->storage == LCP_DENSE || 2 * (size_t)M->csc.colptr[n] > n * n;
  return M->n <= (full ? SMALL_FULL : SMALL) && is_orthant(p);
}

static base_status prepare(void *state, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  (void)err;
  lemke_state *k = state;
  k->sift.f = NULL;
  k->rescaled = false;
  k->small = p->M.storage != LCP_FACTORED && is_small(p);
  if (!k->small || !lemke_system_view(&k->system, &k->store, p)) {
    lemke_system_build(&k->system, &k->store, p, false);
    lemke_sift_prepare(&k->sift, &k->system, p);
  }
  return BASE_OK;
}

/* The system for a factored basis: built where a view was enough until now. */
static const lemke_system *whole(lemke_state *k, const lcp_problem *p) {
  if (k->system.view) {
    lemke_system_build(&k->system, &k->store, p, false);
  }
  return &k->system;
}

/* ---- points ----------------------------------------------------------------------------------- */

/* z of the basis that the engine holds, by row; of a view in the units of the problem. Components a round-off below
 * zero are zero; the residual test that follows sees what that costs. */
static void read_point(const lemke_state *k, const lemke_engine *e, double *z) {
  const lemke_system *s = &k->system;
  const double q_unit = s->view ? lemke_power(s->q_exp) : 1;
  memset(z, 0, sizeof *z * (size_t)s->rows);
  for (int p = 0; p < s->rows; ++p) {
    const int i = e->head[p] - s->rows;
    if (i >= 0 && i < s->rows && (e->x[p] > 0 || lemke_is_free(s, i))) {
      z[i] = e->x[p] * (s->view ? q_unit * lemke_power(s->col_exp[i]) : 1);
    }
  }
}

/* Judges the point in k->trial, of the basis path.in_z, found by `word`; keeps it when it is the best so far. True
 * when no other attempt is needed. */
static bool judge(lemke_state *k, const lcp_stop *stop, const char *word, lcp_result *res) {
  const lemke_system *s = &k->system;
  double defect = 0;
  const double rho = lemke_residual(s, k->trial, &defect);
  res->work.matvecs++;
  if (rho < res->residual && defect <= data_share) {
    res->residual = rho;
    res->variant = word;
    for (int i = 0; i < s->n; ++i) {
      k->best[i] = s->view ? k->trial[i] : ldexp(k->trial[i], s->q_exp + s->col_exp[i]);
    }
    memcpy(k->answer, k->path.in_z, (size_t)s->n);
  }
  return rho <= lemke_smaller(stop->tol, round_off) && defect <= data_share;
}

/* The same for the basis of path.in_z, its values corrected by the data: by the inverse that the table holds, or
 * factored afresh. */
static bool accept_corrected(lemke_state *k, lemke_engine *e, const lcp_stop *stop,
                             const char *word, lcp_result *res) {
  bool right = false;
  for (int pass = 0; pass < 2 && !right; ++pass) {
    if (!lemke_path_settle(&k->path, e, &k->system, 1)) {
      return false;
    }
    read_point(k, e, k->trial);
    right = judge(k, stop, word, res);
  }
  return right;
}

/* The same, with the values of a small table taken as they are where that is good enough. */
static bool accept(lemke_state *k, lemke_engine *e, const lcp_stop *stop, const char *word,
                   lcp_result *res) {
  const bool few = e == &k->table.engine && e->n <= FEW && k->path.pivots <= 2L * e->n &&
                   k->table.tableau.least_pivot > large_pivot;
  if (few && lemke_engine_holds(e, &k->system, k->path.in_z)) {
    read_point(k, e, k->trial);
    if (judge(k, stop, word, res) && res->residual <= few_roundings) {
      return true;
    }
  }
  return accept_corrected(k, e, stop, word, res);
}

/* ---- first bases ------------------------------------------------------------------------------ */

/* True when the start point names a basis other than that of a cold start. */
static bool start_basis(lemke_state *k, const double *z) {
  const lemke_system *s = &k->system;
  bool warm = false;
  for (int i = 0; i < s->rows; ++i) {
    const bool active = i < s->n && !lemke_is_free(s, i) && z[i] > 0;
    warm = warm || active;
    k->path.in_z[i] = lemke_is_free(s, i) || active;
  }
  return warm;
}

/* Contacts slide against their free velocity: for each unknown s without a diagonal whose column is
 * positive (a slip speed) the row i of the column with the least q_i < 0 is made basic with s.
 * True when there is one. */
static bool start_sliding(const lemke_system *s, unsigned char *in_z) {
  bool any = false;
  for (int j = 0; j < s->n; ++j) {
    int best = -1;
    bool slip = s->diagonal[j] == 0 && !lemke_is_free(s, j);
    for (int k = s->colptr[j]; k < s->colptr[j + 1] && slip; ++k) {
      const int i = s->rowind[k];
      slip = s->val[k] > 0 && i < s->n && s->diagonal[i] > 0;
      best = (best < 0 || s->q[i] < s->q[best]) ? i : best;
    }
    if (slip && best >= 0 && s->q[best] < 0) {
      in_z[j] = 1;
      in_z[best] = 1;
      any = true;
    }
  }
  return any;
}

static lcp_outcome outcome_of(lemke_end end) {
  switch (end) {
  case LEMKE_SOLVED:
    return LCP_STALLED; /* a basis, but not one that passes the test */
  case LEMKE_RAY:
    return LCP_RAY;
  case LEMKE_LIMIT:
    return LCP_MAX_ITER;
  case LEMKE_TIMEOUT:
    return LCP_TIME_LIMIT;
  case LEMKE_CYCLE:
  case LEMKE_BROKEN:
    break;
  }
  return LCP_NUMERICAL;
}

/* The ray as a certificate: a Farkas vector where that can be proved. Without proof only a ray of a cold
 * path, whose covering vector is positive, says something of M. */
static void certify_ray(lemke_state *k, const lcp_problem *p, bool cold, lcp_result *res) {
  if (res->certificate.kind != LCP_CERT_NONE) {
    return;
  }
  if (lemke_ray_proves(&k->path, &k->system, p, k->proof)) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = k->proof};
  } else if (cold) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_RAY, .vector = k->proof};
  }
}

/* Row j with the largest |M_ij M_ji| among those not yet used, or -1. */
static int partner(lemke_state *k, int i) {
  const lemke_system *s = &k->system;
  double *column = s->tau0;
  int best = -1;
  double size = 0;
  memset(column, 0, sizeof(double) * (size_t)s->n);
  for (int p = s->colptr[i]; p < s->colptr[i + 1]; ++p) {
    column[s->rowind[p]] = s->val[p];
  }
  for (int j = 0; j < s->n; ++j) {
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      const double product = fabs(s->val[p] * column[j]);
      if (s->rowind[p] == i && product > size && !k->used[j] && !k->ray_basis[j]) {
        size = product;
        best = j;
      }
    }
  }
  return best;
}

/* After a ray that proves nothing: the same method on the principal transforms of the problem that
 * have the blocked pair and one partner basic (a bimatrix game ends every path from the origin on a
 * ray, but not from there). */
static bool restart_after_ray(lemke_state *k, const lcp_problem *p, const lemke_options *o,
                              lcp_result *res) {
  const lemke_system *s = whole(k, p);
  const int pair = k->path.entering % s->rows;
  if (s->rows > s->n) {
    return false;
  }
  memset(k->used, 0, (size_t)s->n);
  memcpy(k->ray_basis, k->path.in_z, (size_t)s->n);
  for (int round = 0; round < o->restarts; ++round) {
    const int j = partner(k, pair);
    if (j < 0) {
      return false;
    }
    k->used[j] = 1;
    memcpy(k->path.in_z, k->ray_basis, (size_t)s->n);
    k->path.in_z[pair] = 1;
    k->path.in_z[j] = 1;
    res->work.fallbacks++;
    const lemke_end end = lemke_path_run(&k->path, &k->basis.engine, s, attempts[0].tol);
    const bool last = end == LEMKE_LIMIT || end == LEMKE_TIMEOUT;
    res->outcome = last ? outcome_of(end) : res->outcome;
    if (accept(k, &k->basis.engine, &o->stop, "restarted", res) || last) {
      return true;
    }
  }
  return false;
}

/* The basis a path ended in is right up to the tolerance for ties, which lets a contact penetrate by
 * as much; a few pivots from there with the sharp one put that right: on a local path, and where that
 * ends on a ray with the cover of all rows. Where masses are 1e8 apart a wrong basis within that tolerance
 * can be one whose point is none at all: then from there. */
static bool polish(lemke_state *k, const lcp_problem *p, const lemke_options *o, lcp_result *res) {
  const lemke_system *s = whole(k, p);
  lemke_engine *e = &k->basis.engine;
  if (!(res->residual < HUGE_VAL)) {
    memcpy(k->answer, k->path.in_z, (size_t)s->n);
  }
  for (int way = 0; way < BASE_COUNT(polishing); ++way) {
    res->work.refinements++;
    memcpy(k->path.in_z, k->answer, (size_t)s->n);
    if (lemke_path_run(&k->path, e, s, polishing[way]) == LEMKE_SOLVED &&
        accept(k, e, &o->stop, "polished", res)) {
      return true;
    }
  }
  return false;
}

/* A ray is then a proof, though not always one that survives rounding. */
static bool ray_is_final(const lcp_problem *p) {
  return (p->traits & (LCP_PSD | LCP_PD | LCP_COPOSITIVE_PLUS)) != 0;
}

/* ---- attempts --------------------------------------------------------------------------------- */

/* The basis that sifting ended in, from what the table still knows or factored. */
static bool accept_sifted(lemke_state *k, const lcp_stop *stop, lcp_result *res) {
  if (!k->sift.tabular) {
    return accept(k, &k->basis.engine, stop, "sifted_basis", res);
  }
  lemke_sift_point(&k->sift, &k->system, k->trial);
  return judge(k, stop, "sifted_table", res);
}

/* From a sifted basis, polished like any other: the sharp tolerances see a contact left out that is
 * violated by little more than round-off. True when no other attempt is needed. */
static bool sift_attempt(lemke_state *k, const lcp_problem *p, const lemke_options *o,
                         const double *z, lcp_result *res) {
  (void)start_basis(k, z);
  const lemke_sift_end sifted =
      lemke_sift_run(&k->sift, &k->path, &k->table, &k->basis, &k->system, attempts[0].tol);
  lemke_end end = LEMKE_SOLVED;
  bool right = sifted == LEMKE_SIFT_DONE && accept_sifted(k, &o->stop, res);
  res->work.fallbacks += k->sift.retreats;
  if (sifted == LEMKE_SIFT_WIDE) {
    end = lemke_path_run(&k->path, &k->basis.engine, &k->system, attempts[0].tol);
    right = accept(k, &k->basis.engine, &o->stop, "sifted_basis", res);
  }
  res->outcome = outcome_of(end);
  if (!right && end == LEMKE_SOLVED && res->residual < HUGE_VAL) {
    right = polish(k, p, o, res);
  }
  if (right || end == LEMKE_LIMIT || end == LEMKE_TIMEOUT || res->residual <= o->stop.tol) {
    return true;
  }
  res->work.fallbacks++;
  return false;
}

/* The path from in_z, all w where it is cold: then on the table, if it is small. *e is the engine. */
static lemke_end run(lemke_state *k, const lcp_problem *p, bool cold, lemke_tolerance tol,
                     lemke_engine **e) {
  const bool table = cold && k->small;
  *e = table ? &k->table.engine : &k->basis.engine;
  return lemke_path_run(&k->path, *e, table ? &k->system : whole(k, p), tol);
}

/* The attempt after a: one that scales rows is no other than the first where they were scaled from the start. */
static int next_attempt(const lemke_state *k, int a) {
  const bool same = a == 0 && k->system.scaled_rows;
  return a + 1 + same;
}

/* The system as attempt a wants it. */
static void scale_for(lemke_state *k, const lcp_problem *p, int a) {
  if (attempts[a].scaled_rows && !k->system.scaled_rows) {
    lemke_system_build(&k->system, &k->store, p, true);
    k->rescaled = true;
  }
}

/* After an attempt from e that ended so: is there nothing left to try? */
static bool settled(lemke_state *k, const lcp_problem *p, const lemke_options *o, lemke_engine *e,
                    lemke_end end, const char *word, lcp_result *res) {
  return accept(k, e, &o->stop, (word == NULL) ? e->kind->word : word, res) || end == LEMKE_LIMIT ||
         end == LEMKE_TIMEOUT || res->certificate.kind == LCP_CERT_FARKAS ||
         (end == LEMKE_SOLVED && polish(k, p, o, res));
}

/* Cold after warm, then the other attempts, until a basis is right to round-off. */
static void run_attempts(lemke_state *k, const lcp_problem *p, const lemke_options *o, double *z,
                         lcp_result *res) {
  bool warm = start_basis(k, z);
  warm = warm || (o->start == START_SLIDING && start_sliding(whole(k, p), k->path.in_z));
  const char *word = NULL; /* of a first attempt, its engine's */
  for (int a = 0; a < BASE_COUNT(attempts);) {
    lemke_engine *e = NULL;
    scale_for(k, p, a);
    const lemke_end end = run(k, p, !warm, attempts[a].tol, &e);
    if (end == LEMKE_RAY) {
      certify_ray(k, p, !warm, res);
    }
    if (end == LEMKE_LIMIT || end == LEMKE_TIMEOUT || a == 0) {
      res->outcome = outcome_of(end);
    }
    if (settled(k, p, o, e, end, word, res)) {
      break;
    }
    if (end == LEMKE_RAY && a == 0 && !warm && !ray_is_final(p) &&
        restart_after_ray(k, p, o, res)) {
      break;
    }
    a = warm ? a : next_attempt(k, a);
    word = warm ? "cold" : (a < BASE_COUNT(attempts)) ? attempts[a].word : NULL;
    warm = false;
    memset(z, 0, sizeof(double) * (size_t)p->M.n);
    (void)start_basis(k, z);
    res->work.fallbacks += a < BASE_COUNT(attempts);
  }
}

/* A small problem that no attempt solved: is there a feasible point at all? Where a proof is found that holds exactly, it
 * takes the place of a ray. */
static void look_for_proof(lemke_state *k, const lcp_problem *p, const lcp_stop *stop,
                           lcp_result *res) {
  const bool open = res->outcome != LCP_MAX_ITER && res->outcome != LCP_TIME_LIMIT;
  if (k->small && open && res->residual > stop->tol && res->certificate.kind != LCP_CERT_FARKAS &&
      lemke_search_proof(&k->path, &k->table, &k->system, p, k->trial)) {
    memcpy(k->proof, k->trial, sizeof *k->proof * (size_t)p->M.n);
    res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = k->proof};
  }
}

static void conclude(const lemke_state *k, const lemke_options *o, lcp_result *res) {
  if (res->residual <= o->stop.tol) {
    res->outcome = LCP_SOLVED;
    res->certificate = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = k->answer};
  } else if (res->certificate.kind == LCP_CERT_FARKAS) {
    res->outcome = LCP_INFEASIBLE;
  }
}

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  lemke_state *k = state;
  const lemke_options *o = opt;
  lemke_path *t = &k->path;
  *res = (lcp_result){.outcome = LCP_NUMERICAL, .residual = HUGE_VAL, .variant = ""};
  if (k->rescaled) { /* by a solve before this one */
    (void)prepare(state, p, opt, NULL);
  }
  memset(k->best, 0, sizeof(double) * (size_t)p->M.n);
  t->pivots = 0;
  t->pivot_limit = o->stop.max_iter;
  t->deadline = -1;
  t->max_seconds = o->stop.max_seconds;
  lemke_engine_forget(&k->table.engine);
  lemke_engine_forget(&k->basis.engine);
  k->basis.basis.factorizations = 0;
  k->basis.basis.backsolves = 0;
  const bool sift = o->start == START_SIFT && k->sift.f != NULL;
  if (!sift || !sift_attempt(k, p, o, z, res)) {
    run_attempts(k, p, o, z, res);
  }
  look_for_proof(k, p, &o->stop, res);
  conclude(k, o, res);
  memcpy(z, k->best, sizeof(double) * (size_t)p->M.n);
  res->work.iterations = t->pivots;
  res->work.pivots = t->pivots;
  res->work.factorizations = k->basis.basis.factorizations;
  res->work.backsolves = k->basis.basis.backsolves;
  if (trace != NULL && trace->len < trace->cap) {
    trace->iteration[trace->len] = t->pivots;
    trace->residual[trace->len++] = res->residual;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_lemke = {
    .name = "lemke",
    .title = "Lemke, lexicographic",
    .cite = "lemke1965; cottle1992, 4.4 and 4.9",
    .words = "Exact, by pivoting along a path.",
    .when = "Problems with friction up to some thousand unknowns, above all from the last step's "
            "answer; a ray tells where none exists.",
    .sets = 1u << LCP_ORTHANT | 1u << LCP_FREE,
    .storages = 1u << LCP_DENSE | 1u << LCP_CSC | 1u << LCP_FACTORED,
    .exact = true,
    .warm = true,
    .fields = field_table,
    .n_fields = BASE_COUNT(field_table),
    .options_size = sizeof(lemke_options),
    .state_size = sizeof(lemke_state),
    .layout = layout,
    .prepare = prepare,
    .solve = solve,
};
