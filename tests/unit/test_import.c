/* Problems of other codes, as this repository holds them: every file is read, two formats of one problem
 * agree, round trips are exact, facets and joints follow their formulas. */
#include "harness/measure/export_lcp.h"
#include "lcp/base/rng.h"
#include "lcp/io/lcp_read.h"
#include "problems/import/import.h"
#include "tests/support/files.h"
#include "tests/support/imported.h"
#include "tests/support/scratch.h"

#include <string.h>
#include <time.h>

static const char *data(const char *name) {
  char path[256];
  (void)snprintf(path, sizeof path, "data/%s", name);
  return tests_file(path);
}

static void every_file_is_read(void **state) {
  (void)state;
  int read = 0;
  for (int i = 0; i < n_imported_file; i++) {
    if (imported_files[i].here) {
      imported_reads(&imported_files[i], data(imported_files[i].name));
      read++;
    }
  }
  assert_int_equal(read, 24);
}

/* The same rolling problem in text (six digits) and HDF5. */
static void text_and_hdf5_agree(void **state) {
  (void)state;
  known_lcp a, b;
  base_error err = {0};
  check_ok(imported_problem(data("friction/GRFC3D_Chute-ndof-768-nc-4-3.dat"), 0, &a, &err), &err);
  check_ok(imported_problem(data("fclib/Chute-ndof-768-nc-4-3.hdf5"), 0, &b, &err), &err);
  double A[400], B[400];
  lcp_matrix_to_dense(&a.p.M, A);
  lcp_matrix_to_dense(&b.p.M, B);
  for (int i = 0; i < 400; i++) {
    check_close(A[i], B[i], 2e-3 * (1.0 + fabs(B[i])));
    check_close(B[i], B[i % 20 * 20 + i / 20], 0.0); /* exactly symmetric */
  }
  for (int i = 0; i < 20; i++) {
    check_close(a.p.q[i], b.p.q[i], 1e-4);
  }
  assert_int_equal(b.p.block[3].n_part, 2);
  check_close(b.p.block[3].part_mu[1], 0.1, 1e-15);
  known_lcp_free(&a);
  known_lcp_free(&b);
}

static void round_trips_are_exact(void **state) {
  (void)state;
  for (int i = 0; i < n_imported_file; i++) {
    const imported_file *f = &imported_files[i];
    if (f->here && f->sets == 1u << LCP_CONE) {
      imported_round_trip(f, data(f->name));
    }
  }
}

/* LCPs and mixed LCPs too: what `lcpbench export --format siconos` writes of them. */
static void lcp_text_round_trips_are_exact(void **state) {
  (void)state;
  for (int i = 0; i < n_imported_file; i++) {
    known_lcp a, b;
    base_error err = {0};
    if (!imported_files[i].here || imported_files[i].sets == 1u << LCP_CONE) {
      continue;
    }
    check_ok(imported_problem(data(imported_files[i].name), 0, &a, &err), &err);
    check_ok(export_lcp_text(&a.p, scratch(".dat"), &err), &err);
    check_ok(imported_problem(scratch(".dat"), 0, &b, &err), &err);
    same_problem(&a.p, &b.p);
    known_lcp_free(&a);
    known_lcp_free(&b);
  }
}

/* Only orthants and equations have this text; neighbours of one kind become one block. */
static void lcp_text_holds_what_it_can(void **state) {
  (void)state;
  static const double M[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 2},
                      q[4] = {-1, 2, 3, -4};
  lcp_block block[4] = {{.size = 1, .set = LCP_ORTHANT},
                        {.start = 1, .size = 1, .set = LCP_FREE},
                        {.start = 2, .size = 1, .set = LCP_FREE},
                        {.start = 3, .size = 1, .set = LCP_ORTHANT}};
  const lcp_problem p = {
      .M = {.storage = LCP_DENSE, .n = 4, .val = M}, .q = q, .block = block, .n_block = 4};
  known_lcp k;
  base_error err = {0};
  check_ok(export_lcp_text(&p, scratch(".dat"), &err), &err);
  check_ok(imported_problem(scratch(".dat"), 0, &k, &err), &err);
  assert_int_equal(k.p.n_block, 3);
  assert_int_equal(k.p.block[1].set, LCP_FREE);
  assert_int_equal(k.p.block[1].size, 2);
  assert_memory_equal(k.p.M.val, M, sizeof M);
  assert_memory_equal(k.p.q, q, sizeof q);
  known_lcp_free(&k);
  block[0].set = LCP_BOX;
  assert_int_equal(export_lcp_text(&p, scratch(".dat"), &err), BASE_EUNSUPPORTED);
  block[0].set = LCP_ORTHANT;
  assert_int_equal(export_lcp_text(&p, "/none/at/all", &err), BASE_EIO);
}

