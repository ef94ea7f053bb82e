/* Which contact points shapes in given poses have, and that their numbers last while features do. */
#include "tests/support/check.h"

#include "tests/support/shape_list.h"
#include "tests/support/shapes_any.h"

static void half_space_lists_every_corner(void **state) {
  (void)state;
  const double up[3] = {0, 0, 1}, x[3] = {0, 0, 0.2}, q[4] = {1, 0, 0, 0};
  any_piece box;
  gap_point g[GAP_MAX];
  any_shape(&box, &spatial_shapes[3], 3);
  const pose at = any_pose(x, q);
  assert_int_equal(gap_halfspace(&box.p, &at, up, 0.0, 0.01, g), 4);
  for (int i = 0; i < 4; i++) {
    check_close(g[i].gap, 0.0, 1e-15);
    assert_int_equal(g[i].feature, i);
  }
  assert_int_equal(gap_halfspace(&box.p, &at, up, 0.0, 1.0, g), 8);
}

/* Lowest point of a tilted disc: centre height - r sin(tilt). */
static void tilted_disc_touches_at_its_lowest_rim_point(void **state) {
  (void)state;
  const double up[3] = {0, 0, 1}, x[3] = {0.1, 0.2, 0.5}, tilt = 0.4;
  const double q[4] = {cos(tilt / 2), sin(tilt / 2), 0, 0};
  any_piece disc;
  gap_point g[GAP_MAX];
  any_shape(&disc, &spatial_shapes[4], 3);
  const pose at = any_pose(x, q);
  assert_int_equal(gap_halfspace(&disc.p, &at, up, 0.0, 0.4, g), 1);
  check_close(g[0].gap, 0.5 - 0.4 * sin(tilt), 1e-14);
  check_close(g[0].x[0], 0.1, 1e-14);
  const double flat[4] = {1, 0, 0, 0};
  const pose lying = any_pose(x, flat);
  assert_int_equal(gap_halfspace(&disc.p, &lying, up, 0.0, 0.6, g), 6);
}

/* A box pushed along a floor box: ids must not change while the corners stay over it. */
static void ids_last_while_features_do(void **state) {
  (void)state;
  any_piece block, table;
  const spec_shape wide = {.kind = SPEC_BOX, .half = {3, 0.05}};
  any_shape(&block, &planar_shapes[4], 2);
  any_shape(&table, &wide, 2);
  const double q[4] = {1, 0, 0, 0}, origin[3] = {0, 0, 0};
  const pose down = any_pose(origin, q);
  for (int i = 0; i <= 100; i++) {
    const double x[3] = {-2.0 + 0.04 * i, 0.35 + 1e-12 * (i % 3 - 1), 0};
    const pose up = any_pose(x, q);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_planar(&block.p, &up, &table.p, &down, 1e-3, g), 2);
    assert_int_equal(g[0].feature + g[1].feature, 1); /* vertices 0 and 1 of the block */
    check_close(g[0].n[1], 1.0, 1e-12);
  }
}

static void equal_boxes_keep_two_points_at_every_rounding(void **state) {
  (void)state;
  any_piece box;
  any_shape(&box, &planar_shapes[4], 2);
  base_rng r = base_rng_seeded(5);
  const double origin[3] = {0, 0, 0};
  for (int i = 0; i < 1000; i++) {
    const double tilt = 1e-12 * base_rng_normal(&r);
    const double q0[4] = {1, 0, 0, 0}, q1[4] = {1, 0, 0, tilt};
    const double x[3] = {1e-12 * base_rng_normal(&r), 0.6 + 1e-13 * base_rng_normal(&r), 0};
    const pose low = any_pose(origin, q0), high = any_pose(x, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_planar(&box.p, &low, &box.p, &high, 1e-3, g), 2);
    assert_true(g[0].feature == SPEC_VERTICES && g[1].feature == SPEC_VERTICES + 1);
  }
}

