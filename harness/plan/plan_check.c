/* plan_check.c - the values of a campaign's axes, before a row is measured. Formulations, solvers
 * and files are read with the key of their cells (plan_key.c). */
#include "harness/plan/plan_check.h"

#include "harness/control/effects_watch.h"
#include "harness/measure/contact_order.h"
#include "harness/measure/problem_source.h"
#include "harness/sequence/sequence_solve.h"
#include "harness/sequence/sequence_source.h"
#include "problems/families/family.h"
#include "problems/read/scene_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static base_status positive(const char *axis, const char *text, base_error *err) {
  double v = 0;
  if (text[0] != '\0' && (!base_parse_real(text, &v) || !(v > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: %.60s: need a number above 0", axis, text);
  }
  return BASE_OK;
}

/* NAME:par=val,... against the parameters of NAME. */
static base_status parameters(const char *name, const char *given, const base_field *fields,
                              int n_fields, size_t size, base_error *err) {
  base_error why = {0};
  void *param = calloc(1, size + 1);
  if (param == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "problems: %s: no memory for parameters", name);
  }
  base_fields_default(fields, n_fields, param);
  const base_status done = base_fields_parse(fields, n_fields, param, given, &why);
  free(param);
  return (done == BASE_OK) ? BASE_OK : BASE_FAIL(err, done, "problems: %s: %.250s", name, why.text);
}

static base_status problem(part_kind kind, const char *text, base_error *err);

part_kind plan_kind(bool has_formulations, const char *problem) {
  return has_formulations ? PART_SCENES : sequence_is(problem) ? PART_SEQUENCES : PART_PROBLEMS;
}

/* A text whose problems are posed when a cell is measured; formulation and solver are read with its key. */
static base_status sequence_problem(const char *text, base_error *err) {
  sequence_text t;
  if (!sequence_is(text)) {
    return BASE_FAIL(err, BASE_EINVAL, "problems: %.80s: no sequence, as others of the part are",
                     text);
  }
  if (!sequence_is_text(text)) {
    return BASE_OK;
  }
  BASE_TRY(sequence_text_parse(text, &t, err));
  return problem(PART_SCENES, t.scene, err);
}

static base_status problem(part_kind kind, const char *text, base_error *err) {
  const bool is_scene = kind == PART_SCENES;
  char name[256];
  const size_t len = strcspn(text, ":");
  if (kind == PART_SEQUENCES) {
    return sequence_problem(text, err);
  }
  if (is_scene ? scene_is_file(text) : problem_is_file(text)) {
    return BASE_OK;
  }
  if (len >= sizeof name) {
    return BASE_FAIL(err, BASE_EINVAL, "problems: %.40s...: name too long", text);
  }
  (void)snprintf(name, sizeof name, "%.*s", (int)len, text);
  const char *given = (text[len] == ':') ? text + len + 1 : NULL;
  const scene *s = is_scene ? scene_find(name) : NULL;
  const lcp_family *f = is_scene ? NULL : lcp_family_find(name);
  if (s != NULL) {
    return parameters(name, given, s->fields, s->n_fields, s->param_size, err);
  }
  if (f != NULL) {
    return parameters(name, given, f->fields, f->n_fields, f->param_size, err);
  }
  return is_scene ? scene_unknown(name, err) : lcp_family_unknown(name, err);
}

static base_status start(part_kind kind, const char *text, base_error *err) {
  sequence_start any;
  if (kind == PART_SEQUENCES) {
    base_error why = {0};
    const base_status found = sequence_start_find(text, &any, &why);
    return (found == BASE_OK) ? BASE_OK : BASE_FAIL(err, found, "starts: %.200s", why.text);
  }
  return (strcmp(text, "cold") == 0 || strcmp(text, "previous") == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "starts: %.60s: need cold or previous", text);
}

base_status plan_check_axis(int axis, part_kind kind, base_error *err) {
  const bool of_scenes = axis == AXIS_steps || axis == AXIS_durations || axis == AXIS_effects ||
                         axis == AXIS_contact_orders || axis == AXIS_islands ||
                         (axis == AXIS_starts && kind != PART_SEQUENCES);
  return (kind == PART_SCENES || !of_scenes)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL,
                         "%s: only scenes have them, and scenes need formulations",
                         campaign_axis_name(axis));
}

base_status plan_check_value(int axis, part_kind kind, const char *text, base_error *err) {
  uint64_t seed;
  switch (axis) {
  case AXIS_problems:
    return problem(kind, text, err);
  case AXIS_steps:
    return positive("steps", text, err);
  case AXIS_durations:
    return positive("durations", text, err);
  case AXIS_starts:
    return start(kind, text, err);
  case AXIS_effects:
    return watch_check(text, err);
  case AXIS_contact_orders:
    return contact_order_parse(text, &seed, err);
  case AXIS_islands:
    return (strcmp(text, "on") == 0 || strcmp(text, "off") == 0)
               ? BASE_OK
               : BASE_FAIL(err, BASE_EINVAL, "islands: %.60s: need on or off", text);
  default:
    return BASE_OK;
  }
}
