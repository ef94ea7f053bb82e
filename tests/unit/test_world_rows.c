/* Rows of a contact set: momentum through them, drift of driven bodies and belts, which pairs and pieces have them. */
#include "problems/vec.h"
#include "tests/support/contact_velocity.h"
#include "tests/support/small_world.h"

#include <string.h>

static base_error err;

/* As far out as the contacts are, on whatever axis. */
static void noise_is_what_rounding_leaves_of_positions(void **state) {
  (void)state;
  for (int axis = 0; axis < 3; axis++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_init(&s);
    s.dim = 3;
    s.duration = 1.0;
    add_body(&s, "a", SPEC_SPHERE, 0.1)->pos[axis] = -64.0;
    add_body(&s, "b", SPEC_SPHERE, 0.1)->pos[axis] = -64.2;
    add_body(&s, "far from all", SPEC_SPHERE, 0.1)->pos[axis] = 1e6;
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
    assert_int_equal(c.n_contact, 1);
    check_close(c.noise / (64.1 * 0x1p-51), 1, 1e-9);
    assert_true(fabs(c.gap[0]) <= c.noise && c.noise < c.tol);
    world_close(w);
    spec_free(&s);
  }
}

static void two_bodies_exchange_momentum_through_rows(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_init(&s);
    s.dim = dim;
    s.duration = 1.0;
    s.friction.dflt = 0.5;
    add_body(&s, "a", SPEC_SPHERE, 0.1)->vel[0] = 1.0;
    spec_body *b = add_body(&s, "b", SPEC_SPHERE, 0.2);
    b->pos[0] = 0.25;
    b->pos[1] = 0.1;
    b->mass = 3.0;
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
    assert_int_equal(c.n_contact, 1);
    check_close(c.gap[0], hypot(0.25, 0.1) - 0.3, 1e-15);
    check_close(c.frame[0], -0.25 / hypot(0.25, 0.1), 1e-15); /* from b to a */
    check_close(c.gap[0], world_min_gap(w), 0.0);
    double impulse[3] = {0.7, 0.2, (dim == 3) ? -0.1 : 0.0}, v[12], scratch[12], p[3], L[3], L0[3];
    world_angular_momentum(w, L0);
    contact_velocity(&c, impulse, v, scratch);
    check_ok(world_advance(w, v, impulse, &err), &err);
    world_momentum(w, p);
    world_angular_momentum(w, L);
    check_close(p[0], 2.0, 1e-14);
    check_close(p[1], 0.0, 1e-14);
    double f[3];
    world_contact_force(w, 0, f);
    check_close(v3_dot(f, f), v3_dot(impulse, impulse) / 1e-4, 1e-9);
    if (dim == 2) { /* in space I(q+) differs from I(q) by O(h) */
      check_close(L[2], L0[2], 1e-14);
    }
    const char *na, *nb;
    world_contact_pair(w, c.id[0], &na, &nb);
    assert_string_equal(na, "a");
    assert_string_equal(nb, "b");
    world_close(w);
    spec_free(&s);
  }
}

/* Its arm lies along the normal, to the last bit of zero: velocities that a row does not see are none of a system's. */
static void a_normal_does_not_turn_a_ball(void **state) {
  (void)state;
  for (int kind = 0; kind < 2; kind++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_init(&s);
    s.dim = 3;
    s.duration = 1.0;
    s.friction.dflt = 0.5;
    static const double away[3] = {0.1234567, -0.0777, 0.2}, pos[3] = {12.3, -4.56, 7.89};
    const double far = v3_norm(away);
    v3_copy(pos, add_body(&s, "a", SPEC_SPHERE, 0.6 * far)->pos);
    v3_add_scaled(pos, 1.0, away,
                  add_body(&s, "b", (kind == 0) ? SPEC_SPHERE : SPEC_BOX, 0.4 * far)->pos);
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    check_ok(world_contacts(w, 0.01, 1.0, &c, &err), &err);
    assert_true(c.n_contact >= 1);
    for (int i = 0; i < c.n_contact; i++) {
      const double *first = c.jac + c.jac_start[i], *second = first + 6 * 3;
      for (int k = 3; k < 6; k++) {
        assert_true(first[k] == 0.0);
        assert_true(kind == 1 || second[k] == 0.0);
      }
      assert_true(v3_norm(first + 9) > 0.5 * 0.6 * far); /* friction does */
      assert_true(kind == 0 || v3_norm(second + 3) > 0.0);
    }
    world_close(w);
    spec_free(&s);
  }
}

