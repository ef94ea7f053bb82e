/* The solves of a simulation: started, made or replayed, judged and counted. */
#include "harness/measure/sim_watch.h"
#include "harness/measure/simulate_state.h"
#include "harness/measure/solve_once.h"
#include "harness/util/stop.h"
#include "lcp/base/clock.h"

#include <stdlib.h>
#include <string.h>

enum { LARGE = 1 << 15 };

/* Solver, judge and choice have their workspaces one after another, which costs page faults in every step. */
static bool takes_turns(const sim *s, const lcp_problem *p) {
  return s->q->least_memory || p->M.n >= LARGE;
}

/* Records the first trouble in words. */
void sim_trouble(sim *s, run_status word, const char *text) {
  if (s->out->note[0] == '\0') {
    (void)snprintf(s->out->note, sizeof s->out->note, "step %ld: %.200s", s->out->steps + 1, text);
  }
  sim_part *part = &s->out->part[s->out->n_part - 1];
  s->out->status = run_status_worse(s->out->status, word);
  part->status = run_status_worse(part->status, word);
}

/* No answer of this step exists: whoever was to give it said so. */
void sim_refuse(sim *s, run_status word, const char *text) {
  sim_trouble(s, word, text);
  s->out->claimed = run_status_worse(s->out->claimed, word);
}

static void add_verdict(sim_result *r, const lcp_verdict *v) {
  r->rho_max = fmax(r->rho_max, v->rho);
  r->natural_max = fmax(r->natural_max, v->natural);
  r->natural_rel_max = fmax(r->natural_rel_max, v->natural_rel);
  r->feas_z_max = fmax(r->feas_z_max, v->infeasible_z);
  r->feas_w_max = fmax(r->feas_w_max, v->infeasible_w);
  r->comp_max = fmax(r->comp_max, v->comp);
}

/* ---- one complementarity problem --------------------------------------------------------------*/

base_status sim_start_point(sim *s, const lcp_problem *p, const double *z0, base_error *err) {
  const int n = p->M.n;
  if (n > s->z_cap || s->z == NULL) { /* a problem without unknowns has a start point too */
    free(s->z);
    s->z_cap = 2 * n + 1;
    s->z = malloc(3 * (size_t)s->z_cap * sizeof *s->z);
    if (s->z == NULL) {
      s->z_cap = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d unknowns", n);
    }
  }
  for (int i = 0; i < n; i++) {
    s->z[i] = (z0 != NULL) ? z0[i] : 0.0;
  }
  s->started = z0;
  if (z0 == NULL) {
    s->started = s->z + 2 * (ptrdiff_t)s->z_cap;
    memcpy(s->z + 2 * (ptrdiff_t)s->z_cap, s->z, (size_t)n * sizeof *s->z);
  }
  return BASE_OK;
}

static base_status open_instance(sim *s, const lcp_problem *p, base_error *err) {
  BASE_TRY(lcp_solver_admits(s->q->solver->solver, p, err));
  if (s->instance == NULL) {
    const lcp_capacity cap = lcp_problem_capacity(p);
    BASE_TRY(lcp_instance_open(&s->instance, s->q->solver->solver, &cap, s->q->solver->opt, err));
  }
  return lcp_instance_prepare(s->instance, p, err);
}

bool sim_without_solution(run_status s) {
  return s == RUN_NUMERICAL || s == RUN_RAY || s == RUN_INFEASIBLE;
}

/* Ends of a solve after which a formulation may try another problem. An iterative method does not see that there is no
 * solution: it does not get there. One that claims what is not so is none of them. */
static bool may_go_on(run_status s) {
  return sim_without_solution(s) || s == RUN_BUDGET || s == RUN_MAX_ITER || s == RUN_STALLED ||
         s == RUN_NEAR;
}

/* Enters a solve into the record. */
static void count_solve(sim *s, const solved *k) {
  sim_result *r = s->out;
  sim_part *part = &r->part[r->n_part - 1];
  r->verified = r->verified && k->verified;
  part->verified = part->verified && k->verified;
  part->rho_max = fmax(part->rho_max, k->v.rho);
  r->claimed = run_status_worse(r->claimed, k->claimed);
  add_verdict(r, &k->v);
  if (k->word != RUN_OK) {
    r->n_unsolved++;
    sim_trouble(s, k->word, k->text);
  }
}

