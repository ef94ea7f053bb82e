#include "harness/check/check_run.h"
#include "harness/measure/check_eval.h"
#include "harness/measure/simulate.h"
#include "harness/util/stop.h"

#include <stdlib.h>
#include <string.h>

/* One simulation to judge. */
typedef struct scene_unit {
  sim_request request;
  const spec_off *off; /* judged by this statement alone; NULL: by the scene's checks */
  const char *forms;   /* which "forms" word the formulation goes by; "" for none */
  const char *limit;   /* what the model lacks: only status, finiteness and the checks that name the
                          formulation are judged; or NULL */
  check_outcome blank;
} scene_unit;

static void emit(isolate_channel *out, const scene_unit *u, const char *check,
                 check_verdict verdict, const char *reason) {
  check_outcome o = u->blank;
  o.verdict = verdict;
  (void)snprintf(o.check, sizeof o.check, "%s%s", u->off != NULL ? "off: " : "", check);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  (void)isolate_emit(out, &o);
}

static void emit_check(isolate_channel *out, const scene_unit *u, const spec_check *c,
                       const check_context *ctx) {
  check_result r;
  char label[160];
  check_evaluate(c, ctx, &r);
  check_label(c, label, sizeof label);
  check_outcome o = u->blank;
  (void)snprintf(o.check, sizeof o.check, "%s%.150s", u->off != NULL ? "off: " : "", label);
  (void)snprintf(o.reason, sizeof o.reason, "%.90s", r.reason);
  o.verdict = r.ok ? CHECK_PASSED : CHECK_FAILED;
  if (r.known) {
    o.got = r.got;
    o.expected = r.expected;
    o.tolerance = r.tolerance;
  }
  (void)isolate_emit(out, &o);
}

/* True when the run is good enough for its checks to mean something. */
static bool judge_status(isolate_channel *out, const scene_unit *u, const sim_result *r) {
  const bool exact = u->request.solver->solver->exact;
  char text[300];
  (void)snprintf(text, sizeof text, "%s: %s", run_status_name(r->status), r->note);
  if (r->status == RUN_UNSUPPORTED) {
    emit(out, u, "status", CHECK_SKIPPED, text);
    return false;
  }
  if (u->request.spec->expect_unsolved && u->limit == NULL) {
    const bool honest = r->status != RUN_OK && r->status != RUN_UNVERIFIED;
    emit(out, u, "status", honest ? CHECK_PASSED : CHECK_FAILED, text);
    return honest;
  }
  if (r->status == RUN_OK) {
    emit(out, u, "status", CHECK_PASSED, "");
    return true;
  }
  const bool accelerations = (u->request.form->form->model & FORM_ACCELERATION) != 0;
  if (accelerations && (r->status == RUN_INFEASIBLE || r->status == RUN_RAY)) {
    (void)snprintf(text, sizeof text, "no solution at acceleration level: %s", r->note);
    emit(out, u, "status", CHECK_SKIPPED, text); /* the model's own answer (Painleve) */
    return false;
  }
  /* An integrator that gives up, and says so, fails as honestly as an iterative solver does. */
  const bool own = (u->request.form->form->model & FORM_NO_LCP) != 0;
  if ((exact && !own) || r->status == RUN_UNVERIFIED) {
    emit(out, u, "status", CHECK_FAILED, text);
    return true;
  }
  (void)snprintf(text, sizeof text, "honest failure: %s: %s", run_status_name(r->status), r->note);
  emit(out, u, "status", CHECK_SKIPPED, text);
  return false;
}

static void judge_checks(isolate_channel *out, const scene_unit *u, const series *record,
                         const sim_result *r) {
  const scene_spec *spec = u->request.spec;
  const check_context ctx = {.record = record,
                             .h = u->request.h,
                             .regularised = strcmp(u->forms, "regularized") == 0,
                             .v_slip = r->v_slip,
                             .deflection = r->deflection,
                             .finite = r->finite};
  const int facets = formulation_choice_facets(u->request.form);
  const char *form = u->request.form->form->name;
  if (u->limit != NULL) {
    const spec_check finite = {.kind = CHECK_FINITE};
    emit_check(out, u, &finite, &ctx);
    bool named = false;
    for (int i = 0; u->off == NULL && i < spec->n_check; i++) {
      if (spec_check_names(&spec->check[i], form)) {
        emit_check(out, u, &spec->check[i], &ctx);
        named = true;
      }
    }
    if (!named) {
      emit(out, u, "numbers", CHECK_SKIPPED, u->limit);
    }
    return;
  }
  if (u->off != NULL) {
    emit_check(out, u, &u->off->check, &ctx);
    return;
  }
  for (int i = 0; i < spec->n_check; i++) {
    if (spec->check[i].kind == CHECK_BRISTLE_DEFLECTION) {
      emit(out, u, "tangential_bristle_deflection", CHECK_SKIPPED,
           "a rule without a number; the unit tests of the bristle law hold it");
    } else if (spec_check_applies(&spec->check[i], form, u->forms, facets)) {
      emit_check(out, u, &spec->check[i], &ctx);
    }
  }
}

