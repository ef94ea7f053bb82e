/* harness/cli/list_json.h - components as whole JSON objects, for tools that build on them. */
#pragma once

#include "lcp/base/fields.h"
#include "problems/scenes/scene.h"

#include <jansson.h>

/* Parameters or options: name, kind (integer, real, choice), unit, default, min, max (null for
 * choices), words (null for numbers), help. */
json_t *list_fields_json(const base_field *f, int n);

/* A built-in scene: name, title, about, cite, parameters, and, as it is with the defaults of its
 * parameters: dim, duration_s, step_s, bodies, effects, observables [{name, unit}], predictions
 * [{quantity, unit, time_s, value, tolerance {abs, h, ...}, formulations, source}] (times and values
 * null where the check has none; formulations empty: all of them). */
base_status list_scene_json(const scene *s, json_t **out, base_error *err);
