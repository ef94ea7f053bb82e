/* What a step makes of bodies that are not where they should be, against closed forms. */
#include "problems/vec.h"
#include "tests/support/small_world.h"

static base_error err;
static const double g = SMALL_WORLD_GRAVITY, h = 0.01;

/* What a step makes of deviations: of any body. */
typedef struct growth {
  bool shared, turned;
  double place, arm, speed, whirl;
} growth;

static growth of_all(const world_growth *grown, int n) {
  growth all = {0};
  for (int i = 0; i < n; i++) {
    all.shared = all.shared || grown[i].group != i;
    all.turned = all.turned || grown[i].turned;
    all.place = fmax(all.place, grown[i].place);
    all.arm = fmax(all.arm, grown[i].arm);
    all.speed = fmax(all.speed, grown[i].speed);
    all.whirl = fmax(all.whirl, grown[i].whirl);
  }
  return all;
}

/* One step without rotation, from rest; the normal impulses of contact i are those of `impulse`. */
static growth step_at_rest(const scene_spec *s, const double *normal, int n_contact, double *turn) {
  world *w;
  contact_set c;
  double impulse[64] = {0}, v[12] = {0}, change[EFFECT_COUNT];
  check_ok(world_open(&w, s, s->present & ~(unsigned)EFFECT_ROTATION, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_int_equal(c.n_contact, n_contact);
  assert_true(c.n_row <= 64 && c.n_dof <= 12);
  for (int i = 0; i < n_contact; i++) {
    impulse[c.row_start[i]] = normal[i];
  }
  world_growth grown[2];
  world_omitted(w, s->present, true, 0.0, v, impulse, change, grown);
  *turn = change[EFFECT_ROTATION_BIT];
  world_close(w);
  return of_all(grown, s->n_body);
}

static bool stays(growth grown) {
  return !grown.shared && !grown.turned;
}

/* A box on a box: the force between them goes through the centre of the upper one, which must be over their common face. */
static void boxes_on_each_other_stand_or_topple(void **state) {
  (void)state;
  static const double offset[] = {0.0, 0.05, 0.099, 0.101, 0.12};
  for (int dim = 2; dim <= 3; dim++) {
    for (int k = 0; k < 5; k++) {
      scene_spec s;
      double turn, normal[8];
      box_on_floor(&s, dim, 0.0);
      spec_body *upper = add_body(&s, "upper", SPEC_BOX, 0.1);
      upper->pos[0] = offset[k];
      upper->pos[dim - 1] = 0.3;
      check_ok(spec_check_all(&s, &err), &err);
      const int feet = (dim == 2) ? 2 : 4;
      for (int i = 0; i < 2 * feet; i++) { /* bodies come before planes */
        normal[i] = ((i < feet) ? 1.0 : 2.0) * s.body[0].mass * g * h / feet;
      }
      const growth grown = step_at_rest(&s, normal, 2 * feet, &turn);
      assert_true(grown.shared);
      assert_int_equal(grown.turned, k >= 2); /* at 0.099 it stands, but not firmly */
      assert_int_equal(grown.arm > 0.0, k >= 2);
      if (k < 3) {
        check_close(turn, 0.0, 1e-15);
      } else {
        assert_true(turn > 1e-3);
      }
      spec_free(&s);
    }
  }
}

/* A box in a corner, pushed into it, with a torque that its feet can balance and with one that they cannot. */
static void floor_and_wall_share(void **state) {
  (void)state;
  scene_spec s;
  double turn;
  spec_static *wall;
  box_on_floor(&s, 2, 0.0);
  s.gravity[0] = g;
  check_ok(spec_add_static(&s, "wall", (double[]){-1, 0, 0}, -0.1, &wall, &err), &err);
  check_ok(spec_check_all(&s, &err), &err);
  const double weight = s.body[0].mass * g * h;
  assert_true(stays(step_at_rest(&s, (double[]){weight, 0, 0, weight}, 4, &turn)));
  check_close(turn, 0.0, 1e-15);
  assert_true(stays(step_at_rest(&s, (double[]){0, weight, weight, 0}, 4, &turn)));
  check_close(turn, 0.0, 1e-15);
  /* a torque that feet of half a width can balance, firmly and not, and one that they cannot; the wall's have as much */
  spec_load *load;
  check_ok(spec_add_load(&s, &load, &err), &err);
  load->kind = SPEC_FORCE;
  load->body = 0;
  static const double share[] = {0.89, 0.99, 1.01};
  for (int k = 0; k < 3; k++) {
    load->torque[2] = share[k] * 2 * 0.1 * s.body[0].mass * g;
    check_ok(spec_check_all(&s, &err), &err);
    assert_int_equal(stays(step_at_rest(&s, (double[]){weight, 0, 0, weight}, 4, &turn)), k == 0);
    assert_int_equal(turn > 1e-12, k == 2);
  }
  spec_free(&s);
}

/* On a corner, its centre above it: no moment, but any deviation makes it fall. On its face none does. */
static void balanced_is_not_steady(void **state) {
  (void)state;
  scene_spec s;
  double turn;
  box_on_floor(&s, 2, 0.0);
  check_ok(spec_check_all(&s, &err), &err);
  const double weight = s.body[0].mass * g * h;
  assert_true(stays(step_at_rest(&s, (double[]){0.5 * weight, 0.5 * weight}, 2, &turn)));
  s.body[0].angle = atan(1.0);
  s.body[0].pos[1] = 0.1 * sqrt(2.0);
  check_ok(spec_check_all(&s, &err), &err);
  assert_false(stays(step_at_rest(&s, (double[]){weight}, 1, &turn)));
  check_close(turn, 0.0, 1e-12);
  spec_free(&s);
}

/* A step of one body without friction, and all else in, from its velocities to v; `normal` is the sum of its normal impulses. */
static void moves_on(scene_spec *s, const double *v, double normal, double place, bool *alike,
                     growth *grown) {
  world *w;
  contact_set c;
  double impulse[64] = {0}, change[EFFECT_COUNT];
  check_ok(spec_check_all(s, &err), &err);
  check_ok(world_open(&w, s, s->present & ~(unsigned)EFFECT_FRICTION, &err), &err);
  check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
  assert_true(c.n_row <= 64);
  for (int i = 0; i < c.n_contact; i++) {
    impulse[c.row_start[i]] = normal / c.n_contact;
  }
  world_growth one[1];
  world_omitted(w, s->present, true, 0.0, v, impulse, change, one);
  const world_growth none = {0}; /* what the step left out is not what is asked about */
  *alike = world_contacts_alike(w, v, impulse, &(world_deviation){1e-9, place}, &none);
  *grown = of_all(one, 1);
  world_close(w);
}

/* With rotation in: what stands firmly, flies or is round keeps a deviation, what turns or is rubbed by much does not. */
static void deviations_keep_their_velocity(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    bool alike;
    growth grown;
    const double weight = 2.0 * g * h;
    for (int k = 0; k < 4; k++) { /* it stands; it slides, rough; in the air; there, turning */
      box_on_floor(&s, dim, (k == 1) ? 1.0 : 0.0);
      s.friction.dflt = (k == 0) ? 1e-6 : 0.5;
      s.body[0].pos[dim - 1] += (k >= 2) ? 1.0 : 0.0;
      s.body[0].omega[2] = (k == 3) ? 1e-3 : 0.0;
      double v[6] = {(k == 1) ? 1.0 : 0.0};
      v[(dim == 2) ? 2 : 5] = s.body[0].omega[2];
      moves_on(&s, v, (k < 2) ? weight : 0.0, 1e-9, &alike, &grown);
      assert_false(grown.shared);
      assert_int_equal(!grown.turned, k == 0 || k == 2);
      /* rubbed by much it may fall over, at the rate sqrt(g / size); what turns in the air keeps its turning, in the plane at least */
      const double size = 0.1 * sqrt((double)dim), unlike = 0.5 / 0.3 - 1.0;
      const double turns = (k == 3 && dim == 3) ? h * 1e-3 * unlike : 0.0;
      check_close(grown.arm, (k == 1) ? h * g / size : 0.0, 1e-12);
      check_close(grown.place, 0.0, 1e-15); /* a plane's normal does not turn */
      check_close(grown.speed, turns, 1e-15);
      check_close(grown.whirl, 2.0 * turns * 1e-3, 1e-15);
      assert_true(alike);
      spec_free(&s);
    }
    /* a ball rolls on one foot */
    spec_init(&s);
    s.dim = dim;
    s.gravity[dim - 1] = -g;
    s.duration = 1.0;
    s.friction.dflt = 0.5;
    spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
    b->inertia[0] = b->inertia[1] = b->inertia[2];
    b->pos[dim - 1] = 0.1;
    b->omega[dim == 2 ? 2 : 1] = 3.0;
    add_floor(&s, dim);
    double v[6] = {0};
    v[dim == 2 ? 2 : 4] = 3.0;
    moves_on(&s, v, weight, 1e-9, &alike, &grown);
    assert_false(grown.shared || grown.turned || grown.place > 0.0 || grown.speed > 0.0);
    spec_free(&s);
  }
}

/* A box that falls flat: the contact is hit whatever the deviation is, where it is deep enough in, and far from where it would not bounce. */
static void impacts_are_alike_or_not(void **state) {
  (void)state;
  static const struct {
    double down, e, in, place;
    bool alike;
  } cases[] = {
      {1.0, 0.0, 1e-3, 1e-9, true}, /* deep */
      {1.0, 0.0, 1e-3, 2e-3, false},
      {1.0, 0.5, 1e-3, 1e-9, true}, /* ten steps of load: it bounces */
      {0.2, 0.5, 1e-3, 1e-9, false},
      {0.05, 0.5, 1e-4, 1e-9, true},    /* half of one: it rests */
      {0.05, 0.5, 1e-3, 1e-9, true},    /* was closed a step before, and with any deviation */
      {0.05, 0.5, 5.0e-4, 1e-9, false}, /* was as good as closed */
  };
  for (int k = 0; k < (int)(sizeof cases / sizeof *cases); k++) {
    scene_spec s;
    bool alike;
    growth grown;
    box_on_floor(&s, 2, 0.0);
    s.friction.dflt = 1e-9;
    s.restitution.dflt = cases[k].e;
    s.body[0].pos[1] = 0.1 - cases[k].in;
    s.body[0].vel[1] = -cases[k].down;
    const double up = (cases[k].down > 0.1) ? cases[k].e * cases[k].down : 0.0;
    const double v[3] = {0.0, up, 0.0};
    moves_on(&s, v, 2.0 * (cases[k].down + up + g * h), cases[k].place, &alike, &grown);
    assert_false(grown.shared || grown.turned);
    assert_int_equal(alike, cases[k].alike);
    spec_free(&s);
  }
}

/* In the air, a ball meets a box's face, or a ball: the face's normal stays as it is, that of two balls turns with their places. */
static void a_face_that_does_not_turn_keeps_its_normal(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    for (int k = 0; k < 2; k++) {
      scene_spec s;
      world *w;
      contact_set c;
      double impulse[64] = {0}, change[EFFECT_COUNT];
      const double v[12] = {0};
      spec_init(&s);
      s.dim = dim;
      s.duration = 1.0;
      s.friction.dflt = 1e-6;
      spec_body *one = add_body(&s, "one", (k == 0) ? SPEC_BOX : SPEC_SPHERE, 0.1);
      one->inertia[0] = one->inertia[1] = one->inertia[2];
      spec_body *ball = add_body(&s, "ball", SPEC_SPHERE, 0.1);
      ball->inertia[0] = ball->inertia[1] = ball->inertia[2];
      ball->pos[0] = 0.2;
      check_ok(spec_check_all(&s, &err), &err);
      check_ok(world_open(&w, &s, s.present & ~(unsigned)EFFECT_FRICTION, &err), &err);
      check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
      assert_int_equal(c.n_contact, 1);
      impulse[0] = 0.5;
      world_growth each[2];
      world_omitted(w, s.present, true, 0.0, v, impulse, change, each);
      const growth grown = of_all(each, 2);
      assert_true(grown.shared);
      assert_int_equal(grown.turned, k == 0); /* nothing keeps the box from turning */
      check_close(grown.arm, 0.5 / (2.0 * world_size(w)), 1e-12);
      assert_int_equal(grown.place > 0.0, k == 1);
      world_close(w);
      spec_free(&s);
    }
  }
}