/* A problem without a solution means wrong modes where the formulation goes on to one that has
 * one (MATHEMATICS 2.3.7): its own method, which counts it as a fallback. Else it stands. */
void sim_settle_held(sim *s) {
  if (s->held.word != RUN_OK) {
    count_solve(s, &s->held);
    s->held.word = RUN_OK;
  }
}

static void add_costs(sim *s, const lcp_problem *p, const lcp_result *claim) {
  sim_result *r = s->out;
  r->n_solves++;
  r->lcp_dim_max = (p->M.n > r->lcp_dim_max) ? p->M.n : r->lcp_dim_max;
  const long nnz = lcp_matrix_entries(&p->M);
  r->nnz_max = (nnz > r->nnz_max) ? nnz : r->nnz_max;
  r->storage = p->M.storage;
  r->variant = claim->variant;
  r->hash = sim_hash(r->hash, s->z, p->M.n);
  lcp_work_add(&r->work, &claim->work);
}

/* Verdict of the answer in s->z; nothing here is timed. */
static base_status judge(sim *s, const lcp_problem *p, const lcp_result *claim, solved *k,
                         base_error *err) {
  *k = (solved){.claimed = RUN_OK};
  BASE_TRY(lcp_judge(p, s->z, &k->v, err));
  k->word = verdict_of(s->q->solver->solver, s->q->solver->opt, p, claim, &k->v, &k->verified);
  if (claim->outcome != LCP_SOLVED) {
    k->claimed = RUN_NUMERICAL;
    (void)run_status_find(lcp_outcome_name(claim->outcome), &k->claimed);
  }
  return BASE_OK;
}

static base_status tell(sim *s, const lcp_problem *p, const solved *k, base_error *err) {
  const sim_listener *l = s->q->listener;
  sim_solved one = {.step = s->out->steps + 1,
                    .p = p,
                    .z = s->z,
                    .status = k->word,
                    .verified = k->verified,
                    .rho = k->v.rho};
  if (l == NULL) {
    return BASE_OK;
  }
  BASE_TRY(formulation_rows_of(s->form, &one.rows, err));
  return l->solved(l->ctx, &one, err);
}

/* Why a claim is no success. A rho that is met is relative to impulses; what a solver then gave up at is its test against
 * the data (RESIDUALS 4), and the row that is farthest off names the place: as in the file of a dumped problem, from 1. */
static void explain(const sim *s, const lcp_problem *p, const lcp_result *claim, solved *k) {
  const double tol = verdict_asked(s->q->solver->solver, s->q->solver->opt);
  const lcp_outcome o = claim->outcome;
  const int n =
      snprintf(k->text, sizeof k->text, "solve %ld (n=%d) is %s: claimed %s, rho=%.3g",
               s->out->n_solves, p->M.n, run_status_name(k->word), lcp_outcome_name(o), k->v.rho);
  if ((o == LCP_MAX_ITER || o == LCP_STALLED || o == LCP_NUMERICAL) && k->v.rho <= tol) {
    (void)snprintf(
        k->text + n, sizeof k->text - (size_t)n,
        "; not against q: row %d is off by %.3g m/s, or rounding may hide more (RESIDUALS 4)",
        k->v.natural_row + 1, k->v.natural);
  }
}

static base_status record(sim *s, const lcp_problem *p, const lcp_result *claim, solved *judged,
                          base_error *err) {
  solved k = *judged;
  add_costs(s, p, claim);
  if (k.word != RUN_OK) {
    explain(s, p, claim, &k);
  }
  if (claim->outcome != LCP_SOLVED && may_go_on(k.word)) {
    s->held = k;
  } else {
    s->held.word = (k.word == RUN_OK) ? RUN_OK : s->held.word;
    count_solve(s, &k);
  }
  BASE_TRY(tell(s, p, &k, err));
  return (s->q->dump == NULL)
             ? BASE_OK
             : dump_problem(s->q->dump, s->out->steps + 1, p, s->z, run_status_name(k.word), err);
}

