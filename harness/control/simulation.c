#include "harness/control/simulation.h"

#include "harness/measure/contact_order.h"
#include "harness/measure/registry.h"
#include "harness/util/args.h"
#include "lcp/base/clock.h"
#include "lcp/base/crew.h"
#include "lcp/base/fields.h"

#include <string.h>

static bool given(const char *text) {
  return text != NULL && text[0] != '\0';
}

static base_status positive(const char *name, const char *text, double dflt, double *out,
                            base_error *err) {
  *out = dflt;
  if (given(text) && (!base_parse_real(text, out) || !(*out > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "%s %s: need a number above 0", name, text);
  }
  return BASE_OK;
}

static base_status start_of(const char *text, formulation_start *out, base_error *err) {
  *out = FORM_COLD;
  if (given(text) && strcmp(text, "previous") == 0) {
    *out = FORM_PREVIOUS;
  } else if (given(text) && strcmp(text, "cold") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--start %s: need cold or previous", text);
  }
  return BASE_OK;
}

/* Islands, and threads. */
static base_status parts_of(const simulation_texts *t, const lcp_solver *solver, sim_request *q,
                            base_error *err) {
  int threads = 1;
  if (given(t->islands) && strcmp(t->islands, "on") != 0 && strcmp(t->islands, "off") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--islands %s: need on or off", t->islands);
  }
  if (given(t->threads) &&
      (!base_parse_int(t->threads, &threads) || threads < 1 || threads > BASE_THREADS_MAX)) {
    return BASE_FAIL(err, BASE_EINVAL, "--threads %s: need 1 to %d", t->threads,
                     (int)BASE_THREADS_MAX);
  }
  q->islands = given(t->islands) && strcmp(t->islands, "on") == 0;
  q->threads = threads;
  if (threads > 1 && solver != NULL && (solver->peer || solver->context != NULL)) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "--threads %d: %s is other people's code, need --threads 1", threads,
                     solver->name);
  }
  return BASE_OK;
}

/* Repeats the steps of a list. */
static void repeat_steps(simulation *s) {
  sim_request *q = &s->request;
  q->step = s->steps.h;
  q->n_step = s->steps.n;
  q->h = 0.0;
  for (long i = 0; i < s->steps.n; i++) {
    q->h = fmax(q->h, s->steps.h[i]);
  }
}

static base_status open_steps(const simulation_texts *t, simulation *out, base_error *err) {
  if (given(t->steps) + given(t->step) + given(t->error) > 1) {
    return BASE_FAIL(err, BASE_EINVAL, "--error, --step and --steps: need one of them");
  }
  if ((given(t->work) || given(t->time_limit)) && !given(t->error)) {
    const bool work = given(t->work);
    return BASE_FAIL(err, BASE_EINVAL, "--%s %s: limits --error, which is missing",
                     work ? "work" : "time-limit", work ? t->work : t->time_limit);
  }
  if (given(t->steps)) {
    BASE_TRY(step_list_read(&out->steps, t->steps, out->request.duration, err));
    repeat_steps(out);
  }
  if (given(t->error)) {
    double limit = ERROR_LIMIT;
    BASE_TRY(error_parse(t->error, &out->error, err));
    BASE_TRY(positive("--work", t->work, limit, &limit, err));
    out->error.limit = lround(fmin(limit, 1e12));
    if (given(t->time_limit) &&
        !(args_seconds(t->time_limit, &out->error.seconds) && out->error.seconds > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "--time-limit %s: need a time above 0, as 30, 30s, 10m or 2h",
                       t->time_limit);
    }
  }
  return BASE_OK;
}

static base_status take(simulation *s, const char *form, const char *solver, base_error *err) {
  formulation_choice_free(&s->form);
  solver_choice_free(&s->solver);
  s->form = (formulation_choice){0};
  s->solver = (solver_choice){0};
  BASE_TRY(formulation_choose(form, &s->form, err));
  BASE_TRY(solver_choose(solver, &s->solver, err));
  return (s->tol[0] != '\0') ? solver_choice_set(&s->solver, "tol", s->tol, err) : BASE_OK;
}

