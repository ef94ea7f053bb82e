/* How far a run may be off by what it left out, against closed forms. */
#include "tests/support/check.h"

#include "harness/control/deviation.h"

#include <string.h>

static base_error err;
static const deviation_scale scale = {.size = 0.5, .speed = 2.0, .fall = 4.0};

/* A box in the plane, one of four times its mass, a point. */
static const world_inertia box = {.mass = 1.0, .bound = 0.5, .gyration = 0.5};
static const world_inertia heavy = {.mass = 4.0, .bound = 0.5, .gyration = 0.5};
static const world_inertia point = {.mass = 1.0};

/* Enters n steps of h that are all like g, by friction. */
static void add(deviation *d, int n, double h, const world_growth *g) {
  double omitted[EFFECT_COUNT] = {0};
  for (int i = 0; i < d->n; i++) {
    omitted[EFFECT_FRICTION_BIT] = fmax(omitted[EFFECT_FRICTION_BIT], g[i].moved + g[i].spun);
  }
  for (int k = 0; k < n; k++) {
    deviation_add(d, &scale, omitted, g, h);
    assert_true(d->any);
  }
}

static deviation of_one(const world_inertia *of) {
  deviation d;
  check_ok(deviation_open(&d, 1, of, &err), &err);
  return d;
}

/* A constant change of velocity moves by a t^2 / 2; where places pull at bodies as gravity does on what falls over, by a (cosh(r t) - 1) / r^2;
 * a turning in space grows by itself. */
static void it_grows_as_what_slides_or_falls_over(void **state) {
  (void)state;
  const double a = 1e-3, h = 1e-5, r = 3.0, t = 1.0;
  const int n = 100000;
  deviation d = of_one(&box);
  add(&d, n, h, &(world_growth){.moved = a * h});
  check_close(d.body[0].v, a * t, 1e-9);
  check_close(d.body[0].x, 0.5 * a * t * t, 2e-5);
  check_close(d.body[0].w, 0.0, 0.0);
  deviation_clear(&d);
  assert_false(d.any);
  const double pull = h * r * r;
  const world_growth tips = {
      .moved = a * h, .place = pull, .arm = pull, .turned = true, .pushed = true};
  add(&d, n, h, &tips);
  check_close(d.body[0].v, a * sinh(r * t) / r, 1e-4);
  check_close(d.body[0].x, a * (cosh(r * t) - 1.0) / (r * r), 1e-4);
  check_close(d.body[0].w, d.body[0].v / box.gyration, 1e-12);
  deviation_clear(&d);
  add(&d, n, h, &(world_growth){.spun = a * h, .speed = h * r, .turned = true});
  check_close(d.body[0].w, a * (exp(r * t) - 1.0) / r, 1e-4);
  check_close(d.body[0].v, 0.0, 0.0);
  deviation_close(&d);
}

/* Euler's equations: a step of dt of the angular velocity w in the frame of a body of inertia I, and of its attitude q. */
static void turn_on(const double *I, double dt, double *w, double *q) {
  double at[7], rate[7], sum[7] = {0};
  static const double share[4] = {1.0, 2.0, 2.0, 1.0}, reach[4] = {0.0, 0.5, 0.5, 1.0};
  for (int k = 0; k < 4; k++) {
    for (int i = 0; i < 7; i++) {
      at[i] = ((i < 3) ? w[i] : q[i - 3]) + ((k > 0) ? reach[k] * dt * rate[i] : 0.0);
    }
    const double *p = at + 3;
    rate[0] = (I[1] - I[2]) * at[1] * at[2] / I[0];
    rate[1] = (I[2] - I[0]) * at[2] * at[0] / I[1];
    rate[2] = (I[0] - I[1]) * at[0] * at[1] / I[2];
    rate[3] = 0.5 * (-p[1] * at[0] - p[2] * at[1] - p[3] * at[2]);
    rate[4] = 0.5 * (p[0] * at[0] + p[2] * at[2] - p[3] * at[1]);
    rate[5] = 0.5 * (p[0] * at[1] + p[3] * at[0] - p[1] * at[2]);
    rate[6] = 0.5 * (p[0] * at[2] + p[1] * at[1] - p[2] * at[0]);
    for (int i = 0; i < 7; i++) {
      sum[i] += share[k] * dt / 6.0 * rate[i];
    }
  }
  for (int i = 0; i < 7; i++) {
    *((i < 3) ? &w[i] : &q[i - 3]) += sum[i];
  }
}

