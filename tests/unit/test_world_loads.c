/* Loads, joints and generalised coordinates of worlds. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "problems/vec.h"
#include "problems/world/model.h"
#include "problems/world/world.h"

#include <string.h>

static base_error err;

static spec_body *add_body(scene_spec *s, const char *name, double x, double y, double z) {
  spec_body *b;
  check_ok(spec_add_body(s, name, &b, &err), &err);
  b->shape.kind = SPEC_SPHERE;
  b->shape.r = 0.1;
  b->mass = 2.0;
  b->inertia[0] = 0.3;
  b->inertia[1] = 0.4;
  b->inertia[2] = 0.5;
  b->quat[0] = 1.0;
  b->pos[0] = x;
  b->pos[1] = y;
  b->pos[2] = z;
  return b;
}

static void start(scene_spec *s, int dim) {
  spec_init(s);
  s->dim = dim;
  s->duration = 10.0;
}

static double observe(const world *w, const char *var) {
  double x = 0.0;
  assert_true(world_observe(w, var, NULL, &x));
  return x;
}

static void free_steps(world *w, double h, int n) {
  contact_set c;
  for (int i = 0; i < n; i++) {
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    check_ok(world_advance(w, c.v_free, NULL, &err), &err);
  }
}

/* Symplectic Euler on x'' = -w^2 x: x_{n+1} = (2 - (w h)^2) x_n - x_{n-1}, amplitude kept. */
static void spring_oscillates_as_symplectic_euler_does(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  spec_load *l;
  start(&s, 2);
  add_body(&s, "m", 0.5, 0, 0);
  check_ok(spec_add_load(&s, &l, &err), &err);
  l->kind = SPEC_SPRING;
  l->other = -1;
  l->k = 8.0; /* omega = 2 */
  l->dir[0] = 1.0;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  const double E = world_energy(w);
  check_close(E, 0.5 * 8.0 * 0.25, 1e-15);
  double x0 = 0.5, x1 = 0.5 * (1.0 - 4.0 * 1e-4), h = 0.01;
  free_steps(w, h, 1);
  for (int i = 0; i < 500; i++) {
    const double x2 = (2.0 - 4.0 * h * h) * x1 - x0;
    check_close(observe(w, "m.x"), x1, 1e-12);
    x0 = x1;
    x1 = x2;
    free_steps(w, h, 1);
  }
  check_close(world_energy(w), E, 0.02 * E);
  contact_set c;
  assert_int_equal(world_contacts(w, 1.0, -1.0, &c, &err), BASE_EINVAL); /* h^2 k/m = 4 */
  world_close(w);
  spec_free(&s);
}