static void add_times(sim *s, const lcp_times *spent, size_t bytes) {
  s->out->time.setup += spent->setup;
  s->out->time.factor += spent->factor;
  s->out->time.solve += spent->solve;
  s->out->workspace = bytes;
}

static base_status open_islands(sim *s, base_error *err) {
  const solver_choice *by = s->q->solver;
  return (s->islands != NULL) ? BASE_OK : lcp_islands_open(&s->islands, by->solver, by->opt, err);
}

/* Part by part; which solver and when is the same, and so is everything behind it. */
static base_status solve_islands(sim *s, const lcp_problem *p, lcp_result *claim, base_error *err) {
  sim_result *r = s->out;
  BASE_TRY(open_islands(s, err));
  BASE_TRY(lcp_islands_solve(s->islands, p, s->z, claim, err));
  const lcp_times spent = lcp_islands_times(s->islands);
  const int count = lcp_islands_count(s->islands), largest = lcp_islands_largest(s->islands);
  r->n_island = (count > r->n_island) ? count : r->n_island;
  r->largest_island = (largest > r->largest_island) ? largest : r->largest_island;
  add_times(s, &spent, lcp_islands_bytes(s->islands));
  return BASE_OK;
}

static base_status solve_now(sim *s, const lcp_problem *p, lcp_result *claim, base_error *err) {
  trace_file *t = s->q->trace;
  if (s->q->islands) {
    return solve_islands(s, p, claim, err);
  }
  BASE_TRY(open_instance(s, p, err));
  BASE_TRY(lcp_instance_solve(s->instance, t != NULL ? trace_begin(t) : NULL, s->z, claim, err));
  const lcp_times spent = lcp_instance_times(s->instance);
  add_times(s, &spent, lcp_instance_bytes(s->instance));
  return (t != NULL) ? trace_end(t, err) : BASE_OK;
}

/* The solver's answer in s->z, from the solver or from the file of an earlier run. */
static base_status answer(sim *s, const lcp_problem *p, lcp_result *claim, base_error *err) {
  if (s->q->replay != NULL) {
    BASE_TRY(answers_take(s->q->replay, p->M.n, s->z, claim, err));
    BASE_TRY(s->q->islands ? open_islands(s, err) : BASE_OK);
    return s->q->islands ? lcp_islands_cut_out_of(s->islands, p, s->z, err) : BASE_OK;
  }
  const base_status done = solve_now(s, p, claim, err);
  answers *store = s->q->store;
  if (store == NULL) {
    return done;
  }
  if (done == BASE_OK) {
    return answers_put(store, p->M.n, s->z, claim, err);
  }
  BASE_TRY(answers_put_failure(store, p->M.n, done, err));
  return done;
}

/* Was p solved in parts that tell the choice as much as p does? Columns without factors do not. */
static bool in_parts(const sim *s, const lcp_problem *p) {
  return s->q->islands && lcp_islands_count(s->islands) > 1 &&
         (p->M.factored == NULL || lcp_islands_at(s->islands, 0).p->M.factored != NULL);
}

static base_status share_in_parts(sim *s, const lcp_problem *p, const double *start,
                                  lcp_share_result *made, base_error *err) {
  if (s->share_parts == NULL) {
    BASE_TRY(lcp_share_parts_open(&s->share_parts, err));
  }
  BASE_TRY(lcp_share_parts_apply(s->share_parts, s->islands, start, s->z, made, err));
  if (takes_turns(s, p)) {
    lcp_share_parts_rest(s->share_parts);
  }
  return BASE_OK;
}

static base_status share_whole(sim *s, const lcp_problem *p, const double *start,
                               lcp_share_result *made, base_error *err) {
  if (s->share == NULL) {
    BASE_TRY(lcp_share_open(&s->share, err));
  }
  BASE_TRY(lcp_share_apply(s->share, p, start, s->z, made, err));
  if (takes_turns(s, p)) {
    lcp_share_rest(s->share);
  }
  return BASE_OK;
}

