#include "tests/support/imported.h"

#include "tests/support/scratch.h"

#include <string.h>

#define MIXED ((1u << LCP_ORTHANT) | (1u << LCP_FREE))
#define PLAIN (1u << LCP_ORTHANT)
#define CONES (1u << LCP_CONE)

const imported_file imported_files[] = {
    {"lcp/lcp_CPS_1.dat", true, 2, 0, PLAIN},
    {"lcp/lcp_CPS_2.dat", true, 3, 0, PLAIN},
    {"lcp/lcp_CPS_3.dat", true, 4, 0, PLAIN},
    {"lcp/lcp_Pang_isolated_sol.dat", true, 3, 0, PLAIN},
    {"lcp/lcp_exp_murty.dat", true, 6, 0, PLAIN},
    {"lcp/lcp_inf_sol_perturbed.dat", true, 3, 0, PLAIN},
    {"lcp/lcp_mmc.dat", true, 26, 0, PLAIN},
    {"lcp/lcp_ortiz.dat", true, 4, 0, PLAIN},
    {"lcp/lcp_tobenna.dat", true, 40, 0, PLAIN},
    {"lcp/lcp_trivial.dat", true, 9, 0, PLAIN},
    {"mlcp/PDSym_mlcp.dat", true, 7, 2, MIXED},
    {"mlcp/PD_mlcp.dat", true, 7, 2, MIXED},
    {"mlcp/RLCD_mlcp.dat", true, 8, 2, MIXED},
    {"mlcp/diodeBridge_mlcp.dat", true, 7, 2, MIXED},
    {"mlcp/m2n1_mlcp.dat", true, 3, 2, MIXED},
    {"friction/BoxesStack1-i100000-32.hdf5.dat", false, 156, 52, CONES},
    {"friction/Capsules-i100-889.dat", false, 828, 276, CONES},
    {"friction/Capsules-i101-404.dat", false, 675, 225, CONES},
    {"friction/Confeti-ex03-Fc3D-SBM.dat", false, 162, 54, CONES},
    {"friction/FrictionContactProblem00031.dat", true, 22, 11, CONES},
    {"friction/FrictionContactProblem00237.dat", false, 752, 376, CONES},
    {"friction/GRFC3D_Chute-ndof-768-nc-4-3.dat", true, 20, 4, CONES},
    {"friction/NESpheres_10_1.dat", true, 27, 9, CONES},
    {"friction/NESpheres_30_1.dat", false, 132, 44, CONES},
    {"friction/OneObject-i100000-316.hdf5.dat", true, 75, 25, CONES},
    {"friction/OneObject-i1028-138.hdf5.dat", false, 69, 23, CONES},
    {"friction/Rover1039.dat", true, 12, 4, CONES},
    {"friction/Rover1040.dat", false, 15, 5, CONES},
    {"friction/fc2d_granularflowonwall_00667_00000.dat", false, 1334, 667, CONES},
    {"friction/rockfall_14_25792.dat", true, 70, 14, CONES},
    {"fclib/Box_Stacks-i0122-82-5.hdf5", true, 246, 82, CONES},
    {"fclib/Capsules-i125-1213.hdf5", false, 858, 286, CONES},
    {"fclib/Chute-ndof-768-nc-4-3.hdf5", true, 20, 4, CONES},
    {"fclib/LMGC_100_PR_PerioBox-i00361-60-03000.hdf5", false, 180, 60, CONES},
    {"fclib/LMGC_GlobalFrictionContactProblem00046.hdf5", true, 27, 9, CONES},
    {"fclib/Spheres-i099-356-679.hdf5", false, 1068, 356, CONES},
};
const int n_imported_file = BASE_COUNT(imported_files);

bool imported_is_fclib(const imported_file *f) {
  return strncmp(f->name, "fclib/", 6) == 0;
}

