/* Friction laws against closed forms: direction, ellipse, stick-slip, LuGre, limits. */
#include "tests/support/check.h"

#include "tests/support/rig.h"

#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A body on one contact below its centre: no rotation. */
static rig *puck(int dim, double h, double mass, double weight, double mu_s, double mu_k) {
  rig *r = rig_new(dim, h);
  r->gravity[dim - 1] = -weight / mass;
  const double zero[3] = {0, 0, 0};
  const double up[3] = {0, dim == 2, dim == 3};
  rig_touch(r, rig_body(r, mass, 1, 1, 1), -1, zero, zero, up, mu_s)->mu_k = mu_k;
  return r;
}

/* Where a puck of 3 m/s in direction (c, s) comes to rest with mu = 0.4, h = 0.001. */
static void slide(const char *form, const char *opt, const double dir[2], double end[2]) {
  rig *r = puck(3, 0.001, 1, 9.81, 0.4, 0.4);
  formulation_run *run = rig_open(form, opt);
  r->v[0] = 3 * dir[0];
  r->v[1] = 3 * dir[1];
  for (int k = 0; k < 1200; k++) {
    rig_step(r, run);
    assert_true(r->answer.solved);
  }
  end[0] = r->x[0][0];
  end[1] = r->x[0][1];
  rig_close(run);
  free(r);
}

/* Distance of a slide along the friction's own axis: v^2/(2 mu g) - v h/2. */
static const double reach = 9 / (2 * 0.4 * 9.81);
static const double lost = 3 * 0.001 / 2;

/* A circular cone keeps the direction, whatever it is, to 1e-9 of the way. */
static void circles_are_straight(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
  } straight[] = {{"regularized", ""},
                  {"regularized", "model=viscous"},
                  {"regularized", "form=mass"},
                  {"coulomb", ""}};
  static const double angles[] = {0, 11.25, 22.5, 45};
  for (int a = 0; a < BASE_COUNT(angles); a++) {
    const double d[2] = {cos(angles[a] * pi / 180), sin(angles[a] * pi / 180)};
    for (int f = 0; f < BASE_COUNT(straight); f++) {
      double x[2];
      slide(straight[f].form, straight[f].opt, d, x);
      check_close(x[1] * d[0] - x[0] * d[1], 0, 1e-9);
      check_close(x[0] * d[0] + x[1] * d[1], reach - lost, 1e-4);
    }
  }
}

/* An inscribed polygon of nd facets brakes along its nearest facet direction alone until the velocity has
 * turned to the bisector, and from there by mu cos(pi/nd) (MATHEMATICS B3): the path bends
 * (nd = 4: from 11.25 to 20.98 degrees) unless it starts along a facet or midway between two. */
static void polygons_bend_the_path(void **state) {
  (void)state;
  static const int facets[] = {4, 4, 4, 4, 8, 8, 16};
  static const double angles[] = {0, 11.25, 22.5, 45, 11.25, 22.5, 11.25};
  const double brake = 0.4 * 9.81;
  for (int a = 0; a < BASE_COUNT(angles); a++) {
    const double half = pi / facets[a];
    const double d[2] = {cos(angles[a] * pi / 180), sin(angles[a] * pi / 180)};
    const double turn = 3 * (d[0] - d[1] / tan(half)) / brake; /* time until the bisector */
    const double late = 3 * d[1] / sin(half);                  /* speed there */
    const double along = late * late / (2 * brake * cos(half));
    const double side = 3 * d[1] * turn + along * sin(half);
    char opt[16];
    double x[2];
    (void)snprintf(opt, sizeof opt, "facets=%d", facets[a]);
    slide("velocity", opt, d, x);
    check_close(x[0], reach, 3e-3);
    check_close(x[1], side, 3e-3);
    const double bent = atan2(x[1], x[0]) * 180 / pi;
    if (a == 1) {
      check_close(bent, 20.98, 0.1);
    } else if (fabs(angles[a] * pi / 180 - half) < 1e-9) {
      check_close(hypot(x[0], x[1]), reach / cos(half), 3e-3); /* cos(pi/nd) of the friction */
      check_close(bent, angles[a], 1e-6);
    }
  }
}

/* Each side of a box acts alone: the two components of the velocity fall at mu g each, and the puck
 * rests at (c^2, s^2) v^2/(2 mu g): straight at 0 and 45 degrees only, and there sqrt(2) too short. */
static void boxes_resist_by_components(void **state) {
  (void)state;
  static const double angles[] = {0, 11.25, 22.5, 45};
  for (int a = 0; a < BASE_COUNT(angles); a++) {
    const double d[2] = {cos(angles[a] * pi / 180), sin(angles[a] * pi / 180)};
    double x[2];
    slide("boxed", "", d, x);
    for (int k = 0; k < 2; k++) {
      check_close(x[k], d[k] * d[k] * reach - d[k] * lost, 1e-4);
    }
  }
}

