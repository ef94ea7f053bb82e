/* cone_newton and cone_ipm on the friction problems of other codes, those of this repository and the others where they lie
 * beside the clone: solved, judged, and in not many more factorisations than when this was written. */
#include "tests/support/check.h"

#include "lcp/lcp_instance.h"
#include "problems/import/import.h"
#include "tests/support/files.h"
#include "tests/support/imported.h"

#include <stdio.h>
#include <string.h>

typedef struct entry {
  const char *file; /* below data/ */
  bool here;        /* in tests/data */
  int steps;        /* Newton's, from zero to 1e-10, a third more than measured */
  int ipm;          /* factorisations of cone_ipm, twice those measured */
} entry;

static const entry entries[] = {
    {"friction/BoxesStack1-i100000-32.hdf5.dat", false, 22, 44},
    {"friction/Capsules-i100-889.dat", false, 28, 404},
    {"friction/Capsules-i101-404.dat", false, 36, 516},
    {"friction/Confeti-ex03-Fc3D-SBM.dat", false, 16, 46},
    {"friction/FrictionContactProblem00031.dat", true, 6, 20},
    {"friction/FrictionContactProblem00237.dat", false, 26, 210},
    {"friction/GRFC3D_Chute-ndof-768-nc-4-3.dat", true, 6, 30},
    {"friction/NESpheres_10_1.dat", true, 10, 24},
    {"friction/NESpheres_30_1.dat", false, 8, 30},
    {"friction/OneObject-i100000-316.hdf5.dat", true, 14, 86},
    {"friction/OneObject-i1028-138.hdf5.dat", false, 18, 70},
    {"friction/Rover1039.dat", true, 12, 16},
    {"friction/Rover1040.dat", false, 15, 32},
    {"friction/fc2d_granularflowonwall_00667_00000.dat", false, 14, 248},
    {"friction/rockfall_14_25792.dat", true, 40, 112},
    {"fclib/Box_Stacks-i0122-82-5.hdf5", true, 8, 26},
    {"fclib/Capsules-i125-1213.hdf5", false, 30, 506},
    {"fclib/Chute-ndof-768-nc-4-3.hdf5", true, 6, 30},
    {"fclib/LMGC_100_PR_PerioBox-i00361-60-03000.hdf5", false, 20, 22},
    {"fclib/LMGC_GlobalFrictionContactProblem00046.hdf5", true, 8, 12},
    {"fclib/Spheres-i099-356-679.hdf5", false, 14, 68},
};

/* Solved within 1e-9; returns the work of it. */
static lcp_work solve_file(const char *path, const char *solver) {
  const lcp_solver *s = lcp_solver_find(solver);
  _Alignas(16) unsigned char opt[512] = {0};
  known_lcp k;
  base_error err = {0};
  lcp_instance *run;
  lcp_result res;
  lcp_verdict v;
  check_ok(imported_problem(path, 0, &k, &err), &err);
  double *z = calloc((size_t)k.p.M.n + 1, sizeof *z);
  assert_non_null(z);
  const lcp_capacity cap = lcp_problem_capacity(&k.p);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&run, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(run, &k.p, &err), &err);
  check_ok(lcp_instance_solve(run, NULL, z, &res, &err), &err);
  check_ok(lcp_judge(&k.p, z, &v, &err), &err);
  print_message("%s, %s: %s, %ld steps, %ld factorisations, rho %.1e\n", path, solver,
                lcp_outcome_name(res.outcome), res.work.iterations, res.work.factorizations, v.rho);
  assert_string_equal(lcp_outcome_name(res.outcome), "ok");
  assert_true(v.rho <= 1e-9);
  lcp_instance_close(run);
  free(z);
  known_lcp_free(&k);
  return res.work;
}

static void friction_files_are_solved(void **state) {
  (void)state;
  int solved = 0;
  for (int i = 0; i < BASE_COUNT(entries); i++) {
    char name[256];
    (void)snprintf(name, sizeof name, "data/%s", entries[i].file);
    const char *path = entries[i].here ? tests_file(name) : shared_file(name);
    if (entries[i].here || file_exists(path)) {
      assert_true(solve_file(path, "cone_newton").iterations <= entries[i].steps);
      assert_true(solve_file(path, "cone_ipm").factorizations <= entries[i].ipm);
      solved++;
    }
  }
  print_message("%d of %d files, the others are not beside the clone\n", solved,
                BASE_COUNT(entries));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(friction_files_are_solved)};
  return cmocka_run_group_tests_name("cone_files", tests, NULL, NULL);
}
