/* The three formulations on contact sets built by hand, against closed forms and each other. */
#include "tests/support/check.h"

#include "formulations/assembly.h"
#include "tests/support/rig.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

/* slides with g (sin - mu cos), or sticks */
static void block_on_incline(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
    double stick_tol, slip_tol;
  } forms[] = {
      {"velocity", "facets=4", 1e-12, 1e-12},
      {"velocity", "facets=8,cone=circumscribed,storage=csc", 1e-12, 1e-12},
      {"velocity", "facets=8,storage=factored", 1e-12, 1e-12},
      {"position", "facets=4,storage=factored", 1e-12, 1e-12},
      {"velocity", "restitution=poisson", 1e-12, 1e-12},
      {"velocity", "planar=three", 1e-12, 1e-12},
      {"position", "facets=8", 1e-12, 1e-12},
      {"regularized", "", 1e-6, 1e-3},
      {"regularized", "model=viscous", 2e-3, 1e-3}, /* creeps at h g sin / (1 + ratio m_t / m) */
      {"regularized", "modes=plain", 1e-6, 1e-3},
      {"regularized", "modes=secant", 1e-6, 1e-3}};
  for (int dim = 2; dim <= 3; dim++) {
    for (int i = 0; i < BASE_COUNT(forms); i++) {
      for (int slip = 0; slip < 2; slip++) {
        if (dim == 3 && slip && strstr(forms[i].opt, "plain") != NULL) {
          continue; /* the plain loop cycles here, and says so */
        }
        const double angle = (slip ? 30 : 20) * pi / 180;
        rig *r = rig_box(dim, 0.01, slip ? 0.3 : 0.5, angle);
        formulation_run *run = rig_open(forms[i].form, forms[i].opt);
        for (int k = 0; k < 100; k++) {
          rig_step(r, run);
          if (!r->answer.solved) {
            fail_msg("%s:%s dim %d slip %d step %d residual %g", forms[i].form, forms[i].opt, dim,
                     slip, k, r->answer.residual);
          }
        }
        const double want = slip ? 9.81 * (sin(angle) - 0.3 * cos(angle)) : 0;
        const bool wide = slip && dim == 3 && strstr(forms[i].opt, "circum") != NULL;
        const double excess = wide ? 0.3 * 9.81 * cos(angle) * (1 / cos(pi / 8) - 1) : 0;
        check_close(r->v[0], want - excess, slip ? forms[i].slip_tol : forms[i].stick_tol);
        check_close(r->v[dim - 1], 0, 1e-11);
        rig_close(run);
        free(r);
      }
    }
  }
}

/* A chain of pinned bodies lying on frictional contacts: joints in the problem or out of it, the
 * same velocities; and pins listed twice change nothing. */
static rig *chain(int dim, bool twice) {
  rig *r = rig_new(dim, 0.01);
  r->gravity[dim - 1] = -9.81;
  r->gravity[0] = 3;
  const double ground[3] = {0, 0, 0};
  const double n[3] = {0, dim == 2, dim == 3};
  for (int b = 0; b < 4; b++) {
    rig_body(r, 1 + b, 0.2, 0.3, 0.4);
    r->x[b][0] = b;
    r->v[(dim == 2 ? 3 : 6) * b] = 0.3;
    const double foot[3] = {0.1, (dim == 2) ? 0 : 0.05 * b, 0};
    if (b != 2) {
      rig_touch(r, b, -1, foot, ground, n, 0.3);
    }
    const double left[3] = {-0.5, 0, 0};
    const double right[3] = {0.5, 0, 0};
    for (int k = 0; k < 1 + twice && b > 0 && b < 3; k++) {
      rig_pin(r, b, b - 1, left, right);
    }
  }
  return r;
}