/* The same ball on the side of a box that stands: firmly, and its normal stays, so that no place matters. */
static void a_ball_that_meets_a_box_that_stands_passes_its_speed_on(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    for (int k = 0; k < 2; k++) { /* beside its middle; at its upper edge, hard */
      scene_spec s;
      double turn, normal[6];
      const int feet = (dim == 2) ? 2 : 4;
      box_on_floor(&s, dim, 0.0);
      s.friction.dflt = 1e-9;
      spec_body *ball = add_body(&s, "ball", SPEC_SPHERE, 0.05);
      ball->inertia[0] = ball->inertia[1] = ball->inertia[2];
      ball->pos[0] = 0.15;
      ball->pos[dim - 1] = (k == 0) ? 0.1 : 0.19;
      check_ok(spec_check_all(&s, &err), &err);
      normal[0] = (k == 0) ? 0.1 : 10.0;
      for (int i = 1; i <= feet; i++) {
        normal[i] = s.body[0].mass * g * h / feet;
      }
      const growth grown = step_at_rest(&s, normal, 1 + feet, &turn);
      assert_true(grown.shared);
      assert_int_equal(grown.turned, k == 1);
      assert_int_equal(grown.arm > 0.0, k == 1);
      spec_free(&s);
    }
  }
}

/* Feet hold a body up, and do not keep it from turning about their normal: one that lies on a floor may spin there, and no deviation grows
 * by it. Its friction turns it then; one that slides is pushed at its centre, or aside of it where something lies on it aside. */
