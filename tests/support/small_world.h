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

#define SMALL_WORLD_GRAVITY 9.81 /* [m/s^2] */

/* A box of edge 0.2 and mass 2 on a floor, rough and elastic, with a speed along x. */
static inline void box_on_floor(scene_spec *s, int dim, double speed) {
  spec_init(s);
  s->dim = dim;
  s->gravity[dim - 1] = -SMALL_WORLD_GRAVITY;
  s->duration = 1.0;
  s->friction.dflt = 0.5;
  s->restitution.dflt = 0.4;
  spec_body *b = add_body(s, "box", SPEC_BOX, 0.1);
  b->pos[dim - 1] = 0.1;
  b->vel[0] = speed;
  add_floor(s, dim);
}

static inline double observe(const world *w, const char *var) {
  double x = 0.0;
  assert_true(world_observe(w, var, NULL, &x));
  return x;
}