static void drift_carries_kinematic_and_belt_motion(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = 2;
  s.duration = 1.0;
  s.friction.dflt = 0.5;
  spec_body *table = add_body(&s, "table", SPEC_BOX, 0.5);
  table->kinematic = true;
  table->vel[0] = 1.0;
  table->acc[0] = 2.0;
  spec_body *block = add_body(&s, "block", SPEC_BOX, 0.1);
  block->pos[1] = 0.6;
  add_floor(&s, 2);
  s.fixed[0].offset = -0.5;
  s.fixed[0].surface_velocity[0] = 3.0;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_dof, 3);
  assert_int_equal(c.n_contact, 2); /* the table has no dof: its floor contacts are not posed */
  /* side 0 is the table: u_t = +-(1 + 2 h) at the end, +-1 before, along t = n turned */
  const double t = c.frame[3];
  check_close(c.u_drift[1], t * 1.02, 1e-15);
  check_close(c.u_before[1], t * 1.0, 1e-15);
  assert_int_equal(c.body[0], -1);
  assert_int_equal(c.body[1], 0);
  world_close(w);
  s.body[0].kinematic = false; /* now the floor's belt is felt */
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_contact, 4);
  int belts = 0;
  for (int i = 0; i < c.n_contact; i++) {
    belts += c.u_drift[c.row_start[i] + 1] == -3.0;
  }
  assert_int_equal(belts, 2);
  world_close(w);
  spec_free(&s);
}

/* A turning paddle and a body with one prescribed axis: their gap changes as J v + drift says. */
static void driven_rotation_enters_the_drift(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_init(&s);
    s.dim = dim;
    s.duration = 1.0;
    spec_body *paddle = add_body(&s, "paddle", SPEC_BOX, 0.5);
    paddle->kinematic = true;
    paddle->vel[1] = 0.2;
    paddle->omega[2] = 3.0;
    paddle->omega[0] = (dim == 3) ? 1.0 : 0.0;
    spec_body *ball = add_body(&s, "ball", SPEC_SPHERE, 0.1);
    ball->pos[0] = 0.3;
    ball->pos[1] = 0.65;
    ball->prescribed = SPEC_X;
    ball->prescribed_v0[0] = -0.4;
    ball->prescribed_a[0] = 2.0;
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    const double h = 1e-6;
    check_ok(world_contacts(w, h, 0.2, &c, &err), &err);
    assert_int_equal(c.n_contact, 1);
    assert_int_equal(c.n_dof, (dim == 2) ? 2 : 5);
    const double gap = c.gap[0], v[5] = {0.3, 0.1, 0.2, -0.1, 0.4};
    double u;
    contact_relative_velocity(&c, v, c.u_drift, &u);
    check_ok(world_advance(w, v, NULL, &err), &err);
    check_ok(world_contacts(w, h, 0.2, &c, &err), &err);
    check_close((c.gap[0] - gap) / h, u, 1e-5);
    check_close(observe(w, "ball.vx"), -0.4 + 2.0 * h, 1e-15);
    world_close(w);
    spec_free(&s);
  }
}