/* Of many answers the one that the problem asks for, in s->z; *moved: it is another than the solver's. */
static base_status share(sim *s, const lcp_problem *p, bool *moved, base_error *err) {
  lcp_share_result made;
  const double from = base_seconds();
  const double *start = (s->q->start == FORM_PREVIOUS) ? s->started : NULL;
  BASE_TRY((in_parts(s, p) ? share_in_parts : share_whole)(s, p, start, &made, err));
  s->out->time.share += base_seconds() - from;
  sim_result *r = s->out;
  if (made.deficit == LCP_SHARE_UNCOUNTED || r->deficit_max == LCP_SHARE_UNCOUNTED) {
    r->deficit_max = LCP_SHARE_UNCOUNTED;
  } else {
    r->deficit_max = (made.deficit > r->deficit_max) ? made.deficit : r->deficit_max;
  }
  r->n_share_missed += made.outcome == LCP_SHARE_MISSED;
  *moved = made.outcome == LCP_SHARE_MADE;
  return BASE_OK;
}

bool sim_keeps_own(const sim *s) {
  const lcp_solver *v = s->q->solver->solver;
  return s->iterates && s->q->start == FORM_PREVIOUS && v->exact && v->warm;
}

/* For the next solve that starts from what was chosen, in s->z. */
static base_status note_own(sim *s, const double *own, base_error *err) {
  formulation_rows rows;
  if (!sim_keeps_own(s)) {
    return BASE_OK;
  }
  BASE_TRY(formulation_rows_of(s->form, &rows, err));
  return own_answers_note(&s->own, &rows, own, s->z, err);
}

/* The solver's answer is judged first: a wrong one stays as it is, for nobody may mend it unseen. What is then chosen among
 * the right ones is judged as well, and is not taken where it does not pass. */
static base_status choose(sim *s, const lcp_problem *p, const lcp_result *claim, solved *k,
                          base_error *err) {
  double *own = s->z + s->z_cap;
  bool moved;
  memcpy(own, s->z, (size_t)p->M.n * sizeof *own);
  BASE_TRY(share(s, p, &moved, err));
  if (!moved) {
    return note_own(s, own, err);
  }
  solved chosen;
  BASE_TRY(judge(s, p, claim, &chosen, err));
  if (chosen.word != RUN_OK) {
    memcpy(s->z, own, (size_t)p->M.n * sizeof *own);
    s->out->n_share_missed++;
    return note_own(s, own, err);
  }
  s->out->n_shared++;
  s->out->hash = sim_hash(s->out->hash, own, p->M.n); /* of both answers */
  *k = chosen;
  return note_own(s, own, err);
}

base_status sim_solve(sim *s, const lcp_problem *p, lcp_outcome *claimed, base_error *err) {
  lcp_result claim = {.outcome = LCP_NUMERICAL};
  solved k;
  BASE_TRY(answer(s, p, &claim, err));
  if (s->instance != NULL && takes_turns(s, p) && claim.outcome == LCP_SOLVED) {
    lcp_instance_rest(s->instance);
  }
  BASE_TRY(judge(s, p, &claim, &k, err));
  if (claim.outcome == LCP_SOLVED && k.word == RUN_OK) {
    BASE_TRY(choose(s, p, &claim, &k, err));
  }
  BASE_TRY(record(s, p, &claim, &k, err));
  *claimed = claim.outcome;
  return BASE_OK;
}

bool sim_due(const sim *s) {
  return s->q->until > 0.0 && stop_due(s->q->until);
}

/* The same behind formulation_solver, for formulations that step by themselves. */
base_status sim_solve_for_formulation(void *ctx, const lcp_problem *p, double *z,
                                      lcp_outcome *claimed, base_error *err) {
  sim *s = ctx;
  const double from = base_seconds();
  BASE_TRY(sim_start_point(s, p, z, err));
  BASE_TRY(sim_solve(s, p, claimed, err));
  memcpy(z, s->z, (size_t)p->M.n * sizeof *z);
  s->called += base_seconds() - from;
  return BASE_OK;
}