/* Four corners of a face are four points, also with equal outlines; ids do not depend on rounding. */
static void stacked_boxes_rest_on_four_points(void **state) {
  (void)state;
  any_piece box, wide;
  const spec_shape plate = {.kind = SPEC_BOX, .half = {2, 2, 0.1}};
  base_rng r = base_rng_seeded(15);
  any_shape(&box, &spatial_shapes[3], 3);
  any_shape(&wide, &plate, 3);
  for (int i = 0; i < 500; i++) {
    const double e = 1e-12;
    const double q0[4] = {1, 0, 0, 0};
    const double q1[4] = {1, e * base_rng_normal(&r), e * base_rng_normal(&r),
                          e * base_rng_normal(&r)};
    const double low[3] = {0, 0, 0}, mid[3] = {e, e, 0.4 + e * base_rng_normal(&r)};
    const double on_plate[3] = {0.3 + 0.001 * i, -0.2, 0.3 + e * base_rng_normal(&r)};
    const pose p0 = any_pose(low, q0), p1 = any_pose(mid, q1), p2 = any_pose(on_plate, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_spatial(&box.p, &p0, &box.p, &p1, 1e-3, g), 4);
    for (uint32_t k = 0; k < 4; k++) {
      assert_true(g[k].feature >= 8 && g[k].feature < 12); /* lower corners of the upper box */
      check_close(g[k].n[2], -1.0, 1e-11);
    }
    assert_int_equal(gap_spatial(&box.p, &p2, &wide.p, &p0, 1e-3, g), 4);
    for (uint32_t k = 0; k < 4; k++) {
      assert_true(g[k].feature < 4);
    }
  }
}

/* A capsule rolling about its own axis on a box keeps its two ids: its corners coincide. */
static void capsules_keep_their_ids_when_they_roll(void **state) {
  (void)state;
  any_piece rod, box;
  any_shape(&rod, &spatial_shapes[2], 3);
  any_shape(&box, &spatial_shapes[3], 3);
  uint32_t first[2] = {0, 0};
  for (int i = 0; i < 100; i++) {
    const double turn = 0.1 * i, low[3] = {0, 0, 0}, high[3] = {0, 0, 0.3 - 1e-4};
    const double q0[4] = {1, 0, 0, 0}, q1[4] = {cos(turn / 2), sin(turn / 2), 0, 0};
    const pose p0 = any_pose(low, q0), p1 = any_pose(high, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_spatial(&rod.p, &p1, &box.p, &p0, 1e-3, g), 2);
    for (int k = 0; k < 2; k++) {
      first[k] = (i == 0) ? g[k].feature : first[k];
      assert_int_equal(g[k].feature, first[k]);
      check_close(g[k].gap, -1e-4, 1e-12);
    }
  }
}

/* A square turned by 45 degrees on an equal square: an octagon of crossings. */
static void turned_square_rests_on_eight_crossings(void **state) {
  (void)state;
  any_piece cube;
  const spec_shape unit = {.kind = SPEC_BOX, .half = {0.5, 0.5, 0.5}};
  const double low[3] = {0, 0, 0}, high[3] = {0, 0, 1.0}, q0[4] = {1, 0, 0, 0};
  const double q1[4] = {cos(0.125 * 3.14159265358979), 0, 0, sin(0.125 * 3.14159265358979)};
  gap_point g[GAP_MAX];
  any_shape(&cube, &unit, 3);
  const pose p0 = any_pose(low, q0), p1 = any_pose(high, q1);
  assert_int_equal(gap_spatial(&cube.p, &p0, &cube.p, &p1, 1e-3, g), 8);
  for (int i = 0; i < 8; i++) {
    assert_true(g[i].feature >= 16);
    check_close(g[i].gap, 0.0, 1e-12);
    check_close(hypot(g[i].x[0], g[i].x[1]), 0.5 / cos(0.125 * 3.14159265358979), 1e-9);
    for (int k = 0; k < i; k++) {
      assert_true(g[i].feature != g[k].feature);
    }
  }
}

static int count_below(const gap_point *g, int n, double gap, double tol) {
  int count = 0;
  for (int k = 0; k < n; k++) {
    count += fabs(g[k].gap - gap) < tol;
  }
  return count;
}

