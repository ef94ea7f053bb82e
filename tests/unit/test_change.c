/* Formulations that take turns in every step: the motion, the bits, the work of warm starts. */
#include "tests/support/check.h"

#include "harness/control/simulation.h"
#include "harness/measure/simulate_state.h"

#include <string.h>

typedef struct way {
  const char *form, *solver;
} way;

enum { STEPS = 40, BOUNCES = 300 };

typedef struct motion {
  int n_step, n_body;
  double *place; /* 3 n_body a step [m] */
  long work;     /* iterations of the solver */
  uint64_t hash;
} motion;

static simulation *opened(const char *scene, way w, const char *start) {
  simulation *s = calloc(1, sizeof *s);
  base_error err = {0};
  const simulation_texts t = {
      .scene = scene, .formulation = w.form, .solver = w.solver, .start = start};
  check_ok(simulation_open(&t, s, &err), &err);
  return s;
}

static void closed(simulation *s) {
  simulation_close(s);
  free(s);
}

static void note_places(const sim *s, motion *m, int step) {
  for (int j = 0; j < m->n_body; j++) {
    double quat[4];
    world_body_pose(s->w, j, m->place + 3 * ((ptrdiff_t)step * m->n_body + j), quat);
  }
}

static void take_steps(sim *s, series *record, simulation *first, simulation *second, motion *m) {
  base_error err = {0};
  for (int i = 0; i < m->n_step; i++) {
    bool taken;
    const simulation *next = (i % 2 == 0) ? first : second;
    if (i > 0 && second != NULL) {
      check_ok(sim_change_combination(s, &next->form, &next->solver, &err), &err);
    }
    check_ok(sim_step(s, record, first->request.h, &taken, &err), &err);
    assert_true(taken);
    note_places(s, m, i);
  }
}

/* Steps by the two in turn, or by the first alone, `most` of them. */
static motion run(simulation *first, simulation *second, int most) {
  base_error err = {0};
  sim s;
  series record;
  sim_result out;
  check_ok(sim_open(&s, &first->request, &record, &out, &err), &err);
  const int planned = (int)out.steps_planned;
  motion m = {.n_step = (planned < most) ? planned : most, .n_body = world_n_body(s.w)};
  m.place = calloc(3 * (size_t)m.n_body * (size_t)m.n_step, sizeof *m.place);
  take_steps(&s, &record, first, second, &m);
  if (out.status != RUN_OK) {
    fail_msg("%s by %s: %s", first->spec.id, first->form.config, out.note);
  }
  m.work = out.work.iterations;
  m.hash = out.hash;
  series_close(&record);
  sim_close(&s);
  return m;
}

static double apart(const motion *a, const motion *b) {
  double most = 0.0;
  for (int i = 0; i < 3 * a->n_body * a->n_step; i++) {
    most = fmax(most, fabs(a->place[i] - b->place[i]));
  }
  return most;
}

enum { WAYS_MOST = 10 };
typedef struct all_alone {
  const way *way;
  int n;
  simulation *sim[WAYS_MOST];
  motion warm[WAYS_MOST], cold[WAYS_MOST];
} all_alone;

static void open_all(const char *scene, const way *w, int n, int most, all_alone *out) {
  *out = (all_alone){.way = w, .n = n};
  for (int k = 0; k < n; k++) {
    simulation *cold = opened(scene, w[k], "cold");
    out->sim[k] = opened(scene, w[k], "previous");
    out->warm[k] = run(out->sim[k], NULL, most);
    out->cold[k] = run(cold, NULL, most);
    closed(cold);
  }
}

static void close_all(all_alone *a) {
  for (int k = 0; k < a->n; k++) {
    free(a->warm[k].place);
    free(a->cold[k].place);
    closed(a->sim[k]);
  }
}

/* Contact with friction lets no two motions drift apart, so what the two formulations differ by in their steps adds up to no
 * more than what they are apart alone: as much on the way to either, and once more for what a hand-over leaves out. Below
 * `floor` the solvers' tolerances are what is seen, through bristles that four corners share (1e-9 m with one each). */
static void expect_between(const char *scene, const all_alone *all, int a, int b, const motion *m) {
  const double floor = 4e-9; /* [m] */
  const double bound = 2.0 * apart(&all->warm[a], &all->warm[b]) + floor;
  const double got = fmax(apart(m, &all->warm[a]), apart(m, &all->warm[b]));
  if (!(got <= bound)) {
    fail_msg("%s, %s and %s in turn: %g m from either, need %g m", scene, all->way[a].form,
             all->way[b].form, got, bound);
  }
}

static const way with_memory[] = {{"velocity", "lemke"},
                                  {"position", "lemke"},
                                  {"coulomb", "nsgs:tol=1e-11"},
                                  {"boxed", "ppm"},
                                  {"boxed:bristle=1e6,damper=1e3", "ppm"},
                                  {"regularized", "lemke"},
                                  {"regularized:ratio=1000", "lemke"},
                                  {"acceleration", "lemke"},
                                  {"event", "lemke"}};
/* The last two take no start from the last step, whoever took it. */
enum { WARM = 7 };