static void what_lies_may_spin(void **state) {
  (void)state;
  static const struct {
    double spin, aside;
    bool loaded;
  } cases[] = {{0.0, 0.0, false}, {1.0, 0.0, false}, {0.0, 0.0, true}, {0.0, 0.06, true}};
  for (int k = 0; k < (int)(sizeof cases / sizeof *cases); k++) {
    scene_spec s;
    world *w;
    contact_set c;
    world_growth grown[2];
    double impulse[64] = {0}, change[EFFECT_COUNT];
    const double v[12] = {1.0, 0.0, 0.0, 0.0, 0.0, cases[k].spin, 1.0}, edge = 0.1;
    box_on_floor(&s, 3, 1.0);
    s.friction.dflt = 1e-6;
    s.body[0].omega[2] = cases[k].spin;
    if (cases[k].loaded) {
      spec_body *upper = add_body(&s, "upper", SPEC_BOX, 0.02);
      upper->pos[1] = cases[k].aside;
      upper->pos[2] = 2.0 * edge + 0.02;
      upper->vel[0] = 1.0;
    }
    check_ok(spec_check_all(&s, &err), &err);
    check_ok(world_open(&w, &s, s.present & ~(unsigned)EFFECT_FRICTION, &err), &err);
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    assert_int_equal(c.n_contact, cases[k].loaded ? 8 : 4);
    const double weight = s.body[0].mass * g * h;
    const double load = cases[k].loaded ? s.body[1].mass * g * h : 0.0;
    for (int i = 0; i < c.n_contact; i++) {
      const double y = c.jac[c.jac_start[i] + 3]; /* of its place, from the centre */
      const double foot = weight + load + load * cases[k].aside * y / (edge * edge);
      impulse[c.row_start[i]] = 0.25 * (c.body[2 * i + 1] < 0 ? foot : load);
    }
    world_omitted(w, s.present, false, 0.0, v, impulse, change, grown);
    const double rub = s.friction.dflt * (weight + load), bound = edge * sqrt(3.0);
    const double moment =
        (cases[k].spin > 0.0) ? rub * bound : s.friction.dflt * load * cases[k].aside;
    assert_false(grown[0].turned || grown[0].arm > 0.0 || grown[0].speed > 0.0);
    assert_int_equal(grown[0].floor >= 0, !cases[k].loaded);
    check_close(grown[0].moved, rub / s.body[0].mass, 1e-15);
    check_close(grown[0].spun, moment * bound / s.body[0].inertia[0], 1e-15);
    world_close(w);
    spec_free(&s);
  }
}

