#include "harness/control/simulation.h"

#include "harness/measure/contact_order.h"
#include "lcp/base/fields.h"
#include "problems/read/scene_file.h"

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
  if (given(t->work) && !given(t->error)) {
    return BASE_FAIL(err, BASE_EINVAL, "--work %s: limits --error, which is missing", t->work);
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

/* The candidates in turn until one has no step that failed. */
static base_status run_chosen(simulation *s, const sim_request *q, series *record, sim_result *out,
                              base_error *err) {
  const choice *c = &s->choice;
  for (int k = 0; k < c->n && k < CHOICE_TRIES; k++) {
    series_close(record);
    step_list_close(&s->steps);
    BASE_TRY(take(s, c->candidate[k].formulation, c->candidate[k].solver, err));
    BASE_TRY(error_run(q, &s->error, record, out, &s->steps, &s->found, err));
    s->tried[s->n_tried++] = out->status;
    if (out->status == RUN_OK) {
      break;
    }
  }
  return BASE_OK;
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
  s->chooses = true;
  return take(s, s->choice.candidate[0].formulation, s->choice.candidate[0].solver, err);
}

base_status simulation_run(simulation *s, series *record, sim_result *out, base_error *err) {
  sim_request *q = &s->request;
  *record = (series){0};
  if (!(s->error.E > 0.0)) {
    return simulate(q, record, out, err);
  }
  sim_request silent = *q;
  silent.trajectory = NULL;
  silent.trace = NULL;
  silent.dump = NULL;
  BASE_TRY(s->chooses ? run_chosen(s, &silent, record, out, err)
                      : error_run(&silent, &s->error, record, out, &s->steps, &s->found, err));
  repeat_steps(s);
  if (q->trajectory == NULL && q->trace == NULL && q->dump == NULL) {
    return BASE_OK;
  }
  const sim_times spent = out->time;
  series_close(record);
  BASE_TRY(simulate(q, record, out, err));
  sim_times_add(&out->time, &spent);
  return BASE_OK;
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
  if (both) {
    BASE_TRY(take(out, t->formulation, t->solver, err));
  }
  BASE_TRY(scene_load(t->scene, &out->spec, err));
  const scene_spec *spec = &out->spec;
  sim_request *q = &out->request;
  *q = (sim_request){.spec = spec, .form = &out->form, .solver = &out->solver};
  BASE_TRY(positive("--step", t->step, spec->n_h > 0 ? spec->h[0] : 0.01, &q->h, err));
  BASE_TRY(positive("--duration", t->duration, spec->duration, &q->duration, err));
  BASE_TRY(sim_check_times(q->h, q->duration, err));
  BASE_TRY(open_steps(t, out, err));
  BASE_TRY(start_of(t->start, &q->start, err));
  if (given(t->contact_order)) {
    BASE_TRY(contact_order_parse(t->contact_order, &q->contact_order, err));
  }
  const char *effects = given(t->effects) ? t->effects : "declared";
  /* the choice wants to know the effects, and a pilot a formulation */
  const bool pilot = strncmp(effects, "auto", 4) == 0;
  BASE_TRY(effects_override(spec->effects, pilot ? "declared" : effects, &q->effects, err));
  if (given(t->error)) {
    BASE_TRY(features_of(spec, q->effects, q->h, &out->features, err));
  }
  if (!both) {
    BASE_TRY(choose_combination(out, given(t->rows) ? t->rows : NULL, err));
  }
  return effects_choose(q, effects, &out->effects, err);
}

void simulation_close(simulation *s) {
  step_list_close(&s->steps);
  spec_free(&s->spec);
  formulation_choice_free(&s->form);
  solver_choice_free(&s->solver);
}
