#include "harness/sequence/sequence_solve.h"

#include "harness/measure/sim_watch.h"
#include "lcp/base/clock.h"
#include "lcp/lcp_cone.h"

#include <stdlib.h>
#include <string.h>

#define WORD_(id, word) word,
static const char *const start_names[] = {SEQUENCE_STARTS(WORD_)};

const char *sequence_start_name(sequence_start s) {
  return start_names[s];
}

base_status sequence_start_find(const char *text, sequence_start *out, base_error *err) {
  *out = SEQUENCE_COLD;
  if (text == NULL || text[0] == '\0') {
    return BASE_OK;
  }
  for (int k = 0; k < SEQUENCE_START_COUNT; k++) {
    if (strcmp(text, start_names[k]) == 0) {
      *out = (sequence_start)k;
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "start %.60s: need cold, previous, basis or predicted", text);
}

/* ---- the past of a pass ---------------------------------------------------------------------- */

/* Answers of the last problem and of the one before, each with the problem it belongs to. */
typedef struct past {
  const sequence_item *of; /* NULL: nothing is known */
  double *z;               /* n of it; owned, as the next one */
  unsigned char *basic;    /* n; see has_basis */
  bool has_basis;
} past;

typedef struct pass {
  const sequence_request *q;
  sequence_result *out;
  lcp_instance *instance;
  past last, before;
  double *z;           /* of the problem at hand */
  int *from, *earlier; /* its rows in the last problem, and in the one before */
} pass;

static base_status open_pass(pass *s, const sequence_request *q, sequence_result *out,
                             base_error *err) {
  const size_t n = (size_t)sequence_largest(q->sequence) + 1;
  *s = (pass){.q = q, .out = out};
  s->z = malloc(n * sizeof *s->z);
  s->from = malloc(n * sizeof *s->from);
  s->earlier = malloc(n * sizeof *s->earlier);
  s->last = (past){.z = malloc(n * sizeof(double)), .basic = malloc(n)};
  s->before = (past){.z = malloc(n * sizeof(double)), .basic = malloc(n)};
  return (s->z != NULL && s->from != NULL && s->earlier != NULL && s->last.z != NULL &&
          s->last.basic != NULL && s->before.z != NULL && s->before.basic != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory for start points of %zu unknowns", n);
}

static void close_pass(pass *s) {
  lcp_instance_close(s->instance);
  free(s->z);
  free(s->from);
  free(s->earlier);
  free(s->last.z);
  free(s->last.basic);
  free(s->before.z);
  free(s->before.basic);
}

static void remember(pass *s, const sequence_item *k, const lcp_result *claim) {
  const past oldest = s->before;
  const size_t n = (size_t)k->p.M.n;
  bool finite = true;
  s->before = s->last;
  s->last = oldest;
  for (size_t i = 0; i < n; i++) {
    finite = finite && isfinite(s->z[i]);
  }
  s->last.of = finite ? k : NULL;
  memcpy(s->last.z, s->z, n * sizeof *s->z);
  s->last.has_basis = claim->outcome == LCP_SOLVED && claim->certificate.kind == LCP_CERT_BASIS;
  if (s->last.has_basis) {
    memcpy(s->last.basic, claim->certificate.basis, n);
  }
}

/* ---- start points ---------------------------------------------------------------------------- */

static void clip(const lcp_problem *p, double *z) {
  for (int b = 0; b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    for (int i = k->start; i < k->start + k->size; i++) {
      if (k->set == LCP_ORTHANT) {
        z[i] = fmax(z[i], 0.0);
      } else if (k->set == LCP_BOX) {
        z[i] = fmin(fmax(z[i], p->lo[i]), p->hi[i]);
      }
    }
    if (k->set == LCP_CONE) {
      lcp_cone_project(k, z + k->start, z + k->start);
    }
  }
}

/* Where a basic row begins: within its bounds, and not at one of them. */
static double inside(const lcp_problem *p, const lcp_block *b, int i, double unit) {
  if (b->set != LCP_BOX) {
    return unit;
  }
  const bool low = p->lo[i] > -HUGE_VAL, high = p->hi[i] < HUGE_VAL;
  return (low && high) ? 0.5 * p->lo[i] + 0.5 * p->hi[i]
         : low         ? p->lo[i] + unit
         : high        ? p->hi[i] - unit
                       : unit;
}

static void start_from_basis(pass *s, const lcp_problem *p) {
  double unit = 0.0;
  for (int i = 0; i < s->last.of->p.M.n; i++) {
    unit = fmax(unit, fabs(s->last.z[i]));
  }
  unit = (unit > 0.0) ? unit : 1.0;
  for (int b = 0; b < p->n_block; b++) {
    for (int i = p->block[b].start; i < p->block[b].start + p->block[b].size; i++) {
      if (s->from[i] >= 0 && s->last.basic[s->from[i]]) {
        s->z[i] = inside(p, &p->block[b], i, unit);
      }
    }
  }
}

/* s->z for problem k. */
static void start_point(pass *s, const sequence_item *k) {
  const int n = k->p.M.n;
  const sequence_start start = s->q->start;
  memset(s->z, 0, (size_t)n * sizeof *s->z);
  if (start == SEQUENCE_COLD || s->last.of == NULL ||
      (start == SEQUENCE_BASIS && !s->last.has_basis)) {
    return;
  }
  sequence_match(k, s->last.of, s->from);
  for (int i = 0; i < n; i++) {
    s->z[i] = (s->from[i] >= 0) ? s->last.z[s->from[i]] : 0.0;
  }
  if (start == SEQUENCE_BASIS) {
    start_from_basis(s, &k->p);
  } else if (start == SEQUENCE_PREDICTED && s->before.of != NULL) {
    sequence_match(k, s->before.of, s->earlier);
    for (int i = 0; i < n; i++) {
      const bool both = s->from[i] >= 0 && s->earlier[i] >= 0;
      s->z[i] += both ? s->z[i] - s->before.z[s->earlier[i]] : 0.0;
    }
  }
  clip(&k->p, s->z);
}

/* ---- one problem ----------------------------------------------------------------------------- */

static void trouble(sequence_result *out, run_status word, const sequence_item *k,
                    const char *text) {
  if (out->note[0] == '\0') {
    (void)snprintf(out->note, sizeof out->note, "step %ld, solve %d: %.180s", k->step, k->solve,
                   text);
  }
  out->status = run_status_worse(out->status, word);
}

static void add_verdict(lcp_verdict *worst, const lcp_verdict *v) {
  worst->rho = fmax(worst->rho, v->rho);
  worst->natural = fmax(worst->natural, v->natural);
  worst->natural_rel = fmax(worst->natural_rel, v->natural_rel);
  worst->infeasible_z = fmax(worst->infeasible_z, v->infeasible_z);
  worst->infeasible_w = fmax(worst->infeasible_w, v->infeasible_w);
  worst->comp = fmax(worst->comp, v->comp);
}

static base_status judge(pass *s, const sequence_item *k, const lcp_result *claim,
                         base_error *err) {
  sequence_result *out = s->out;
  const solver_choice *solver = s->q->solver;
  lcp_verdict v;
  bool verified;
  run_status claimed = RUN_OK;
  BASE_TRY(lcp_judge(&k->p, s->z, &v, err));
  const run_status word = verdict_of(solver->solver, solver->opt, &k->p, claim, &v, &verified);
  if (claim->outcome != LCP_SOLVED &&
      !run_status_find(lcp_outcome_name(claim->outcome), &claimed)) {
    claimed = RUN_NUMERICAL;
  }
  out->n++;
  out->n_unsolved += word != RUN_OK;
  out->verified = out->verified && verified;
  out->claimed = run_status_worse(out->claimed, claimed);
  out->hash = sim_hash(out->hash, s->z, k->p.M.n);
  add_verdict(&out->worst, &v);
  if (word != RUN_OK) {
    char text[120];
    (void)snprintf(text, sizeof text, "%s (n=%d): claimed %s, rho=%.3g", run_status_name(word),
                   k->p.M.n, lcp_outcome_name(claim->outcome), v.rho);
    trouble(out, word, k, text);
  }
  return BASE_OK;
}

static base_status solve_now(pass *s, const sequence_item *k, lcp_result *claim,
                             sequence_cost *cost, base_error *err) {
  sequence_result *out = s->out;
  trace_file *t = s->q->trace;
  BASE_TRY(lcp_instance_prepare(s->instance, &k->p, err));
  BASE_TRY(lcp_instance_solve(s->instance, t != NULL ? trace_begin(t) : NULL, s->z, claim, err));
  const lcp_times spent = lcp_instance_times(s->instance);
  out->time.setup += spent.setup;
  out->time.factor += spent.factor;
  out->time.solve += spent.solve;
  out->variant = claim->variant;
  out->storage = lcp_instance_storage(s->instance);
  out->bytes = lcp_instance_bytes(s->instance);
  lcp_work_add(&out->work, &claim->work);
  if (cost != NULL) {
    *cost = (sequence_cost){spent.setup + spent.factor + spent.solve,
                            claim->work.iterations + claim->work.pivots};
  }
  return (t != NULL) ? trace_end(t, err) : BASE_OK;
}

static base_status solve_item(pass *s, const sequence_item *k, sequence_cost *cost,
                              base_error *err) {
  const sequence_request *q = s->q;
  lcp_result claim = {.outcome = LCP_NUMERICAL};
  start_point(s, k);
  BASE_TRY(q->replay != NULL ? answers_take(q->replay, k->p.M.n, s->z, &claim, err)
                             : solve_now(s, k, &claim, cost, err));
  if (q->store != NULL) {
    BASE_TRY(answers_put(q->store, k->p.M.n, s->z, &claim, err));
  }
  BASE_TRY(judge(s, k, &claim, err));
  remember(s, k, &claim);
  if (q->start == SEQUENCE_BASIS && q->replay == NULL && claim.outcome == LCP_SOLVED &&
      !s->last.has_basis) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: hands over no basis to start from",
                     q->solver->solver->name);
  }
  return BASE_OK;
}