/* One contact, W = diag(1, 2, 2) plus coupling: the facet LCP by hand. */
static void facets_follow_the_formula(void **state) {
  (void)state;
  static const char one[] = "3\n1\n0\n3\n3\n3 3\n1 0.25 0\n0.25 2 0\n0 0 2\n-1 2 3\n0.5\n";
  FILE *f = fopen(scratch(".dat"), "wb");
  assert_non_null(f);
  assert_true(fputs(one, f) >= 0);
  assert_int_equal(fclose(f), 0);
  known_lcp k;
  base_error err = {0};
  check_ok(imported_problem(scratch(".dat"), 4, &k, &err), &err);
  assert_int_equal(k.p.M.n, 6);
  static const double want[6][6] = {
      {1, 0.25, 0, -0.25, 0, 0}, {0.25, 2, 0, -2, 0, 1}, {0, 0, 2, 0, -2, 1},
      {-0.25, -2, 0, 2, 0, 1},   {0, 0, -2, 0, 2, 1},    {0.5, -1, -1, -1, -1, 0},
  };
  static const double q[6] = {-1, 2, 3, -2, -3, 0};
  double M[36];
  lcp_matrix_to_dense(&k.p.M, M);
  for (int i = 0; i < 6; i++) {
    for (int j = 0; j < 6; j++) {
      check_close(M[6 * j + i], want[i][j], 1e-15);
    }
    check_close(k.p.q[i], q[i], 2e-15);
  }
  known_lcp_free(&k);
  double r[3];
  friction_facet_impulse(3, 1, 4, (const double[]){2, 0, 0.5, 0.25, 0, 9}, r);
  check_close(r[0], 2.0, 0.0);
  check_close(r[1], -0.25, 1e-15);
  check_close(r[2], 0.5, 1e-15);
}

/* One contact that rolls and slides along x: the facets hold that direction, so the polyhedral answer
 * is the one on the true cone, r = (1, -mu, 0, -mu_r, 0) times the normal impulse. */
static void rolling_facets_hold_the_cone_along_them(void **state) {
  (void)state;
  FILE *f = fopen(scratch(".dat"), "wb");
  assert_non_null(f);
  assert_true(fputs("5\n1\n0\n5\n5\n5 5\n1 0 0 0 0 0 1 0 0 0 0 0 1 0 0 0 0 0 2 0 0 0 0 0 2\n"
                    "-1 3 0 2 0\n0.5\n0.1\n",
                    f) >= 0);
  assert_int_equal(fclose(f), 0);
  for (int nd = 4; nd <= 16; nd *= 2) {
    import_posed p;
    lcp_verdict v;
    base_error err = {0};
    double z[35] = {0}, r[5];
    check_ok(import_pose(scratch(".dat"), nd, &p, &err), &err);
    assert_int_equal(p.posed.p.M.n, 2 * nd + 3);
    assert_int_equal(p.cone.p.M.n, 5);
    z[0] = 1.0;               /* r_n */
    z[1 + nd / 2] = 0.5;      /* friction against +x */
    z[1 + nd] = 3.0 - 0.5;    /* its sigma: the speed left */
    z[2 + nd + nd / 2] = 0.1; /* rolling against +x */
    z[2 + 2 * nd] = 2.0 - 0.2;
    friction_facet_impulse(5, 1, nd, z, r);
    static const double want[5] = {1.0, -0.5, 0.0, -0.1, 0.0};
    for (int i = 0; i < 5; i++) {
      check_close(r[i], want[i], 1e-15);
    }
    check_ok(lcp_judge(&p.posed.p, z, &v, &err), &err);
    check_close(v.rho, 0.0, 1e-14);
    check_ok(import_judge_cone(&p, z, &v, &err), &err);
    check_close(v.natural, 0.0, 1e-14);
    z[2 + nd + nd / 2] = 0.2; /* outside the rolling cone: the judge must see it */
    check_ok(import_judge_cone(&p, z, &v, &err), &err);
    assert_true(v.natural > 0.05 && v.infeasible_z > 0.05);
    import_posed_free(&p);
  }
}

/* ---- joints --------------------------------------------------------------------------------- */

static lcp_csc csc_of(int n_row, int n_col, const double *by_rows) {
  int *colptr = calloc((size_t)n_col + 1, sizeof *colptr);
  int *rowind = malloc((size_t)(n_row * n_col) * sizeof *rowind);
  double *val = malloc((size_t)(n_row * n_col) * sizeof *val);
  int nnz = 0;
  for (int j = 0; j < n_col; j++) {
    for (int i = 0; i < n_row; i++) {
      if (by_rows[i * n_col + j] != 0.0) {
        rowind[nnz] = i;
        val[nnz++] = by_rows[i * n_col + j];
      }
    }
    colptr[j + 1] = nnz;
  }
  return (lcp_csc){n_row, n_col, colptr, rowind, val};
}

