/* problems/spec/effects.h - the effects a scene declares, and the plan made once from them.
 *
 * What is not declared costs nothing: no dof, no row, no force term, no branch in a hot loop. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

#define EFFECT_LIST(X)                                                                             \
  X(EFFECT_GRAVITY, "gravity")         /* constant acceleration */                                 \
  X(EFFECT_CONTACT, "contact")         /* unilateral normal rows */                                \
  X(EFFECT_FRICTION, "friction")       /* tangential rows where mu > 0 */                          \
  X(EFFECT_RESTITUTION, "restitution") /* e > 0 at impacts */                                      \
  X(EFFECT_ROLLING, "rolling")         /* rolling resistance rows */                               \
  X(EFFECT_TORSION, "torsion")         /* drilling friction row */                                 \
  X(EFFECT_JOINTS, "joints")           /* bilateral rows */                                        \
  X(EFFECT_ROTATION, "rotation")       /* rotational dofs */                                       \
  X(EFFECT_GYROSCOPIC, "gyroscopic")   /* omega x I omega */                                       \
  X(EFFECT_DAMPING, "damping")         /* dampers among the loads */                               \
  X(EFFECT_LOADS, "loads")             /* springs, applied and time-dependent forces */            \
  X(EFFECT_MOTION, "motion")           /* kinematic bodies, prescribed dofs, belts */              \
  X(EFFECT_SPATIAL, "spatial")         /* three dimensions; absent: planar */

#define EFFECT_ENUM_(id, text) id##_BIT,
enum { EFFECT_LIST(EFFECT_ENUM_) EFFECT_COUNT };
#define EFFECT_MASK_(id, text) id = 1u << id##_BIT,
typedef enum effect { EFFECT_LIST(EFFECT_MASK_) EFFECT_NONE = 0 } effect;

const char *effect_name(int bit);

/* Writes "gravity friction ..." of the bits in mask. */
void effects_print(unsigned mask, char *buf, size_t cap);

/* Applies "declared", "all" or a comma list of -NAME / +NAME to a declared mask. */
base_status effects_override(unsigned declared, const char *spec, unsigned *out, base_error *err);
