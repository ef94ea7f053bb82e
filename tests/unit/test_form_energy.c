/* Energy: no formulation with b_n >= 0 creates any (MATHEMATICS 2.1, 2.3.9), in random contact sets and in
 * random worlds; a loaded stick holds for ever where the friction law is rigid or a bristle, and creeps
 * at the predicted rate where it is viscous. */
#include "tests/support/check.h"

#include "harness/measure/registry.h"
#include "harness/measure/series.h"
#include "harness/measure/simulate.h"
#include "lcp/base/rng.h"
#include "tests/support/rig.h"

#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Every third spatial scene also resists spinning and rolling, where the formulation has moments; under
 * Poisson's law all contacts of a set bounce alike, from e = 0.1 to 1. */
static rig *random_set(const char *form, const char *opt, int k) {
  const bool moments = k % 3 == 0 && strcmp(form, "acceleration") != 0;
  rig *r = rig_random(1000 + (uint64_t)k, 2 + k % 2, 0.5);
  for (int i = 0; i < r->n_contact && moments; i++) {
    r->contact[i].torsion = 0.02 * (1 + i);
    r->contact[i].rolling = 0.03;
  }
  for (int i = 0; i < r->n_contact && strstr(opt, "poisson") != NULL; i++) {
    r->contact[i].e = 0.1 * (1 + k % 10);
  }
  return r;
}

/* Two steps of one random system at contact, the second with the memory of the first: kinetic energy
 * and that of the bristles never rises by more than 1e-10 of itself. Gaps stay closed, so b_n = 0.
 * False where a step was not solved, which is said. */
static bool loses(const char *form, const char *opt, int k) {
  rig *r = random_set(form, opt, k);
  formulation_run *run = rig_open(form, opt);
  double before = (rig_set(r), rig_kinetic(r));
  bool solved = true;
  for (int step = 0; step < 2 && solved; step++) {
    memset(r->x, 0, sizeof r->x); /* the same contacts, closed */
    rig_step(r, run);
    solved = r->answer.solved;
    const double after = rig_kinetic(r) + r->answer.spring_energy;
    if (solved && after > before * (1 + 1e-10)) {
      fail_msg("%s:%s scene %d step %d: %.17g J before, %.17g J after", form, opt, k, step, before,
               after);
    }
    before = after;
  }
  rig_close(run);
  free(r);
  return solved;
}

/* What may stay unsolved: modes that go round until mode_iter (which sets these are is up to rounding: seen
 * 0, 2 and 0), bounds that do not settle (85), forces that do not exist (3). */
static void random_sets_only_lose(void **state) {
  (void)state;
  enum { SCENES = CHECK_FEWER(1000) };
  static const struct {
    const char *form, *opt;
    int allowed; /* unsolved, which is said */
  } all[] = {{"normal", "", 0},
             {"velocity", "facets=4", 0},
             {"velocity", "facets=7,cone=circumscribed", 0},
             {"velocity", "restitution=poisson", 0},
             {"velocity", "restitution=poisson,storage=factored", 0},
             {"position", "facets=8", 0},
             {"regularized", "", 2},
             {"regularized", "model=viscous", 4},
             {"regularized", "bias=position", 2},
             {"boxed", "", 88},
             {"coulomb", "", 0},
             {"acceleration", "", 3}};
  for (int i = 0; i < BASE_COUNT(all); i++) {
    int unsolved = 0;
    for (int k = 0; k < SCENES; k++) {
      unsolved += !loses(all[i].form, all[i].opt, k);
    }
    if (unsolved > all[i].allowed) {
      fail_msg("%s:%s: %d of %d not solved", all[i].form, all[i].opt, unsolved, SCENES);
    }
  }
}

static const char *const poisson[] = {"restitution=poisson",
                                      "restitution=poisson,storage=factored"};