static void pairs_multiplicity_and_no_collision_are_honoured(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = 2;
  s.gravity[1] = -9.81;
  s.duration = 1.0;
  s.friction.dflt = 0.5;
  check_ok(spec_add_pair(&s.friction, "low", "floor", 0.0, &err), &err);
  add_body(&s, "low", SPEC_BOX, 0.1)->pos[1] = 0.1;
  add_body(&s, "high", SPEC_BOX, 0.1)->pos[1] = 0.3;
  add_floor(&s, 2);
  s.contact_multiplicity = 3;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_contact, 12);
  assert_int_equal(c.n_row, 6 * 2 + 6 * 1);
  check_ok(contact_set_check(&c, &err), &err);
  world_close(w);
  s.contact_multiplicity = 257;
  assert_int_equal(world_open(&w, &s, ~0u, &err), BASE_EINVAL);
  spec_free(&s);
}

/* A dumbbell of two spheres touches the floor with both pieces, at their own places. */
static void compounds_touch_with_every_piece(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = 3;
  s.duration = 1.0;
  spec_body *b = add_body(&s, "bell", SPEC_COMPOUND, 0.1);
  b->shape.n_part = 2;
  b->shape.part = calloc(2, sizeof *b->shape.part);
  for (int i = 0; i < 2; i++) {
    b->shape.part[i].shape.kind = SPEC_SPHERE;
    b->shape.part[i].shape.r = 0.1;
    b->shape.part[i].pos[0] = (i == 0) ? -0.5 : 0.5;
    b->shape.part[i].quat[0] = 1.0;
  }
  b->pos[2] = 0.1;
  b->quat[0] = b->quat[3] = sqrt(0.5); /* turned by 90 degrees about z */
  add_floor(&s, 3);
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  assert_int_equal(c.n_contact, 2);
  assert_true(c.id[0] != c.id[1]);
  for (int i = 0; i < 2; i++) {
    double x[3];
    world_contact_point(w, i, x);
    check_close(x[0], 0.0, 1e-15);
    check_close(x[1], (i == 0) ? -0.5 : 0.5, 1e-15);
    check_close(c.gap[i], 0.0, 1e-15);
  }
  world_close(w);
  spec_free(&s);
}

/* Contacts far beyond a body's own reach are not listed; what can be met within the step is. */
static void margin_follows_the_speeds(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = 2;
  s.duration = 1.0;
  spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
  b->pos[1] = 1.0;
  b->vel[1] = -50.0;
  add_floor(&s, 2);
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err); /* falls 0.5 m in the step */
  assert_int_equal(c.n_contact, 0);
  check_ok(world_contacts(w, 0.02, -1.0, &c, &err), &err); /* 1.0 m */
  assert_int_equal(c.n_contact, 1);
  check_ok(world_contacts(w, 0.01, 1.0, &c, &err), &err);
  assert_int_equal(c.n_contact, 1);
  world_close(w);
  spec_free(&s);
}

/* Motion in the x-z plane of space: friction acts in that plane, on a floor, a wall and a slope. */
static void tangents_of_plane_motion_lie_in_the_plane(void **state) {
  (void)state;
  static const double normal[][3] = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0.6, 0, -0.8}};
  for (int i = 0; i < BASE_COUNT(normal); i++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_static *wall;
    spec_init(&s);
    s.dim = 3;
    s.duration = 1.0;
    s.friction.dflt = 0.5;
    spec_body *ball = add_body(&s, "ball", SPEC_SPHERE, 0.1);
    v3_scale(0.1, normal[i], ball->pos);
    check_ok(spec_add_static(&s, "wall", normal[i], 0.0, &wall, &err), &err);
    check_ok(world_open(&w, &s, ~0u & ~(unsigned)EFFECT_SPATIAL, &err), &err);
    check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
    assert_int_equal(c.n_contact, 1);
    assert_int_equal(c.rows[0].tangent, 1);
    check_close(c.frame[3 + 1], 0.0, 1e-15);
    check_close(v3_dot(c.frame + 3, normal[i]), 0.0, 1e-15);
    check_close(v3_norm(c.frame + 3), 1.0, 1e-15);
    check_close(fabs(c.frame[6 + 1]), 1.0, 1e-15); /* about which it rolls */
    world_close(w);
    spec_free(&s);
  }
}