/* Cylinders stand on six points and lie on two, on boxes and on each other. */
static void cylinders_stand_and_lie(void **state) {
  (void)state;
  static const spec_shape can = {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 0.2}};
  static const spec_shape table = {.kind = SPEC_BOX, .half = {1, 1, 0.1}};
  const double up[4] = {1, 0, 0, 0}, down[4] = {sqrt(0.5), sqrt(0.5), 0, 0};
  any_piece a, b, c;
  gap_point g[GAP_MAX];
  any_shape(&a, &can, 3);
  any_shape(&b, &table, 3);
  any_shape(&c, &can, 3);
  const pose floor_ = any_pose((const double[]){0, 0, -0.1}, up);
  const pose upright = any_pose((const double[]){0.2, 0.1, 0.2}, up);
  const pose lying = any_pose((const double[]){0.2, 0.1, 0.3}, down);
  const pose above = any_pose((const double[]){0.2, 0.1, 0.6}, up);
  const pose beside = any_pose((const double[]){0.8, 0.1, 0.3}, down);
  int n = gap_spatial(&a.p, &upright, &b.p, &floor_, 0.01, g);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 6);
  assert_int_equal(n, 6);
  for (int k = 0; k < n; k++) {
    check_close(g[k].n[2], 1.0, 1e-12);
  }
  n = gap_spatial(&a.p, &lying, &b.p, &floor_, 0.01, g);
  assert_int_equal(n, 2);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 2);
  n = gap_spatial(&c.p, &above, &a.p, &upright, 0.01, g);
  assert_int_equal(n, 6);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 6);
  n = gap_spatial(&c.p, &beside, &a.p, &lying, 0.01, g);
  assert_int_equal(n, 2);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 2);
  for (int k = 0; k < n; k++) {
    check_close(g[k].n[0], 1.0, 1e-12);
  }
}

/* Cores that meet have no direction from one to the other: the normal is at right angles to both, and from the
 * axis of a long cylinder the way out is through its mantle. */
static void cores_that_meet_have_a_normal(void **state) {
  (void)state;
  static const spec_shape rod = {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
                          ball = {.kind = SPEC_SPHERE, .r = 0.1},
                          post = {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 2.0}};
  const double here[3] = {0}, plain[4] = {1, 0, 0, 0}, upright[4] = {sqrt(0.5), 0, -sqrt(0.5), 0},
               sideways[4] = {sqrt(0.5), 0, 0, sqrt(0.5)};
  const pose along = any_pose(here, plain), up = any_pose(here, upright),
             across = any_pose(here, sideways);
  any_piece a, b;
  gap_point g[GAP_MAX];
  any_shape(&a, &rod, 3);
  any_shape(&b, &rod, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &across, 0.0, g), 1);
  check_close(g[0].gap, -0.2, 1e-15);
  check_close(fabs(g[0].n[2]), 1.0, 1e-12);
  any_shape(&a, &ball, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &up, 0.0, g), 1);
  check_close(g[0].gap, -0.2, 1e-15);
  check_close(g[0].n[2], 0.0, 1e-12); /* the rod stands along z */
  any_shape(&b, &post, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &along, 0.0, g), 1);
  check_close(g[0].gap, -0.4, 1e-15);
  check_close(hypot(g[0].n[0], g[0].n[1]), 1.0, 1e-12);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cores_that_meet_have_a_normal),
      cmocka_unit_test(cylinders_stand_and_lie),
      cmocka_unit_test(stacked_boxes_rest_on_four_points),
      cmocka_unit_test(capsules_keep_their_ids_when_they_roll),
      cmocka_unit_test(turned_square_rests_on_eight_crossings),
      cmocka_unit_test(half_space_lists_every_corner),
      cmocka_unit_test(tilted_disc_touches_at_its_lowest_rim_point),
      cmocka_unit_test(ids_last_while_features_do),
      cmocka_unit_test(equal_boxes_keep_two_points_at_every_rounding),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