static void forces_follow_their_time_laws(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  spec_load *l;
  start(&s, 2);
  add_body(&s, "a", 0, 0, 0);
  add_body(&s, "b", 5, 0, 0);
  add_body(&s, "c", 10, 0, 0);
  const spec_load_kind kinds[] = {SPEC_FORCE, SPEC_FORCE_RAMP, SPEC_FORCE_SINE};
  for (int i = 0; i < 3; i++) {
    check_ok(spec_add_load(&s, &l, &err), &err);
    l->kind = kinds[i];
    l->body = i;
    l->other = -1;
    l->force[1] = 3.0;
    l->torque[2] = 0.6;
    l->dir[1] = 1.0;
    l->rate = 4.0;
    l->omega = 5.0;
    l->phase = 0.2;
  }
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  const double h = 0.01;
  const int n = 50;
  free_steps(w, h, n);
  double sine = 0.0;
  for (int i = 0; i < n; i++) {
    sine += h * 4.0 * sin(5.0 * h * i + 0.2) / 2.0;
  }
  check_close(observe(w, "a.vy"), 3.0 * h * n / 2.0, 1e-13);
  check_close(observe(w, "a.omega"), 0.6 * h * n / 0.3, 1e-13);
  check_close(observe(w, "b.vy"), 4.0 / 2.0 * h * h * n * (n - 1) / 2.0, 1e-13);
  check_close(observe(w, "c.vy"), sine, 1e-13);
  world_close(w);
  /* undeclared: nothing moves */
  check_ok(world_open(&w, &s, EFFECT_ROTATION, &err), &err);
  free_steps(w, h, n);
  check_close(world_max_speed(w), 0.0, 0.0);
  assert_true(world_may_rest(w)); /* these loads are not simulated */
  world_close(w);
  /* nothing may change with time, nor turn */
  static const spec_load_kind constant[] = {SPEC_FORCE, SPEC_FORCE, SPEC_FORCE};
  for (int i = 0; i < 3; i++) {
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    assert_int_equal(world_may_rest(w),
                     s.load[1].kind == SPEC_FORCE && s.load[2].kind == SPEC_FORCE);
    world_close(w);
    s.load[i].kind = constant[i];
  }
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  assert_true(world_may_rest(w));
  world_close(w);
  s.body[0].omega[2] = 1e-3;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  assert_false(world_may_rest(w));
  world_close(w);
  s.body[0].omega[2] = 0.0;
  s.load[0].kind = SPEC_SPRING;
  s.load[0].anchor_vel[0] = 1e-3;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  assert_false(world_may_rest(w));
  world_close(w);
  spec_free(&s);
}

/* A spring with a damper between two spinning bodies: internal, so momenta stay. */
static void pair_spring_keeps_momenta(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  spec_load *l;
  start(&s, 3);
  add_body(&s, "a", 0, 0, 0)->omega[1] = 2.0;
  add_body(&s, "b", 1, 0.2, 0)->vel[2] = 0.5;
  check_ok(spec_add_load(&s, &l, &err), &err);
  l->kind = SPEC_SPRING_PAIR;
  l->other = 1;
  l->k = 20.0;
  l->c = 0.5;
  l->rest = 0.7;
  l->offset[1] = 0.1;
  l->other_offset[2] = -0.1;
  check_ok(world_open(&w, &s, ~(unsigned)EFFECT_CONTACT, &err), &err);
  double p0[3], p1[3], L0[3], L1[3];
  world_momentum(w, p0);
  world_angular_momentum(w, L0);
  const double E0 = world_energy(w);
  free_steps(w, 1e-4, 5000);
  world_momentum(w, p1);
  world_angular_momentum(w, L1);
  for (int k = 0; k < 3; k++) {
    check_close(p1[k], p0[k], 1e-12);
    check_close(L1[k], L0[k], 1e-3); /* first order in h: I(q) against I(q+) */
  }
  assert_true(world_energy(w) < E0); /* the damper took some */
  world_close(w);
  spec_free(&s);
}

/* ---- joints ----------------------------------------------------------------------------------- */

static const spec_joint_kind joint_kinds[] = {SPEC_BALL, SPEC_HINGE, SPEC_SLIDER, SPEC_FIXED,
                                              SPEC_DISTANCE};

static void two_jointed_bodies(scene_spec *s, int dim, spec_joint_kind kind, bool to_world) {
  spec_joint *j;
  start(s, dim);
  s->effects = 0;
  spec_body *a = add_body(s, "a", 0, 0, 0);
  a->angle = 0.3;
  a->quat[0] = 0.8, a->quat[3] = 0.6;
  spec_body *b = add_body(s, "b", 1, 0.5, (dim == 3) ? 0.3 : 0.0);
  b->angle = -0.4;
  b->quat[0] = 0.6, b->quat[1] = 0.8;
  check_ok(spec_add_joint(s, "j", &j, &err), &err);
  j->kind = kind;
  j->body = 0;
  j->other = to_world ? -1 : 1;
  j->anchor[0] = 0.4;
  j->anchor[1] = 0.1;
  j->other_anchor[0] = 0.9;
  j->other_anchor[1] = 0.7;
  j->axis[0] = 1.0;
  j->axis[1] = 0.5;
}