/* As the texts say: one formulation and solver, or several in turn. */
static base_status take_given(simulation *s, const simulation_texts *t, base_error *err) {
  if (strchr(t->formulation, '/') == NULL && strchr(t->solver, '/') == NULL) {
    return take(s, t->formulation, t->solver, err);
  }
  if (given(t->error)) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--formulation %.100s, --solver %.100s: change at steps, which --error is yet "
                     "to find",
                     t->formulation, t->solver);
  }
  combination_plan *p = &s->combinations;
  BASE_TRY(
      combination_plan_parse(t->formulation, t->solver, s->tol[0] != '\0' ? s->tol : NULL, p, err));
  s->request.combinations = p;
  s->request.form = &p->span[0].form;
  s->request.solver = &p->span[0].solver;
  return BASE_OK;
}

static base_status run_candidate(simulation *s, int k, const sim_request *q, series *record,
                                 sim_result *out, base_error *err) {
  const choice_candidate *c = &s->choice.candidate[k];
  s->taken = k;
  series_close(record);
  step_list_close(&s->steps);
  error_result_close(&s->found);
  BASE_TRY(take(s, c->formulation, c->solver, err));
  return error_run(q, &s->error, record, out, &s->steps, &s->found, err);
}

/* The candidates in turn, while there is time, until one has no step that failed, and the friction that is asked for. Where none is, the
 * first that proved a step to have no solution says more than the last that found none. */
static base_status run_chosen(simulation *s, const sim_request *q, series *record, sim_result *out,
                              base_error *err) {
  const choice *c = &s->choice;
  int proved = -1;
  for (int k = 0; k < c->n && k < CHOICE_TRIES && (k == 0 || !error_late(&s->error, 0.0)); k++) {
    BASE_TRY(run_candidate(s, k, q, record, out, err));
    s->tried[s->n_tried++] = s->found.other_law ? RUN_UNSUPPORTED : out->status;
    if (out->status == RUN_OK && !s->found.other_law) {
      return BASE_OK;
    }
    proved = (proved < 0 && out->status == RUN_INFEASIBLE) ? k : proved;
  }
  const bool again = proved >= 0 && !error_late(&s->error, 0.0);
  return (again && out->status != RUN_OK && out->status != RUN_INFEASIBLE)
             ? run_candidate(s, proved, q, record, out, err)
             : BASE_OK;
}

/* What the model of a candidate is; 0: it is none. */
static unsigned model_of(const choice_candidate *c) {
  formulation_choice f = {0};
  base_error ignored;
  const bool known = formulation_choose(c->formulation, &f, &ignored) == BASE_OK;
  const unsigned model = known ? f.form->model : 0;
  formulation_choice_free(&f);
  return model;
}

/* Is its cone of friction made of facets or boxes, so that it is off in space by an angle that no step shows? */
static bool has_flat_cone(unsigned model) {
  const unsigned round = FORM_CONE_EXACT | FORM_REGULARISED | FORM_NO_LCP;
  return (model & FORM_FRICTION) != 0 && (model & round) == 0;
}

/* Does what it holds by friction creep, however slowly, while what pulls at it changes? */
static bool creeps(unsigned model) {
  return (model & FORM_REGULARISED) != 0;
}

/* Those of a kind come behind all others, each in its order. */
static void put_last(choice *c, bool (*kind)(unsigned model)) {
  choice_candidate last[CHOICE_MOST];
  int n_last = 0;
  int n = 0;
  for (int i = 0; i < c->n; i++) {
    if (kind(model_of(&c->candidate[i]))) {
      last[n_last++] = c->candidate[i];
    } else {
      c->candidate[n++] = c->candidate[i];
    }
  }
  memcpy(c->candidate + n, last, (size_t)n_last * sizeof *last);
}

/* Rows of other scenes do not tell that the friction of a combination does not suit this one: such candidates come last. */
static void put_unfit_last(const simulation *s, choice *c) {
  if (!(features_of_name(&s->features, "friction") > 0.0)) {
    return;
  }
  if (spec_loads_vary(s->request.spec) && (s->request.effects & EFFECT_LOADS) != 0) {
    put_last(c, creeps);
  }
  if (features_of_name(&s->features, "spatial") > 0.0) {
    put_last(c, has_flat_cone);
  }
}

/* Ranks the combinations for the scene. E with a unit counts against the size of the smallest body. */
static base_status choose_combination(simulation *s, const char *rows, base_error *err) {
  const sim_request *q = &s->request;
  double E = s->error.E;
  if (strcmp(s->error.unit, "m") == 0) {
    double length;
    BASE_TRY(error_first_scale(q, &length, err));
    E /= length;
  }
  BASE_TRY(choice_make(&s->features, E, rows, &s->choice, err));
  put_unfit_last(s, &s->choice);
  s->chooses = true;
  return take(s, s->choice.candidate[0].formulation, s->choice.candidate[0].solver, err);
}

