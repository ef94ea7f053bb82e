/* problems/read/read_scene.h - parts of the scene reader (internal to problems/read). */
#pragma once

#include "problems/read/node.h"
#include "problems/spec/name_index.h"
#include "problems/spec/spec.h"

enum { READ_BODIES = 1000000, READ_ITEMS = 100000 };

/* An unchecked spec from one object of the case format (spec_init done by the callee, spec_free by
 * the caller on success and failure). */
base_status read_scene(json_t *v, scene_spec *s, base_error *err);

base_status read_body(scene_spec *s, json_t *v, int index, base_error *err);
base_status read_static(scene_spec *s, json_t *v, int index, base_error *err);
/* Loads and joints name bodies: they come after these. */
base_status read_load(scene_spec *s, const name_index *names, json_t *v, int index,
                      base_error *err);
base_status read_joint(scene_spec *s, const name_index *names, json_t *v, int index,
                       base_error *err);
base_status read_check(scene_spec *s, json_t *v, int index, base_error *err);
base_status read_off(scene_spec *s, const char *name, json_t *v, base_error *err);
/* Two names of a pair ["a", "b"]. */
base_status read_pair_names(const node *n, json_t *v, const char *what, char *a, char *b);
