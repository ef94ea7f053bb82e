/* problems/scenes/scene.h - the catalogue of built-in scenes, and scene files.
 *
 * A scene is one constant in one file under problems/scenes: a table of parameters and a function
 * that fills a scene_spec. It declares its effects and its predictions (as spec checks); both are
 * claims that tests/conform/test_scenes.c runs. */
#pragma once

#include "lcp/base/fields.h"
#include "problems/spec/spec.h"

typedef struct scene {
  const char *name, *title, *cite;
  const char *about;        /* one paragraph: mechanics, what is known, source */
  const base_field *fields; /* parameters, SI units, physical ranges */
  int n_fields;
  size_t param_size;
  base_status (*build)(const void *param, scene_spec *out, base_error *err);
} scene;

const scene *const *scenes(int *count);
const scene *scene_find(const char *name);

/* "NAME:par=val,..." (built-in) or a path to a JSON or YAML scene file holding one scene (or
 * "FILE#ID" for one of a list) into a checked spec. */
base_status scene_load(const char *text, scene_spec *out, base_error *err);

/* A case file: all scenes (groups "scenes" and "stress", or a bare scene or list). */
typedef struct scene_file {
  int n_scene;
  scene_spec *scene;
  int n_failed; /* scenes that could not be read */
  struct scene_file_failure {
    char id[64];
    base_error err;
  } * failed;
} scene_file;
base_status scene_file_read(const char *path, scene_file *out, base_error *err);
void scene_file_free(scene_file *f);