static void joints_in_and_out(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    rig *in = chain(dim, false);
    rig *out = chain(dim, false);
    rig *twice = chain(dim, true);
    rig *soft = chain(dim, false);
    formulation_run *mixed = rig_open("velocity", "joints=mixed,facets=8,joint_push=0");
    formulation_run *eliminated = rig_open("velocity", "facets=8,joint_push=0");
    formulation_run *redundant = rig_open("velocity", "facets=8,joint_push=0");
    rig *parts = chain(dim, false);
    formulation_run *factored =
        rig_open("velocity", "facets=8,storage=factored,joints=mixed,joint_push=0");
    formulation_run *regularized = rig_open("regularized", "ratio=1e6,joint_push=0");
    for (int k = 0; k < 20; k++) {
      rig_step(in, mixed);
      rig_step(out, eliminated);
      rig_step(twice, redundant);
      rig_step(soft, regularized);
      rig_step(parts, factored);
      assert_true(in->answer.solved && out->answer.solved && twice->answer.solved &&
                  soft->answer.solved);
      for (int i = 0; i < in->set.n_dof; i++) {
        check_close(in->v[i], out->v[i], 1e-12);
        check_close(twice->v[i], out->v[i], 1e-12);
        check_close(parts->v[i], out->v[i], 1e-12);
        check_close(soft->v[i], out->v[i], dim == 2 ? 1e-4 : 0.05); /* 8 facets in space */
      }
    }
    rig_close(mixed);
    rig_close(eliminated);
    rig_close(redundant);
    rig_close(regularized);
    rig_close(factored);
    free(parts);
    free(in);
    free(out);
    free(twice);
    free(soft);
  }
}

/* Under contacts the errors of eliminated joints are taken back by a velocity of its own, the least that does it: contacts and the
 * next velocity are those without an error. */
static void errors_are_taken_back_beside_the_motion(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    rig *r = chain(dim, true);
    rig *still = chain(dim, true);
    formulation_run *run = rig_open("velocity", "facets=8,joint_push=0.5");
    formulation_run *none = rig_open("velocity", "facets=8,joint_push=0");
    for (int b = 0; b < 3; b++) {
      r->x[b][1] += 0.01 * b;
      still->x[b][1] += 0.01 * b;
      r->v[(dim == 2 ? 3 : 6) * b + dim - 1] = -1;
      still->v[(dim == 2 ? 3 : 6) * b + dim - 1] = -1;
    }
    rig_step(r, run);
    rig_step(still, none);
    assert_true(r->answer.solved && r->answer.shift != NULL && still->answer.shift == NULL);
    const contact_set *c = &r->set;
    double u[64];
    contact_relative_velocity(c, r->answer.shift, NULL, u);
    for (int i = 0; i < c->n_dof; i++) {
      check_close(r->v[i], still->v[i], 1e-13);
    }
    const int first = c->row_start[c->n_contact];
    double largest = 0;
    for (int row = first; row < c->n_row; row++) {
      check_close(u[row], -0.5 / c->h * c->joint_error[row - first], 1e-9);
      largest = fmax(largest, fabs(u[row]));
    }
    assert_true(largest > 0.1);
    rig_close(run);
    rig_close(none);
    free(r);
    free(still);
  }
}

/* Pinned bodies that fall onto their contacts, or random ones, where e is not 0 by Poisson's law. */
static rig *falling(int which, double e) {
  const int dim = 2 + which % 2;
  rig *r = (which < 4) ? chain(dim, false) : rig_random((uint64_t)which, dim, 0.5);
  for (int b = 0; b < r->n_body && which < 4; b++) {
    r->v[(dim == 2 ? 3 : 6) * b + dim - 1] = -1;
  }
  for (int i = 0; i < r->n_contact; i++) {
    r->contact[i].e = e;
  }
  return r;
}

/* Boxes in the air, on the ground and on each other: the frictionless end velocity is unique, so it must
 * not depend on the storage, in both phases of an impact; pinned bodies in factored form keep their
 * joints as free rows. */
