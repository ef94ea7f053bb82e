/* tests/support/small_world.h - a few bodies on a floor, for tests of worlds. */
#pragma once

#include "tests/support/check.h"

#include "problems/world/world.h"

static inline spec_body *add_body(scene_spec *s, const char *name, spec_shape_kind kind,
                                  double size) {
  base_error err = {0};
  spec_body *b;
  check_ok(spec_add_body(s, name, &b, &err), &err);
  b->shape.kind = kind;
  b->shape.r = (kind == SPEC_BOX) ? 0.0 : size;
  b->shape.half[0] = b->shape.half[1] = b->shape.half[2] = size;
  b->mass = 2.0;
  b->inertia[0] = 0.3;
  b->inertia[1] = 0.4;
  b->inertia[2] = 0.5;
  b->quat[0] = 1.0;
  return b;
}

static inline void add_floor(scene_spec *s, int dim) {
  base_error err = {0};
  const double up[3] = {0, dim == 2, dim == 3};
  spec_static *f;
  check_ok(spec_add_static(s, "floor", up, 0.0, &f, &err), &err);
}

static inline double observe(const world *w, const char *var) {
  double x = 0.0;
  assert_true(world_observe(w, var, NULL, &x));
  return x;
}
