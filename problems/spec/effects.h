/* problems/spec/effects.h - the effects a scene declares, and the plan made once from them.
 *
 * What is not declared costs nothing: no dof, no row, no force term, no branch in a hot loop. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

/* X(mask, name, plain words) */
#define EFFECT_LIST(X)                                                                             \
  X(EFFECT_GRAVITY, "gravity", "constant acceleration")                                            \
  X(EFFECT_CONTACT, "contact", "bodies push each other apart")                                     \
  X(EFFECT_FRICTION, "friction", "bodies rub, where mu > 0")                                       \
  X(EFFECT_RESTITUTION, "restitution", "bodies bounce: e > 0 at impacts")                          \
  X(EFFECT_ROLLING, "rolling", "a moment against rolling")                                         \
  X(EFFECT_TORSION, "torsion", "a moment against spinning on a contact")                           \
  X(EFFECT_JOINTS, "joints", "bilateral constraints")                                              \
  X(EFFECT_ROTATION, "rotation", "bodies turn")                                                    \
  X(EFFECT_GYROSCOPIC, "gyroscopic", "the moment omega x I omega")                                 \
  X(EFFECT_DAMPING, "damping", "dampers among the loads")                                          \
  X(EFFECT_LOADS, "loads", "springs, applied and time-dependent forces")                           \
  X(EFFECT_MOTION, "motion", "prescribed motion: kinematic bodies, belts")                         \
  X(EFFECT_SPATIAL, "spatial", "three dimensions; absent: planar")

#define EFFECT_ENUM_(id, text, words) id##_BIT,
enum { EFFECT_LIST(EFFECT_ENUM_) EFFECT_COUNT };
#define EFFECT_MASK_(id, text, words) id = 1u << id##_BIT,
typedef enum effect { EFFECT_LIST(EFFECT_MASK_) EFFECT_NONE = 0 } effect;

const char *effect_name(int bit);
const char *effect_words(int bit); /* what it is, in plain words */

/* Writes "gravity friction ..." of the bits in mask. */
void effects_print(unsigned mask, char *buf, size_t cap);

/* Applies "declared", "all" or a comma list of -NAME / +NAME to a declared mask. */
base_status effects_override(unsigned declared, const char *spec, unsigned *out, base_error *err);
