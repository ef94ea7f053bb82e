/* problems/scenes/scene.h - the catalogue of built-in scenes.
 *
 * A scene is one constant in one file under problems/scenes: a table of parameters and a function
 * that fills a scene_spec. It declares its effects and its predictions (as spec checks); both are
 * claims that tests/conform/test_scenes.c runs. */
#pragma once

#include "lcp/base/fields.h"
#include "problems/spec/spec.h"

/* The kinds of scenes that a reader comes with; each has an answer of its own on the report's first
 * screen, made from the scenes that stand for it. */
#define SCENE_SITUATIONS(X)                                                                        \
  X(SITUATION_STACK, "stack", "Bodies rest on each other.")                                        \
  X(SITUATION_GRASP, "grasp", "A body is held between others by friction.")                        \
  X(SITUATION_SLIDING, "sliding", "Bodies slide, roll or stick on a surface.")                     \
  X(SITUATION_IMPACT, "impact", "Bodies hit each other.")
#define SCENE_SITUATION_ENUM_(id, name, words) id,
typedef enum scene_situation {
  SITUATION_OTHER, /* stands for none of them */
  SCENE_SITUATIONS(SCENE_SITUATION_ENUM_) SITUATION_COUNT
} scene_situation;

const char *scene_situation_name(scene_situation s);  /* "" for SITUATION_OTHER */
const char *scene_situation_words(scene_situation s); /* a sentence; "" for SITUATION_OTHER */

typedef struct scene {
  const char *name, *title, *cite; /* cite: keys of docs/references.bib; "": none */
  const char *about;               /* one paragraph: mechanics, what is known, source */
  scene_situation situation;       /* what it stands for when formulations are compared */
  bool redundant; /* more contacts than rigid bodies can tell apart: the contact rows depend on each
                     other at the start, with the parameters' defaults */
  const base_field *fields; /* parameters, SI units, physical ranges */
  int n_fields;
  size_t param_size;
  base_status (*build)(const void *param, scene_spec *out, base_error *err);
} scene;

const scene *const *scenes(int *count);
const scene *scene_find(const char *name);

/* The failure where scene_find has none, with the nearest name. */
base_status scene_unknown(const char *name, base_error *err);

/* "NAME:par=val,..." into a checked spec, which the caller frees. BASE_EINVAL: unknown name or parameter. */
base_status scene_build(const char *text, scene_spec *out, base_error *err);