static void run_unit(void *ctx, isolate_channel *out) {
  const scene_unit *u = ctx;
  series record;
  sim_result r;
  base_error err = {0};
  const base_status done = simulate(&u->request, &record, &r, &err);
  if (done == BASE_EUNSUPPORTED) {
    emit(out, u, "run", CHECK_SKIPPED, err.text);
  } else if (done != BASE_OK) {
    emit(out, u, "run", CHECK_FAILED, err.text);
  } else if (judge_status(out, u, &r)) {
    judge_checks(out, u, &record, &r);
  }
  series_close(&record);
}

const char *check_not_applicable(const scene_spec *spec, const formulation_choice *form) {
  const char *forms = (form->form->stands_for != NULL) ? form->form->stands_for : "";
  for (int i = 0; i < spec->n_not_applicable; i++) {
    if (strcmp(spec->not_applicable[i], form->form->name) == 0 ||
        strcmp(spec->not_applicable[i], forms) == 0) {
      return "not applicable, says the file";
    }
  }
  return NULL;
}

const char *check_limit(const scene_spec *spec, const formulation_choice *form) {
  const unsigned model = form->form->model;
  const bool soft = (model & FORM_PENALTY) != 0;
  if (spec->contact_stiffness > 0.0) {
    return soft ? NULL : "models no compliant normal contact: its numbers are not judged";
  }
  if (soft && (spec->effects & EFFECT_CONTACT) != 0) {
    return "models compliant normal contact: the numbers of rigid contact are not judged";
  }
  if ((spec->effects & EFFECT_FRICTION) != 0 && (model & FORM_FRICTION) == 0) {
    return "models no friction: its numbers are not judged";
  }
  return NULL;
}

/* What the scene says of each effect switched off. */
static base_status run_off(const check_plan *plan, scene_unit *u, base_error *err) {
  const scene_spec *spec = u->request.spec;
  for (int k = 0; k < spec->n_off && stop_requested() == 0; k++) {
    u->off = &spec->off[k];
    if (!spec_check_applies(&u->off->check, u->request.form->form->name, u->forms, 0)) {
      continue;
    }
    u->request.effects = spec->effects & ~u->off->effect;
    BASE_TRY(check_isolated(plan, &u->blank, run_unit, u, err));
  }
  return BASE_OK;
}

/* The scene with one formulation and solver: as declared at every step length, then each effect
 * off. */
static base_status run_pair(const check_plan *plan, scene_unit *u, base_error *err) {
  const scene_spec *spec = u->request.spec;
  const int n_h = (plan->step > 0.0) ? 1 : spec->n_h;
  for (int i = 0; i < n_h && stop_requested() == 0; i++) {
    u->request.h = (plan->step > 0.0) ? plan->step : spec->h[i];
    u->request.effects = spec->effects;
    u->request.duration = spec->duration;
    if (spec->contact_stiffness > 0.0) { /* critically damped: at rest after 40 / omega */
      const double settled = 40.0 * sqrt(spec->body[0].mass / spec->contact_stiffness);
      u->request.duration = fmin(spec->duration, fmax(2.0 * u->request.h, settled));
    }
    u->off = NULL;
    u->blank.step = u->request.h;
    BASE_TRY(check_isolated(plan, &u->blank, run_unit, u, err));
    if (u->limit == NULL) {
      BASE_TRY(run_off(plan, u, err));
    }
  }
  return BASE_OK;
}

