/* problems/scenes/scene.h - the catalogue of built-in scenes.
 *
 * A scene is one constant in one file under problems/scenes: a table of parameters and a function
 * that fills a scene_spec. It declares its effects and its predictions (as spec checks); both are
 * claims that tests/conform/test_scenes.c runs. */
#pragma once

#include "lcp/base/fields.h"
#include "problems/spec/spec.h"

typedef struct scene {
  const char *name, *title, *cite; /* cite: keys of docs/references.bib; "": none */
  const char *about;               /* one paragraph: mechanics, what is known, source */
  const base_field *fields;        /* parameters, SI units, physical ranges */
  int n_fields;
  size_t param_size;
  base_status (*build)(const void *param, scene_spec *out, base_error *err);
} scene;

const scene *const *scenes(int *count);
const scene *scene_find(const char *name);

/* "NAME:par=val,..." into a checked spec, which the caller frees. BASE_EINVAL: unknown name or parameter. */
base_status scene_build(const char *text, scene_spec *out, base_error *err);