/* ---- a pass ---------------------------------------------------------------------------------- */

static base_status admit(const sequence_request *q, lcp_capacity *cap, base_error *err) {
  const lcp_solver *s = q->solver->solver;
  *cap = (lcp_capacity){0};
  if (q->start != SEQUENCE_COLD && !s->warm) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: does not use a start point", s->name);
  }
  for (int i = 0; i < q->sequence->n; i++) {
    const lcp_problem *p = &q->sequence->item[i].p;
    BASE_TRY(lcp_solver_admits(s, p, err));
    const lcp_capacity one = lcp_problem_capacity(p);
    *cap = (one.n > cap->n) ? one : *cap; /* an instance grows by itself where this is too little */
  }
  return BASE_OK;
}

static base_status run_pass(pass *s, sequence_cost *cost, base_error *err) {
  const sequence *all = s->q->sequence;
  lcp_capacity cap;
  BASE_TRY(admit(s->q, &cap, err));
  if (s->q->replay == NULL) {
    BASE_TRY(lcp_instance_open(&s->instance, s->q->solver->solver, &cap, s->q->solver->opt, err));
  }
  for (int i = 0; i < all->n; i++) {
    BASE_TRY(solve_item(s, &all->item[i], cost != NULL ? &cost[i] : NULL, err));
  }
  return BASE_OK;
}

