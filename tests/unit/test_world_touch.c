/* Bodies that come near each other between the ends of a step. */
#include "tests/support/small_world.h"

#include <math.h>
#include <stdlib.h>

static base_error err;

static const double near_by = 1e-6; /* [m] */

static double passed; /* at what speed, as last asked [m/s] */

/* Takes the world from where it is over h at the velocities it has, and asks. */
static double first_touch(world *w, double h) {
  contact_set c;
  double at;
  double *start = malloc(world_saved_size(w) * sizeof *start);
  assert_non_null(start);
  world_save(w, start);
  check_ok(world_contacts(w, h, 0.0, &c, &err), &err);
  check_ok(world_advance(w, c.v, NULL, &err), &err);
  check_ok(world_first_touch(w, h, start, near_by, &at, &passed, &err), &err);
  free(start);
  return at;
}

/* A box of edge 0.2 whose face is 0.02 above the floor and that makes a quarter of a turn at 3 rad/s. */
static world *spinning_box(scene_spec *s, int dim, double omega) {
  world *w;
  spec_init(s);
  s->dim = dim;
  s->duration = 1.0;
  spec_body *b = add_body(s, "box", SPEC_BOX, 0.1);
  b->pos[dim - 1] = 0.12;
  b->omega[(dim == 2) ? 2 : 1] = omega;
  add_floor(s, dim);
  check_ok(world_open(&w, s, ~0u & ~(unsigned)EFFECT_GYROSCOPIC, &err), &err);
  return w;
}

static void a_corner_passes_the_floor(void **state) {
  (void)state;
  const double corner = 0.1 * sqrt(2.0);
  const double quarter = 2.0 * atan(1.0);
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    world *w = spinning_box(&s, dim, 3.0);
    const double at = (asin((0.12 - near_by) / corner) - 0.5 * quarter) / 3.0;
    const double got = first_touch(w, quarter / 3.0);
    check_close(got, at, 10.0 * near_by);
    check_close(observe(w, "box.y"), (dim == 2) ? 0.12 : 0.0, 1e-15); /* where it was */
    world_close(w);
    spec_free(&s);
  }
}

static void what_ends_before_it_or_stands_still_tells_of_none(void **state) {
  (void)state;
  scene_spec s;
  world *w = spinning_box(&s, 2, 3.0);
  assert_true(first_touch(w, 0.05) == 0.05);
  world_close(w);
  spec_free(&s);
  w = spinning_box(&s, 2, 0.0);
  assert_true(first_touch(w, 0.5) == 0.5);
  world_close(w);
  spec_free(&s);
}

/* A box turns by a ball, which flies along with it: the way of both counts. */
static void a_face_passes_a_ball(void **state) {
  (void)state;
  const double quarter = 2.0 * atan(1.0);
  scene_spec s;
  world *w;
  spec_init(&s);
  s.dim = 2;
  s.duration = 1.0;
  add_body(&s, "box", SPEC_BOX, 0.1);
  add_body(&s, "ball", SPEC_SPHERE, 0.05);
  s.body[0].omega[2] = 3.0;
  s.body[0].vel[1] = s.body[1].vel[1] = 40.0;
  s.body[1].pos[0] = 0.17;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  /* the face beside the corner is 0.1 from the box's centre, the ball's centre 0.17 cos(angle) */
  const double at = acos(0.15 / 0.17) / 3.0;
  check_close(first_touch(w, quarter / 3.0), at, 10.0 * near_by);
  world_close(w);
  spec_free(&s);
}

/* Two discs of radius 0.05 a metre apart, one of which goes through the other at 2 m/s. */
static world *crossing_discs(scene_spec *s) {
  world *w;
  spec_init(s);
  s->dim = 2;
  s->duration = 1.0;
  add_body(s, "fast", SPEC_SPHERE, 0.05);
  add_body(s, "still", SPEC_SPHERE, 0.05);
  s->body[0].vel[0] = 2.0;
  s->body[1].pos[0] = 1.0;
  check_ok(world_open(&w, s, ~0u, &err), &err);
  return w;
}

static void discs_that_cross_have_passed(void **state) {
  (void)state;
  scene_spec s;
  world *w = crossing_discs(&s);
  check_close(first_touch(w, 1.0), 0.45, near_by);
  check_close(passed, 2.0, 1e-9);
  world_close(w);
  spec_free(&s);
}

static void discs_that_still_come_on_have_not(void **state) {
  (void)state;
  scene_spec s;
  world *w = crossing_discs(&s);
  assert_true(first_touch(w, 0.45 + 0.25 * near_by) == 0.45 + 0.25 * near_by);
  assert_true(passed == 0.0);
  world_close(w);
  spec_free(&s);
}

static void what_is_near_tells_how_fast_it_nears(void **state) {
  (void)state;
  scene_spec s;
  world *w = crossing_discs(&s);
  double speed;
  check_ok(world_nearing(w, 0.89, &speed, &err), &err);
  assert_true(speed == 0.0);
  check_ok(world_nearing(w, 0.91, &speed, &err), &err);
  check_close(speed, 2.0, 1e-6);
  world_close(w);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_corner_passes_the_floor),
      cmocka_unit_test(what_ends_before_it_or_stands_still_tells_of_none),
      cmocka_unit_test(a_face_passes_a_ball),
      cmocka_unit_test(discs_that_cross_have_passed),
      cmocka_unit_test(discs_that_still_come_on_have_not),
      cmocka_unit_test(what_is_near_tells_how_fast_it_nears),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
