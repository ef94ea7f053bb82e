/* problems/read/scene_file.h - scenes from files: a scene file holds one scene or a list, a case file many. */
#pragma once

#include "problems/scenes/scene.h"

/* "NAME:par=val,..." (built-in) or a path to a JSON or YAML scene file holding one scene (or
 * "FILE#ID" for one of a list) into a checked spec. */
base_status scene_load(const char *text, scene_spec *out, base_error *err);

/* Is this text of a scene a path (with a slash, or an ending of a scene file), not a name? */
bool scene_is_file(const char *text);

/* The path in the text of a scene file, and the ID behind its #; *id NULL: none. A file that has that name
 * as it is has it with its #. */
void scene_file_split(const char *text, char *path, size_t cap, const char **id);

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