/* A body that turns freely about its middle axis, and one a little faster about another: the bound holds while the difference grows to a
 * hundred times what it was. */
static void it_grows_as_what_turns_over(void **state) {
  (void)state;
  static const double I[3] = {1.0, 1.3, 1.6}, spin = 5.0, off = 1e-7, dt = 1e-3;
  double w[2][3] = {{0.0, spin, 0.0}, {off, spin, -off}}, q[2][4] = {{1.0}, {1.0}};
  const world_inertia unit = {.mass = 1.0, .bound = 1.0, .gyration = 1.0};
  const double unlike = I[2] / I[0] - 1.0, speed = dt * spin * unlike;
  deviation d = of_one(&unit);
  add(&d, 1, 0.0, &(world_growth){.spun = off * sqrt(2.0), .turned = true});
  double truth = 0.0;
  for (int k = 0; k < 6000; k++) {
    turn_on(I, dt, w[0], q[0]);
    turn_on(I, dt, w[1], q[1]);
    add(&d, 1, dt, &(world_growth){.speed = speed, .whirl = 2.0 * speed * spin, .turned = true});
    double angle = 0.0;
    for (int i = 0; i < 4; i++) {
      angle += 4.0 * (q[0][i] - q[1][i]) * (q[0][i] - q[1][i]);
    }
    truth = sqrt(angle);
    assert_true(truth <= d.body[0].a);
  }
  assert_true(truth > 100.0 * off);
  deviation_close(&d);
}

/* What is foreseen from half of the way is what comes of the other half. */
static void the_end_is_that_of_going_on(void **state) {
  (void)state;
  const double a = 1e-3, h = 1e-5, r = 3.0;
  for (int k = 0; k < 2; k++) {
    deviation d = of_one(&point);
    const double pull = (k == 0) ? 0.0 : h * r * r;
    const world_growth g = {.moved = a * h, .place = pull, .arm = pull};
    add(&d, 50000, h, &g);
    check_close(d.body[0].grows, (k == 0) ? 0.0 : r, 1e-12);
    const deviation_forecast end = deviation_after(&d, 0, &scale, 0.5);
    check_close(end.now, fmax(d.body[0].v / scale.speed, d.body[0].x / scale.size), 1e-12);
    check_close(end.last, end.both, 1e-12);
    assert_true(end.free < end.both);
    add(&d, 50000, h, &g);
    const double there = fmax(d.body[0].v / scale.speed, d.body[0].x / scale.size);
    check_close(end.both / there, 1.0, 1e-4);
    deviation_close(&d);
  }
  /* nothing falls faster than the smallest body: an impact's growth is not that of the steps to come */
  deviation d = of_one(&box);
  add(&d, 1, h, &(world_growth){.moved = 1.0, .arm = 10.0});
  check_close(d.body[0].grows, scale.fall, 1e-12);
  assert_true(isfinite(deviation_after(&d, 0, &scale, 1e6).last));
  /* a turning counts as a velocity at the size, and as an angle */
  deviation_clear(&d);
  add(&d, 1, 0.1, &(world_growth){.spun = 1.0});
  const double turned = fmax(1.0 / box.bound * scale.size / scale.speed, 0.1 / box.bound);
  check_close(deviation_after(&d, 0, &scale, 0.0).now, turned, 1e-12);
  deviation_close(&d);
}