static void storages_agree(void **state) {
  (void)state;
#define ALIKE "joint_push=0,storage="
  static const char *const options[2][3] = {
      {ALIKE "dense", ALIKE "csc", ALIKE "factored,joints=mixed"},
      {"restitution=poisson," ALIKE "dense", "restitution=poisson," ALIKE "csc",
       "restitution=poisson," ALIKE "factored,joints=mixed"}};
#undef ALIKE
  for (int which = 0; which < 24; which++) {
    const int bounces = which / 2 % 2;
    rig *r[3];
    formulation_run *run[3];
    for (int k = 0; k < 3; k++) {
      r[k] = falling(which, 0.5 * bounces);
      run[k] = rig_open("normal", options[bounces][k]);
    }
    for (int step = 0; step < 3; step++) {
      for (int k = 0; k < 3; k++) {
        rig_step(r[k], run[k]);
        assert_true(r[k]->answer.solved);
        assert_true(step > 0 || which > 3 || r[k]->solves == 1 + bounces);
      }
      for (int d = 0; d < r[0]->set.n_dof; d++) {
        check_close(r[1]->v[d], r[0]->v[d], 1e-11);
        check_close(r[2]->v[d], r[0]->v[d], 1e-11);
      }
    }
    for (int k = 0; k < 3; k++) {
      rig_close(run[k]);
      free(r[k]);
    }
  }
}

/* coulomb, storage=auto: factors beyond 24 rows at a body with six velocities, but not where there is a joint; one run may
 * change from step to step. */
static void exact_cones_choose_their_storage(void **state) {
  (void)state;
  static const struct {
    int contacts; /* on each of four bodies */
    bool pinned, factored;
  } cases[] = {
      {8, false, false}, {9, false, true}, {9, true, false}, {8, false, false}, {12, false, true}};
  formulation_run *run = rig_open("coulomb", "");
  for (int i = 0; i < BASE_COUNT(cases); i++) {
    rig *r = rig_new(3, 0.01);
    lcp_problem p;
    const double *z0, origin[3] = {0}, up[3] = {0, 0, 1};
    bool pending = false;
    base_error err = {0};
    for (int b = 0; b < 4; b++) {
      (void)rig_body(r, 1, 0.1, 0.1, 0.1);
      for (int c = 0; c < cases[i].contacts; c++) {
        const double at[3] = {cos(c), sin(c), 0};
        (void)rig_touch(r, b, -1, at, at, up, 0.5);
      }
    }
    if (cases[i].pinned) {
      rig_pin(r, 0, 1, origin, origin);
    }
    check_ok(formulation_begin(run, rig_set(r), FORM_PREVIOUS, &err), &err);
    check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
    assert_true(pending && p.M.n >= 4 * 3 * cases[i].contacts);
    assert_int_equal(p.M.storage == LCP_FACTORED, cases[i].factored);
    free(r);
  }
  rig_close(run);
}

/* Contact space and mass matrix are the same step. */
static void both_forms_agree(void **state) {
  (void)state;
  static const char *const opts[][2] = {
      {"form=contact,tol=1e-13,prox=0", "form=mass,tol=1e-13,prox=0"},
      {"form=contact,model=viscous,tol=1e-13,prox=0", "form=mass,model=viscous,tol=1e-13,prox=0"},
      {"form=contact,tol=1e-13,prox=0", "form=mass,factor=cholmod,tol=1e-13,prox=0"}};
  int compared = 0;
  for (int i = 0; i < BASE_COUNT(opts); i++) {
    for (int which = 0; which < 24; which++) {
      rig *r[2];
      formulation_run *run[2];
      for (int k = 0; k < 2; k++) {
        r[k] = (which < 4) ? rig_stack(1 + which, 0.01, 0.5)
                           : rig_random((uint64_t)which, 2 + which % 2, 0.5);
        r[k]->gravity[0] = (which == 1) ? 2 : 7;
        run[k] = rig_open("regularized", opts[i][k]);
      }
      for (int step = 0; step < 3; step++) {
        rig_step(r[0], run[0]);
        rig_step(r[1], run[1]);
        const bool both = r[0]->answer.solved && r[1]->answer.solved; /* 1e-13 is at the rounding */
        if (!both) {
          break;
        }
        compared++;
        for (int d = 0; d < r[0]->set.n_dof; d++) {
          check_close(r[0]->v[d], r[1]->v[d], 2e-12);
        }
      }
      rig_close(run[0]);
      rig_close(run[1]);
      free(r[0]);
      free(r[1]);
    }
  }
  assert_true(compared > 150); /* of 216, some end at the rounding */
}