/* A box of edge 0.2 on its corner, which is `open` above the floor, turns about it and slips at `slip`. The corner's velocity changes by
 * omega^2 times the way to the centre of mass, along the normal, and where it holds along the floor. */
static void on_its_corner(double open, double slip, double normal, double tangent) {
  const double h = 1e-2;
  const double omega = 2.0;
  const double angle = 0.5;
  const double up[3] = {0.0, 1.0, 0.0};
  const double way[2] = {0.1 * (cos(angle) - sin(angle)), 0.1 * (sin(angle) + cos(angle))};
  scene_spec s;
  world *w;
  contact_set c;
  box_on_floor(&s, 2, 0.0);
  spec_body *b = &s.body[0];
  b->angle = angle;
  b->pos[1] = way[1] + open;
  b->vel[0] = slip - omega * way[1];
  b->vel[1] = omega * way[0];
  b->omega[2] = omega;
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  assert_true(world_turns(w, h));
  check_ok(world_contacts_turned(w, h, 0.05, &c, &err), &err);
  for (int i = 0; i < c.n_contact; i++) {
    const double *drift = c.u_drift + c.row_start[i];
    const double *to = c.frame + 9 * (ptrdiff_t)i + 3;
    if (fabs(c.gap[i] - open) < 1e-12) {
      const double change = h * omega * omega;
      check_close(drift[0], normal * change * way[1], 1e-7 * change);
      check_close(drift[1], tangent * change * way[0] * to[0], 1e-7 * change);
      const double arm = way[0];
      check_close(contact_mobility(&c, i, 0), 1.0 / b->mass + arm * arm / b->inertia[0], 1e-12);
      check_close(contact_coupling(&c, i, 0, i, 0), contact_mobility(&c, i, 0), 1e-15);
    }
    check_close(v3_dot(c.frame + 9 * (ptrdiff_t)i, up), 1.0, 1e-15);
    for (int k = 0; k < i; k++) {
      const double arms = c.jac[c.jac_start[i] + 2] * c.jac[c.jac_start[k] + 2];
      check_close(contact_coupling(&c, i, 0, k, 0), 1.0 / b->mass + arms / b->inertia[0], 1e-9);
      check_close(contact_coupling(&c, k, 0, i, 0), contact_coupling(&c, i, 0, k, 0), 1e-15);
    }
  }
  assert_true(c.n_contact > 0);
  world_close(w);
  spec_free(&s);
}

static void contacts_turn_within_a_step(void **state) {
  (void)state;
  on_its_corner(0.0, 0.0, 1.0, 1.0);
  on_its_corner(0.0, 1.0, 1.0, 0.0);
  on_its_corner(0.01, 0.0, 0.0, 0.0);
}

static void what_slides_on_a_face_does_not_turn(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  box_on_floor(&s, 3, 5.0);
  check_ok(world_open(&w, &s, ~0u, &err), &err);
  assert_false(world_turns(w, 1e-2));
  world_close(w);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(noise_is_what_rounding_leaves_of_positions),
      cmocka_unit_test(two_bodies_exchange_momentum_through_rows),
      cmocka_unit_test(a_normal_does_not_turn_a_ball),
      cmocka_unit_test(drift_carries_kinematic_and_belt_motion),
      cmocka_unit_test(driven_rotation_enters_the_drift),
      cmocka_unit_test(pairs_multiplicity_and_no_collision_are_honoured),
      cmocka_unit_test(compounds_touch_with_every_piece),
      cmocka_unit_test(margin_follows_the_speeds),
      cmocka_unit_test(tangents_of_plane_motion_lie_in_the_plane),
      cmocka_unit_test(contacts_turn_within_a_step),
      cmocka_unit_test(what_slides_on_a_face_does_not_turn),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
