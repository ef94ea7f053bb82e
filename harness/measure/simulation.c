#include "harness/measure/simulation.h"

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

base_status simulation_open(const simulation_texts *t, simulation *out, base_error *err) {
  *out = (simulation){0};
  spec_init(&out->spec);
  if (!given(t->formulation) || !given(t->solver)) {
    const char *missing = given(t->formulation) ? "solver" : "formulation";
    return BASE_FAIL(err, BASE_EINVAL, "--%s is missing; see lcpbench list %ss", missing, missing);
  }
  BASE_TRY(formulation_choose(t->formulation, &out->form, err));
  BASE_TRY(solver_choose(t->solver, &out->solver, err));
  if (given(t->tol)) {
    BASE_TRY(solver_choice_set(&out->solver, "tol", t->tol, err));
  }
  BASE_TRY(scene_load(t->scene, &out->spec, err));
  const scene_spec *spec = &out->spec;
  sim_request *q = &out->request;
  *q = (sim_request){.spec = spec, .form = &out->form, .solver = &out->solver};
  BASE_TRY(positive("--step", t->step, spec->n_h > 0 ? spec->h[0] : 0.01, &q->h, err));
  BASE_TRY(positive("--duration", t->duration, spec->duration, &q->duration, err));
  BASE_TRY(sim_check_times(q->h, q->duration, err));
  BASE_TRY(start_of(t->start, &q->start, err));
  if (given(t->contact_order)) {
    BASE_TRY(contact_order_parse(t->contact_order, &q->contact_order, err));
  }
  return effects_choose(q, given(t->effects) ? t->effects : "declared", &out->effects, err);
}

void simulation_close(simulation *s) {
  spec_free(&s->spec);
  formulation_choice_free(&s->form);
  solver_choice_free(&s->solver);
}
