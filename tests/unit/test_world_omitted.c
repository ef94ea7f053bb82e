/* What effects that are left out would have done in a step, against closed forms. */
#include "problems/vec.h"
#include "tests/support/small_world.h"

#include <string.h>

static base_error err;
static const double g = SMALL_WORLD_GRAVITY, h = 0.01;

/* One step without `without` in which `share` of the weight goes to each contact with a normal row; tangents carry nothing. */
static void step_without(const scene_spec *s, unsigned without, const double *share,
                         double change[EFFECT_COUNT]) {
  world *w;
  contact_set c;
  const unsigned all = s->present;
  check_ok(world_open(&w, s, all & ~without, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  double impulse[64] = {0}, v[6] = {0};
  assert_true(c.n_row <= 64 && c.n_dof <= 6);
  for (int i = 0; i < c.n_contact; i++) {
    impulse[c.row_start[i]] = share[i] * s->body[0].mass * g * h;
  }
  memcpy(v, c.v, (size_t)c.n_dof * sizeof *v);
  world_growth grown[1];
  world_omitted(w, all, true, 0.0, v, impulse, change, grown);
  world_close(w);
}

static const double even[] = {0.25, 0.25, 0.25, 0.25}, pair[] = {0.5, 0.5};

static void a_box_at_rest_needs_nothing(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    double change[EFFECT_COUNT];
    box_on_floor(&s, dim, 0.0);
    check_ok(spec_check_all(&s, &err), &err);
    step_without(&s, EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_ROTATION | EFFECT_SPATIAL,
                 (dim == 2) ? pair : even, change);
    for (int e = 0; e < EFFECT_COUNT; e++) {
      check_close(change[e], 0.0, 1e-15);
    }
    spec_free(&s);
  }
}

/* Sliding: at most mu g h on the centre, and on a point at the corner what the moment about the centre adds. */
static void friction_left_out_is_bounded_by_the_weight(void **state) {
  (void)state;
  scene_spec s;
  double change[EFFECT_COUNT];
  box_on_floor(&s, 2, 3.0);
  check_ok(spec_check_all(&s, &err), &err);
  step_without(&s, EFFECT_FRICTION | EFFECT_ROTATION, pair, change);
  const double mu = 0.5, corner = 0.1 * sqrt(2.0);
  const double more = corner * corner * s.body[0].mass / s.body[0].inertia[0];
  check_close(change[EFFECT_FRICTION_BIT], mu * g * h * (1.0 + more), 1e-12);
  spec_free(&s);
  /* slower than what friction would take away: it stops, by so little that its feet can balance it */
  box_on_floor(&s, 2, 1e-4);
  check_ok(spec_check_all(&s, &err), &err);
  step_without(&s, EFFECT_FRICTION, pair, change);
  check_close(change[EFFECT_FRICTION_BIT], 2 * 1e-4, 1e-12);
  spec_free(&s);
}

/* What is left out changes a body's velocity and its turning, each by its own; up to the least it is none. */
static void the_least_is_none(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  double change[EFFECT_COUNT], impulse[4] = {0};
  const double v[3] = {3.0, 0.0, 1.0}, rub = 0.5 * g * h; /* mu and the weight, by the mass */
  box_on_floor(&s, 2, 3.0);
  s.body[0].omega[2] = v[2];
  check_ok(spec_check_all(&s, &err), &err);
  check_ok(world_open(&w, &s, s.present & ~(unsigned)EFFECT_FRICTION, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_int_equal(c.n_row, 2);
  impulse[0] = impulse[1] = 0.5 * s.body[0].mass * g * h;
  const double gyration = world_inertia_of(w, s.present, 0).gyration;
  const double spun = rub / (gyration * gyration);
  for (int k = 0; k < 2; k++) {
    world_growth grown;
    const double least = (rub + spun) * ((k == 0) ? 0.999 : 1.001);
    world_omitted(w, s.present, false, least, v, impulse, change, &grown);
    check_close(change[EFFECT_FRICTION_BIT], (k == 0) ? rub + spun : 0.0, 1e-12);
    check_close(grown.moved, (k == 0) ? rub : 0.0, 1e-12);
    check_close(grown.spun, (k == 0) ? spun : 0.0, 1e-12);
    assert_true(grown.turned && grown.pushed && grown.group == 0);
  }
  world_close(w);
  spec_free(&s);
}

/* A ball whose centre of mass is where its contact pushes past it: a moment, and no feet to share it. */
static void a_moment_needs_rotation(void **state) {
  (void)state;
  scene_spec s;
  double change[EFFECT_COUNT];
  box_on_floor(&s, 2, 0.0);
  check_ok(spec_check_all(&s, &err), &err);
  static const double one_side[] = {1.0, 0.0};
  step_without(&s, EFFECT_ROTATION, one_side, change);
  check_close(change[EFFECT_ROTATION_BIT], 0.0, 1e-15); /* two feet: they may share it */
  s.body[0].angle = 0.3;                                /* on one corner */
  s.body[0].pos[1] = 0.1 * (sin(0.3) + cos(0.3));
  static const double corner[] = {1.0};
  step_without(&s, EFFECT_ROTATION, corner, change);
  const double arm = 0.1 * (cos(0.3) - sin(0.3)), reach = 0.1 * sqrt(2.0);
  const double moment = s.body[0].mass * g * h * arm;
  check_close(change[EFFECT_ROTATION_BIT], moment * reach / s.body[0].inertia[0], 1e-12);
  spec_free(&s);
}

/* What friction and rolling did in a step in which they are simulated. */
static void what_acted_is_told(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  double impulse[8] = {0};
  world_growth grown[1] = {{.acted = 1.0, .held = 1.0}};
  spec_init(&s);
  s.dim = 2;
  s.gravity[1] = -g;
  s.duration = 1.0;
  s.friction.dflt = 0.5;
  s.rolling.dflt = 0.01;
  spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
  b->pos[1] = 0.1;
  add_floor(&s, 2);
  check_ok(spec_check_all(&s, &err), &err);
  check_ok(world_open(&w, &s, s.present, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_true(c.n_contact == 1 && c.rows[0].tangent == 1 && c.rows[0].rolling == 1);
  world_acted(w, impulse, grown);
  check_close(grown[0].acted, 0.0, 0.0);
  impulse[0] = 2.0, impulse[1] = -0.6, impulse[2] = 0.003;
  world_acted(w, impulse, grown);
  check_close(grown[0].acted, 0.6 / s.body[0].mass, 1e-15);
  check_close(grown[0].held, 0.003 * 0.1 / s.body[0].inertia[0], 1e-15);
  world_close(w);
  spec_free(&s);
}

/* Rolling that is left out may have shifted the load of a box that slides with friction, and so turned it; not that of a ball, and not
 * without friction. */
static void rolling_shifts_what_rubs(void **state) {
  (void)state;
  for (int k = 0; k < 3; k++) {
    scene_spec s;
    double change[EFFECT_COUNT];
    const double rolling = 1e-3;
    box_on_floor(&s, 3, 1.0);
    s.rolling.dflt = rolling;
    if (k == 1) {
      s.body[0].shape.kind = SPEC_SPHERE;
      s.body[0].shape.r = 0.1;
      s.body[0].inertia[0] = s.body[0].inertia[1] = s.body[0].inertia[2];
    }
    check_ok(spec_check_all(&s, &err), &err);
    const unsigned without = EFFECT_ROLLING | ((k == 2) ? EFFECT_FRICTION : 0u);
    step_without(&s, without, (k == 1) ? (double[]){1.0} : even, change);
    const double moment = rolling * 0.5 * s.body[0].mass * g * h, bound = 0.1 * sqrt(3.0);
    check_close(change[EFFECT_ROLLING_BIT], (k == 0) ? moment * bound / s.body[0].inertia[0] : 0.0,
                1e-15);
    spec_free(&s);
  }
}

/* Two cubes that push each other with 1 N s, side by side or one on the other, a step without rotation: `first` stands first in the scene;
 * speed along x, and `aside` of the back one along their face. What that may change of the velocity of either. */
static double taken_off(bool stacked, const char *first, const double speed[2], double aside,
                        double rough) {
  static const double push = 1.0;
  scene_spec s;
  world *w;
  contact_set c;
  world_growth grown[2];
  double change[EFFECT_COUNT], impulse[64] = {0}, v[6] = {0};
  spec_init(&s);
  s.dim = 3;
  s.duration = 1.0;
  s.gravity[2] = -g;
  s.friction.dflt = 0.1;
  for (int k = 0; k < 2; k++) {
    const bool front = (k == 0) == (strcmp(first, "front") == 0);
    spec_body *b = add_body(&s, front ? "front" : "back", SPEC_BOX, 0.1);
    b->pos[0] = (front && !stacked) ? 0.2 : 0.0;
    b->pos[2] = (front && stacked) ? 0.3 : 0.1;
    b->vel[0] = speed[front];
    b->vel[1] = front ? 0.0 : aside;
  }
  add_floor(&s, 3);
  check_ok(spec_add_pair(&s.friction, "front", "floor", rough, &err), &err);
  check_ok(spec_check_all(&s, &err), &err);
  check_ok(world_open(&w, &s, s.present & ~(unsigned)EFFECT_ROTATION, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_true(c.n_row <= 64 && c.n_dof == 6 && c.n_contact == (stacked ? 8 : 12));
  for (int i = 0; i < c.n_contact; i++) {
    impulse[c.row_start[i]] = push / 4.0;
  }
  memcpy(v, c.v, sizeof v);
  world_omitted(w, s.present, false, 0.0, v, impulse, change, grown);
  world_close(w);
  spec_free(&s);
  return change[EFFECT_ROTATION_BIT];
}

/* A face holds up to mu times what presses on it. By so much of its load friction on the floor is another where that is of another coefficient,
 * or direction, or where one of them does not slide. */
static void load_is_taken_off_by_a_face(void **state) {
  (void)state;
  static const double together[] = {1.0, 1.0}, apart[] = {1.0, -1.0}, one[] = {1.0, 0.0};
  static const double meeting[] = {2.0, 1.0}; /* and may part again, each by its own friction */
  const double held = 0.1 / 2.0;              /* over the mass */
  static const char *const first[] = {"front", "back"};
  for (int k = 0; k < 2; k++) {
    check_close(taken_off(false, first[k], together, 0.0, 0.5), held * 0.4, 1e-12);
    check_close(taken_off(false, first[k], apart, 0.0, 0.1), held * 0.2, 1e-12);
    check_close(taken_off(false, first[k], one, 0.0, 0.1), held * 0.1, 1e-12);
    check_close(taken_off(false, first[k], together, 0.0, 0.1), 0.0, 1e-15);
    check_close(taken_off(false, first[k], meeting, 0.0, 0.1), held * 0.1, 1e-12);
    check_close(taken_off(true, first[k], together, 0.0, 0.5), 0.0, 1e-15);
    /* The back one slides along the face, too: the friction of that on both, -0.1 and 0.1 along y, is 0.2 apart, and each of them is another than
     * that of the floor on the same body, which slides along (1, 1) and (1, 0). */
    const double side = 0.1 * (2.0 + sqrt(2.0 - sqrt(2.0)) + sqrt(2.0));
    check_close(taken_off(false, first[k], together, 1.0, 0.1), held * side, 1e-12);
  }
}

static void a_force_across_needs_space(void **state) {
  (void)state;
  scene_spec s;
  double change[EFFECT_COUNT];
  box_on_floor(&s, 3, 0.0);
  s.gravity[1] = 2.0;
  check_ok(spec_check_all(&s, &err), &err);
  step_without(&s, EFFECT_SPATIAL, even, change);
  check_close(change[EFFECT_SPATIAL_BIT], 2.0 * h, 1e-12);
  spec_free(&s);
}

static void an_impact_needs_restitution(void **state) {
  (void)state;
  scene_spec s;
  double change[EFFECT_COUNT];
  box_on_floor(&s, 2, 0.0);
  s.body[0].vel[1] = -2.0;
  check_ok(spec_check_all(&s, &err), &err);
  step_without(&s, EFFECT_RESTITUTION, pair, change);
  check_close(change[EFFECT_RESTITUTION_BIT], 2 * (0.4 * 2.0 * 2), 1e-12); /* both corners */
  spec_free(&s);
}

static void motion_at_the_start_is_seen(void **state) {
  (void)state;
  scene_spec s;
  box_on_floor(&s, 3, 1.0);
  check_ok(spec_check_all(&s, &err), &err);
  assert_int_equal(world_moved_by(&s, ~0u), 0);
  s.body[0].omega[1] = 1.0; /* in the plane of motion */
  assert_int_equal(world_moved_by(&s, ~0u), EFFECT_ROTATION);
  s.body[0].omega[0] = 1.0;
  assert_int_equal(world_moved_by(&s, ~0u), EFFECT_ROTATION | EFFECT_SPATIAL);
  s.body[0].omega[0] = s.body[0].omega[1] = 0.0;
  s.body[0].vel[1] = 1.0;
  assert_int_equal(world_moved_by(&s, ~0u), EFFECT_SPATIAL);
  assert_int_equal(world_moved_by(&s, EFFECT_FRICTION), 0);
  spec_free(&s);
}

/* Before a step is solved: what slides on one plane rubs, and what leans out of the plane is pushed out of it. */
static void some_of_it_is_foreseen(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  double change[EFFECT_COUNT];
  for (int k = 0; k < 4;
       k++) { /* at rest; sliding; sliding along a wall too; on a slope out of the plane */
    box_on_floor(&s, 3, (k == 1 || k == 2) ? 3.0 : 0.0);
    if (k == 2) {
      spec_static *wall;
      check_ok(spec_add_static(&s, "wall", (double[]){0, 1, 0}, -0.1, &wall, &err), &err);
    } else if (k == 3) {
      s.fixed[0].normal[1] = sin(0.2), s.fixed[0].normal[2] = cos(0.2);
      s.body[0].quat[0] = cos(0.1), s.body[0].quat[1] = -sin(0.1);
      s.body[0].pos[1] = 0.1 * sin(0.2), s.body[0].pos[2] = 0.1 * cos(0.2);
    }
    check_ok(spec_check_all(&s, &err), &err);
    check_ok(world_open(&w, &s, s.present & ~(unsigned)EFFECT_FRICTION, &err), &err);
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    assert_true(c.n_contact >= 4);
    world_growth grown = {0};
    world_foreseen(w, ~0u, change, &grown);
    const double slope = 0.5 * g * h * cos(0.2); /* mu g h cos, less than g h sin */
    const double rubs = (k == 1) ? 0.5 * g * h : (k == 3) ? fmin(slope, g * h * sin(0.2)) : 0.0;
    check_close(change[EFFECT_FRICTION_BIT], rubs, 1e-12);
    check_close(change[EFFECT_SPATIAL_BIT], (k == 3) ? g * h * cos(0.2) : 0.0, 1e-12);
    check_close(grown.moved, change[EFFECT_FRICTION_BIT] + change[EFFECT_SPATIAL_BIT], 1e-12);
    check_close(grown.spun, 0.0, 0.0); /* nothing says that it turns */
    world_foreseen(w, EFFECT_SPATIAL, change, &grown);
    check_close(change[EFFECT_FRICTION_BIT], 0.0, 0.0);
    world_close(w);
    spec_free(&s);
  }
}

/* The bodies are where they were, with fewer axes and back; a step from there has the bits of a world that began so. */
static void effects_change_in_place(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  box_on_floor(&s, 3, 1.0);
  s.body[0].omega[1] = 2.0;
  check_ok(spec_check_all(&s, &err), &err);
  check_ok(world_open(&w, &s, s.present, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  check_ok(world_advance(w, (double[]){1, 0, 0, 0, 2, 0}, NULL, &err), &err);
  double before[3], after[3], quat[4], turned[4], velocity[3], omega[3];
  world_body_pose(w, 0, before, quat);
  check_ok(world_set_effects(w, s.present & ~(unsigned)(EFFECT_ROTATION | EFFECT_SPATIAL), &err),
           &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_int_equal(c.n_dof, 2);
  assert_int_equal(world_moves(w, EFFECT_ROTATION | EFFECT_SPATIAL, 1e-12), 0);
  check_ok(world_set_effects(w, s.present, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_int_equal(c.n_dof, 6);
  world_body_pose(w, 0, after, turned);
  world_body_velocity(w, 0, velocity, omega);
  assert_memory_equal(before, after, sizeof before);
  assert_memory_equal(quat, turned, sizeof quat);
  check_close(velocity[0], 1.0, 0.0);
  check_close(omega[1], 0.0, 0.0); /* stood still without rotation */
  check_close(world_time(w), h, 0.0);
  world_close(w);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box_at_rest_needs_nothing),
      cmocka_unit_test(friction_left_out_is_bounded_by_the_weight),
      cmocka_unit_test(the_least_is_none),
      cmocka_unit_test(a_moment_needs_rotation),
      cmocka_unit_test(what_acted_is_told),
      cmocka_unit_test(rolling_shifts_what_rubs),
      cmocka_unit_test(load_is_taken_off_by_a_face),
      cmocka_unit_test(a_force_across_needs_space),
      cmocka_unit_test(an_impact_needs_restitution),
      cmocka_unit_test(motion_at_the_start_is_seen),
      cmocka_unit_test(some_of_it_is_foreseen),
      cmocka_unit_test(effects_change_in_place),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