/* The law that a formulation says it has. */
static formulation_friction said(const char *form, const char *opt) {
  const formulation *f = formulation_find(form);
  base_error err = {0};
  void *options = calloc(1, f->options_size + 1);
  base_fields_default(f->fields, f->n_fields, options);
  assert_int_equal(base_fields_parse(f->fields, f->n_fields, options, opt, &err), BASE_OK);
  const formulation_friction is = formulation_friction_of(f, 3, options);
  free(options);
  return is;
}

/* The most that friction takes in one step, over mu times the normal force, of all directions of a slide, is what the formulation says; and
 * where it says so, a slide along an axis is not pushed off it. */
static void laws_say_how_far_they_reach(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
  } laws[] = {{"coulomb", ""},
              {"regularized", ""},
              {"boxed", ""},
              {"velocity", "facets=4"},
              {"velocity", "facets=6"},
              {"velocity", "cone=circumscribed,facets=4"},
              {"velocity", "cone=circumscribed,facets=5"},
              {"position", "cone=circumscribed,facets=8"},
              {"acceleration", "facets=8"}};
  enum { TURNS = 360 };
  const double h = 0.001, force = 0.4 * 9.81;
  for (int l = 0; l < BASE_COUNT(laws); l++) {
    const formulation_friction law = said(laws[l].form, laws[l].opt);
    double most = 0;
    for (int k = 0; k < TURNS; k++) {
      rig *r = puck(3, h, 1, 9.81, 0.4, 0.4);
      formulation_run *run = rig_open(laws[l].form, laws[l].opt);
      r->v[0] = (k == 0) ? 3 : 3 * cos(2 * pi * k / TURNS);
      r->v[1] = (k == 0) ? 0 : 3 * sin(2 * pi * k / TURNS);
      const double from[2] = {r->v[0], r->v[1]};
      rig_step(r, run);
      assert_true(r->answer.solved);
      most = fmax(most, hypot(r->v[0] - from[0], r->v[1] - from[1]) / (force * h));
      assert_true(k > 0 || law.aslant || r->v[1] == 0);
      rig_close(run);
      free(r);
    }
    const bool lagged = (formulation_find(laws[l].form)->model & FORM_BOUNDS_LAGGED) != 0;
    if (most > law.most * (1 + 1e-9) || (!lagged && most < law.most * (1 - 1e-9))) {
      printf("# %s:%s says %.17g, does %.17g\n", laws[l].form, laws[l].opt, law.most, most);
      fail();
    }
  }
  assert_true(said("velocity", "facets=6").aslant && said("acceleration", "facets=5").aslant);
  assert_false(said("velocity", "facets=8").aslant || said("boxed", "").aslant);
}

/* A load of `share` of what static friction holds stops a slide and cannot turn it round: the puck rests where it stopped, at
 * v^2 / 2 (a + mu_k g), wherever in a step that is. Kinetic friction, a third of the static, would let it go (0.2 m by the end). */
static void slides_end_where_loads_would_turn_them(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
  } laws[] = {{"velocity", "facets=4"}, {"position", "facets=8"},
              {"coulomb", ""},          {"boxed", ""},
              {"regularized", ""},      {"regularized", "form=contact"},
              {"acceleration", ""},     {"velocity", "planar=three"}};
  static const double share[] = {0.5, 0.8, 0.95};
  enum { SIZES = 12 }; /* of steps */
  for (int k = 0; k < 2 * BASE_COUNT(laws) * BASE_COUNT(share) * SIZES; k++) {
    const int l = k % BASE_COUNT(laws), dim = 2 + k / BASE_COUNT(laws) % 2;
    const double load = share[k / (2 * BASE_COUNT(laws)) % BASE_COUNT(share)] * 0.6 * 10;
    const int steps = 400 + 7 * (k / (2 * BASE_COUNT(laws) * BASE_COUNT(share)));
    const double h = 0.6 / steps, end = 1 / (2 * (load + 2));
    rig *r = puck(dim, h, 1, 10, 0.6, 0.2);
    formulation_run *run = rig_open(laws[l].form, laws[l].opt);
    r->gravity[0] = -load;
    r->v[0] = 1;
    for (int i = 0; i < steps; i++) {
      rig_step(r, run);
      assert_true(r->answer.solved);
    }
    if (fabs(r->x[0][0] - end) > 2.5 * h) {
      printf("# %s:%s in %d dimensions, load %g, step %.17g\n", laws[l].form, laws[l].opt, dim,
             load, h);
      check_close(r->x[0][0], end, 2.5 * h);
    }
    check_close(r->v[0], 0, 1e-5);
    rig_close(run);
    free(r);
  }
}

