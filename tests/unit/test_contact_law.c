/* What friction gives beyond Coulomb's (contact_law.h), by hand: one point contact of a body of 2 kg with the ground, so that W = 1/2 along each
 * row. */
#include "tests/support/check.h"

#include "problems/world/contact_law.h"
#include "tests/support/rig.h"

#include <stdlib.h>
#include <string.h>

static const double zero[3] = {0}, up[3] = {0, 0, 1};
enum { HOLDS = 1, SLIDES = 2 };

static contact_law law_of(rig *r, const double l[3], unsigned char mode, const double u[3],
                          const double free_u[3], double v[6]) {
  memset(v, 0, 6 * sizeof *v);
  return contact_law_at(rig_set(r), l, &mode, u, free_u, v);
}

/* mu l_n = 2 N s along the slip of (3, 4) m/s, against it: nothing. Along x only: (-2 + 6/5, 8/5) N s beyond, half of it as velocity. */
static void edges_turn_friction(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  (void)rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.5);
  const double u[3] = {0, 3, 4};
  const double against[3] = {4, -1.2, -1.6};
  const double edge[3] = {4, -2, 0};
  const double along[3] = {4, 2, 0};
  double v[6];
  assert_false(law_of(r, against, SLIDES, u, u, v).bent);
  assert_true(law_of(r, edge, SLIDES, u, u, v).bent);
  const contact_set *c = rig_set(r);
  for (int k = 1; k < 3; k++) {
    double along_row = 0.0;
    for (int i = 0; i < 6; i++) {
      along_row += c->jac[6 * k + i] * v[i];
    }
    check_close(along_row, 0.5 * ((k == 1) ? -2 + 1.2 : 1.6), 1e-15);
  }
  assert_false(law_of(r, edge, HOLDS, u, u, v).bent);
  assert_false(law_of(r, along, SLIDES, u, u, v).bent); /* of before the slip turned */
  assert_true(v[0] == 0 && v[1] == 0 && v[2] == 0);
  const double still[3] = {0, 1e-9, 0};
  assert_false(law_of(r, edge, SLIDES, still, still, v).bent); /* in no direction */
  free(r);
}

/* The same friction at a slip of (3, 4) / 10000 m/s: what it gives beyond would be 0.9 m/s, and is no more than the slip. */
static void friction_does_no_more_than_its_slip(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  (void)rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.5);
  const double u[3] = {0, 3e-4, 4e-4};
  const double edge[3] = {4, -2, 0};
  double v[6];
  assert_true(law_of(r, edge, SLIDES, u, u, v).bent);
  check_close(hypot(v[0], v[1]), 5e-4, 1e-15);
  free(r);
}

/* A ball that comes down at 2 m/s and goes up at 1, its contact holding, still slips at 0.1 m/s. */
static void bristles_leave_slip(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.5)->e = 0.5;
  r->v[2] = -2;
  const double l[3] = {6, -1, 0};
  const double back[3] = {1, 0.1, 0}, free_u[3] = {-2, 0.01, 0}, loads[3] = {-2, 0.05, 0};
  const double stays[3] = {0, 0.1, 0}, none[3] = {1, 0, 0};
  double v[6];
  check_close(law_of(r, l, HOLDS, back, free_u, v).left, 0.1, 0.0);
  check_close(law_of(r, l, SLIDES, back, free_u, v).left, 0.0, 0.0);
  check_close(law_of(r, l, HOLDS, back, loads, v).left, 0.0, 0.0); /* what loads give in the step */
  check_close(law_of(r, l, HOLDS, none, free_u, v).left, 0.0, 0.0);
  /* it stays: no more than friction of 3 N s could have taken, half of what is left of that as velocity */
  const double most[3] = {6, -2.9, 0};
  check_close(law_of(r, l, HOLDS, stays, free_u, v).left, 0.1, 0.0);
  check_close(law_of(r, most, HOLDS, stays, free_u, v).left, 0.05, 1e-15);
  r->v[2] = -0.01; /* by what loads give in the step */
  const double pressed[3] = {-0.02, 0.01, 0};
  check_close(law_of(r, l, HOLDS, stays, pressed, v).left, 0.0, 0.0);
  free(r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(edges_turn_friction),
      cmocka_unit_test(friction_does_no_more_than_its_slip),
      cmocka_unit_test(bristles_leave_slip),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