static double *copy_of(const double *x, int n) {
  double *y = malloc((size_t)n * sizeof *y);
  memcpy(y, x, (size_t)n * sizeof *y);
  return y;
}

/* A unit mass that touches the ground (normal y, tangent x), welded to another one: dofs x, y of each. The
 * contact feels both masses: W = 1/2; both fall with (0.5, -1), b lets the weld open at 0.2 along x. */
static friction_problem welded(bool global) {
  static const double M[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  static const double H[8] = {0, 1, 1, 0, 0, 0, 0, 0}, G[8] = {1, 0, 0, 1, -1, 0, 0, -1};
  static const double W[4] = {1, 0, 0, 1}, V[4] = {0, 1, 1, 0}, R[4] = {2, 0, 0, 2};
  static const double f[4] = {0.5, -1, 0.5, -1}, b[2] = {-0.2, 0}, q[2] = {-1, 0.5}, mu = 0.3;
  friction_problem p = {.rows = 2, .n_contact = 1, .global = global, .n_joint = 2};
  p.mu = copy_of(&mu, 1);
  if (global) {
    p.M = csc_of(4, 4, M);
    p.H = csc_of(4, 2, H);
    p.G = csc_of(4, 2, G);
    p.f = copy_of(f, 4);
    p.w = copy_of((const double[]){0, 0}, 2);
    p.b = copy_of(b, 2);
  } else {
    p.W = csc_of(2, 2, W);
    p.V = csc_of(2, 2, V);
    p.R = csc_of(2, 2, R);
    p.q = copy_of(q, 2);
    p.s = copy_of(b, 2);
  }
  return p;
}

static size_t bytes_of(const char *path, unsigned char *bytes, size_t n) {
  FILE *f = fopen(path, "rb");
  assert_non_null(f);
  const size_t size = fread(bytes, 1, n, f);
  (void)fclose(f);
  return size;
}

/* Two exports of one problem are the same bytes, also in different seconds. */
static void exports_hold_no_time(void **state) {
  (void)state;
  static unsigned char first[65536], second[65536];
  base_error err = {0};
  friction_problem p = welded(true);
  check_ok(friction_write_fclib(scratch(".hdf5"), &p, &err), &err);
  const size_t size = bytes_of(scratch(".hdf5"), first, sizeof first);
  const time_t written = time(NULL);
  while (time(NULL) <= written) {
    (void)nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
  }
  check_ok(friction_write_fclib(scratch(".hdf5"), &p, &err), &err);
  assert_true(size > 1000 && size < sizeof first);
  assert_int_equal(bytes_of(scratch(".hdf5"), second, sizeof second), size);
  assert_memory_equal(first, second, size);
  friction_free(&p);
}

static void joints_are_eliminated(void **state) {
  (void)state;
  for (int global = 0; global < 2; global++) {
    base_error err = {0};
    friction_problem p = welded(global == 1), back, third;
    check_ok(friction_write_fclib(scratch(".hdf5"), &p, &err), &err);
    assert_int_equal(friction_write_siconos(scratch(".dat"), &p, &err), BASE_EUNSUPPORTED);
    check_ok(friction_read_fclib(scratch(".hdf5"), &back, &err), &err);
    assert_int_equal(back.n_joint, 2);
    check_ok(friction_write_fclib(scratch(".hdf5"), &back, &err), &err);
    check_ok(friction_read_fclib(scratch(".hdf5"), &third, &err), &err);
    same_matrix(global == 1 ? &third.G : &third.V, global == 1 ? &p.G : &p.V);
    same_vector(global == 1 ? third.b : third.s, global == 1 ? p.b : p.s, 2);
    check_ok(friction_condense(&back, &err), &err);
    assert_int_equal(back.n_joint, 0);
    assert_int_equal(back.W.colptr[2], 2); /* diagonal */
    check_close(back.W.val[0], 0.5, 1e-15);
    check_close(back.W.val[1], 0.5, 1e-15);
    /* 0 = x_A - x_B - 0.2 shares the difference: x_A = 0.5 + 0.1 */
    check_close(back.q[0], -1.0, 1e-15);
    check_close(back.q[1], 0.6, 1e-15);
    friction_free(&p);
    friction_free(&back);
    friction_free(&third);
  }
}

/* Rows and columns i0 .. of a symmetric matrix, row-major. */
static lcp_csc part_of(const double *K, int size, int i0, int n_row, int j0, int n_col) {
  double *by_rows = malloc((size_t)(n_row * n_col) * sizeof *by_rows);
  for (int i = 0; i < n_row; i++) {
    memcpy(by_rows + (ptrdiff_t)i * n_col, K + (ptrdiff_t)(i0 + i) * size + j0,
           (size_t)n_col * sizeof *by_rows);
  }
  const lcp_csc A = csc_of(n_row, n_col, by_rows);
  free(by_rows);
  return A;
}

/* K = [W V; V' R] of random joints: with joints kept or eliminated, K (r, l) + (q, s) is the same where its
 * lower part vanishes; and W stays symmetric to the bit. */
static void elimination_leaves_the_velocities(void **state) {
  (void)state;
  enum { N = 30, M = 20, SIZE = N + M };
  base_rng rng = base_rng_seeded(7);
  double K[SIZE * SIZE], A[SIZE * SIZE], x[SIZE], u[SIZE] = {0};
  for (int k = 0; k < SIZE * SIZE; k++) {
    A[k] = base_rng_normal(&rng);
  }
  for (int i = 0; i < SIZE; i++) {
    x[i] = base_rng_normal(&rng);
    for (int j = 0; j <= i; j++) {
      double sum = (i == j) ? 1.0 : 0.0;
      for (int k = 0; k < SIZE; k++) {
        sum += A[i * SIZE + k] * A[j * SIZE + k];
      }
      K[i * SIZE + j] = K[j * SIZE + i] = sum;
    }
  }
  friction_problem p = {.rows = 2, .n_contact = N / 2, .n_joint = M};
  p.W = part_of(K, SIZE, 0, N, 0, N);
  p.V = part_of(K, SIZE, 0, N, N, M);
  p.R = part_of(K, SIZE, N, M, N, M);
  for (int i = 0; i < SIZE; i++) {
    for (int j = 0; j < SIZE; j++) {
      u[i] -= K[i * SIZE + j] * x[j];
    }
  }
  p.q = copy_of(u, N); /* so that u = 0 and the joints hold at x */
  p.s = copy_of(u + N, M);
  base_error err = {0};
  check_ok(friction_eliminate_joints(&p, &err), &err);
  for (int i = 0; i < N; i++) {
    double now = p.q[i];
    for (int j = 0; j < N; j++) {
      assert_true(p.W.val[j * N + i] == p.W.val[i * N + j]);
      now += p.W.val[j * N + i] * x[j];
    }
    check_close(now, 0.0, 1e-9);
  }
  friction_free(&p);
}

static void dependent_joints_are_refused(void **state) {
  (void)state;
  base_error err = {0};
  friction_problem p = welded(false);
  lcp_csc_free(&p.R);
  p.R = csc_of(2, 2, (const double[]){2, 2, 2, 2});
  assert_int_equal(friction_condense(&p, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "repeat each other"));
  lcp_csc_free(&p.R);
  p.R = csc_of(2, 2, (const double[]){2, 1, 0, 2});
  assert_int_equal(friction_condense(&p, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "not symmetric"));
  free(p.s);
  p.s = NULL;
  assert_int_equal(friction_check(&p, &err), BASE_EINVAL);
  friction_free(&p);
}

/* Friction text tells a global problem by the size of its first matrix: as many dofs as rows would read back
 * as a local one. */
static void ambiguous_text_is_not_written(void **state) {
  (void)state;
  const double one[4] = {1, 0, 0, 1}, two[2] = {0.5, -1}, mu = 0.3;
  friction_problem p = {.rows = 2, .n_contact = 1, .global = true}, back;
  base_error err = {0};
  p.M = csc_of(2, 2, one);
  p.H = csc_of(2, 2, one);
  p.f = copy_of(two, 2);
  p.w = copy_of(two, 2);
  p.mu = copy_of(&mu, 1);
  assert_int_equal(friction_write_siconos(scratch(".dat"), &p, &err), BASE_EUNSUPPORTED);
  assert_non_null(strstr(err.text, "2 of dofs and of rows"));
  check_ok(friction_write_fclib(scratch(".hdf5"), &p, &err), &err);
  check_ok(friction_read_fclib(scratch(".hdf5"), &back, &err), &err);
  assert_true(back.global);
  friction_free(&p);
  friction_free(&back);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_file_is_read),
      cmocka_unit_test(text_and_hdf5_agree),
      cmocka_unit_test(round_trips_are_exact),
      cmocka_unit_test(lcp_text_round_trips_are_exact),
      cmocka_unit_test(lcp_text_holds_what_it_can),
      cmocka_unit_test(facets_follow_the_formula),
      cmocka_unit_test(joints_are_eliminated),
      cmocka_unit_test(exports_hold_no_time),
      cmocka_unit_test(elimination_leaves_the_velocities),
      cmocka_unit_test(dependent_joints_are_refused),
      cmocka_unit_test(ambiguous_text_is_not_written),
      cmocka_unit_test(rolling_facets_hold_the_cone_along_them),
  };
  return cmocka_run_group_tests(tests, NULL, scratch_remove);
}
