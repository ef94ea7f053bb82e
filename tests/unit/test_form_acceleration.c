/* The acceleration-level problem of a sliding rod against the table of Painleve regimes: one number
 * p N + b, with one, none or two solutions (Painleve 1895; Baraff 1991). */
#include "tests/support/check.h"

#include "formulations/formulation.h"

#include <string.h>

typedef struct regime {
  double tan_theta, mu, omega, v_tip;
  double p, b; /* [1/kg], [m/s^2] */
} regime;

/* Uniform rod, half length 1 m, 1 kg, g = 9.81: p = 1 + 3 cos(t)(cos(t) - mu sin(t)) for v_tip < 0,
 * with + for v_tip > 0; b = omega^2 sin(t) - g. */
static const regime regimes[] = {
    {2.0, 1.0, 0.0, -1.0, 0.4, -9.81},
    {2.0, 2.0, 0.0, -1.0, -0.8, -9.81},
    {2.0, 2.0, 4.0, -1.0, -0.8, 4.500835055998653},
    {2.0, 1.0, 4.0, -1.0, 0.4, 4.500835055998653},
    {2.0, 2.0, 0.0, 1.0, 4.0, -9.81},
    {1.0, 1.5, 0.0, -1.0, 0.25, -9.81},
    {4.0, 2.0, 5.0, -1.0, -0.23529411764705882, 14.443562559},
};

static void rod_spec(scene_spec *s, const regime *r) {
  base_error err = {0};
  spec_body *b;
  spec_static *floor;
  const double up[3] = {0, 1, 0};
  const double angle = atan(r->tan_theta);
  spec_init(s);
  s->dim = 2;
  s->gravity[1] = -9.81;
  s->duration = 1.0;
  s->friction.dflt = r->mu;
  check_ok(spec_add_body(s, "rod", &b, &err), &err);
  b->shape = (spec_shape){.kind = SPEC_ROD, .half = {1.0}};
  b->mass = 1.0;
  b->inertia[0] = 1.0 / 3.0;
  b->angle = angle;
  b->pos[1] = sin(angle); /* the lower end touches */
  b->omega[2] = r->omega;
  /* tip at centre - (cos, sin): v_tip = v + omega (sin, -cos); no normal speed */
  b->vel[0] = r->v_tip - r->omega * sin(angle);
  b->vel[1] = r->omega * cos(angle);
  check_ok(spec_add_static(s, "floor", up, 0.0, &floor, &err), &err);
  check_ok(spec_check_all(s, &err), &err);
}

static void poses_the_number_of_the_table(void **state) {
  (void)state;
  const formulation *f = formulation_find("acceleration");
  assert_non_null(f);
  for (int i = 0; i < BASE_COUNT(regimes); i++) {
    base_error err = {0};
    scene_spec s;
    world *w;
    formulation_run *run;
    contact_set c;
    lcp_problem p;
    const double *z0, h = 1e-3;
    unsigned char opt[256] = {0};
    bool pending;
    rod_spec(&s, &regimes[i]);
    check_ok(world_open(&w, &s, s.effects, &err), &err);
    base_fields_default(f->fields, f->n_fields, opt);
    check_ok(formulation_open(&run, f, opt, &err), &err);
    check_ok(world_contacts_curved(w, h, -1.0, &c, &err), &err);
    check_ok(formulation_begin(run, &c, FORM_COLD, &err), &err);
    check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
    assert_true(pending);
    assert_int_equal(p.M.n, 1); /* sliding: the normal force alone */
    check_close(p.M.val[0], regimes[i].p, 1e-12);
    check_close(p.q[0] / h, regimes[i].b, 1e-7 * fabs(regimes[i].b)); /* differences of u */
    formulation_close(run);
    world_close(w);
    spec_free(&s);
  }
}

/* A failed solve is passed on, and no impulse is made up. */
static void unsolved_is_said(void **state) {
  (void)state;
  const formulation *f = formulation_find("acceleration");
  base_error err = {0};
  scene_spec s;
  world *w;
  formulation_run *run;
  contact_set c;
  lcp_problem p;
  formulation_answer a;
  const double *z0, zero = 0.0;
  unsigned char opt[256] = {0};
  bool pending;
  rod_spec(&s, &regimes[1]);
  check_ok(world_open(&w, &s, s.effects, &err), &err);
  base_fields_default(f->fields, f->n_fields, opt);
  check_ok(formulation_open(&run, f, opt, &err), &err);
  check_ok(world_contacts_curved(w, 1e-3, -1.0, &c, &err), &err);
  check_ok(formulation_begin(run, &c, FORM_COLD, &err), &err);
  check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
  check_ok(formulation_recover(run, &zero, LCP_INFEASIBLE, &err), &err);
  formulation_answer_of(run, &a);
  assert_false(a.solved);
  assert_int_equal(a.work.rays, 1);
  assert_true(a.impulse[0] == 0.0);
  formulation_close(run);
  world_close(w);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(poses_the_number_of_the_table),
      cmocka_unit_test(unsolved_is_said),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