/* Options that the scene fixes: its facets, its contact stiffness. */
static base_status fit(const scene_spec *spec, formulation_choice *form, base_error *err) {
  char number[32];
  if (spec->facets > 0 && formulation_choice_has(form, "facets")) {
    (void)snprintf(number, sizeof number, "%d", spec->facets);
    return formulation_choice_set(form, "facets", number, err);
  }
  if (spec->contact_stiffness > 0.0 && (form->form->model & FORM_PENALTY) != 0) {
    base_real_print(spec->contact_stiffness, number, sizeof number);
    BASE_TRY(formulation_choice_set(form, "law", "kelvin_voigt", err));
    BASE_TRY(formulation_choice_set(form, "stiffness", number, err));
    base_real_print(2.0 * sqrt(spec->contact_stiffness * spec->body[0].mass), number,
                    sizeof number); /* critical: settles soonest */
    BASE_TRY(formulation_choice_set(form, "integrator", "msbdf", err));
    BASE_TRY(formulation_choice_set(form, "atol", "1e-15", err));
    return formulation_choice_set(form, "damping", number, err);
  }
  return BASE_OK;
}

const char *check_default_solver(const scene_spec *spec, const formulation_choice *form) {
  if ((spec->effects & EFFECT_FRICTION) == 0) {
    return "lemke";
  }
  if ((form->form->model & FORM_BOUNDS_LAGGED) != 0) {
    return "ppm";
  }
  const unsigned cones = FORM_CONE_EXACT | FORM_REGULARISED;
  return ((form->form->model & cones) == FORM_CONE_EXACT) ? "nsgs" : "lemke";
}

static base_status run_formulation(const check_plan *plan, const scene_spec *spec,
                                   const formulation_choice *given, base_error *err) {
  formulation_choice form;
  char text[CHOICE_CONFIG + 80];
  const char *forms = (given->form->stands_for != NULL) ? given->form->stands_for : "";
  (void)snprintf(text, sizeof text, "%s%s%s", given->form->name, given->config[0] ? ":" : "",
                 given->config);
  BASE_TRY(formulation_choose(text, &form, err));
  base_error misfit = {0};
  base_status done = fit(spec, &form, &misfit);
  if (done == BASE_EINVAL) { /* an option out of the formulation's range is a limit of it */
    check_skip(plan, spec->id, misfit.text);
    formulation_choice_free(&form);
    return BASE_OK;
  }
  for (int i = 0; done == BASE_OK && i < plan->n_solver; i++) {
    scene_unit u = {.forms = forms, .limit = check_limit(spec, &form), .blank = {.check = "run"}};
    u.request = (sim_request){.spec = spec, .form = &form, .solver = &plan->solver[i]};
    u.blank.got = u.blank.expected = u.blank.tolerance = (double)NAN;
    (void)snprintf(u.blank.id, sizeof u.blank.id, "%.63s", spec->id);
    (void)snprintf(u.blank.formulation, sizeof u.blank.formulation, "%s", form.form->name);
    (void)snprintf(u.blank.solver, sizeof u.blank.solver, "%s", plan->solver[i].solver->name);
    const char *fits = check_default_solver(spec, &form);
    if (plan->default_solvers && strcmp(plan->solver[i].solver->name, fits) != 0) {
      continue;
    }
    const char *why = check_not_applicable(spec, &form);
    if (why != NULL) {
      u.blank.verdict = CHECK_SKIPPED;
      (void)snprintf(u.blank.reason, sizeof u.blank.reason, "%s", why);
      check_report_add(plan->report, &u.blank);
    } else {
      done = run_pair(plan, &u, err);
    }
  }
  formulation_choice_free(&form);
  return done;
}

/* Does every shape, effect and load of the scene exist here, also with an effect switched off? */
static bool can_open(const check_plan *plan, const scene_spec *spec) {
  for (int k = -1; k < spec->n_off; k++) {
    const unsigned off = (k < 0) ? 0u : spec->off[k].effect;
    world *w = NULL;
    base_error why = {0};
    if (world_open(&w, spec, spec->effects & ~off, &why) != BASE_OK) {
      check_refuse(plan, spec->id, why.text);
      return false;
    }
    world_close(w);
  }
  return true;
}

base_status check_scene_case(const check_plan *plan, const scene_spec *spec, base_error *err) {
  if (!can_open(plan, spec)) {
    return BASE_OK;
  }
  for (int i = 0; i < plan->n_form; i++) {
    BASE_TRY(run_formulation(plan, spec, &plan->form[i], err));
  }
  return BASE_OK;
}