/* Bodies go on by themselves until one pushes the other: the energy of both may be in each then, and does not grow by pushing again. */
static void it_passes_on_by_energy(void **state) {
  (void)state;
  const world_inertia two[2] = {heavy, box};
  const world_growth apart[2] = {{.group = 0}, {.group = 1}}, push[2] = {{.group = 0}};
  world_growth rubs[2] = {{.group = 0, .moved = 1.0}, {.group = 1}};
  deviation d;
  check_ok(deviation_open(&d, 2, two, &err), &err);
  add(&d, 1, 0.0, rubs);
  add(&d, 3, 0.0, apart);
  check_close(d.body[0].v, 1.0, 1e-12);
  check_close(d.body[1].v, 0.0, 0.0);
  for (int k = 0; k < 5; k++) {
    add(&d, 1, 0.0, push);
    add(&d, 1, 0.0, apart);
    check_close(d.body[0].v, 1.0, 1e-12);
    check_close(d.body[1].v, 2.0, 1e-12); /* of a quarter of the mass */
    check_close(d.energy, 2.0, 1e-12);
  }
  rubs[0].moved = 0.5;
  add(&d, 1, 0.0, rubs);
  check_close(d.body[0].v, 1.5, 1e-12);
  check_close(d.body[1].v, 2.0, 1e-12); /* not its own */
  check_close(d.energy, 3.0, 1e-12);
  deviation_close(&d);
}

/* Of a ball a contact does not turn velocity into turning; of a box it may, both ways, and in flight it does not. */
static void what_may_turn_mixes(void **state) {
  (void)state;
  const struct {
    bool turned, pushed;
    double v, w;
  } cases[] = {
      {false, true, 1.0, 3.0},
      {true, false, 1.0, 3.0},
      {true, true, sqrt(1.0 + 1.5 * 1.5), sqrt(1.0 + 1.5 * 1.5) / 0.5},
  };
  for (int k = 0; k < (int)(sizeof cases / sizeof *cases); k++) {
    deviation d = of_one(&box);
    const world_growth g = {
        .moved = 1.0, .spun = 3.0, .turned = cases[k].turned, .pushed = cases[k].pushed};
    add(&d, 1, 0.1, &g);
    check_close(d.body[0].v, cases[k].v, 1e-12);
    check_close(d.body[0].w, cases[k].w, 1e-12);
    world_deviation at;
    deviation_points(&d, &at);
    check_close(at.speed, cases[k].v + cases[k].w, 1e-12);
    check_close(at.place, 0.1 * at.speed, 1e-12);
    deviation_close(&d);
  }
}

static void it_is_kept_and_told_by_effects(void **state) {
  (void)state;
  deviation d = of_one(&box), kept = of_one(&box);
  double omitted[EFFECT_COUNT] = {0};
  deviation_add(&d, &scale, omitted, &(world_growth){.place = 1.0}, 0.01);
  assert_false(d.any); /* of nothing nothing comes */
  omitted[EFFECT_FRICTION_BIT] = 1e-3;
  omitted[EFFECT_ROTATION_BIT] = 1.0;
  deviation_add(&d, &scale, omitted, &(world_growth){.moved = 1.0}, 0.01);
  assert_true(d.any);
  assert_int_equal(deviation_by(&d, 0.1), EFFECT_ROTATION);
  assert_int_equal(deviation_by(&d, 1e-4), EFFECT_ROTATION | EFFECT_FRICTION);
  deviation_copy(&kept, &d);
  deviation_clear(&d);
  assert_int_equal(deviation_by(&d, 0.1), 0);
  check_close(kept.body[0].v, 1.0, 0.0);
  memset(omitted, 0, sizeof omitted);
  deviation_add(&kept, &scale, omitted, &(world_growth){0}, 0.01); /* it stays off */
  check_close(kept.body[0].x, 0.02, 1e-12);
  deviation_close(&d);
  deviation_close(&kept);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_grows_as_what_slides_or_falls_over),
      cmocka_unit_test(it_grows_as_what_turns_over),
      cmocka_unit_test(the_end_is_that_of_going_on),
      cmocka_unit_test(it_passes_on_by_energy),
      cmocka_unit_test(what_may_turn_mixes),
      cmocka_unit_test(it_is_kept_and_told_by_effects),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