static bool wants_files(const sim_request *q) {
  return q->trajectory != NULL || q->end != NULL || q->trace != NULL || q->dump != NULL ||
         q->store != NULL || q->replay != NULL;
}

/* The request without what a run that comes back to earlier steps would spoil. */
static sim_request without_files(const sim_request *q) {
  sim_request silent = *q;
  silent.trajectory = NULL;
  silent.end = NULL;
  silent.trace = NULL;
  silent.dump = NULL;
  silent.store = silent.replay = NULL;
  return silent;
}

/* When what looks for steps and effects is to end. What they are found for is run to its end then. */
static double ends_at(const simulation *s) {
  return (s->error.until > 0.0) ? s->error.until : HUGE_VAL;
}

/* Finds the effects; the request has them afterwards. */
static base_status run_watched(simulation *s, series *record, sim_result *out, base_error *err) {
  sim_request *q = &s->request;
  sim_request silent = without_files(q);
  silent.effects = s->spec.effects;
  silent.until = ends_at(s);
  BASE_TRY(watch_run(&silent, s->watch, record, out, &s->watched, err));
  s->plan = s->watched.plan;
  q->effects = effects_plan_union(&s->plan);
  q->plan = &s->plan;
  return BASE_OK;
}

/* Finds the steps for given effects; with --effects auto those that a run of even steps needs at some time. */
static base_status run_to_error(simulation *s, series *record, sim_result *out, base_error *err) {
  sim_times spent = {0};
  if (s->watch > 0.0) {
    BASE_TRY(run_watched(s, record, out, err));
    spent = out->time;
    series_close(record);
    s->watched.plan = (effects_plan){.n = 1, .span = {{0, s->request.effects}}};
  }
  sim_request silent = without_files(&s->request);
  silent.plan = s->request.plan = NULL;
  silent.until = ends_at(s);
  BASE_TRY(s->chooses ? run_chosen(s, &silent, record, out, err)
                      : error_run(&silent, &s->error, record, out, &s->steps, &s->found, err));
  sim_times_add(&out->time, &spent);
  repeat_steps(s);
  return BASE_OK;
}

static base_status run_alone(simulation *s, series *record, sim_result *out, base_error *err) {
  sim_request *q = &s->request;
  const bool to_error = s->error.E > 0.0;
  if (!to_error && !(s->watch > 0.0)) {
    return step_list_run(q, &s->steps, record, out, err);
  }
  BASE_TRY(to_error ? run_to_error(s, record, out, err) : run_watched(s, record, out, err));
  if (!wants_files(q)) {
    return BASE_OK;
  }
  const sim_times spent = out->time;
  series_close(record);
  BASE_TRY((to_error && s->steps.n == 0) ? step_list_run_none(q, record, out, err)
                                         : step_list_run(q, &s->steps, record, out, err));
  sim_times_add(&out->time, &spent);
  return BASE_OK;
}

base_status simulation_run(simulation *s, series *record, sim_result *out, base_error *err) {
  base_crew *crew = NULL;
  *record = (series){0};
  s->error.until = (s->error.seconds > 0.0) ? base_seconds() + s->error.seconds : 0.0;
  if (s->request.threads > 1) {
    BASE_TRY(base_crew_open(&crew, s->request.threads, err));
  }
  base_crew *before = base_crew_take_up(crew);
  const base_status done = run_alone(s, record, out, err);
  (void)base_crew_take_up(before);
  base_crew_close(crew);
  return done;
}

