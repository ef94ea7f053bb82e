/* Every registered scene: builds from its table, and its claims are run: declared effects must show,
 * no other effect may matter, predictions must hold. Each kind of false claim is planted once. */
#include "tests/support/check.h"

#include "harness/measure/predictions.h"
#include "problems/read/scene_file.h"

#include <lapacke.h>
#include <stdio.h>
#include <string.h>

static void every_scene_builds(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  assert_true(n >= 5);
  for (int i = 0; i < n; i++) {
    scene_spec s;
    base_error err = {0};
    assert_ptr_equal(scene_find(all[i]->name), all[i]);
    check_ok(scene_load(all[i]->name, &s, &err), &err);
    assert_true(strlen(all[i]->about) > 80);
    assert_true(strlen(all[i]->title) > 5);
    if ((s.effects & ~s.present) != 0 && s.model == NULL) {
      fail_msg("%s declares effects that are not there", all[i]->name);
    }
    if (s.n_check == 0) {
      fail_msg("%s predicts nothing", all[i]->name);
    }
    for (int c = 0; c < s.n_check; c++) {
      if (!isfinite(s.check[c].value)) {
        fail_msg("%s: check %d is not finite", all[i]->name, c);
      }
    }
    spec_free(&s);
  }
}

/* Each parameter, alone, at the ends of its range: built, or refused in one line. */
static void ranges_hold(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    for (int f = 0; f < all[i]->n_fields; f++) {
      const base_field *field = &all[i]->fields[f];
      assert_non_null(field->help);
      if (field->kind == BASE_CHOICE || field->max > 1000.0) {
        continue; /* sizes in the thousands belong to the scaling study */
      }
      for (int end = 0; end < 2; end++) {
        char text[160], number[32];
        scene_spec s;
        base_error err = {0};
        base_real_print(end == 0 ? field->min : field->max, number, sizeof number);
        (void)snprintf(text, sizeof text, "%s:%s=%s", all[i]->name, field->name, number);
        if (scene_load(text, &s, &err) == BASE_OK) {
          spec_free(&s);
        } else if (strchr(err.text, '\n') != NULL || err.text[0] == '\0') {
          fail_msg("%s: not one line: '%s'", text, err.text);
        }
      }
    }
  }
}

static void wrong_parameters_are_refused(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    char text[160];
    scene_spec s;
    base_error err = {0};
    (void)snprintf(text, sizeof text, "%s:no_such_parameter=1", all[i]->name);
    assert_int_equal(scene_load(text, &s, &err), BASE_EINVAL);
    assert_non_null(strstr(err.text, "no_such_parameter"));
  }
}

/* ---- what it stands for --------------------------------------------------------------------- */

/* How many of the normal rows of the contacts at the start depend on the others. */
static int dependent_rows(const char *name) {
  scene_spec s;
  world *w;
  contact_set set;
  base_error err = {0};
  check_ok(scene_load(name, &s, &err), &err);
  check_ok(world_open(&w, &s, s.effects, &err), &err);
  check_ok(world_contacts(w, s.h[0], 1e-9, &set, &err), &err);
  const int m = set.n_contact, n = set.n_dof;
  double *J = calloc((size_t)m * (size_t)n + 1, sizeof *J);
  double *sigma = calloc((size_t)m + (size_t)n + 1, sizeof *sigma);
  double *scratch = calloc((size_t)m + (size_t)n + 1, sizeof *scratch);
  for (int i = 0; i < m; i++) {
    const double *row = set.jac + set.jac_start[i];
    const int n_rows = set.row_start[i + 1] - set.row_start[i];
    for (int side = 0; side < 2; side++) {
      const int b = set.body[2 * i + side], dofs = contact_dofs(&set, b);
      for (int d = 0; d < dofs; d++) {
        J[i * n + set.dof_start[b] + d] = row[d];
      }
      row += n_rows * dofs;
    }
  }
  int rank = 0;
  if (m > 0 && n > 0) {
    assert_int_equal(
        LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'N', m, n, J, n, sigma, NULL, 1, NULL, 1, scratch),
        0);
    for (int i = 0; i < (m < n ? m : n); i++) {
      rank += sigma[i] > 1e-10 * sigma[0];
    }
  }
  free(J);
  free(sigma);
  free(scratch);
  world_close(w);
  spec_free(&s);
  return m - rank;
}

static void says_what_it_stands_for(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  int count[SITUATION_COUNT] = {0};
  for (int i = 0; i < n; i++) {
    assert_in_range(all[i]->situation, 0, SITUATION_COUNT - 1);
    count[all[i]->situation]++;
    const int dependent = dependent_rows(all[i]->name);
    if (all[i]->redundant && dependent == 0) {
      fail_msg("%s is called redundant, and its contacts are independent", all[i]->name);
    }
  }
  for (int s = SITUATION_OTHER + 1; s < SITUATION_COUNT; s++) {
    assert_true(count[s] > 0);
    assert_true(strlen(scene_situation_name((scene_situation)s)) > 0);
    check_sentence(scene_situation_name((scene_situation)s),
                   scene_situation_words((scene_situation)s), NULL);
  }
  assert_int_equal(dependent_rows("bounce"), 0); /* the count does tell them apart */
}

/* ---- claims are run ------------------------------------------------------------------------- */

