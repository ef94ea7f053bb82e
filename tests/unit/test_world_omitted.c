/* What effects that are left out would have done in a step, against closed forms. */
#include "problems/vec.h"
#include "tests/support/small_world.h"

#include <string.h>

static base_error err;
static const double g = 9.81, h = 0.01;

/* A box of edge 0.2 and mass 1 on a floor, with a speed along x. */
static void box_on_floor(scene_spec *s, int dim, double speed) {
  spec_init(s);
  s->dim = dim;
  s->gravity[dim - 1] = -g;
  s->duration = 1.0;
  s->friction.dflt = 0.5;
  s->restitution.dflt = 0.4;
  spec_body *b = add_body(s, "box", SPEC_BOX, 0.1);
  b->pos[dim - 1] = 0.1;
  b->vel[0] = speed;
  add_floor(s, dim);
}

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
      cmocka_unit_test(boxes_on_each_other_stand_or_topple),
      cmocka_unit_test(floor_and_wall_share),
      cmocka_unit_test(balanced_is_not_steady),
      cmocka_unit_test(deviations_keep_their_velocity),
      cmocka_unit_test(impacts_are_alike_or_not),
      cmocka_unit_test(what_nothing_presses_does_not_rest),
      cmocka_unit_test(what_lies_may_spin),
      cmocka_unit_test(what_acted_is_told),
      cmocka_unit_test(rolling_shifts_what_rubs),
      cmocka_unit_test(joints_go_with_places),
      cmocka_unit_test(a_face_that_does_not_turn_keeps_its_normal),
      cmocka_unit_test(a_ball_that_meets_a_box_that_stands_passes_its_speed_on),
      cmocka_unit_test(a_force_across_needs_space),
      cmocka_unit_test(an_impact_needs_restitution),
      cmocka_unit_test(motion_at_the_start_is_seen),
      cmocka_unit_test(some_of_it_is_foreseen),
      cmocka_unit_test(effects_change_in_place),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