/* The mass form projects joints out of M_hat, also ones listed twice, also where nothing touches: the
 * velocities of the contact form, and where joints are independent its impulses. Stiffness is given: a
 * ratio G/m_t would mean the effective mass with joints in one form and without them in the other. Contacts feel joint_push in the
 * mass form only. */
static void joints_in_the_mass_form(void **state) {
  (void)state;
  static const char *const mass[] = {
      "form=mass,stiffness=fixed,k=1e5,c=300,tol=1e-12,prox=0,joint_push=0",
      "form=mass,factor=cholmod,stiffness=fixed,k=1e5,c=300,tol=1e-12,prox=0,joint_push=0"};
  for (int which = 0; which < 16; which++) {
    const int dim = 2 + which % 2;
    const bool twice = which & 2, floats = which & 4;
    rig *a = chain(dim, twice);
    rig *b = chain(dim, twice);
    a->n_contact = b->n_contact = floats ? 0 : a->n_contact;
    formulation_run *contact = rig_open(
        "regularized", "form=contact,stiffness=fixed,k=1e5,c=300,tol=1e-12,prox=0,joint_push=0");
    formulation_run *other = rig_open("regularized", mass[which / 8]);
    for (int k = 0; k < 20; k++) {
      rig_step(a, contact);
      rig_step(b, other);
      assert_true(a->answer.solved && b->answer.solved);
      for (int i = 0; i < a->set.n_dof; i++) {
        check_close(b->v[i], a->v[i], 1e-9);
      }
      for (int i = a->set.row_start[a->n_contact]; i < a->set.n_row && !twice; i++) {
        check_close(b->answer.impulse[i], a->answer.impulse[i], 1e-8);
      }
    }
    rig_close(contact);
    rig_close(other);
    free(a);
    free(b);
  }
}

/* CHOLMOD's analysis is kept while the same bodies share contacts, and made anew where they do not. */
static void analysis_stands_with_the_contacts(void **state) {
  (void)state;
  rig *r = rig_stack(4, 0.01, 0.5);
  formulation_run *run = rig_open("regularized", "form=mass,factor=cholmod");
  for (int step = 0; step < 6; step++) {
    r->n_contact = (step < 3) ? 16 : 12; /* the top box loses its support */
    rig_step(r, run);
    assert_true(r->answer.solved && r->answer.work.factorizations > 0);
    assert_int_equal(r->answer.work.analyses, step == 0 || step == 3);
  }
  rig_close(run);
  free(r);
}

/* Newton's law at position level is refused where it is asked for; without it, or without restitution, the step is taken. */
static void position_level_has_no_newton(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
    double e;
    bool taken;
  } all[] = {{"regularized", "bias=position", 0.5, false},
             {"regularized", "bias=position,restitution=none", 0.5, true},
             {"regularized", "bias=position", 0, true},
             {"boxed", "level=position", 0.5, false},
             {"coulomb", "level=position", 0.5, false},
             {"normal", "level=position", 0.5, false},
             {"normal", "", 0.5, true}};
  for (int i = 0; i < BASE_COUNT(all); i++) {
    base_error err = {0};
    rig *r = rig_new(2, 0.01);
    const double zero[3] = {0, 0, 0};
    const double up[3] = {0, 1, 0};
    r->gravity[1] = -9.81;
    rig_touch(r, rig_body(r, 2, 1, 1, 1), -1, zero, zero, up, 0.1)->e = all[i].e;
    formulation_run *run = rig_open(all[i].form, all[i].opt);
    const base_status done = formulation_begin(run, rig_set(r), FORM_COLD, &err);
    assert_int_equal(done, all[i].taken ? BASE_OK : BASE_EUNSUPPORTED);
    rig_close(run);
    free(r);
  }
}

