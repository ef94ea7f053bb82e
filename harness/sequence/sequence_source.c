#include "harness/sequence/sequence_source.h"

#include "harness/measure/registry.h"
#include "harness/measure/simulate.h"
#include "harness/sequence/sequence_file.h"
#include "lcp/base/fields.h"

#include <string.h>

enum { FIELDS = 5 };

bool sequence_is_text(const char *text) {
  int n = 0;
  for (; *text != '\0'; text++) {
    n += *text == '@';
  }
  return n == FIELDS - 1;
}

bool sequence_is(const char *text) {
  return sequence_is_text(text) || sequence_is_folder(text);
}

base_status sequence_text_parse(const char *text, sequence_text *out, base_error *err) {
  char step[32];
  char count[16];
  int n = 0;
  *out = (sequence_text){0};
  const struct {
    char *to;
    size_t cap;
  } field[FIELDS] = {{out->scene, sizeof out->scene},
                     {out->formulation, sizeof out->formulation},
                     {out->solver, sizeof out->solver},
                     {step, sizeof step},
                     {count, sizeof count}};
  for (int i = 0; i < FIELDS; i++) {
    const size_t len = strcspn(text, "@");
    if (len == 0 || len >= field[i].cap || (text[len] == '@') != (i + 1 < FIELDS)) {
      return BASE_FAIL(err, BASE_EINVAL, "%.120s: need SCENE@FORMULATION@SOLVER@STEP@COUNT", text);
    }
    (void)snprintf(field[i].to, field[i].cap, "%.*s", (int)len, text);
    text += len + (text[len] == '@');
  }
  if (!base_parse_real(step, &out->h) || !(out->h > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "step %s of a sequence: need a number above 0", step);
  }
  if (!base_parse_int(count, &n) || n < 1) {
    return BASE_FAIL(err, BASE_EINVAL, "count %s of a sequence: need an integer of at least 1",
                     count);
  }
  out->count = n;
  return BASE_OK;
}

static base_status put(void *ctx, const sim_solved *k, base_error *err) {
  return sequence_put(ctx, k, err);
}

static base_status pose(const sequence_text *t, const scene_spec *spec,
                        const formulation_choice *form, const solver_choice *solver, sequence *out,
                        base_error *err) {
  series record;
  sim_result r;
  const sim_listener all = {put, out};
  const sim_request q = {.spec = spec,
                         .effects = spec->effects,
                         .form = form,
                         .solver = solver,
                         .h = t->h,
                         .duration = t->h * (double)t->count,
                         .start = FORM_COLD,
                         .listener = &all};
  const base_status done = simulate(&q, &record, &r, err);
  series_close(&record);
  BASE_TRY(done);
  out->steps = r.steps;
  out->status = r.status;
  (void)snprintf(out->note, sizeof out->note, "%s", r.note);
  return (out->n > 0) ? BASE_OK
                      : BASE_FAIL(err, BASE_EUNSUPPORTED,
                                  "%.80s: %ld steps by %.60s posed no problem%s%.150s", t->scene,
                                  r.steps, t->formulation, r.note[0] != '\0' ? ": " : "", r.note);
}

base_status sequence_pose(const sequence_text *t, sequence *out, base_error *err) {
  scene_spec spec;
  formulation_choice form = {0};
  solver_choice solver = {0};
  *out = (sequence){.h = t->h, .count = t->count};
  memcpy(out->scene, t->scene, sizeof out->scene);
  memcpy(out->formulation, t->formulation, sizeof out->formulation);
  memcpy(out->solver, t->solver, sizeof out->solver);
  BASE_TRY(scene_open(t->scene, &spec, err));
  base_status done = formulation_choose(t->formulation, &form, err);
  if (done == BASE_OK) {
    done = solver_choose(t->solver, &solver, err);
  }
  if (done == BASE_OK) {
    done = pose(t, &spec, &form, &solver, out, err);
  }
  spec_free(&spec);
  formulation_choice_free(&form);
  solver_choice_free(&solver);
  return done;
}

base_status sequence_open(const char *text, sequence *out, base_error *err) {
  sequence_text t;
  *out = (sequence){0};
  if (!sequence_is_text(text)) {
    return sequence_read(text, out, err);
  }
  BASE_TRY(sequence_text_parse(text, &t, err));
  return sequence_pose(&t, out, err);
}