/* A contact that carries and stays closed is closed for a deviation too only while loads press it. */
static void what_nothing_presses_does_not_rest(void **state) {
  (void)state;
  for (int k = 0; k < 3; k++) { /* its weight; without gravity a push by another; idle there */
    scene_spec s;
    bool alike;
    growth grown;
    box_on_floor(&s, 2, 0.0);
    s.gravity[1] = (k == 0) ? -g : 0.0;
    s.friction.dflt = 1e-9;
    s.restitution.dflt = 0.0;
    const double weight = 2.0 * g * h;
    moves_on(&s, (const double[3]){0}, (k < 2) ? weight : 0.0, 1e-9, &alike, &grown);
    assert_int_equal(alike, k != 1);
    spec_free(&s);
  }
}

/* What hangs on a joint goes with its place at the rate sqrt(g / size), and turning with w at w more; without gravity at w alone. */
static void joints_go_with_places(void **state) {
  (void)state;
  for (int k = 0; k < 2; k++) {
    scene_spec s;
    world *w;
    contact_set c;
    double impulse[64] = {0}, v[3] = {0}, change[EFFECT_COUNT];
    spec_joint *j;
    spec_init(&s);
    s.dim = 2;
    s.gravity[1] = (k == 0) ? -g : 0.0;
    s.duration = 1.0;
    add_body(&s, "bob", SPEC_BOX, 0.1)->omega[2] = v[2] = 2.0;
    check_ok(spec_add_joint(&s, "pin", &j, &err), &err);
    j->kind = SPEC_BALL;
    j->other = -1;
    check_ok(spec_check_all(&s, &err), &err);
    check_ok(world_open(&w, &s, s.present, &err), &err);
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    assert_true(c.n_row <= 64);
    world_growth grown;
    world_omitted(w, s.present, true, 0.0, v, impulse, change, &grown);
    assert_true(grown.pushed && grown.turned);
    const double falls = (k == 0) ? g / world_size(w) : 0.0;
    check_close(grown.place, h * (falls + 2.0 * 2.0), 1e-12);
    check_close(grown.arm, grown.place, 0.0);
    const world_inertia of = world_inertia_of(w, s.present, 0);
    check_close(of.mass, 2.0, 1e-12);
    check_close(of.bound, world_size(w), 1e-12);
    check_close(of.gyration * of.bound, sqrt(s.body[0].inertia[0] / 2.0), 1e-12);
    check_close(world_inertia_of(w, 0, 0).gyration, 0.0, 0.0); /* without rotation */
    world_close(w);
    spec_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(boxes_on_each_other_stand_or_topple),
      cmocka_unit_test(floor_and_wall_share),
      cmocka_unit_test(balanced_is_not_steady),
      cmocka_unit_test(deviations_keep_their_velocity),
      cmocka_unit_test(impacts_are_alike_or_not),
      cmocka_unit_test(a_face_that_does_not_turn_keeps_its_normal),
      cmocka_unit_test(a_ball_that_meets_a_box_that_stands_passes_its_speed_on),
      cmocka_unit_test(what_lies_may_spin),
      cmocka_unit_test(what_nothing_presses_does_not_rest),
      cmocka_unit_test(joints_go_with_places),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