/* "auto:E", or a plan of effects. */
static base_status open_effects(simulation *s, const char *text, base_error *err) {
  sim_request *q = &s->request;
  bool automatic;
  BASE_TRY(watch_parse(text, &automatic, &s->watch, err));
  BASE_TRY(effects_plan_parse(s->spec.effects, automatic ? "declared" : text, &s->plan, err));
  q->effects = effects_plan_union(&s->plan);
  q->plan = (s->plan.n > 1) ? &s->plan : NULL;
  q->sleep = s->plan.sleep || (automatic && s->error.E == 0.0);
  q->judged = automatic;
  if (automatic && s->combinations.n > 0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--effects %.120s: watches one formulation and solver, which change", text);
  }
  if (automatic && s->steps.n_turned + s->steps.n_extrapolated > 0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--effects %.120s: watches plain steps, and some of --steps are extrapolated",
                     text);
  }
  if (s->plan.sleep && s->error.E > 0.0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--effects %.120s: bodies sleep in given steps, which --error is yet to find",
                     text);
  }
  if (s->plan.sleep && s->steps.n_turned + s->steps.n_extrapolated > 0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--effects %.120s: bodies sleep in plain steps, and some of --steps are "
                     "extrapolated",
                     text);
  }
  if (s->plan.sleep && (q->form->form->memory == 0 || s->spec.model != NULL)) {
    const bool coordinates = s->spec.model != NULL;
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "--effects %.120s: %.64s has no %s", text,
                     coordinates ? s->spec.id : q->form->form->name,
                     coordinates ? "bodies that could sleep" : "memory to wake with");
  }
  if (s->plan.sleep && s->combinations.n > 0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--effects %.120s: bodies sleep with one formulation, and these change", text);
  }
  return (q->plan == NULL || s->error.E == 0.0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL,
                         "--effects %.120s: changes at steps, which --error is yet to find", text);
}

base_status simulation_open(const simulation_texts *t, simulation *out, base_error *err) {
  *out = (simulation){0};
  spec_init(&out->spec);
  const bool both = given(t->formulation) && given(t->solver);
  if (!both && (given(t->formulation) || given(t->solver) || !given(t->error))) {
    const char *missing = given(t->formulation) ? "solver" : "formulation";
    return BASE_FAIL(err, BASE_EINVAL, "--%s is missing; see lcpbench list %ss", missing, missing);
  }
  if (both && given(t->rows)) {
    return BASE_FAIL(err, BASE_EINVAL, "--rows %.200s: formulation and solver are given", t->rows);
  }
  (void)snprintf(out->tol, sizeof out->tol, "%s", given(t->tol) ? t->tol : "");
  const scene_spec *spec = &out->spec;
  sim_request *q = &out->request;
  *q = (sim_request){.spec = spec, .form = &out->form, .solver = &out->solver};
  if (both) {
    BASE_TRY(take_given(out, t, err));
  }
  BASE_TRY(scene_open(t->scene, &out->spec, err));
  BASE_TRY(positive("--step", t->step, spec->n_h > 0 ? spec->h[0] : 0.01, &q->h, err));
  BASE_TRY(positive("--duration", t->duration, spec->duration, &q->duration, err));
  BASE_TRY(open_steps(t, out, err));
  if (!given(t->error)) {
    BASE_TRY(sim_check_times(q->h, q->duration, err));
  }
  BASE_TRY(start_of(t->start, &q->start, err));
  if (given(t->contact_order)) {
    BASE_TRY(contact_order_parse(t->contact_order, &q->contact_order, err));
  }
  BASE_TRY(open_effects(out, given(t->effects) ? t->effects : "declared", err));
  if (given(t->error)) {
    BASE_TRY(error_first_step(q, &q->h, err)); /* the steps are yet to be found */
    BASE_TRY(sim_check_times(q->h, q->duration, err));
    BASE_TRY(features_of(spec, q->effects, q->h, &out->features, err));
  }
  if (!both) {
    BASE_TRY(choose_combination(out, given(t->rows) ? t->rows : NULL, err));
  }
  for (int k = 1; k < out->combinations.n; k++) {
    BASE_TRY(parts_of(t, out->combinations.span[k].solver.solver, q, err));
  }
  if (given(t->memory) && strcmp(t->memory, "usual") != 0 && strcmp(t->memory, "least") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--memory %s: need usual or least", t->memory);
  }
  q->least_memory = given(t->memory) && strcmp(t->memory, "least") == 0;
  return parts_of(t, q->solver->solver, q, err);
}

base_status simulation_list_steps(simulation *s, long taken, base_error *err) {
  const sim_request *q = &s->request;
  const bool even = s->steps.n == 0 && s->error.E == 0.0;
  const long n = even ? taken : 0;
  for (long i = 0; i < n; i++) {
    BASE_TRY(step_list_append(&s->steps, q->h, 0, err));
  }
  return BASE_OK;
}

void simulation_close(simulation *s) {
  step_list_close(&s->steps);
  error_result_close(&s->found);
  spec_free(&s->spec);
  formulation_choice_free(&s->form);
  solver_choice_free(&s->solver);
  combination_plan_free(&s->combinations);
}