static void ellipse_of_coefficients(void **state) {
  (void)state;
  const double h = 0.001;
  rig *r = puck(3, h, 1, 9.81, 0.4, 0.4);
  formulation_run *run = rig_open("regularized", "ellipse=0.5");
  r->v[1] = 2;
  for (int k = 0; k < 100; k++) {
    rig_step(r, run);
  }
  check_close(r->v[1], 2 - 0.1 * 0.2 * 9.81, 1e-9); /* along t2: half of mu */
  r->v[0] = 2;
  r->v[1] = 2;
  rig_step(r, run);
  /* associated slip on the ellipse: lambda along (mu1^2 u1, mu2^2 u2) / |(mu1 u1, mu2 u2)| */
  const double *l = r->answer.impulse;
  check_close(l[2] / l[1], 0.25 * r->v[1] / r->v[0], 1e-4); /* the bristle still turns */
  check_close(l[1] * l[1] / 0.16 + l[2] * l[2] / 0.04, l[0] * l[0], 1e-12);
  rig_close(run);
  free(r);
}

/* A box turns about the vertical and stops within the step, faster at first than the corners one by one could stop: friction turns their
 * slip round, and they hold in the next solve. */
static void spins_end_in_few_solves(void **state) {
  (void)state;
  static const char *const ratios[] = {"ratio=1000", "ratio=1e5"};
  for (int i = 0; i < BASE_COUNT(ratios); i++) {
    for (int k = 0; k < 8; k++) {
      const double rate = 1.2 + 0.2 * k;
      rig *r = rig_box(3, 0.1, 0.5, 0);
      formulation_run *run = rig_open("regularized", ratios[i]);
      r->v[5] = rate;
      rig_step(r, run);
      assert_true(r->answer.solved);
      assert_true(fabs(r->v[5]) < 0.01 * rate);
      if (r->solves > 3) {
        fail_msg("%s, %g rad/s: %ld solves", ratios[i], rate, r->solves);
      }
      rig_close(run);
      free(r);
    }
  }
}

/* Belt (MATHEMATICS B16): slip phase, then stick; period from theory. */
static void belt_stick_slip(void **state) {
  (void)state;
  const double K = 20;
  const double belt = 0.1;
  const double D = 0.1 * 9.81 / K;
  const double w = sqrt(K);
  const double period = 2 / w * (pi - atan(w * D / belt)) + 2 * D / belt;
  rig *r = puck(2, 1e-4, 1, 9.81, 0.4, 0.3);
  r->contact[0].belt = belt;
  formulation_run *run = rig_open("regularized", "");
  double last = -1;
  double measured = 0;
  unsigned char mode = 1;
  for (int k = 0; k < 80000; k++) {
    r->gravity[0] = -K * r->x[0][0];
    rig_step(r, run);
    assert_true(r->answer.solved);
    if (mode == 1 && r->answer.mode[0] == 2 && r->t > 2) {
      measured = (last > 0) ? r->t - last : 0;
      last = r->t;
    }
    mode = r->answer.mode[0];
  }
  check_close(measured, period, 2e-3);
  rig_close(run);
  free(r);
}

/* LuGre with the parameters of the 1995 paper: pulled by a spring of 2 N/m at 0.1 m/s the first
 * slip comes at Fs/(K V) = 7.5 s; under an oscillating load below the limit it drifts for ever,
 * where a bristle returns (MATHEMATICS 2.3.4). */
static void lugre_slips_and_drifts(void **state) {
  (void)state;
  rig *r = puck(2, 1e-3, 1, 10, 0.15, 0.1);
  formulation_run *run = rig_open("regularized", "model=lugre");
  double first = 0;
  for (int k = 0; k < 9000 && first == 0; k++) {
    r->gravity[0] = 2 * (0.1 * r->t - r->x[0][0]);
    rig_step(r, run);
    assert_true(r->answer.solved);
    first = (r->v[0] > 0.05) ? r->t : 0;
  }
  check_close(first, 7.5, 0.1);
  rig_close(run);
  free(r);

  static const char *const opts[] = {"model=lugre", "stiffness=fixed,k=1e5,c=316"};
  double drift[2];
  for (int i = 0; i < 2; i++) {
    r = puck(2, 1e-3, 1, 10, 0.15, 0.1);
    run = rig_open("regularized", opts[i]);
    double at[2] = {0, 0};
    for (int k = 0; k < 6000; k++) {
      r->gravity[0] = 0.4 + 0.4 * sin(2 * pi * r->t);
      rig_step(r, run);
      at[0] = (k == 1999) ? r->x[0][0] : at[0];
      at[1] = r->x[0][0];
    }
    drift[i] = (at[1] - at[0]) / 4;
    rig_close(run);
    free(r);
  }
  check_close(drift[0], 5.1e-6, 5e-7);
  check_close(drift[1], 0, 1e-9);
}

