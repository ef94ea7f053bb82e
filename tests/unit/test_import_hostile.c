/* Malformed files of other codes are refused in one line, and nothing is allocated that a file does not hold. */
#include "problems/import/import.h"
#include "tests/support/imported.h"
#include "tests/support/scratch.h"

#include <hdf5.h>
#include <string.h>

static void refused(const char *path, const char *says) {
  known_lcp k;
  base_error err = {0};
  const base_status s = imported_problem(path, 0, &k, &err);
  if (s == BASE_OK) {
    known_lcp_free(&k);
    fail_msg("accepted where it should say '%s'", says);
  }
  if ((s != BASE_EINVAL && s != BASE_EIO && s != BASE_EUNSUPPORTED) ||
      strstr(err.text, says) == NULL || strchr(err.text, '\n') != NULL) {
    fail_msg("'%s' should say '%s'", err.text, says);
  }
}

static void refused_text(const char *text, const char *says) {
  FILE *f = fopen(scratch(".dat"), "wb");
  assert_non_null(f);
  assert_true(fputs(text, f) >= 0);
  assert_int_equal(fclose(f), 0);
  refused(scratch(".dat"), says);
}

static void malformed_text_is_refused(void **state) {
  (void)state;
  refused("/nonexistent.dat", "cannot be opened");
  /* friction, dense */
  refused_text("", "neither");
  refused_text("hello world", "neither");
  refused_text("4 1 0 4 4", "neither");
  refused_text("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0", "bytes left");
  refused_text("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 0 0 0", "mu announces");
  refused_text("3 1 0 3 3 3 3 1 0 0 0 nan 0 0 0 1 0 0 0 .5", "nan");
  refused_text("3 1 0 3 3 3 3 1 0 0 0 x 0 0 0 1 0 0 0 .5", "'x'");
  refused_text("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 0 0 0 -.5", "mu");
  refused_text("3 1 0 3 3 2 3 1 0 0 0 1 0 0 0 1 0 0 0 .5", "3..3");
  refused_text("3 1000000 0 3000000 3000000 3000000 3000000 1", "bytes left");
  refused_text("3 4000000 2 12000000 12000000 1", "bytes left");
  refused_text("3 99999999999999999999 0 3 3", "neither");
  /* friction, block-sparse */
  refused_text("2 1 1 2 2 9 1 1 2 2 2 9 0 9", "bytes left");
  refused_text("2 1 1 2 2 1 1 1 1 2 2 1 0 1 0 0 1 0 0 1 0 0 .5", "end before");
  refused_text("2 1 1 2 2 1 1 1 2 2 2 1 0 1 7 0 1 0 0 1 0 0 .5", "column is '7'");
  refused_text("2 1 1 2 2 1 1 1 2 2 2 1 0 0 0 0 1 0 0 1 0 0 .5", "row index");
  refused_text("2 1 1 2 2 1 1 1 2 2 2 1 0 1 0 3 1 0 0 1 0 0 .5", "number of a block");
  /* friction, CSparse */
  refused_text("2 1 2 2 2 1\nMatlab\n2-by-2", "line of CSparse");
  refused_text("2 1 2 2 2 1\nCSparse 3\n3-by-2, nzmax: 1 nnz: 1\n", "2-by-2");
  refused_text("2 1 2 2 2 1\nCSparse 3\ntriplet: 2-by-2, nzmax: 9 nnz: 2000000\n0 0 : 1", "left");
  refused_text("2 1 2 2 2 1\nCSparse 3\ntriplet: 2-by-2, nzmax: 1 nnz: 1\n0 5 : 1\n0 0 .5",
               "column");
  refused_text("2 1 2 2 2 1\nCSparse 3\ntriplet: 2-by-2, nzmax: 1 nnz: 1\n0 0 = 1\n0 0 .5", "':'");
  /* mixed */
  refused_text("0 1 1 1 0 1 2 0 1", "flag of the whole");
  refused_text("1 1 0 0 0", "without unknowns");
  refused_text("1 1 1 2 0 1 5 0 1", "end of a block");
  refused_text("1 1 1 2 0 1 3 0 2", "flag of a block");
  refused_text("1 1 1 2 0 1 3 0 1 0 3 3 3 3 1 2 3", "bytes left");
  refused_text("1 1 1 2 0 1 3 0 1 0 3 2 3 3", "columns");
  refused_text("1 1 1 2 0 1 3 0 1 1 3 3 3 3", "storage");
  refused_text("1 1 1 0 0 1 0 0 1 1 1 1 inf 1", "inf");
  refused_text("1 1 900000 100000 0 1000000 0 0 1000000 1000000 1000000 1000000", "bytes left");
  /* LCP */
  refused_text("2 0 2 2 2 2 1 0 0", "bytes left");
}

