/* FCLIB's HDF5 files (FIELD E): /fclib_local, /fclib_global or /fclib_global_rolling with matrices
 * in triplet (nz >= 0: x[k] at row i[k], column p[k]), column (nz = -1) or row (-2) form. Stored
 * solutions are zeros in practice and are not read. */
#include "lcp/base/input.h"
#include "problems/families/triplets.h"
#include "problems/import/friction_problem.h"
#include "problems/import/hdf5_library.h"
#include "problems/import/survives.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct source {
  const hdf5_library *h5;
  hid_t file;
  const char *path;
  base_error *err;
} source;

#define BAD(s, ...) BASE_FAIL((s)->err, BASE_EINVAL, __VA_ARGS__)

/* ---- datasets ------------------------------------------------------------------------------- */

/* Opens a one-dimensional, uncompressed dataset of numbers; its length in *n. What is stored must
 * really be in the file, so a hostile length allocates nothing. */
static base_status open_dataset(const source *s, const char *name, H5T_class_t class, hid_t *id,
                                hsize_t *n) {
  *id = s->h5->H5Dopen2(s->file, name, H5P_DEFAULT);
  if (*id < 0) {
    return BAD(s, "%s: no dataset %s", s->path, name);
  }
  const hid_t space = s->h5->H5Dget_space(*id), type = s->h5->H5Dget_type(*id);
  const bool shape = space >= 0 && s->h5->H5Sget_simple_extent_ndims(space) == 1 &&
                     s->h5->H5Sget_simple_extent_dims(space, n, NULL) == 1;
  const bool kind = type >= 0 && s->h5->H5Tget_class(type) == class;
  const size_t size = (type >= 0) ? s->h5->H5Tget_size(type) : 0;
  if (space >= 0) {
    (void)s->h5->H5Sclose(space);
  }
  if (type >= 0) {
    (void)s->h5->H5Tclose(type);
  }
  if (!shape || !kind || size == 0) {
    return BAD(s, "%s: %s: need a list of %s", s->path, name,
               class == H5T_INTEGER ? "integers" : "real numbers");
  }
  if (*n > 0x7fffffff || s->h5->H5Dget_storage_size(*id) < *n * size) {
    return BAD(s, "%s: %s: announces %llu numbers that the file does not hold uncompressed",
               s->path, name, (unsigned long long)*n);
  }
  return BASE_OK;
}

static base_status read_dataset(const source *s, const char *name, H5T_class_t class, int want,
                                void **out, int *n) {
  hid_t id;
  hsize_t count = 0;
  const bool integer = (class == H5T_INTEGER);
  *out = NULL;
  base_status status = open_dataset(s, name, class, &id, &count);
  if (status == BASE_OK && want >= 0 && count != (hsize_t)want) {
    status =
        BAD(s, "%s: %s: has %llu numbers, need %d", s->path, name, (unsigned long long)count, want);
  }
  if (status == BASE_OK) {
    *out = malloc(((size_t)count + 1) * (integer ? sizeof(int) : sizeof(double)));
    *n = (int)count;
    if (*out == NULL) {
      status = BASE_FAIL(s->err, BASE_ENOMEM, "%s: %s: no memory", s->path, name);
    } else if (count > 0 &&
               s->h5->H5Dread(id, integer ? *s->h5->H5T_NATIVE_INT_g : *s->h5->H5T_NATIVE_DOUBLE_g,
                              H5S_ALL, H5S_ALL, H5P_DEFAULT, *out) < 0) {
      status = BAD(s, "%s: %s: could not be read", s->path, name);
    }
  }
  if (id >= 0) {
    (void)s->h5->H5Dclose(id);
  }
  return status;
}

static base_status read_reals(const source *s, const char *group, const char *name, int want,
                              double **out) {
  char path[128];
  void *data;
  int n;
  (void)snprintf(path, sizeof path, "%s/%s", group, name);
  const base_status status = read_dataset(s, path, H5T_FLOAT, want, &data, &n);
  *out = data;
  return status;
}

static base_status read_ints(const source *s, const char *group, const char *name, int want,
                             int **out, int *n) {
  char path[128];
  void *data;
  (void)snprintf(path, sizeof path, "%s/%s", group, name);
  const base_status status = read_dataset(s, path, H5T_INTEGER, want, &data, n);
  *out = data;
  return status;
}