static void turns_keep_the_motion(void **state) {
  (void)state;
  static const char *const scenes[] = {"stack:n=3", "incline", "slide"};
  long work = 0;
  long cold = 0;
  for (int k = 0; k < CHECK_FEWER(BASE_COUNT(scenes)); k++) {
    all_alone all;
    open_all(scenes[k], with_memory, BASE_COUNT(with_memory), STEPS, &all);
    for (int i = 0; i < all.n * all.n; i++) {
      const int a = i / all.n, b = i % all.n;
      if (a == b) {
        continue;
      }
      motion m = run(all.sim[a], all.sim[b], STEPS);
      const long both = (all.cold[a].work + all.cold[b].work) / 2;
      expect_between(scenes[k], &all, a, b, &m);
      if (a < WARM && b < WARM) { /* where either has to find its vertex anew it may be dearer */
        assert_true((double)m.work <= 1.2 * (double)both);
        work += m.work;
        cold += both;
      }
      free(m.place);
    }
    close_all(&all);
  }
  assert_true(3 * work < cold);
}

/* Changed for itself, nothing of what a formulation remembers is lost. */
static void the_same_goes_on_bit_for_bit(void **state) {
  (void)state;
  for (int k = 0; k < BASE_COUNT(with_memory) - 1; k++) {
    simulation *a = opened("slide", with_memory[k], "previous");
    simulation *b = opened("slide", with_memory[k], "previous");
    motion alone = run(a, NULL, STEPS);
    motion turns = run(a, b, STEPS);
    assert_int_equal(alone.work, turns.work);
    assert_true(alone.hash == turns.hash);
    free(alone.place);
    free(turns.place);
    closed(a);
    closed(b);
  }
}

/* Nor of the speed at which contacts closed, by which `penalty` lets them part. */
static void a_penalty_in_the_middle_of_an_impact_goes_on(void **state) {
  (void)state;
  static const way penalty = {"penalty", "lemke"};
  simulation *a = opened("impact", penalty, "previous");
  simulation *b = opened("impact", penalty, "previous");
  motion alone = run(a, NULL, BOUNCES);
  motion turns = run(a, b, BOUNCES);
  assert_true(alone.n_step > 10);
  assert_memory_equal(alone.place, turns.place, 3 * (size_t)alone.n_step * sizeof *alone.place);
  free(alone.place);
  free(turns.place);
  closed(a);
  closed(b);
}

/* `position` meets an impact in one step and gives it back in the next: whoever takes that one does. */
static void an_impact_that_is_owed_is_given_back(void **state) {
  (void)state;
  static const way both[] = {{"position:restitution=two_steps", "lemke"},
                             {"velocity", "lemke"},
                             {"coulomb", "nsgs:tol=1e-11"}};
  all_alone all;
  open_all("bounce", both, BASE_COUNT(both), BOUNCES, &all);
  for (int b = 1; b < all.n; b++) {
    for (int turn = 0; turn < 2; turn++) {
      motion m = run(all.sim[turn == 0 ? 0 : b], all.sim[turn == 0 ? b : 0], BOUNCES);
      expect_between("bounce", &all, 0, b, &m);
      free(m.place);
    }
  }
  close_all(&all);
}

/* The same from the texts of a command line, at the steps that they name. */
static void texts_name_steps(void **state) {
  (void)state;
  base_error err = {0};
  simulation *s = opened(
      "slide", (way){"velocity/10:boxed/20:regularized", "lemke/10:ppm/20:lemke"}, "previous");
  series record;
  sim_result out;
  assert_int_equal(s->combinations.n, 3);
  assert_string_equal(combination_plan_at(&s->combinations, 9)->form.form->name, "velocity");
  assert_string_equal(combination_plan_at(&s->combinations, 10)->solver.solver->name, "ppm");
  check_ok(simulation_run(s, &record, &out, &err), &err);
  assert_int_equal(out.status, RUN_OK);
  assert_true(out.n_modes > 0); /* of the last */
  series_close(&record);
  closed(s);
  static const way wrong[] = {{"velocity/10:boxed/10:velocity", "ppm"},
                              {"velocity/boxed", "ppm"},
                              {"velocity/0:boxed", "ppm"},
                              {"velocity/5:nothing", "ppm"},
                              {"velocity", "ppm/x:lemke"}};
  for (int k = 0; k < BASE_COUNT(wrong); k++) {
    simulation r;
    const simulation_texts t = {
        .scene = "slide", .formulation = wrong[k].form, .solver = wrong[k].solver};
    assert_int_equal(simulation_open(&t, &r, &err), BASE_EINVAL);
    simulation_close(&r);
  }
  simulation_texts t = {.scene = "slide", .formulation = "velocity/5:boxed", .solver = "ppm"};
  for (int k = 0; k < 2; k++) { /* who chooses steps or effects has one formulation */
    simulation r;
    t.error = (k == 0) ? "1%" : NULL;
    t.effects = (k == 1) ? "auto:1e-3" : NULL;
    assert_int_equal(simulation_open(&t, &r, &err), BASE_EINVAL);
    simulation_close(&r);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(turns_keep_the_motion),
      cmocka_unit_test(the_same_goes_on_bit_for_bit),
      cmocka_unit_test(a_penalty_in_the_middle_of_an_impact_goes_on),
      cmocka_unit_test(an_impact_that_is_owed_is_given_back),
      cmocka_unit_test(texts_name_steps),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
