/* FCLIB's HDF5 layout (FIELD E), matrices as triplets with
 * x[k] at row i[k], column p[k]. */
#include "lcp/base/output.h"
#include "problems/import/friction_problem.h"
#include "problems/import/hdf5_library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct target {
  const hdf5_library *h5;
  hid_t file;
  hid_t dataset; /* properties of a dataset: without the time of writing */
  bool failed;
} target;

static void make_group(target *t, const char *name) {
  const hid_t id = t->h5->H5Gcreate2(t->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  t->failed = t->failed || id < 0 || t->h5->H5Gclose(id) < 0;
}

static void put(target *t, const char *group, const char *name, hid_t file_type, hid_t type,
                const void *data, int n) {
  char path[128];
  const hsize_t dims[1] = {(hsize_t)n};
  (void)snprintf(path, sizeof path, "%s/%s", group, name);
  const hid_t space = t->h5->H5Screate_simple(1, dims, NULL);
  const hid_t id =
      t->h5->H5Dcreate2(t->file, path, file_type, space, H5P_DEFAULT, t->dataset, H5P_DEFAULT);
  t->failed = t->failed || id < 0 ||
              (n > 0 && t->h5->H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0);
  if (id >= 0) {
    t->failed = t->h5->H5Dclose(id) < 0 || t->failed;
  }
  (void)t->h5->H5Sclose(space);
}

static void put_reals(target *t, const char *group, const char *name, const double *x, int n) {
  put(t, group, name, *t->h5->H5T_IEEE_F64LE_g, *t->h5->H5T_NATIVE_DOUBLE_g, x, n);
}

static void put_ints(target *t, const char *group, const char *name, const int *x, int n) {
  put(t, group, name, *t->h5->H5T_STD_I32LE_g, *t->h5->H5T_NATIVE_INT_g, x, n);
}

static void put_matrix(target *t, const char *group, const lcp_csc *A) {
  const int nnz = A->colptr[A->n_col];
  int *col = malloc(((size_t)nnz + 1) * sizeof *col);
  if (col == NULL) {
    t->failed = true;
    return;
  }
  for (int j = 0; j < A->n_col; j++) {
    for (int at = A->colptr[j]; at < A->colptr[j + 1]; at++) {
      col[at] = j;
    }
  }
  make_group(t, group);
  put_ints(t, group, "m", &A->n_row, 1);
  put_ints(t, group, "n", &A->n_col, 1);
  put_ints(t, group, "nz", &nnz, 1);
  put_ints(t, group, "nzmax", &nnz, 1);
  put_ints(t, group, "p", col, nnz);
  put_ints(t, group, "i", A->rowind, nnz);
  put_reals(t, group, "x", A->val, nnz);
  free(col);
}

static void put_problem(target *t, const friction_problem *p) {
  const bool rolling = p->rows == 5;
  const char *top = !p->global ? "/fclib_local"
                    : rolling  ? "/fclib_global_rolling"
                               : "/fclib_global";
  const int n = p->rows * p->n_contact;
  char vectors[64], matrix[64];
  make_group(t, top);
  put_ints(t, top, "spacedim", &p->rows, 1);
  (void)snprintf(vectors, sizeof vectors, "%s/vectors", top);
  make_group(t, vectors);
  put_reals(t, vectors, "mu", p->mu, p->n_contact);
  if (rolling) {
    put_reals(t, vectors, "mu_r", p->mu_r, p->n_contact);
  }
  if (!p->global) {
    put_reals(t, vectors, "q", p->q, n);
    (void)snprintf(matrix, sizeof matrix, "%s/W", top);
    put_matrix(t, matrix, &p->W);
    if (p->n_joint > 0) {
      put_matrix(t, "/fclib_local/V", &p->V);
      put_matrix(t, "/fclib_local/R", &p->R);
      put_reals(t, vectors, "s", p->s, p->n_joint);
    }
    return;
  }
  put_reals(t, vectors, "f", p->f, p->M.n_col);
  put_reals(t, vectors, "w", p->w, n);
  (void)snprintf(matrix, sizeof matrix, "%s/M", top);
  put_matrix(t, matrix, &p->M);
  (void)snprintf(matrix, sizeof matrix, "%s/H", top);
  put_matrix(t, matrix, &p->H);
  if (p->n_joint > 0) {
    (void)snprintf(matrix, sizeof matrix, "%s/G", top);
    put_matrix(t, matrix, &p->G);
    put_reals(t, vectors, "b", p->b, p->n_joint);
  }
}

base_status friction_write_fclib(const char *path, const friction_problem *p, base_error *err) {
  BASE_TRY(friction_check(p, err));
  if (p->rows == 5 && !p->global) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: FCLIB has no local rolling problems", path);
  }
  hdf5_library h5;
  BASE_TRY(hdf5_begin(&h5, err));
  base_out out;
  BASE_TRY(base_out_open_regular(&out, path, err));
  H5E_auto2_t print;
  void *data;
  (void)h5.H5Eget_auto2(H5E_DEFAULT, &print, &data);
  (void)h5.H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* a library does not print */
  target t = {&h5, h5.H5Fcreate(out.temporary, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
              h5.H5Pcreate(*h5.H5P_CLS_DATASET_CREATE_ID_g), false};
  t.failed = t.dataset < 0 || h5.H5Pset_obj_track_times(t.dataset, false) < 0;
  if (t.file >= 0) {
    put_problem(&t, p);
    t.failed = h5.H5Fclose(t.file) < 0 || t.failed;
  }
  (void)h5.H5Pclose(t.dataset);
  (void)h5.H5Eset_auto2(H5E_DEFAULT, print, data);
  if (t.file < 0 || t.failed) {
    (void)base_out_close(&out, false, NULL);
    return BASE_FAIL(err, BASE_EIO, "%s: could not be written", path);
  }
  return base_out_close(&out, true, err);
}
