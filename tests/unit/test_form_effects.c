/* What a scene does not declare costs no unknown: counts per formulation with effects switched. */
#include "tests/support/check.h"

#include "formulations/formulation.h"
#include "problems/read/scene_file.h"
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

/* Dofs that a plan of these effects leaves: 2 or 3 translations, 1 or 3 rotations where declared, less
 * what the body's own data lock or prescribe. */
static int planned_dofs(const scene_spec *s, unsigned effects) {
  const bool turns = (effects & EFFECT_ROTATION) != 0;
  const unsigned move = (s->dim == 2) ? SPEC_X | SPEC_Y : SPEC_X | SPEC_Y | SPEC_Z;
  const unsigned spin = (s->dim == 2) ? SPEC_RZ : SPEC_ROT;
  int n = 0;
  for (int b = 0; b < s->n_body; b++) {
    const spec_body *body = &s->body[b];
    const unsigned all = (move | (turns ? spin : 0u)) & ~(body->lock | body->prescribed);
    for (unsigned bit = 1; bit <= SPEC_RZ && !body->kinematic; bit <<= 1) {
      n += (all & bit) != 0;
    }
  }
  return n;
}

/* Rows exist for declared effects with a coefficient above zero, and for nothing else. */
static void check_rows(const char *name, const contact_set *c, unsigned effects) {
  const bool joints = (effects & EFFECT_JOINTS) != 0;
  assert_true((c->restitution == NULL) || (effects & EFFECT_RESTITUTION) != 0);
  assert_true((c->mu_torsion == NULL) || (effects & EFFECT_TORSION) != 0);
  assert_true((c->mu_rolling == NULL) || (effects & EFFECT_ROLLING) != 0);
  assert_true(joints || c->n_group == c->n_contact);
  for (int i = 0; i < c->n_contact; i++) {
    const contact_rows r = c->rows[i];
    const bool rubs = (effects & EFFECT_FRICTION) != 0 && c->mu_static[i] > 0;
    const bool drills = c->mu_torsion != NULL && c->mu_torsion[i] > 0;
    const bool rolls = c->mu_rolling != NULL && c->mu_rolling[i] > 0;
    const int rolling = rolls ? c->dim - 1 : 0;
    if (r.tangent != (rubs ? c->dim - 1 : 0) || r.torsion != drills || r.rolling != rolling ||
        c->row_start[i + 1] - c->row_start[i] != 1 + r.tangent + r.torsion + r.rolling) {
      fail_msg("%s: contact %d has rows %d %d %d", name, i, r.tangent, r.torsion, r.rolling);
    }
  }
}

enum { FACETS = 6 };

static int facets_of(int rows) {
  return (rows == 0) ? 0 : ((rows == 1) ? 2 : FACETS) + 1; /* and a sigma */
}

/* Unknowns of a contact with these rows. */
static int unknowns(const formulation *f, contact_rows r) {
  if ((f->model & FORM_CONE_POLYHEDRAL) != 0) {
    return 1 + facets_of(r.tangent) + facets_of(r.torsion) + facets_of(r.rolling);
  }
  const bool rows = (f->model & (FORM_CONE_EXACT | FORM_BOUNDS_LAGGED)) != 0;
  return (rows && (f->model & FORM_REGULARISED) == 0) ? 1 + r.tangent + r.torsion + r.rolling : 1;
}

static void check_unknowns(const char *name, const formulation *f, const contact_set *c) {
  const bool facets = (f->model & FORM_CONE_POLYHEDRAL) != 0;
  formulation_run *run = rig_open(f->name, facets ? "facets=6" : "");
  base_error err = {0};
  lcp_problem p = {0};
  formulation_answer a = {0};
  const double *z0;
  bool pending;
  check_ok(formulation_begin(run, c, FORM_COLD, &err), &err);
  check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
  formulation_answer_of(run, &a);
  int want = 0;
  for (int i = 0; i < c->n_contact; i++) {
    want += (a.bias[i] < HUGE_VAL) ? unknowns(f, c->rows[i]) : 0;
  }
  if ((pending ? p.M.n : 0) != want) {
    fail_msg("%s, %s: %d unknowns, want %d", name, f->name, pending ? p.M.n : 0, want);
  }
  rig_close(run);
}