/* ---- HDF5 ----------------------------------------------------------------------------------- */

/* Without the time of writing: every run reads the same bytes. */
static void put(hid_t file, const char *name, hid_t type, const void *x, hsize_t n) {
  const hid_t space = H5Screate_simple(1, &n, NULL);
  const hid_t timeless = H5Pcreate(H5P_DATASET_CREATE);
  assert_true(H5Pset_obj_track_times(timeless, false) >= 0);
  const hid_t id = H5Dcreate2(file, name, type, space, H5P_DEFAULT, timeless, H5P_DEFAULT);
  assert_true(id >= 0 && H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, x) >= 0);
  (void)H5Pclose(timeless);
  (void)H5Dclose(id);
  (void)H5Sclose(space);
}

typedef struct hostile {
  const char *says;
  int spacedim, m, n, nz, p[4], i[3], n_p;
  double mu[1], x[3];
} hostile;

/* One planar contact, W = [1 .5; .5 1] by rows but for what is wrong. */
static const hostile hostiles[] = {
    {"spacedim = 7", 7, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"is 3 x 2", 2, 3, 2, -2, {0, 2, 3, 3}, {0, 1, 1}, 4, {0.5}, {1, 0.5, 1}},
    {"p has 2 numbers", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 2, {0.5}, {1, 0.5, 1}},
    {"p must run from 0", 2, 2, 2, -2, {1, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"p must run from 0", 2, 2, 2, -2, {0, 2, 9, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"p decreases", 2, 2, 2, -2, {0, 4, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"outside the matrix", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 9, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"outside the matrix", 2, 2, 2, 3, {0, -1, 1, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"nz = -3", 2, 2, 2, -3, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"m = -2", 2, -2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"need 9", 2, 2, 2, 9, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}},
    {"mu", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {-0.5}, {1, 0.5, 1}},
    {"W", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, HUGE_VAL, 1}},
};

static void write_hostile(const hostile *h, bool with_x) {
  const hid_t file = H5Fcreate(scratch(".hdf5"), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  static const char *const groups[] = {"/fclib_local", "/fclib_local/W", "/fclib_local/vectors"};
  for (int g = 0; g < BASE_COUNT(groups); g++) {
    (void)H5Gclose(H5Gcreate2(file, groups[g], H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  const double q[2] = {-1.0, 1.0};
  put(file, "/fclib_local/spacedim", H5T_NATIVE_INT, &h->spacedim, 1);
  put(file, "/fclib_local/W/m", H5T_NATIVE_INT, &h->m, 1);
  put(file, "/fclib_local/W/n", H5T_NATIVE_INT, &h->n, 1);
  put(file, "/fclib_local/W/nz", H5T_NATIVE_INT, &h->nz, 1);
  put(file, "/fclib_local/W/p", H5T_NATIVE_INT, h->p, (hsize_t)h->n_p);
  put(file, "/fclib_local/W/i", H5T_NATIVE_INT, h->i, 3);
  if (with_x) {
    put(file, "/fclib_local/W/x", H5T_NATIVE_DOUBLE, h->x, 3);
  } else {
    put(file, "/fclib_local/W/x", H5T_NATIVE_INT, h->i, 3);
  }
  put(file, "/fclib_local/vectors/q", H5T_NATIVE_DOUBLE, q, 2);
  put(file, "/fclib_local/vectors/mu", H5T_NATIVE_DOUBLE, h->mu, 1);
  (void)H5Fclose(file);
}

static void malformed_hdf5_is_refused(void **state) {
  (void)state;
  const hostile good = {"", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}};
  known_lcp k;
  base_error err = {0};
  write_hostile(&good, true);
  check_ok(imported_problem(scratch(".hdf5"), 0, &k, &err), &err);
  known_lcp_free(&k);
  for (int i = 0; i < BASE_COUNT(hostiles); i++) {
    write_hostile(&hostiles[i], true);
    refused(scratch(".hdf5"), hostiles[i].says);
  }
  write_hostile(&good, false);
  refused(scratch(".hdf5"), "need a list of real numbers");
  /* truncated everywhere */
  write_hostile(&good, true);
  unsigned char bytes[32768];
  FILE *f = fopen(scratch(".hdf5"), "rb");
  assert_non_null(f);
  const size_t size = fread(bytes, 1, sizeof bytes, f);
  (void)fclose(f);
  for (size_t cut = 16; cut < size; cut += size / 23) {
    f = fopen(scratch(".hdf5"), "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, cut, f), cut);
    (void)fclose(f);
    refused(scratch(".hdf5"), "");
  }
  const hid_t empty = H5Fcreate(scratch(".hdf5"), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  (void)H5Fclose(empty);
  refused(scratch(".hdf5"), "no group");
}

/* One byte in 37 of a good file, each alone, becomes 255: lengths, addresses and types that no check before libhdf5 sees. The
 * file is refused in one line or still read, and the process that reads it survives. */
static void damaged_bytes_do_no_harm(void **state) {
  (void)state;
  const hostile good = {"", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}};
  write_hostile(&good, true);
  unsigned char bytes[32768];
  FILE *f = fopen(scratch(".hdf5"), "rb");
  assert_non_null(f);
  const size_t size = fread(bytes, 1, sizeof bytes, f);
  (void)fclose(f);
  int n_refused = 0, n_read = 0;
  for (size_t at = 0; at < size; at += 37) {
    const unsigned char was = bytes[at];
    bytes[at] = 255;
    f = fopen(scratch(".hdf5"), "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    (void)fclose(f);
    bytes[at] = was;
    known_lcp k;
    base_error err = {0};
    if (imported_problem(scratch(".hdf5"), 0, &k, &err) == BASE_OK) {
      known_lcp_free(&k);
      n_read++;
    } else {
      assert_true(err.text[0] != '\0' && strchr(err.text, '\n') == NULL);
      n_refused++;
    }
  }
  assert_true(n_refused > 10 && n_read > 10); /* both happen */
}

/* ---- HDF5, global: a good file with one dataset replaced ------------------------------------- */

typedef struct edit {
  const char *name; /* below the group of the problem */
  int n;            /* numbers put in its place; -1: nothing */
  bool real;
  double x[6];
  const char *says;
} edit;

static const edit common_edits[] = {
    {"spacedim", -1, false, {0}, "no dataset"},
    {"spacedim", 1, false, {7}, "spacedim = 7"},
    {"spacedim", 2, false, {3, 3}, "has 2 numbers"},
    {"M/m", 1, false, {-2}, "m = -2"},
    {"M/n", 1, false, {90000000}, "M"},
    {"M/nz", 1, false, {-9}, "nz = -9"},
    {"M/p", 2, false, {0, 1}, "p has 2 numbers"},
    {"M/i", 1, false, {0}, "M/x"},
    {"M/x", 1, true, {1}, "M/x"},
    {"H", -1, false, {0}, "H/m"},
    {"H/m", 1, false, {1}, "need"},
    {"H/i", -1, false, {0}, "no dataset"},
    {"vectors/f", 1, true, {0}, "M"},
    {"vectors/w", 1, true, {0}, "w: has 1"},
    {"vectors/mu", 1, true, {-0.5}, "mu"},
    {"vectors/mu", 1, false, {1}, "list of real numbers"},
    {"vectors/mu", 0, true, {0}, "0 contacts"},
};
static const edit rolling_edits[] = {
    {"vectors/mu_r", -1, false, {0}, "no dataset"},
    {"vectors/mu_r", 1, true, {-1}, "mu_r"},
    {"vectors/mu_r", 2, true, {1, 1}, "has 2 numbers"},
    {"spacedim", 1, false, {2}, "spacedim = 2"},
};

static void put_edit(const char *group, const edit *e) {
  char name[96];
  (void)snprintf(name, sizeof name, "%s/%s", group, e->name);
  const hid_t file = H5Fopen(scratch(".hdf5"), H5F_ACC_RDWR, H5P_DEFAULT);
  assert_true(file >= 0 && H5Ldelete(file, name, H5P_DEFAULT) >= 0);
  int integers[6];
  for (int i = 0; i < e->n; i++) {
    integers[i] = (int)e->x[i];
  }
  if (e->n >= 0 && e->real) {
    put(file, name, H5T_NATIVE_DOUBLE, e->x, (hsize_t)e->n);
  } else if (e->n >= 0) {
    put(file, name, H5T_NATIVE_INT, integers, (hsize_t)e->n);
  }
  (void)H5Fclose(file);
}

/* One contact of `rows` rows on `rows` + 1 dofs: M = 2, H = identity above a row of zeros. */
static void write_global(int rows) {
  char text[1024];
  int used = snprintf(text, sizeof text, "%d 1 0 %d %d %d %d\n", rows, rows + 1, rows + 1, rows + 1,
                      rows + 1);
  for (int i = 0; i < (rows + 1) * (rows + 1); i++) {
    used += snprintf(text + used, sizeof text - (size_t)used, "%d ", (i % (rows + 2) == 0) ? 2 : 0);
  }
  used += snprintf(text + used, sizeof text - (size_t)used, "\n0 %d %d %d %d\n", rows + 1, rows,
                   rows + 1, rows);
  for (int i = 0; i < rows * (rows + 1); i++) {
    used += snprintf(text + used, sizeof text - (size_t)used, "%d ", (i % (rows + 2) == 0) ? 1 : 0);
  }
  for (int i = 0; i < 2 * rows + 1; i++) {
    used += snprintf(text + used, sizeof text - (size_t)used, "-1 ");
  }
  (void)snprintf(text + used, sizeof text - (size_t)used, "0.5 %s", (rows == 5) ? "0.1" : "");
  FILE *f = fopen(scratch(".dat"), "wb");
  assert_non_null(f);
  assert_true(fputs(text, f) >= 0 && fclose(f) == 0);
  friction_problem p;
  base_error err = {0};
  check_ok(friction_read_siconos(scratch(".dat"), &p, &err), &err);
  check_ok(friction_write_fclib(scratch(".hdf5"), &p, &err), &err);
  friction_free(&p);
}

static void edits_are_refused(int rows, const char *group, const edit *list, int n) {
  known_lcp k;
  base_error err = {0};
  write_global(rows);
  check_ok(imported_problem(scratch(".hdf5"), 0, &k, &err), &err);
  known_lcp_free(&k);
  for (int i = 0; i < n; i++) {
    write_global(rows);
    put_edit(group, &list[i]);
    refused(scratch(".hdf5"), list[i].says);
  }
}

static void malformed_global_hdf5_is_refused(void **state) {
  (void)state;
  edits_are_refused(3, "/fclib_global", common_edits, BASE_COUNT(common_edits));
  edits_are_refused(5, "/fclib_global_rolling", common_edits, BASE_COUNT(common_edits));
  edits_are_refused(5, "/fclib_global_rolling", rolling_edits, BASE_COUNT(rolling_edits));
}

/* A dataset may announce what was never stored: no memory for it. */
static void empty_promises_allocate_nothing(void **state) {
  (void)state;
  const hostile good = {"", 2, 2, 2, -2, {0, 2, 3, 0}, {0, 1, 1}, 3, {0.5}, {1, 0.5, 1}};
  write_hostile(&good, true);
  const hid_t file = H5Fopen(scratch(".hdf5"), H5F_ACC_RDWR, H5P_DEFAULT);
  (void)H5Ldelete(file, "/fclib_local/vectors/mu", H5P_DEFAULT);
  const hsize_t n = 100000000;
  const hid_t space = H5Screate_simple(1, &n, NULL);
  const hid_t id =
      H5Dcreate2(file, "/fclib_local/vectors/mu", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                 H5P_DEFAULT, H5P_DEFAULT); /* late allocation: nothing is stored */
  (void)H5Dclose(id);
  (void)H5Sclose(space);
  (void)H5Fclose(file);
  refused(scratch(".hdf5"), "does not hold");
}

/* libhdf5 loses some of its own memory on damaged files; what this project allocates is still counted. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libhdf5";
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(malformed_text_is_refused),
      cmocka_unit_test(malformed_hdf5_is_refused),
      cmocka_unit_test(damaged_bytes_do_no_harm),
      cmocka_unit_test(malformed_global_hdf5_is_refused),
      cmocka_unit_test(empty_promises_allocate_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, scratch_remove);
}