static int expected_rows(int dim, spec_joint_kind kind) {
  switch (kind) {
  case SPEC_BALL:
    return dim;
  case SPEC_HINGE:
    return (dim == 2) ? 2 : 5;
  case SPEC_SLIDER:
    return (dim == 2) ? 2 : 5;
  case SPEC_FIXED:
    return (dim == 2) ? 3 : 6;
  case SPEC_DISTANCE:
    break;
  }
  return 1;
}

/* Row counts, zero error at the start, and d error/dt = J v. */
static void joint_errors_change_at_the_rate_of_their_rows(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(21);
  const unsigned effects = ~(unsigned)(EFFECT_CONTACT | EFFECT_GYROSCOPIC);
  for (int i = 0; i < 4 * BASE_COUNT(joint_kinds); i++) {
    const int dim = (i & 1) ? 3 : 2;
    const spec_joint_kind kind = joint_kinds[i / 4];
    scene_spec s;
    world *w;
    contact_set c;
    two_jointed_bodies(&s, dim, kind, (i & 2) != 0);
    check_ok(world_open(&w, &s, effects, &err), &err);
    const double h = 1e-6;
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    check_ok(contact_set_check(&c, &err), &err);
    assert_int_equal(c.n_group - c.n_contact, 1);
    assert_int_equal(c.n_row, expected_rows(dim, kind));
    double v[12], u[6];
    for (int k = 0; k < c.n_dof; k++) {
      v[k] = base_rng_between(&r, -1, 1);
    }
    contact_relative_velocity(&c, v, c.u_drift, u);
    for (int k = 0; k < c.n_row; k++) {
      check_close(c.joint_error[k], 0.0, 1e-15);
    }
    check_ok(world_advance(w, v, NULL, &err), &err);
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    for (int k = 0; k < c.n_row; k++) {
      check_close(c.joint_error[k] / h, u[k], 1e-5);
    }
    world_close(w);
    spec_free(&s);
  }
}