void imported_reads(const imported_file *f, const char *path) {
  known_lcp k;
  base_error err = {0};
  check_ok(imported_problem(path, 0, &k, &err), &err);
  check_ok(lcp_problem_check(&k.p, &err), &err);
  if (k.p.M.n != f->n || k.p.n_block != f->n_block || lcp_problem_sets(&k.p) != f->sets) {
    fail_msg("%s: n = %d, %d blocks, sets %x", f->name, k.p.M.n, k.p.n_block,
             lcp_problem_sets(&k.p));
  }
  double *d = calloc((size_t)k.p.M.n, sizeof *d);
  assert_non_null(d);
  lcp_matrix_diagonal(&k.p.M, d);
  for (int j = 0; j < k.p.M.n && f->sets == CONES; j++) {
    assert_true(d[j] > 0.0); /* a Delassus matrix */
  }
  free(d);
  known_lcp_free(&k);
}

void imported_friction(const imported_file *f, const char *path, friction_problem *out) {
  base_error err = {0};
  assert_int_equal(f->sets, CONES);
  check_ok(imported_is_fclib(f) ? friction_read_fclib(path, out, &err)
                                : friction_read_siconos(path, out, &err),
           &err);
}

void same_matrix(const lcp_csc *a, const lcp_csc *b) {
  assert_int_equal(a->n_row, b->n_row);
  assert_int_equal(a->n_col, b->n_col);
  if (a->n_col == 0) {
    return;
  }
  const size_t nnz = (size_t)a->colptr[a->n_col];
  assert_memory_equal(a->colptr, b->colptr, ((size_t)a->n_col + 1) * sizeof(int));
  assert_memory_equal(a->rowind, b->rowind, nnz * sizeof(int));
  assert_memory_equal(a->val, b->val, nnz * sizeof(double));
}

void same_vector(const double *a, const double *b, int n) {
  assert_true((a == NULL) == (b == NULL));
  if (a != NULL) {
    assert_memory_equal(a, b, (size_t)n * sizeof *a);
  }
}

void same_friction(const friction_problem *a, const friction_problem *b) {
  const int n = a->rows * a->n_contact;
  assert_int_equal(a->rows, b->rows);
  assert_int_equal(a->n_contact, b->n_contact);
  same_matrix(&a->W, &b->W);
  same_matrix(&a->M, &b->M);
  same_matrix(&a->H, &b->H);
  same_vector(a->q, b->q, n);
  same_vector(a->w, b->w, n);
  same_vector(a->f, b->f, a->M.n_col);
  same_vector(a->mu, b->mu, a->n_contact);
  same_vector(a->mu_r, b->mu_r, a->n_contact);
}

void same_problem(const lcp_problem *a, const lcp_problem *b) {
  assert_int_equal(a->M.n, b->M.n);
  assert_int_equal(a->n_block, b->n_block);
  const size_t n = (size_t)a->M.n;
  double *A = malloc(n * n * sizeof *A);
  double *B = malloc(n * n * sizeof *B);
  assert_non_null(A);
  assert_non_null(B);
  lcp_matrix_to_dense(&a->M, A);
  lcp_matrix_to_dense(&b->M, B);
  assert_memory_equal(A, B, n * n * sizeof *A);
  assert_memory_equal(a->q, b->q, n * sizeof *a->q);
  free(A);
  free(B);
  for (int i = 0; i < a->n_block; i++) {
    assert_int_equal(a->block[i].set, b->block[i].set);
    assert_int_equal(a->block[i].start, b->block[i].start);
    assert_int_equal(a->block[i].size, b->block[i].size);
  }
}

void imported_round_trip(const imported_file *f, const char *path) {
  friction_problem a, b, c;
  base_error err = {0};
  imported_friction(f, path, &a);
  check_ok(friction_write_siconos(scratch(".dat"), &a, &err), &err);
  check_ok(friction_read_siconos(scratch(".dat"), &b, &err), &err);
  same_friction(&a, &b);
  if (a.rows != 5 || a.global) { /* FCLIB has no local rolling problems */
    check_ok(friction_write_fclib(scratch(".hdf5"), &b, &err), &err);
    check_ok(friction_read_fclib(scratch(".hdf5"), &c, &err), &err);
    same_friction(&a, &c);
    friction_free(&c);
  }
  friction_free(&a);
  friction_free(&b);
}

base_status imported_problem(const char *path, int facets, known_lcp *out, base_error *err) {
  import_posed both;
  memset(out, 0, sizeof *out);
  BASE_TRY(import_pose(path, facets, &both, err));
  *out = both.posed;
  known_lcp_free(&both.cone);
  return BASE_OK;
}