static base_status read_int(const source *s, const char *group, const char *name, int *x) {
  int *one, n;
  const base_status status = read_ints(s, group, name, 1, &one, &n);
  if (status == BASE_OK) {
    *x = one[0];
  }
  free(one);
  return status;
}

static bool has(const source *s, const char *path) {
  char head[128];
  (void)snprintf(head, sizeof head, "%s", path);
  for (char *slash = strchr(head + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
    *slash = '\0'; /* H5Lexists wants every group on the way to exist */
    if (s->h5->H5Lexists(s->file, head, H5P_DEFAULT) <= 0) {
      return false;
    }
    *slash = '/';
  }
  return s->h5->H5Lexists(s->file, head, H5P_DEFAULT) > 0;
}

/* ---- matrices ------------------------------------------------------------------------------- */

typedef struct stored {
  int m, n, nz, n_p, n_i;
  int *p, *i;
  double *x;
} stored;

static base_status read_stored(const source *s, const char *group, stored *a) {
  BASE_TRY(read_int(s, group, "m", &a->m));
  BASE_TRY(read_int(s, group, "n", &a->n));
  BASE_TRY(read_int(s, group, "nz", &a->nz));
  if (a->m < 1 || a->n < 1 || a->nz < -2) {
    return BAD(s, "%s: %s: m = %d, n = %d, nz = %d: need m, n >= 1, nz >= -2", s->path, group, a->m,
               a->n, a->nz);
  }
  BASE_TRY(read_ints(s, group, "p", -1, &a->p, &a->n_p));
  BASE_TRY(read_ints(s, group, "i", -1, &a->i, &a->n_i));
  BASE_TRY(read_reals(s, group, "x", a->n_i, &a->x));
  const int want = (a->nz >= 0) ? a->nz : (a->nz == -1) ? a->n + 1 : a->m + 1;
  /* a triplet matrix may have spare room behind its entries */
  if (a->n_p < want || (a->nz >= 0 && a->n_i < a->nz) || (a->nz < 0 && a->n_p != want)) {
    return BAD(s, "%s: %s: p has %d numbers, need %d", s->path, group, a->n_p, want);
  }
  return BASE_OK;
}

static base_status out_of_range(const source *s, const char *group, int k) {
  return BAD(s, "%s: %s: entry %d lies outside the matrix", s->path, group, k + 1);
}

static base_status collect_triplets(const source *s, const char *group, const stored *a,
                                    triplets *t) {
  for (int k = 0; k < a->nz; k++) {
    if (a->i[k] < 0 || a->i[k] >= a->m || a->p[k] < 0 || a->p[k] >= a->n) {
      return out_of_range(s, group, k);
    }
    triplets_add(t, a->i[k], a->p[k], a->x[k]);
  }
  return BASE_OK;
}

/* Compressed columns, or rows: `major` of them. */
static base_status collect_compressed(const source *s, const char *group, const stored *a,
                                      triplets *t) {
  const bool columns = (a->nz == -1);
  const int major = columns ? a->n : a->m, minor = columns ? a->m : a->n;
  if (a->p[0] != 0 || a->p[major] > a->n_i) {
    return BAD(s, "%s: %s: p must run from 0 to at most %d", s->path, group, a->n_i);
  }
  for (int j = 0; j < major; j++) {
    if (a->p[j + 1] < a->p[j]) {
      return BAD(s, "%s: %s: p decreases at %d", s->path, group, j + 1);
    }
    for (int k = a->p[j]; k < a->p[j + 1] && k < a->n_i; k++) {
      if (a->i[k] < 0 || a->i[k] >= minor) {
        return out_of_range(s, group, k);
      }
      triplets_add(t, columns ? a->i[k] : j, columns ? j : a->i[k], a->x[k]);
    }
  }
  return BASE_OK;
}

/* m or n far above the number of entries would be empty rows; the vectors beside the matrix, read
 * first, bound them: want_row and want_col (-1: any). */
static base_status read_matrix(const source *s, const char *group, int want_row, int want_col,
                               lcp_csc *out) {
  stored a = {0};
  triplets t = {0};
  base_status status = read_stored(s, group, &a);
  if (status == BASE_OK &&
      ((want_row >= 0 && a.m != want_row) || (want_col >= 0 && a.n != want_col))) {
    status =
        BAD(s, "%s: %s is %d x %d: need %d x %d", s->path, group, a.m, a.n, want_row, want_col);
  }
  if (status == BASE_OK) {
    status = triplets_open(&t, a.m, a.n, a.n_i, s->err);
  }
  if (status == BASE_OK) {
    status =
        (a.nz >= 0) ? collect_triplets(s, group, &a, &t) : collect_compressed(s, group, &a, &t);
  }
  if (status == BASE_OK) {
    status = triplets_to_csc(&t, out, s->err);
  }
  triplets_free(&t);
  free(a.p);
  free(a.i);
  free(a.x);
  return status;
}

/* ---- problem -------------------------------------------------------------------------------- */

/* mu gives the number of contacts, spacedim the rows of one. */
static base_status read_sizes(const source *s, const char *group, friction_problem *p) {
  char vectors[64], path[96];
  int dim, n;
  void *mu;
  (void)snprintf(vectors, sizeof vectors, "%s/vectors", group);
  (void)snprintf(path, sizeof path, "%s/mu", vectors);
  BASE_TRY(read_int(s, group, "spacedim", &dim));
  const base_status status = read_dataset(s, path, H5T_FLOAT, -1, &mu, &n);
  p->mu = mu;
  BASE_TRY(status);
  const bool rolling = strstr(group, "rolling") != NULL;
  if ((dim != 2 && dim != 3 && dim != 5) || (rolling && dim != 5 && dim != 3) ||
      (!rolling && dim == 5) || n < 1 || n > 100000000) {
    return BAD(s, "%s: %s: spacedim = %d with %d contacts", s->path, group, dim, n);
  }
  p->rows = rolling ? 5 : dim;
  p->n_contact = n;
  return rolling ? read_reals(s, vectors, "mu_r", n, &p->mu_r) : BASE_OK;
}

/* The right-hand side of the joints, whose length is their number. */
static base_status read_joint_vector(const source *s, const char *g, const char *name, double **x,
                                     int *n) {
  char path[96];
  void *data;
  (void)snprintf(path, sizeof path, "%s/vectors/%s", g, name);
  const base_status status = read_dataset(s, path, H5T_FLOAT, -1, &data, n);
  *x = data;
  if (status == BASE_OK && *n < 1) {
    return BAD(s, "%s: %s: joints without rows", s->path, path);
  }
  return status;
}

static base_status read_local(const source *s, friction_problem *p) {
  static const char g[] = "/fclib_local";
  BASE_TRY(read_sizes(s, g, p));
  const int n = p->rows * p->n_contact;
  BASE_TRY(read_reals(s, "/fclib_local/vectors", "q", n, &p->q));
  BASE_TRY(read_matrix(s, "/fclib_local/W", n, n, &p->W));
  if (!has(s, "/fclib_local/V") && !has(s, "/fclib_local/R")) {
    return BASE_OK;
  }
  BASE_TRY(read_joint_vector(s, g, "s", &p->s, &p->n_joint));
  BASE_TRY(read_matrix(s, "/fclib_local/V", n, p->n_joint, &p->V));
  return read_matrix(s, "/fclib_local/R", p->n_joint, p->n_joint, &p->R);
}

static base_status read_global(const source *s, const char *g, friction_problem *p) {
  char vectors[64], group[64];
  void *f;
  int dofs;
  BASE_TRY(read_sizes(s, g, p));
  const int n = p->rows * p->n_contact;
  p->global = true;
  (void)snprintf(vectors, sizeof vectors, "%s/vectors", g);
  BASE_TRY(read_reals(s, vectors, "w", n, &p->w));
  (void)snprintf(group, sizeof group, "%s/vectors/f", g);
  const base_status status = read_dataset(s, group, H5T_FLOAT, -1, &f, &dofs);
  p->f = f;
  BASE_TRY(status);
  (void)snprintf(group, sizeof group, "%s/M", g);
  BASE_TRY(read_matrix(s, group, dofs, dofs, &p->M));
  (void)snprintf(group, sizeof group, "%s/H", g);
  BASE_TRY(read_matrix(s, group, dofs, n, &p->H));
  (void)snprintf(group, sizeof group, "%s/G", g);
  if (!has(s, group)) {
    return BASE_OK;
  }
  BASE_TRY(read_joint_vector(s, g, "b", &p->b, &p->n_joint));
  return read_matrix(s, group, dofs, p->n_joint, &p->G);
}

static base_status read_any(const source *s, friction_problem *p) {
  static const char *const globals[] = {"/fclib_global", "/fclib_global_rolling"};
  for (int i = 0; i < BASE_COUNT(globals); i++) {
    if (has(s, globals[i])) {
      return read_global(s, globals[i], p);
    }
  }
  if (has(s, "/fclib_local")) {
    return read_local(s, p);
  }
  return BAD(s, "%s: no group fclib_local, fclib_global or fclib_global_rolling", s->path);
}

/* Standard input is no file that the library could open by its name: it gets the bytes. */
static hid_t open_image(const hdf5_library *h5, const char *path) {
  FILE *f;
  if (base_in_open(path, &f, NULL) != BASE_OK) {
    return -1;
  }
  const long size = (fseek(f, 0, SEEK_END) == 0) ? ftell(f) : -1;
  char *bytes = (size > 0 && fseek(f, 0, SEEK_SET) == 0) ? malloc((size_t)size) : NULL;
  const bool whole = bytes != NULL && fread(bytes, 1, (size_t)size, f) == (size_t)size;
  const hid_t access = h5->H5Pcreate(*h5->H5P_CLS_FILE_ACCESS_ID_g);
  hid_t file = -1;
  if (whole && access >= 0 && h5->H5Pset_fapl_core(access, 65536, 0) >= 0 &&
      h5->H5Pset_file_image(access, bytes, (size_t)size) >= 0) { /* a copy */
    file = h5->H5Fopen(path, H5F_ACC_RDONLY, access);
  }
  if (access >= 0) {
    (void)h5->H5Pclose(access);
  }
  free(bytes);
  (void)fclose(f);
  return file;
}

static hid_t open_file(const hdf5_library *h5, const char *path) {
  return base_in_is_stdin(path) ? open_image(h5, path)
                                : h5->H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
}

base_status friction_read_fclib_here(const char *path, friction_problem *out, base_error *err) {
  memset(out, 0, sizeof *out);
  hdf5_library h5;
  BASE_TRY(hdf5_begin(&h5, err));
  H5E_auto2_t print;
  void *data;
  (void)h5.H5Eget_auto2(H5E_DEFAULT, &print, &data);
  (void)h5.H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* a library does not print */
  base_error inner = {0};
  source s = {&h5, open_file(&h5, path), path, err};
  base_status status = BASE_EINVAL;
  if (s.file < 0) {
    status = BASE_FAIL(err, BASE_EINVAL, "%s: not an HDF5 file, or damaged", path);
  } else {
    status = read_any(&s, out);
    (void)h5.H5Fclose(s.file);
    if (status == BASE_OK && (status = friction_check(out, &inner)) != BASE_OK) {
      (void)BASE_FAIL(err, status, "%s: %s", path, inner.text);
    }
  }
  (void)h5.H5Eset_auto2(H5E_DEFAULT, print, data);
  if (status != BASE_OK) {
    friction_free(out);
  }
  return status;
}

typedef struct trial {
  const char *path;
  size_t most; /* memory [B] */
  friction_problem problem;
  base_status status;
  base_error err;
} trial;

static void read_problem(void *ctx) {
  trial *t = ctx;
  t->status = friction_read_fclib_here(t->path, &t->problem, &t->err);
}

static void try_reading(void *ctx) {
  survives_within(((const trial *)ctx)->most, read_problem, ctx);
}

/* HDF5 does not say why a file cannot be opened. */
static base_status size_of(const char *path, size_t *bytes, base_error *err) {
  FILE *f;
  BASE_TRY(base_in_open(path, &f, err));
  const long end = (fseek(f, 0, SEEK_END) == 0) ? ftell(f) : 0;
  (void)fclose(f);
  *bytes = (end > 0) ? (size_t)end : 0;
  return BASE_OK;
}

base_status friction_read_fclib(const char *path, friction_problem *out, base_error *err) {
  memset(out, 0, sizeof *out);
  trial t = {.path = path};
  size_t bytes = 0;
  bool survived = false;
  BASE_TRY(size_of(path, &bytes, err));
  t.most = ((size_t)256 << 20) + 64 * bytes; /* sparse blocks and their product */
  BASE_TRY(survives(try_reading, &t, &survived, err));
  if (!survived) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: damaged: the HDF5 library fails on it", path);
  }
  try_reading(&t);
  *out = t.problem;
  if (t.status != BASE_OK && err != NULL) {
    *err = t.err;
  }
  return t.status;
}
