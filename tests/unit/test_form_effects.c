/* What a scene does not declare costs no unknown: counts per formulation with effects switched. */
#include "tests/support/check.h"

#include "formulations/formulation.h"
#include "problems/scene.h"
#include "tests/support/rig.h"

#include <stdlib.h>
#include <string.h>

typedef struct count {
  const char *scene, *effects, *form, *options;
  int dof, dim;
} count;

static const count counts[] = {
    {"incline:mu=0.5", "declared", "velocity", "facets=4", 6, 24},
    {"incline:mu=0.5", "declared", "velocity", "facets=8", 6, 40},
    {"incline:mu=0.5", "declared", "position", "facets=8", 6, 40},
    {"incline:mu=0.5", "declared", "coulomb", "", 6, 12},
    {"incline:mu=0.5", "declared", "boxed", "", 6, 12},
    {"incline:mu=0.5", "declared", "regularized", "", 6, 4},
    {"incline:mu=0.5", "-friction", "velocity", "facets=8", 6, 4},
    {"incline:mu=0.5", "-friction", "coulomb", "", 6, 4},
    {"incline:mu=0.5", "-friction", "normal", "", 6, 4},
    {"incline:mu=0", "declared", "velocity", "facets=8", 6, 4},
    {"incline:mu=0.5", "-friction,-rotation", "velocity", "facets=4", 3, 4},
    {"incline:mu=0.5,dim=2", "declared", "velocity", "facets=8", 3, 8},
    {"incline:mu=0.5,dim=2", "declared", "velocity", "planar=three", 3, 6},
    {"incline:mu=0.5,dim=2", "declared", "regularized", "", 3, 2},
    {"incline:mu=0.5", "-contact", "velocity", "", 6, 0},
    {"stack:n=3", "declared", "velocity", "facets=4", 18, 72},
    {"stack:n=3", "-friction", "velocity", "facets=4", 18, 12},
};

static void undeclared_effects_cost_nothing(void **state) {
  (void)state;
  for (int i = 0; i < BASE_COUNT(counts); i++) {
    const count *k = &counts[i];
    base_error err = {0};
    scene_spec spec;
    unsigned effects;
    world *w;
    contact_set set;
    check_ok(scene_load(k->scene, &spec, &err), &err);
    check_ok(effects_override(spec.effects, k->effects, &effects, &err), &err);
    check_ok(world_open(&w, &spec, effects, &err), &err);
    check_ok(world_contacts(w, 0.01, -1, &set, &err), &err);
    assert_int_equal(set.n_dof, k->dof);
    formulation_run *run = rig_open(k->form, k->options);
    check_ok(formulation_begin(run, &set, FORM_COLD, &err), &err);
    lcp_problem p = {0};
    const double *z0;
    bool pending;
    check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
    if ((pending ? p.M.n : 0) != k->dim) {
      fail_msg("%s %s %s: %d unknowns, want %d", k->scene, k->effects, k->form, pending ? p.M.n : 0,
               k->dim);
    }
    rig_close(run);
    world_close(w);
    spec_free(&spec);
  }
}

/* After the sets have been met once, a step allocates nothing. */
static void steps_do_not_allocate(void **state) {
  (void)state;
  static const char *const forms[] = {"normal",      "velocity", "position",
                                      "regularized", "coulomb",  "boxed"};
  for (int f = 0; f < BASE_COUNT(forms); f++) {
    rig *r = rig_stack(3, 0.01, 0.5);
    formulation_run *run = rig_open(forms[f], "");
    const contact_set *set = rig_set(r);
    base_error err = {0};
    long heap = 0;
    for (int step = 0; step < 3; step++) {
      heap = check_heap_calls;
      check_ok(formulation_begin(run, set, FORM_PREVIOUS, &err), &err);
      bool pending = true;
      for (int solve = 0; solve < 3 && pending; solve++) {
        lcp_problem p;
        const double *z0;
        static double z[400];
        check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
        if (pending) {
          check_ok(formulation_recover(run, z, LCP_SOLVED, &err), &err);
        }
      }
      heap = check_heap_calls - heap;
    }
    assert_int_equal(heap, 0);
    rig_close(run);
    free(r);
  }
}

/* Without friction `velocity` poses the problem of `normal`, bit by bit: no tangential row anywhere. */
static void frictionless_velocity_is_normal(void **state) {
  (void)state;
  static const char *const forms[2][2] = {{"normal", ""}, {"velocity", "facets=16"}};
  for (int k = 0; k < 20; k++) {
    double entry[2][600] = {{0}};
    unsigned traits[2];
    for (int f = 0; f < 2; f++) {
      rig *r = (k == 0) ? rig_stack(5, 0.01, 0) : rig_random((uint64_t)k, 2 + k % 2, 0.5);
      for (int i = 0; i < r->n_contact; i++) {
        r->contact[i].mu = 0;
      }
      formulation_run *run = rig_open(forms[f][0], forms[f][1]);
      base_error err = {0};
      lcp_problem p = {0};
      const double *z0;
      bool pending;
      check_ok(formulation_begin(run, rig_set(r), FORM_COLD, &err), &err);
      check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
      assert_true(pending && p.M.n == r->n_contact && p.M.n <= 20);
      lcp_matrix_to_dense(&p.M, entry[f]);
      memcpy(entry[f] + (size_t)p.M.n * (size_t)p.M.n, p.q, (size_t)p.M.n * sizeof *p.q);
      traits[f] = p.traits;
      rig_close(run);
      free(r);
    }
    assert_memory_equal(entry[0], entry[1], sizeof entry[0]);
    assert_int_equal(traits[0], traits[1]);
  }
}

/* Unknowns of p contacts with friction: the table of formulations/README.md. */
static void dimensions_in_closed_form(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
    long planar, spatial; /* per contact */
  } rows[] = {{"normal", "", 1, 1},
              {"regularized", "", 1, 1},
              {"regularized", "model=viscous", 1, 1},
              {"regularized", "model=lugre", 1, 1},
              {"boxed", "", 2, 3},
              {"coulomb", "", 2, 3},
              {"velocity", "facets=4", 4, 6},
              {"velocity", "facets=8", 4, 10},
              {"velocity", "facets=16", 4, 18},
              {"velocity", "facets=4,planar=three", 3, 6},
              {"position", "facets=4", 4, 6},
              {"position", "facets=8", 4, 10},
              {"position", "facets=16", 4, 18},
              {"acceleration", "facets=4", 4, 6},
              {"acceleration", "facets=8", 4, 10},
              {"acceleration", "facets=16", 4, 18}};
  for (int i = 0; i < BASE_COUNT(rows); i++) {
    for (int dim = 2; dim <= 3; dim++) {
      rig *r = rig_box(dim, 0.01, 0.5, 0);
      formulation_run *run = rig_open(rows[i].form, rows[i].opt);
      rig_step(r, run);
      const long want = r->n_contact * ((dim == 2) ? rows[i].planar : rows[i].spatial);
      if (r->answer.lcp_dim != want || !r->answer.solved) {
        fail_msg("%s:%s, %d dimensions: %d unknowns, want %ld", rows[i].form, rows[i].opt, dim,
                 r->answer.lcp_dim, want);
      }
      rig_close(run);
      free(r);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(undeclared_effects_cost_nothing),
      cmocka_unit_test(steps_do_not_allocate),
      cmocka_unit_test(frictionless_velocity_is_normal),
      cmocka_unit_test(dimensions_in_closed_form),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
