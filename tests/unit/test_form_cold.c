/* A cold step takes nothing from the steps before it but the state of the model: it has the bits of the same step
 * of a fresh run that begins from that state. */
#include "tests/support/check.h"

#include "formulations/regularized/regularized.h"
#include "tests/support/rig.h"
#include "tests/support/tableau.h"

#include <string.h>

enum { STEPS = 25 };

/* A box that slides and spins on its corners, and is still doing so after STEPS. */
static rig *sliding_box(void) {
  rig *r = rig_box(3, 0.005, 0.4, 0.1);
  r->v[0] = 3.0;
  r->v[1] = 1.0;
  r->v[5] = 2.0;
  return r;
}

static void same_bits(const rig *a, const rig *b) {
  const size_t n = (size_t)a->set.n_dof, rows = (size_t)a->set.n_row;
  assert_memory_equal(a->answer.v_next, b->answer.v_next, n * sizeof(double));
  assert_memory_equal(a->answer.impulse, b->answer.impulse, rows * sizeof(double));
  double size = 0.0;
  for (size_t i = 0; i < rows; i++) {
    size += fabs(a->answer.impulse[i]);
  }
  assert_true(size > 0.0);
  assert_int_equal(a->answer.work.solves, b->answer.work.solves);
}

static void cold_steps_are_fresh(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
  } all[] = {{"normal", ""},
             {"velocity", "facets=8"},
             {"velocity", "joints=mixed,storage=csc"},
             {"position", ""},
             {"boxed", ""},
             {"coulomb", ""},
             {"acceleration", ""},
             {"regularized", "model=viscous"},
             {"regularized", "model=viscous,form=mass"},
             {"regularized", "model=viscous,modes=secant"},
             {"regularized", "model=viscous,pose=cone"},
             {"velocity", "restitution=poisson"},
             {"position", "restitution=two_steps"}};
  for (int f = 0; f < BASE_COUNT(all); f++) {
    rig *old = sliding_box();
    formulation_run *past = rig_open(all[f].form, all[f].opt);
    for (int k = 0; k < STEPS; k++) {
      rig_step(old, past);
    }
    rig *young = malloc(sizeof *young);
    memcpy(young, old, sizeof *young);
    formulation_run *fresh = rig_open(all[f].form, all[f].opt);
    rig_step(old, past);
    rig_step(young, fresh);
    same_bits(old, young);
    rig_close(past);
    rig_close(fresh);
    free(old);
    free(young);
  }
}

extern const formulation form_regularized;

/* rig_step on a bare state. */
static void step_of(rig *r, regularized *s, const reg_options *o) {
  base_error err = {0};
  const formulation *f = &form_regularized;
  check_ok(f->begin(s, rig_set(r), o, FORM_COLD, &err), &err);
  for (;;) {
    lcp_problem p;
    const double *z0;
    bool pending;
    check_ok(f->assemble(s, &p, &z0, &pending, &err), &err);
    if (!pending) {
      break;
    }
    double *z = calloc((size_t)p.M.n, sizeof *z);
    check_ok(f->recover(s, z, tableau_solve(&p, z), &err), &err);
    free(z);
  }
  f->answer(s, &r->answer);
  memcpy(r->v, r->answer.v_next, (size_t)r->set.n_dof * sizeof *r->v);
  for (int k = 0; k < 3; k++) {
    r->x[0][k] += r->h * r->v[k];
  }
  r->t += r->h;
}

/* Deflections stay, since they are forces; modes, directions, factors and impulses do not. */
static void cold_bristles_keep_deflections_alone(void **state) {
  (void)state;
  static const char *const options[] = {"", "form=mass", "model=lugre"};
  for (int f = 0; f < BASE_COUNT(options); f++) {
    base_error err = {0};
    reg_options o;
    base_fields_default(form_regularized.fields, form_regularized.n_fields, &o);
    check_ok(
        base_fields_parse(form_regularized.fields, form_regularized.n_fields, &o, options[f], &err),
        &err);
    rig *old = sliding_box();
    regularized *past = calloc(1, sizeof *past), *fresh = calloc(1, sizeof *fresh);
    for (int k = 0; k < STEPS; k++) {
      step_of(old, past, &o);
    }
    rig *young = malloc(sizeof *young);
    memcpy(young, old, sizeof *young);
    check_ok(contact_memory_begin(&fresh->memory, reg_layout(rig_set(young)), rig_set(young), &err),
             &err);
    double deflection = 0.0;
    for (int i = 0; i < young->set.n_contact; i++) {
      const double *from = contact_memory_now(&past->memory, i);
      double *to = contact_memory_now(&fresh->memory, i);
      to[PAST_CLOSED] = from[PAST_CLOSED];
      to[PAST_SLIDES] = from[PAST_SLIDES];
      to[PAST_SPRUNG] = from[PAST_SPRUNG];
      const int pulls = contact_memory_pulls(&past->memory);
      for (int k = 0; k < past->memory.layout.pull; k += PAST_PULL_NUMBERS) {
        memcpy(to + pulls + k, from + pulls + k, PAST_PULL_NUMBERS * sizeof *to);
        deflection += fabs(from[pulls + k]);
      }
    }
    assert_true(deflection > 0.0);
    step_of(old, past, &o);
    step_of(young, fresh, &o);
    same_bits(old, young);
    form_regularized.close(past);
    form_regularized.close(fresh);
    free(past);
    free(fresh);
    free(old);
    free(young);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cold_steps_are_fresh),
      cmocka_unit_test(cold_bristles_keep_deflections_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
