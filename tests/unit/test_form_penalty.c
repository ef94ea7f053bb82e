/* Compliant contact: force laws against their formulas, a ball at rest and a bounce against what
 * Hertz's law gives in closed form. */
#include "tests/support/check.h"

#include "formulations/formulation.h"
#include "formulations/penalty_law.h"

#include <string.h>

static void laws_give_their_formulas(void **state) {
  (void)state;
  const double K = 2.5e6, d = 3e-4, v = 0.7;
  double x = penalty_damping(PENALTY_HERTZ, 0.5);
  check_close(penalty_normal_force(PENALTY_HERTZ, K, 0, x, 1, d, v), K * pow(d, 1.5), 1e-12);
  check_close(penalty_normal_force(PENALTY_KELVIN_VOIGT, K, 40, 0, 1, d, v), K * d + 28.0, 1e-9);
  x = penalty_damping(PENALTY_HUNT_CROSSLEY, 0.8);
  check_close(penalty_normal_force(PENALTY_HUNT_CROSSLEY, K, 0, x, 2.0, d, v),
              K * pow(d, 1.5) * (1 + 1.5 * 0.2 * 0.35), 1e-12);
  x = penalty_damping(PENALTY_LANKARANI_NIKRAVESH, 0.8);
  check_close(penalty_normal_force(PENALTY_LANKARANI_NIKRAVESH, K, 0, x, 2.0, d, v),
              K * pow(d, 1.5) * (1 + 0.75 * 0.36 * 0.35), 1e-12);
  check_close(penalty_normal_force(PENALTY_KELVIN_VOIGT, K, 1e6, 0, 1, d, -v), 0.0, 0.0);
}

static void friction_stays_below_coulomb(void **state) {
  (void)state;
  const double u[2] = {0.3, -0.4};
  double f[2] = {0, 0};
  penalty_friction(0.5, 20.0, 1e-3, 2, u, f);
  const double size = hypot(f[0], f[1]);
  assert_true(size < 10.0);
  check_close(size, 10.0 / sqrt(1 + 1e-6 / 0.25), 1e-12);
  check_close(f[0] / f[1], u[0] / u[1], 1e-12);
}

/* A ball of radius 0.1 m and 1 kg dropped with its lowest point 0.05 m above the floor. */
static void ball_spec(scene_spec *s, double e) {
  base_error err = {0};
  spec_body *b;
  const double up[3] = {0, 1, 0};
  spec_static *floor;
  spec_init(s);
  s->dim = 2;
  s->gravity[1] = -9.81;
  s->duration = 1.0;
  check_ok(spec_add_body(s, "ball", &b, &err), &err);
  b->shape = (spec_shape){.kind = SPEC_SPHERE, .r = 0.1};
  b->mass = 1.0;
  b->inertia[0] = 0.005;
  b->pos[1] = 0.15;
  check_ok(spec_add_static(s, "floor", up, 0.0, &floor, &err), &err);
  s->restitution.dflt = e;
  check_ok(spec_check_all(s, &err), &err);
}

typedef struct fixture {
  scene_spec spec;
  world *w;
  formulation_run *run;
  unsigned char opt[256];
} fixture;

static void open_ball(fixture *x, double e, const char *options) {
  base_error err = {0};
  const formulation *f = formulation_find("penalty");
  assert_non_null(f);
  assert_true(f->options_size <= sizeof x->opt);
  ball_spec(&x->spec, e);
  check_ok(world_open(&x->w, &x->spec, x->spec.effects, &err), &err);
  base_fields_default(f->fields, f->n_fields, x->opt);
  check_ok(base_fields_parse(f->fields, f->n_fields, x->opt, options, &err), &err);
  check_ok(formulation_open(&x->run, f, x->opt, &err), &err);
}

static void close_ball(fixture *x) {
  formulation_close(x->run);
  world_close(x->w);
  spec_free(&x->spec);
}

static formulation_answer advance(fixture *x, double h, int steps) {
  base_error err = {0};
  formulation_answer a = {0};
  for (int i = 0; i < steps; i++) {
    check_ok(formulation_step(x->run, x->w, h, NULL, &a, &err), &err);
  }
  return a;
}

/* Elastic Hertz contact: the energy is the invariant, the deepest point solves
 * 0.4 K d^2.5 = m g (H + d). */
static void hertz_bounce_keeps_energy(void **state) {
  (void)state;
  fixture x;
  open_ball(&x, 1.0, "law=hertz,stiffness=1e6,integrator=rk8pd,rtol=1e-10,atol=1e-13");
  const double start = world_energy(x.w);
  double deepest = 0.0, worst = 0.0, y;
  for (int i = 0; i < 400; i++) {
    const formulation_answer a = advance(&x, 5e-4, 1);
    assert_true(world_observe(x.w, "ball.y", NULL, &y));
    deepest = fmax(deepest, 0.1 - y);
    worst = fmax(worst, fabs(world_energy(x.w) + a.spring_energy - start));
  }
  check_close(worst, 0.0, 2e-7);
  double d = 1e-3;
  for (int i = 0; i < 60; i++) {
    d = pow(9.81 * (0.05 + d) / 0.4e6, 0.4);
  }
  check_close(deepest, d, 2e-4 * d); /* sampled every 0.5 ms of a 5 ms contact */
  close_ball(&x);
}

/* At rest K d^1.5 = m g, and the impulse of a step is the weight times h. */
static void comes_to_rest_with_the_weight(void **state) {
  (void)state;
  fixture x;
  open_ball(&x, 0.3, "law=kelvin_voigt,stiffness=1e5,damping=400");
  const formulation_answer a = advance(&x, 0.01, 150);
  double y;
  assert_true(world_observe(x.w, "ball.y", NULL, &y));
  check_close(0.1 - y, 9.81 / 1e5, 1e-8);
  assert_int_equal(a.set->n_contact, 1);
  check_close(a.impulse[a.set->row_start[0]], 0.0981, 1e-6);
  assert_true(a.work.evaluations > 0);
  close_ball(&x);
}

/* A ball dropped without restitution stays on the floor; with e it leaves with e times the speed it came with, which the
 * height 0.05 e^2 shows. */
static void rebounds_by_restitution(void **state) {
  (void)state;
  const double restitution[] = {0.0, 0.3, 0.6, 0.9};
  for (int k = 0; k < 4; k++) {
    fixture x;
    open_ball(&x, restitution[k], "stiffness=1e10"); /* gravity does little in so short an impact */
    double highest = 0.0, y;
    (void)advance(&x, 1e-3, 103); /* it falls 0.101 s, and is in contact for less than 2 ms */
    for (int i = 0; i < 100; i++) {
      (void)advance(&x, 1e-3, 1);
      assert_true(world_observe(x.w, "ball.y", NULL, &y));
      highest = fmax(highest, y - 0.1);
    }
    const double e = fmax(restitution[k], 0.01);
    check_close(highest, 0.05 * e * e, 0.05 * 0.03 * e + 1e-5);
    close_ball(&x);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(laws_give_their_formulas),  cmocka_unit_test(friction_stays_below_coulomb),
      cmocka_unit_test(hertz_bounce_keeps_energy), cmocka_unit_test(comes_to_rest_with_the_weight),
      cmocka_unit_test(rebounds_by_restitution),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