/* Position level: no overlap at any step, the bounce one step late, and as high as Newton's law says
 * (e^2 H, first order in h); friction of the rebound is that of e lambda_n, so an oblique impact that
 * slips loses mu (1 + e) of its normal speed (MATHEMATICS B6). */
static void position_rebounds_a_step_later(void **state) {
  (void)state;
  static const double law[] = {0, 0.5, 0.8, 1};
  for (int i = 0; i < BASE_COUNT(law); i++) {
    const double e = law[i];
    const double high = 1;
    const double h = 0.0005;
    rig *r = rig_new(2, h);
    const double zero[3] = {0, 0, 0};
    const double up[3] = {0, 1, 0};
    r->gravity[1] = -9.81;
    rig_body(r, 2, 1, 1, 1);
    rig_touch(r, 0, -1, zero, zero, up, 0.1)->e = e;
    r->x[0][1] = high;
    r->v[0] = 5;
    formulation_run *run = rig_open("position", "restitution=two_steps");
    double apex = 0;
    double along = 0;
    bool met = false;
    for (int k = 0; k * h < 0.95; k++) {
      rig_step(r, run);
      assert_true(r->answer.solved && r->x[0][1] > -1e-12);
      met = met || r->x[0][1] < 1e-9;
      apex = (met && r->x[0][1] > apex) ? r->x[0][1] : apex;
      along = (r->t < 0.6) ? r->v[0] : along;
    }
    const double fall = sqrt(2 * 9.81 * high);
    assert_true(met);
    check_close(apex, e * e * high, 8 * h);
    if (e > 0) { /* at e = 0 it goes on sliding under its weight */
      check_close(along, 5 - 0.1 * (1 + e) * fall, 10 * h);
    }
    rig_close(run);
    free(r);
  }
}

/* A spin is noise below the error of the speeds it comes with over the radius of gyration: of 2e-15 rad/s at
 * 1 m/s nothing is left with a radius of 1 m, everything with one of 1 km. */
static void noise_of_a_spin(void **state) {
  (void)state;
  static const struct { double inertia, spin; } bodies[] = {{1, 0}, {1e6, 2e-15}};
  for (int i = 0; i < BASE_COUNT(bodies); i++) {
    const double zero[3] = {0}, up[3] = {0, 0, 1}, I = bodies[i].inertia;
    rig *r = rig_new(3, 0.01);
    rig_touch(r, rig_body(r, 1, I, I, I), -1, zero, zero, up, 0.5)->torsion = 0.02;
    r->v[0] = 1;
    r->v[5] = 2e-15;
    const contact_set *c = rig_set(r);
    form_assembly a = {0};
    contact_memory memory = {0};
    base_error err = {0};
    check_ok(contact_memory_begin(&memory, (contact_layout){.head = 1}, c, &err), &err);
    check_ok(form_assembly_begin(&a, c, FORM_ROWS_ALL, &(form_rule){0}, &memory, &err), &err);
    assert_int_equal(a.n_row, 4);
    check_close(a.r[1], 1, 0);
    check_close(a.r[3], bodies[i].spin, 0);
    form_assembly_close(&a);
    contact_memory_close(&memory);
    free(r);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(noise_of_a_spin),
      cmocka_unit_test(block_on_incline),
      cmocka_unit_test(joints_in_and_out),
      cmocka_unit_test(errors_are_taken_back_beside_the_motion),
      cmocka_unit_test(position_rebounds_a_step_later),
      cmocka_unit_test(position_level_has_no_newton),
      cmocka_unit_test(storages_agree),
      cmocka_unit_test(exact_cones_choose_their_storage),
      cmocka_unit_test(both_forms_agree),
      cmocka_unit_test(joints_in_the_mass_form),
      cmocka_unit_test(analysis_stands_with_the_contacts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
