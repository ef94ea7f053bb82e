/* The physical residual (RESIDUALS 5) against numbers worked out by hand: one point contact of a body of 2 kg, so
 * that a = J_n W J_n' = 1/2. */
#include "tests/support/check.h"

#include "problems/world/contact_merit.h"
#include "tests/support/rig.h"

#include <stdlib.h>

static const double zero[3] = {0}, up[3] = {0, 0, 1};

static contact_merit merit_of(rig *r, const double *impulse, const double *v_next, double bias) {
  contact_merit m;
  base_error err = {0};
  check_ok(contact_merit_at(rig_set(r), impulse, v_next, &bias, &m, &err), &err);
  return m;
}

/* Impulse (4, -3, 0) at mu = 1/2 on a body that slides with 1 m/s: v+ = (-1/2, 0, 2). Then
 * a l = (2, -3/2, 0), u~ = (2 + 1/4, -1/2, 0), and a l - u~ = (-1/4, -1, 0) has the projection
 * (1/5, -1/10, 0) on the cone, at the distance sqrt(5.2) from a l. */
static void sliding_contact(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  (void)rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.5);
  r->v[0] = 1;
  const double impulse[3] = {4, -3, 0}, v[6] = {-0.5, 0, 2};
  contact_merit m = merit_of(r, impulse, v, 0);
  check_close(m.ncp, sqrt(5.2), 1e-15);
  check_close(m.ncp_rel, sqrt(5.2) / 2, 1e-15); /* the largest speed is u_n = 2 m/s */
  check_close(m.normal, 2, 1e-15);
  check_close(m.cone, 1, 1e-15);          /* 3 - 2 N s */
  check_close(m.cone_rel, 0.5, 1e-15);    /* over mu l_n = 2 N s */
  check_close(m.dissipation, 2.5, 1e-15); /* 2 * 1/2 + 3 * 1/2 J */
  check_close(m.momentum, 0, 1e-15);

  /* a bias of -2 m/s closes the normal gap: a l - u~ = (7/4, -1, 0), within no cone of 1/2 */
  m = merit_of(r, impulse, v, -2);
  const double s = (1.75 + 0.5) / 1.25;
  check_close(m.ncp, hypot(s - 2, 0.5 * s - 1.5), 1e-15);
  check_close(m.normal, 0, 1e-15);

  /* left out by the formulation and without impulse: not judged */
  m = merit_of(r, zero, r->v, HUGE_VAL);
  assert_true(m.ncp == 0 && m.normal == 0 && m.cone == 0 && m.dissipation == 0);

  /* an impulse that the velocity does not know of: || M (v+ - v_free) - J' l || = 5 over 5 N s */
  m = merit_of(r, impulse, r->v, 0);
  check_close(m.momentum, 1, 1e-15);
  free(r);
}

/* Two bodies of 1 kg pinned at a point: what they move apart with, over the speeds around the pin. */
static void joints_apart(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  const int a = rig_body(r, 1, 1, 1, 1), b = rig_body(r, 1, 1, 1, 1);
  rig_pin(r, a, b, zero, zero);
  double v[12] = {0};
  const double none[3] = {0};
  contact_merit m = merit_of(r, none, v, HUGE_VAL);
  assert_true(m.joint == 0 && m.joint_rel == 0); /* nothing moves */
  v[0] = v[6] = 3;
  assert_true(merit_of(r, none, v, HUGE_VAL).joint_rel == 0); /* together */
  v[6] = 3 - 1e-3;
  m = merit_of(r, none, v, HUGE_VAL);
  check_close(m.joint, 1e-3, 1e-15);
  check_close(m.joint_rel, 1e-3 / 6, 1e-15); /* two rows of J of length 1, at 3 m/s */
  free(r);
}

/* Sticking up to mu_s, sliding at mu_k: an impulse on the kinetic cone against the motion is right. */
static void two_coefficients(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.5)->mu_k = 0.25;
  r->v[0] = 3;
  r->v[2] = -2;
  const double kinetic[3] = {4, -1, 0}, fast[6] = {2.5};
  contact_merit m = merit_of(r, kinetic, fast, 0);
  check_close(m.ncp, 0, 1e-15);
  check_close(m.dissipation, 0, 1e-15);
  r->v[0] = 1; /* held by more than mu_k l_n, less than mu_s l_n */
  const double held[3] = {4, -2, 0}, rest[6] = {0};
  m = merit_of(r, held, rest, 0);
  check_close(m.ncp, 0, 1e-15);
  check_close(m.cone, 0, 1e-15);
  free(r);
}

/* Drilling friction alone: measured at the arm of its coefficient, an impulse of (0.1 - 0.08)/0.02 = 1 N s
 * beyond the cone, over l_n = 4 N s. */
static void moment_without_friction(void **state) {
  (void)state;
  rig *r = rig_new(3, 0.01);
  rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0)->torsion = 0.02;
  const double impulse[2] = {4, 0.1}, v[6] = {0, 0, 2, 0, 0, 0.1};
  const contact_merit m = merit_of(r, impulse, v, 0);
  check_close(m.cone, 1, 1e-14);
  check_close(m.cone_rel, 0.25, 1e-14);
  free(r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sliding_contact),
      cmocka_unit_test(two_coefficients),
      cmocka_unit_test(joints_apart),
      cmocka_unit_test(moment_without_friction),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