/* Newton's cradle of three, touching (MATHEMATICS B7): by Poisson's law the first ends with (1 - 2e)/3, the others with
 * (1 + e)/3, although the second contact does not approach. */
static void poisson_moves_a_cradle(void **state) {
  (void)state;
  for (int k = 0; k < 10; k++) {
    const double e = 0.1 * k, right[3] = {0.5, 0, 0}, left[3] = {-0.5, 0, 0}, n[3] = {1, 0, 0};
    rig *r = rig_new(2, 0.01);
    for (int b = 0; b < 3; b++) {
      rig_body(r, 1, 0.1, 0.1, 0.1);
      r->x[b][0] = b;
    }
    rig_touch(r, 1, 0, left, right, n, 0)->e = e;
    rig_touch(r, 2, 1, left, right, n, 0)->e = e;
    r->v[0] = 1;
    formulation_run *run = rig_open("velocity", poisson[k % 2]);
    rig_step(r, run);
    assert_true(r->answer.solved);
    check_close(r->v[0], (1 - 2 * e) / 3, 1e-12);
    check_close(r->v[3], (1 + e) / 3, 1e-12);
    check_close(r->v[6], (1 + e) / 3, 1e-12);
    rig_close(run);
    free(r);
  }
}

/* A disc with I = m r^2/2 lands while it slides at 1 m/s along the floor (MATHEMATICS B6): friction takes
 * mu (1 + e) m |u_n|, of both phases, where that is less than m |u_t|/3, what stops the sliding. */