/* A scene with the given effects: its dofs, rows, and the unknowns of every formulation that poses a
 * problem of contacts on their own (`acceleration` counts its sliding ones as one: see its tests). */
static void check_plan(const char *name, const scene_spec *s, unsigned effects) {
  base_error err = {0};
  world *w;
  contact_set c;
  int n;
  const formulation *const *all = formulations(&n);
  check_ok(world_open(&w, s, effects, &err), &err);
  check_ok(world_contacts(w, s->h[0], -1, &c, &err), &err);
  if (s->model == NULL) {
    assert_int_equal(c.n_dof, planned_dofs(s, effects));
  }
  check_rows(name, &c, effects);
  for (int f = 0; f < n; f++) {
    if ((all[f]->model & (FORM_NO_LCP | FORM_ACCELERATION)) == 0) {
      check_unknowns(name, all[f], &c);
    }
  }
  world_close(w);
}

/* Every scene as declared, and with each effect of contact or rotation dropped in turn. */
static void every_scene_costs_what_it_declares(void **state) {
  (void)state;
  static const unsigned dropped[] = {
      0, EFFECT_FRICTION, EFFECT_RESTITUTION, EFFECT_ROTATION, EFFECT_ROLLING, EFFECT_TORSION};
  int n;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < BASE_COUNT(dropped); k++) {
      base_error err = {0};
      scene_spec s;
      check_ok(scene_load(all[i]->name, &s, &err), &err);
      if (k == 0 || (s.effects & dropped[k]) != 0) {
        check_plan(all[i]->name, &s, s.effects & ~dropped[k]);
      }
      spec_free(&s);
    }
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

/* A scene is refused where something that occurs in it is declared as lacking, in one line that names it, and by
 * its data alone: effects that are switched on without occurring are no reason. */
static void what_a_formulation_lacks_is_refused(void **state) {
  (void)state;
  static const struct {
    const char *scene, *form, *effects, *says; /* NULL: admitted */
  } rows[] = {
      {"woodpecker", "event", "declared",
       "event: needs bodies, the scene has generalised coordinates"},
      {"slider_crank", "acceleration", "declared",
       "acceleration: needs bodies, the scene has generalised coordinates"},
      {"woodpecker", "velocity", "declared", NULL},
      {"billiard", "acceleration", "declared", "acceleration: does not simulate rolling torsion"},
      {"billiard", "penalty", "declared", "penalty: does not simulate rolling torsion"},
      {"billiard", "penalty", "-torsion,-rolling", NULL},
      {"billiard", "velocity", "all", NULL},
      {"bounce", "event", "all", NULL},
      {"bounce", "acceleration", "all", NULL},
  };
  for (int i = 0; i < BASE_COUNT(rows); i++) {
    base_error err = {0};
    scene_spec spec;
    unsigned effects;
    world *w;
    check_ok(scene_load(rows[i].scene, &spec, &err), &err);
    check_ok(effects_override(spec.effects, rows[i].effects, &effects, &err), &err);
    check_ok(world_open(&w, &spec, effects, &err), &err);
    const base_status got = formulation_admits(formulation_find(rows[i].form), w, &err);
    assert_int_equal(got, (rows[i].says != NULL) ? BASE_EUNSUPPORTED : BASE_OK);
    if (rows[i].says != NULL) {
      assert_string_equal(err.text, rows[i].says);
    }
    world_close(w);
    spec_free(&spec);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(undeclared_effects_cost_nothing),
      cmocka_unit_test(every_scene_costs_what_it_declares),
      cmocka_unit_test(steps_do_not_allocate),
      cmocka_unit_test(frictionless_velocity_is_normal),
      cmocka_unit_test(dimensions_in_closed_form),
      cmocka_unit_test(what_a_formulation_lacks_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