typedef enum fault {
  FAULT_NONE,
  FAULT_UNSOLVED,
  FAULT_MISSED,
  FAULT_UNDECLARED,
  FAULT_MISSING
} fault;
static const char *const fault_names[] = {"none", "no formulation solved every step",
                                          "a prediction is missed", "an undeclared effect matters",
                                          "a declared effect never shows"};

typedef struct verdict {
  bool solved;
  int n, n_missed;
  unsigned seen;
} verdict;

/* One run with the given effects; its predictions judged. */
static verdict run(const scene_spec *given, unsigned effects, const char *form,
                   const char *solver) {
  scene_spec spec = *given; /* a view; nothing of it is freed */
  formulation_choice f;
  solver_choice s;
  sim_result r = {0};
  series record = {0};
  prediction_summary p;
  base_error err = {0};
  verdict v = {0};
  spec.effects = effects;
  check_ok(formulation_choose(form, &f, &err), &err);
  check_ok(solver_choose(solver, &s, &err), &err);
  const sim_request q = {.spec = &spec,
                         .effects = effects,
                         .form = &f,
                         .solver = &s,
                         .h = spec.h[0],
                         .duration = spec.duration};
  check_ok(simulate(&q, &record, &r, &err), &err);
  predictions_summarise(&q, &record, &r, &p);
  v.solved = (r.status == RUN_OK) != spec.expect_unsolved;
  v.n = p.n;
  v.n_missed = p.n_missed;
  v.seen = r.effects_seen;
  series_close(&record);
  formulation_choice_free(&f);
  solver_choice_free(&s);
  return v;
}

/* Effects whose work a run can see; the others belong to the data. */
enum {
  VISIBLE = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_ROLLING |
            EFFECT_TORSION | EFFECT_JOINTS | EFFECT_ROTATION
};

/* At rest by symmetry: what they declare beyond contact is there for solvers to meet the whole
 * problem, and has nothing to do until the ground tilts. Then it must show: what of `unseen` does
 * not, with gravity turned by a tenth? */
static unsigned idle_until_tilted(const scene_spec *s, unsigned unseen, const char *form,
                                  const char *solver) {
  static const char *const resting[] = {"needle", "pyramid", "silo", "stack", "wall"};
  bool rests = false;
  for (int i = 0; i < BASE_COUNT(resting); i++) {
    rests = rests || strcmp(s->id, resting[i]) == 0;
  }
  if (!rests || unseen == 0) {
    return unseen;
  }
  scene_spec tilted = *s; /* a view; nothing of it is freed */
  tilted.gravity[0] = 0.1 * s->gravity[s->dim - 1];
  tilted.n_check = 0;
  return unseen & ~run(&tilted, s->effects, form, solver).seen;
}

static fault judge(const scene_spec *s) {
  static const char *const ways[][2] = {{"velocity:facets=8", "lemke"}, {"coulomb", "nsgs"}};
  verdict v = {0};
  const char *const *way = ways[0];
  for (int w = 0; w < BASE_COUNT(ways) && !v.solved; w++) {
    way = ways[w];
    v = run(s, s->effects, ways[w][0], ways[w][1]);
    if (v.solved && v.n_missed > 0) {
      const verdict all = run(s, s->effects | s->present, ways[w][0], ways[w][1]);
      return (all.solved && all.n_missed == 0) ? FAULT_UNDECLARED : FAULT_MISSED;
    }
  }
  if (!v.solved) {
    return FAULT_UNSOLVED;
  }
  /* where the only right answer is "no solution", no step is taken that could show an effect */
  const unsigned unseen =
      s->expect_unsolved ? 0u
                         : idle_until_tilted(s, s->effects & VISIBLE & ~v.seen, way[0], way[1]);
  return (unseen != 0 && s->model == NULL) ? FAULT_MISSING : FAULT_NONE;
}

static void every_claim_holds(void **state) {
  (void)state;
  int n, n_bad = 0;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    scene_spec s;
    base_error err = {0};
    check_ok(scene_load(all[i]->name, &s, &err), &err);
    const fault f = judge(&s);
    if (f != FAULT_NONE) {
      print_error("%s: %s\n", all[i]->name, fault_names[f]);
      n_bad++;
    }
    spec_free(&s);
  }
  assert_int_equal(n_bad, 0);
}

static void false_claims_are_found(void **state) {
  (void)state;
  scene_spec s;
  base_error err = {0};
  check_ok(scene_load("incline", &s, &err), &err);
  assert_int_equal(judge(&s), FAULT_NONE);
  s.effects &= ~(unsigned)EFFECT_FRICTION; /* it sticks by friction alone */
  assert_int_equal(judge(&s), FAULT_UNDECLARED);
  s.effects |= EFFECT_FRICTION | EFFECT_RESTITUTION; /* it never hits anything */
  s.restitution.dflt = 0.5;
  assert_int_equal(judge(&s), FAULT_MISSING);
  spec_free(&s);
  check_ok(scene_load("slide", &s, &err), &err);
  s.check[0].value *= 1.1;
  assert_int_equal(judge(&s), FAULT_MISSED);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scene_builds),           cmocka_unit_test(ranges_hold),
      cmocka_unit_test(wrong_parameters_are_refused), cmocka_unit_test(every_claim_holds),
      cmocka_unit_test(says_what_it_stands_for),      cmocka_unit_test(false_claims_are_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
