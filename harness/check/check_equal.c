/* Equivalences: two scenes (or one scene with something switched off) that must agree. */
#include "harness/check/check_run.h"
#include "harness/measure/simulate.h"

#include <stdlib.h>
#include <string.h>

typedef struct equal_unit {
  sim_request request[2];
  const case_equivalence *e;
  check_outcome blank;
} equal_unit;

static const char *var_of(const equal_unit *u, int side, int i) {
  return (side == 0) ? u->e->var_a[i] : u->e->var_b[i];
}

static void emit(isolate_channel *out, const equal_unit *u, const char *check,
                 check_verdict verdict, const char *reason) {
  check_outcome o = u->blank;
  o.verdict = verdict;
  (void)snprintf(o.check, sizeof o.check, "%s", check);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  (void)isolate_emit(out, &o);
}

/* Values of the mapped quantities of one side at time t; false: reported already. */
static bool run_side(const equal_unit *u, int side, double *value, isolate_channel *out) {
  series record;
  sim_result r;
  base_error err = {0};
  const char *file = check_not_applicable(u->request[side].spec, u->request[side].form);
  const char *why =
      (file != NULL) ? file : check_limit(u->request[side].spec, u->request[side].form);
  if (why != NULL) {
    emit(out, u, "run", CHECK_SKIPPED, why);
    return false;
  }
  const base_status done = simulate(&u->request[side], &record, &r, &err);
  bool good = false;
  if (done != BASE_OK) {
    emit(out, u, "run", done == BASE_EUNSUPPORTED ? CHECK_SKIPPED : CHECK_FAILED, err.text);
  } else if (r.status != RUN_OK) {
    const bool own = (u->request[side].form->form->model & FORM_NO_LCP) != 0;
    const bool skip = r.status == RUN_UNSUPPORTED || !u->request[side].solver->solver->exact ||
                      (own && r.status != RUN_UNVERIFIED);
    emit(out, u, "status", skip ? CHECK_SKIPPED : CHECK_FAILED, r.note);
  } else {
    good = true;
    for (int i = 0; i < u->e->n_var; i++) {
      spec_check c = {.kind = CHECK_STATE};
      (void)snprintf(c.var, sizeof c.var, "%s", var_of(u, side, i));
      const series_var *v = series_find_var(&record, &c);
      if (v == NULL || !series_at(&record, v->column, u->e->t, &value[i])) {
        emit(out, u, var_of(u, side, i), CHECK_FAILED, "not recorded at that time");
        good = false;
      }
    }
  }
  series_close(&record);
  return good;
}

static void run_unit(void *ctx, isolate_channel *out) {
  const equal_unit *u = ctx;
  double value[2][SPEC_OBSERVE];
  if (!run_side(u, 0, value[0], out) || !run_side(u, 1, value[1], out)) {
    return;
  }
  for (int i = 0; i < u->e->n_var; i++) {
    check_outcome o = u->blank;
    (void)snprintf(o.check, sizeof o.check, "equal %.60s", var_of(u, 0, i));
    o.got = value[1][i];
    o.expected = value[0][i];
    o.tolerance = u->e->tol * fmax(1.0, fabs(o.expected));
    o.verdict = (fabs(o.got - o.expected) <= o.tolerance) ? CHECK_PASSED : CHECK_FAILED;
    (void)isolate_emit(out, &o);
  }
}

static const scene_spec *find(const scene_file *file, const char *name) {
  for (int i = 0; i < file->n_scene; i++) {
    if (strcmp(file->scene[i].id, name) == 0) {
      return &file->scene[i];
    }
  }
  return NULL;
}

/* A copy that also records the mapped quantities. */
static base_status watch(const scene_spec *from, const equal_unit *u, int side, scene_spec *to,
                         base_error *err) {
  BASE_TRY(spec_copy(from, to, err));
  for (int i = 0; i < u->e->n_var; i++) {
    spec_check *c;
    BASE_TRY(spec_add_check(to, CHECK_STATE, var_of(u, side, i), &c, err));
  }
  return BASE_OK;
}

static base_status choose_facets(const formulation_choice *given, int facets,
                                 formulation_choice *out, base_error *err) {
  char text[CHOICE_CONFIG + 80];
  (void)snprintf(text, sizeof text, "%s%s%s", given->form->name, given->config[0] ? ":" : "",
                 given->config);
  BASE_TRY(formulation_choose(text, out, err));
  if (facets > 0 && formulation_choice_has(out, "facets")) {
    char number[16];
    (void)snprintf(number, sizeof number, "%d", facets);
    return formulation_choice_set(out, "facets", number, err);
  }
  return BASE_OK;
}

static base_status run_pairs(const check_plan *plan, equal_unit *u, const int facets[2],
                             base_error *err) {
  base_status done = BASE_OK;
  for (int f = 0; done == BASE_OK && f < plan->n_form; f++) {
    formulation_choice form[2] = {{0}, {0}};
    done = choose_facets(&plan->form[f], facets[0], &form[0], err);
    if (done == BASE_OK) {
      done = choose_facets(&plan->form[f], facets[1], &form[1], err);
    }
    for (int s = 0; done == BASE_OK && s < plan->n_solver; s++) {
      const char *fits = check_default_solver(u->request[0].spec, &form[0]);
      if (plan->default_solvers && strcmp(plan->solver[s].solver->name, fits) != 0) {
        continue;
      }
      for (int side = 0; side < 2; side++) {
        u->request[side].form = &form[side];
        u->request[side].solver = &plan->solver[s];
      }
      (void)snprintf(u->blank.formulation, sizeof u->blank.formulation, "%s",
                     plan->form[f].form->name);
      (void)snprintf(u->blank.solver, sizeof u->blank.solver, "%s", plan->solver[s].solver->name);
      done = check_isolated(plan, &u->blank, run_unit, u, err);
    }
    formulation_choice_free(&form[0]);
    formulation_choice_free(&form[1]);
  }
  return done;
}

base_status check_equivalence(const check_plan *plan, const case_equivalence *e,
                              const scene_file *scenes, base_error *err) {
  equal_unit u = {.e = e, .blank = {.check = "equal"}};
  u.blank.got = u.blank.expected = u.blank.tolerance = (double)NAN;
  (void)snprintf(u.blank.id, sizeof u.blank.id, "%s", e->id);
  const scene_spec *a = find(scenes, e->a);
  const scene_spec *b = find(scenes, e->b);
  if (a == NULL || b == NULL) {
    check_skip(plan, e->id, "one of its scenes could not be read");
    return BASE_OK;
  }
  scene_spec spec[2];
  spec_init(&spec[0]);
  spec_init(&spec[1]);
  base_status done = watch(a, &u, 0, &spec[0], err);
  if (done == BASE_OK) {
    done = watch(b, &u, 1, &spec[1], err);
  }
  if (done == BASE_OK) {
    const int facets[2] = {a->facets, e->facets_b > 0 ? e->facets_b : b->facets};
    const double h = (plan->step > 0.0) ? plan->step : a->h[0];
    for (int side = 0; side < 2; side++) {
      u.request[side] = (sim_request){
          .spec = &spec[side], .effects = spec[side].effects, .h = h, .duration = e->t};
    }
    u.request[1].effects &= ~e->off_b;
    if (e->multiplicity_b > 0) {
      spec[1].contact_multiplicity = e->multiplicity_b;
    }
    u.blank.step = h;
    done = run_pairs(plan, &u, facets, err);
  }
  spec_free(&spec[0]);
  spec_free(&spec[1]);
  return done;
}