base_status sequence_solve(const sequence_request *q, sequence_result *out, sequence_cost *cost,
                           base_error *err) {
  pass s;
  base_error why = {0};
  *out = (sequence_result){
      .status = RUN_OK, .claimed = RUN_OK, .verified = true, .variant = "", .hash = SIM_HASH_START};
  base_status done = open_pass(&s, q, out, &why);
  if (done == BASE_OK) {
    done = run_pass(&s, cost, &why);
  }
  close_pass(&s);
  if (done == BASE_EUNSUPPORTED) {
    out->status = RUN_UNSUPPORTED;
    out->verified = false;
    (void)snprintf(out->note, sizeof out->note, "%.230s", why.text);
    return BASE_OK;
  }
  if (done != BASE_OK && err != NULL) {
    *err = why;
  }
  return done;
}

/* ---- against a cold start -------------------------------------------------------------------- */

/* Of one problem over the passes. */
typedef struct extremes {
  double cold_most, warm_least; /* [s] */
} extremes;

static base_status run_turn(const sequence_request *q, sequence_cost *cold, sequence_cost *warm,
                            extremes *e, bool *defined, base_error *err) {
  sequence_request one = {.sequence = q->sequence, .solver = q->solver, .start = q->start};
  sequence_result r;
  BASE_TRY(sequence_solve(&one, &r, warm, err));
  *defined = r.status != RUN_UNSUPPORTED;
  if (!*defined) {
    return BASE_OK;
  }
  one.start = SEQUENCE_COLD;
  BASE_TRY(sequence_solve(&one, &r, cold, err));
  for (int i = 0; i < q->sequence->n; i++) {
    e[i].cold_most = fmax(e[i].cold_most, cold[i].seconds);
    e[i].warm_least = fmin(e[i].warm_least, warm[i].seconds);
  }
  return BASE_OK;
}

static base_status run_turns(const sequence_request *q, double limit, sequence_cost *cost,
                             extremes *e, sequence_regressions *out, base_error *err) {
  const int n = q->sequence->n;
  sequence_cost *warm = cost + n;
  const double from = base_seconds();
  bool defined = true;
  bool timed = true;
  for (int i = 0; i < n; i++) {
    e[i] = (extremes){0.0, HUGE_VAL};
  }
  for (int turn = 0; turn < SEQUENCE_PASSES && defined && timed; turn++) {
    BASE_TRY(run_turn(q, cost, warm, e, &defined, err));
    timed = SEQUENCE_PASSES * (base_seconds() - from) < limit * (turn + 1);
  }
  if (!defined) {
    return BASE_OK;
  }
  out->work = 0;
  out->time = timed ? 0 : SEQUENCE_UNCOUNTED;
  for (int i = 0; i < n; i++) {
    out->work += warm[i].work > cost[i].work;
    out->time += timed && e[i].warm_least > e[i].cold_most;
  }
  return BASE_OK;
}

base_status sequence_compare(const sequence_request *q, double limit, sequence_regressions *out,
                             base_error *err) {
  const size_t n = (size_t)q->sequence->n;
  sequence_cost *cost = calloc(2 * n + 1, sizeof *cost);
  extremes *e = calloc(n + 1, sizeof *e);
  *out = (sequence_regressions){SEQUENCE_UNCOUNTED, SEQUENCE_UNCOUNTED};
  const base_status done = (cost != NULL && e != NULL)
                               ? run_turns(q, limit, cost, e, out, err)
                               : BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu costs", n);
  free(cost);
  free(e);
  return done;
}