/* mu = 0 is the frictionless problem; G and mu large is a bilateral no-slip contact. */
static void limits_of_the_law(void **state) {
  (void)state;
  for (int which = 0; which < 20; which++) {
    const int dim = 2 + which % 2;
    rig *a = rig_random((uint64_t)which, dim, 0.5);
    rig *b = rig_random((uint64_t)which, dim, 0.5);
    for (int i = 0; i < a->n_contact; i++) {
      a->contact[i].mu = 0;
      a->contact[i].mu_k = 0;
    }
    formulation_run *none = rig_open("regularized", "");
    formulation_run *normal = rig_open("normal", "");
    rig_step(a, none);
    rig_step(b, normal);
    assert_true(a->answer.solved && b->answer.solved);
    assert_int_equal(a->answer.lcp_dim, b->answer.lcp_dim);
    for (int d = 0; d < a->set.n_dof; d++) {
      check_close(a->v[d], b->v[d], 1e-12);
    }
    rig_close(none);
    rig_close(normal);
    free(a);
    free(b);
  }
  rig *r = rig_new(3, 0.01);
  const double arm[3] = {0.1, 0.2, -0.3};
  const double ground[3] = {0, 0, 0};
  const double up[3] = {0, 0, 1};
  rig_touch(r, rig_body(r, 2, 0.3, 0.2, 0.4), -1, arm, ground, up, 1e6);
  r->x[0][2] = 0.3;
  const double v[6] = {1, -2, -3, 0.5, 0.6, 0.7};
  memcpy(r->v, v, sizeof v);
  formulation_run *run = rig_open("regularized", "ratio=1e12,form=contact");
  rig_step(r, run);
  assert_true(r->answer.solved);
  for (int k = 0; k < 3; k++) { /* point velocity v + w x r */
    const double w[3] = {r->v[3], r->v[4], r->v[5]};
    const double turn = w[(k + 1) % 3] * arm[(k + 2) % 3] - w[(k + 2) % 3] * arm[(k + 1) % 3];
    check_close(r->v[k] + turn, 0, 1e-10);
  }
  rig_close(run);
  free(r);
}

/* The bristle's deflection, and the most it was, after 3000 steps at rest with h^2 k/m = 10^power. */
static void deflect(const char *form, int power, double *end, double *most) {
  const double h = 0.01;
  const double k = 2 * pow(10, power) / (h * h);
  char opt[160];
  (void)snprintf(opt, sizeof opt, "form=%s,stiffness=fixed,k=%.17g,c=%.17g", form, k,
                 2 * sqrt(2 * k));
  rig *r = rig_box(2, h, 0.5, 20 * pi / 180);
  formulation_run *run = rig_open("regularized", opt);
  *most = 0;
  for (int step = 0; step < 3000; step++) {
    rig_step(r, run);
    if (!r->answer.solved || !isfinite(r->v[0])) {
      fail_msg("%s: step %d: residual %g", opt, step, r->answer.residual);
    }
    *most = fmax(*most, r->x[0][0]);
  }
  *end = r->x[0][0];
  rig_close(run);
  free(r);
}

/* Stiffness from h^2 k/m = 1e-3 to 1e12 (MATHEMATICS S17): every step solved, the bristle ends at F/(n k), never
 * beyond mu N/k, to the rounding of the positions. In the mass form k drowns the mass from 1e6 on, which is
 * why `auto` does not take it for given stiffness. */
static void every_stiffness_holds(void **state) {
  (void)state;
  const double pull = 2 * 9.81 * sin(20 * pi / 180);
  const double press = 2 * 9.81 * cos(20 * pi / 180);
  for (int power = -3; power <= 12; power += 3) {
    const double k = 2 * pow(10, power) / 1e-4;
    double end, most;
    deflect("auto", power, &end, &most);
    check_close(end, pull / (2 * k), 1e-5 * pull / (2 * k) + 1e-15);
    assert_true(most <= 0.5 * press / (2 * k) + 1e-15);
    if (power <= 3) {
      deflect("mass", power, &end, &most);
      check_close(end, pull / (2 * k), 1e-5 * pull / (2 * k));
      assert_true(most <= 0.5 * press / (2 * k));
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(circles_are_straight),
      cmocka_unit_test(polygons_bend_the_path),
      cmocka_unit_test(boxes_resist_by_components),
      cmocka_unit_test(laws_say_how_far_they_reach),
      cmocka_unit_test(slides_end_where_loads_would_turn_them),
      cmocka_unit_test(ellipse_of_coefficients),
      cmocka_unit_test(spins_end_in_few_solves),
      cmocka_unit_test(belt_stick_slip),
      cmocka_unit_test(lugre_slips_and_drifts),
      cmocka_unit_test(limits_of_the_law),
      cmocka_unit_test(every_stiffness_holds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