/* Rows that no dof can move are not posed; without the effect there are none at all. */
static void joints_pose_only_rows_that_dofs_can_move(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  two_jointed_bodies(&s, 2, SPEC_FIXED, false);
  check_ok(world_open(&w, &s, EFFECT_JOINTS, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_row, 2);
  world_close(w);
  check_ok(world_open(&w, &s, EFFECT_ROTATION, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_group, 0);
  assert_null(c.joint_error);
  world_close(w);
  s.joint[0].other = 0;
  assert_int_equal(world_open(&w, &s, EFFECT_JOINTS, &err), BASE_EINVAL);
  spec_free(&s);
}

/* ---- generalised coordinates ------------------------------------------------------------------ */

/* A bead of mass 2 on the parabola y = x^2 above the floor y = 0, q = x: M = 2 (1 + 4 x^2). */
static void bead_start(const void *p, double *q, double *v) {
  q[0] = *(const double *)p;
  v[0] = 0.0;
}

static void bead_mass(const void *p, const double *q, double *M) {
  (void)p;
  M[0] = 2.0 * (1.0 + 4.0 * q[0] * q[0]);
}

static void bead_force(const void *p, double t, const double *q, const double *v, double *f) {
  (void)p;
  (void)t;
  f[0] = -2.0 * 9.81 * 2.0 * q[0] - 8.0 * q[0] * v[0] * v[0];
}

static double bead_potential(const void *p, double t, const double *q) {
  (void)p;
  (void)t;
  return 2.0 * 9.81 * q[0] * q[0];
}

static void bead_contact(const void *p, int i, mech_contact *out) {
  (void)p;
  (void)i;
  *out = (mech_contact){.a = "bead", .b = "stop", .mu = 0.3, .restitution = 0.5};
}

static void bead_gap(const void *p, const double *q, int i, double *gap, double *jn, double *jt) {
  (void)p;
  (void)i;
  *gap = q[0];
  jn[0] = 1.0;
  jt[0] = 2.0 * q[0];
}

static const char *const bead_names[] = {"s"};
static const mech_model bead = {.name = "bead",
                                .dim = 2,
                                .n_dof = 1,
                                .n_contact = 1,
                                .dof_name = bead_names,
                                .start = bead_start,
                                .mass = bead_mass,
                                .force = bead_force,
                                .potential = bead_potential,
                                .contact = bead_contact,
                                .gap = bead_gap};

static void models_give_sets_energies_and_observables(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  start(&s, 2);
  s.model = &bead;
  s.model_param = malloc(sizeof(double));
  s.model_param_size = sizeof(double);
  *(double *)s.model_param = 0.5;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  const double E = world_energy(w);
  check_close(E, 2.0 * 9.81 * 0.25, 1e-14);
  check_ok(world_contacts(w, 1e-4, 1.0, &c, &err), &err);
  check_ok(contact_set_check(&c, &err), &err);
  assert_int_equal(c.n_contact, 1);
  assert_int_equal(c.n_row, 2);
  check_close(c.gap[0], 0.5, 0.0);
  check_close(c.restitution[0], 0.5, 0.0);
  check_close(c.inv_mass[0], 1.0 / 4.0, 1e-15);
  free_steps(w, 1e-4, 2000);
  check_close(world_energy(w) / E, 1.0, 1e-3);
  check_close(observe(w, "s.v"), world_max_speed(w) * (observe(w, "s.v") > 0 ? 1 : -1), 0.0);
  check_close(world_min_gap(w), observe(w, "s"), 0.0);
  const char *a, *b;
  world_contact_pair(w, c.id[0], &a, &b);
  assert_string_equal(a, "bead");
  world_close(w);
  check_ok(world_open(&w, &s, EFFECT_CONTACT, &err), &err); /* no friction: one row */
  check_ok(world_contacts(w, 1e-4, 1.0, &c, &err), &err);
  assert_int_equal(c.n_row, 1);
  assert_null(c.restitution);
  world_close(w);
  spec_free(&s);
}

/* A heavy body and a light one on a spring: the light end decides, wherever it stands; damping counts twice. */
static void springs_too_stiff_for_a_step_are_refused(void **state) {
  (void)state;
  for (int swap = 0; swap < 2; swap++) {
    scene_spec s;
    world *w;
    spec_load *l;
    contact_set c;
    start(&s, 2);
    add_body(&s, "a", 0, 0, 0)->mass = swap ? 1.0 : 1000.0;
    add_body(&s, "b", 1, 0, 0)->mass = swap ? 1000.0 : 1.0;
    check_ok(spec_add_load(&s, &l, &err), &err);
    l->kind = SPEC_SPRING_PAIR;
    l->other = 1;
    l->rest = 1.0;
    l->k = 100.0;
    l->c = 5.0;
    check_ok(world_open(&w, &s, ~(unsigned)EFFECT_CONTACT, &err), &err);
    check_ok(world_contacts(w, 0.12, -1.0, &c, &err), &err);                /* 1.44 + 1.2 < 4 */
    assert_int_equal(world_contacts(w, 0.17, -1.0, &c, &err), BASE_EINVAL); /* 2.89 + 1.7 */
    assert_non_null(strstr(err.text, "load 1: explicit spring"));
    world_close(w);
    spec_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(springs_too_stiff_for_a_step_are_refused),
      cmocka_unit_test(spring_oscillates_as_symplectic_euler_does),
      cmocka_unit_test(forces_follow_their_time_laws),
      cmocka_unit_test(pair_spring_keeps_momenta),
      cmocka_unit_test(joint_errors_change_at_the_rate_of_their_rows),
      cmocka_unit_test(joints_pose_only_rows_that_dofs_can_move),
      cmocka_unit_test(models_give_sets_energies_and_observables),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
