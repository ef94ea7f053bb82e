/* Problems of other codes as those codes wrote them (HDF5 by FCLIB with rows stored one by one, sparse-block
 * and CSparse text, remarks behind the numbers): no re-export can stand for these layouts, so they are read
 * where they lie beside the clone, and what tests/data holds is compared with them. Skipped, by name,
 * elsewhere. */
#include "tests/support/files.h"
#include "tests/support/imported.h"
#include "tests/support/scratch.h"

#include <stdio.h>

static const char *original(const imported_file *f) {
  char path[256];
  (void)snprintf(path, sizeof path, "data/%s", f->name);
  return shared_file(path);
}

static const char *ours(const imported_file *f) {
  char path[256];
  (void)snprintf(path, sizeof path, "data/%s", f->name);
  return tests_file(path);
}

static void every_original_is_read(void **state) {
  (void)state;
  for (int i = 0; i < n_imported_file; i++) {
    imported_reads(&imported_files[i], original(&imported_files[i]));
  }
}

static void round_trips_of_originals_are_exact(void **state) {
  (void)state;
  for (int i = 0; i < n_imported_file; i++) {
    const imported_file *f = &imported_files[i];
    if (f->sets == 1u << LCP_CONE && f->n <= 300) {
      imported_round_trip(f, original(f));
    }
  }
}

static void the_repository_holds_their_numbers(void **state) {
  (void)state;
  for (int i = 0; i < n_imported_file; i++) {
    const imported_file *f = &imported_files[i];
    base_error err = {0};
    if (f->here && f->sets == 1u << LCP_CONE) {
      friction_problem a, b;
      imported_friction(f, original(f), &a);
      imported_friction(f, ours(f), &b);
      same_friction(&a, &b);
      friction_free(&a);
      friction_free(&b);
    } else if (f->here) {
      known_lcp a, b;
      check_ok(imported_problem(original(f), 0, &a, &err), &err);
      check_ok(imported_problem(ours(f), 0, &b, &err), &err);
      same_problem(&a.p, &b.p);
      known_lcp_free(&a);
      known_lcp_free(&b);
    }
  }
}

/* Every second row of the trajectory, to twelve digits. */
static void the_repository_holds_the_trajectory(void **state) {
  (void)state;
  enum { COLUMNS = 7, ROWS = 300 };
  FILE *a = fopen(shared_file("data/trajectories/woodpecker_every25.ref"), "r");
  FILE *b = fopen(tests_file("data/trajectories/woodpecker_every50.ref"), "r");
  assert_non_null(a);
  assert_non_null(b);
  double x = 0, y = 0;
  for (int c = 0; c < 2; c++) {
    assert_true(fscanf(a, "%lf", &x) == 1 && fscanf(b, "%lf", &y) == 1);
    check_close(y, x, 0);
  }
  for (int row = 0; row < ROWS; row++) {
    for (int c = 0; c < COLUMNS; c++) {
      assert_true(fscanf(a, "%lf", &x) == 1 && fscanf(b, "%lf", &y) == 1);
      check_close(y, x, 1e-11 * fabs(x));
    }
    for (int c = 0; c < COLUMNS; c++) {
      assert_int_equal(fscanf(a, "%lf", &x), 1);
    }
  }
  assert_int_equal(fscanf(b, "%lf", &y), EOF);
  (void)fclose(a);
  (void)fclose(b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_original_is_read),
      cmocka_unit_test(round_trips_of_originals_are_exact),
      cmocka_unit_test(the_repository_holds_their_numbers),
      cmocka_unit_test(the_repository_holds_the_trajectory),
  };
  if (!file_exists(original(&imported_files[0]))) {
    return skip_by_name(tests, BASE_COUNT(tests),
                        "the originals are not here (LCPBENCH_SHARED, ../shared)");
  }
  return cmocka_run_group_tests(tests, NULL, scratch_remove);
}