static void poisson_rubs_in_both_phases(void **state) {
  (void)state;
  for (int k = 0; k < 12; k++) {
    const double e = 0.8, mu = 0.025 * (1 + k), m = 2, radius = 0.5, fall = 1;
    const double foot[3] = {0, -radius, 0}, ground[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    rig *r = rig_new(2, 0.01);
    rig_body(r, m, 0, 0, 0.5 * m * radius * radius);
    r->x[0][1] = radius;
    r->v[0] = 1;
    r->v[1] = -fall;
    rig_touch(r, 0, -1, foot, ground, n, mu)->e = e;
    formulation_run *run = rig_open("velocity", poisson[k % 2]);
    rig_step(r, run);
    const double friction = fmin(mu * (1 + e) * m * fall, m / 3);
    assert_true(r->answer.solved);
    check_close(r->v[1], e * fall, 1e-12);
    check_close(r->v[0], 1 - friction / m, 1e-12);
    check_close(r->v[2], -friction * radius / (0.5 * m * radius * radius), 1e-12);
    rig_close(run);
    free(r);
  }
}

/* Three discs and a box thrown at each other above a floor, e = 0. */
static void random_world(scene_spec *s, uint64_t seed) {
  base_rng g = base_rng_seeded(seed);
  base_error err = {0};
  const double up[3] = {0, 1, 0};
  spec_static *floor;
  spec_init(s);
  s->dim = 2;
  s->gravity[1] = -9.81;
  s->duration = 0.4;
  s->friction.dflt = base_rng_between(&g, 0.05, 1.0);
  (void)snprintf(s->id, sizeof s->id, "random");
  check_ok(spec_add_static(s, "floor", up, 0.0, &floor, &err), &err);
  for (int i = 0; i < 4; i++) {
    char name[16];
    spec_body *b;
    (void)snprintf(name, sizeof name, "b%d", i);
    check_ok(spec_add_body(s, name, &b, &err), &err);
    b->shape = (spec_shape){.kind = SPEC_SPHERE, .r = 0.1};
    if (i == 3) {
      b->shape = (spec_shape){.kind = SPEC_BOX, .half = {0.12, 0.08}};
    }
    b->mass = base_rng_between(&g, 0.5, 2.0);
    b->inertia[0] = 0.005 * b->mass;
    b->pos[0] = 0.3 * (i % 2) + 0.02 * base_rng_between(&g, -1, 1);
    b->pos[1] = (i < 2) ? 0.2 : 0.52;
    b->angle = base_rng_between(&g, -1, 1);
    b->vel[0] = (i % 2 == 0 ? 1.0 : -1.0) * base_rng_between(&g, 0, 2);
    b->vel[1] = base_rng_between(&g, -2, 0);
    b->omega[2] = base_rng_between(&g, -5, 5);
  }
  check_ok(spec_check_all(s, &err), &err);
}

/* Largest energy of a run above that at its start, and above that of the step before [J]. */
static void gains(const char *form, const char *solver, uint64_t seed, double gain[2]) {
  scene_spec spec;
  formulation_choice f;
  solver_choice s;
  sim_result r = {0};
  series record = {0};
  base_error err = {0};
  random_world(&spec, seed);
  check_ok(formulation_choose(form, &f, &err), &err);
  check_ok(solver_choose(solver, &s, &err), &err);
  const sim_request q = {.spec = &spec,
                         .effects = spec.effects,
                         .form = &f,
                         .solver = &s,
                         .h = 0.01,
                         .duration = spec.duration};
  check_ok(simulate(&q, &record, &r, &err), &err);
  if (r.status != RUN_OK) {
    fail_msg("%s seed %d: %s", form, (int)seed, r.note);
  }
  const double *e = record.column[SERIES_ENERGY];
  gain[0] = gain[1] = 0;
  for (int k = 1; k < record.n_row; k++) {
    gain[0] = fmax(gain[0], (e[k] - e[0]) / fabs(e[0]));
    gain[1] = fmax(gain[1], (e[k] - e[k - 1]) / fabs(e[0]));
  }
  series_close(&record);
  formulation_choice_free(&f);
  solver_choice_free(&s);
  spec_free(&spec);
}

/* The integrators: to their own error control. Compliant contact stores energy, so what is left in the
 * bodies never exceeds what was there at the start. */
static void integrators_only_lose(void **state) {
  (void)state;
  for (uint64_t seed = 0; seed < 3; seed++) {
    double gain[2];
    gains("event", "lemke", seed, gain);
    check_close(gain[1], 0, 1e-9);
    gains("penalty", "lemke", seed, gain);
    check_close(gain[0], 0, 1e-6);
  }
}

/* 1e5 steps on a slope: a bristle sags by m g sin / (n k) and stays; a viscous law creeps at
 * m g sin / (n c) (MATHEMATICS B1), to 1 %. */
static void loaded_stick(void **state) {
  (void)state;
  const double angle = 20 * pi / 180;
  const double pull = 2 * 9.81 * sin(angle);
  for (int viscous = 0; viscous < 2; viscous++) {
    rig *r = rig_box(2, 0.01, 0.5, angle);
    formulation_run *run =
        rig_open("regularized", viscous ? "model=viscous,stiffness=fixed,c=5000"
                                        : "model=bristle,stiffness=fixed,k=1e6,c=1000");
    double early = 0;
    for (int k = 0; k < 100000; k++) {
      r->x[0][1] = 0.1; /* no rotation of the points: the gap is that of the start */
      rig_step(r, run);
      assert_true(r->answer.solved);
      early = (k == 999) ? r->x[0][0] : early;
    }
    const double rest = r->x[0][0] - early;
    if (viscous) {
      check_close(rest / (99000 * 0.01), pull / (2 * 5000), 0.01 * pull / (2 * 5000));
    } else {
      check_close(r->x[0][0], pull / (2 * 1e6), 0.01 * pull / (2 * 1e6));
      check_close(rest, 0, 1e-12);
    }
    rig_close(run);
    free(r);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_sets_only_lose),
      cmocka_unit_test(poisson_moves_a_cradle),
      cmocka_unit_test(poisson_rubs_in_both_phases),
      cmocka_unit_test(integrators_only_lose),
      cmocka_unit_test(loaded_stick),
  };
  return cmocka_run_group_tests_name("energy", tests, NULL, NULL);
}
