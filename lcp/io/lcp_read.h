/* lcp/io/lcp_read.h - problems from files. Every reader owns what it returns, refuses sizes the
 * file cannot hold before allocating, and names file, line and rule when it fails. */
#pragma once

#include "lcp/lcp_problem.h"

/* An owned problem: p views the arrays below. */
typedef struct lcp_file_problem {
  lcp_problem p;
  void *owned[12]; /* freed by lcp_file_problem_free */
  int n_owned;
} lcp_file_problem;

/* Siconos text LCP: n, storage type, n, n, "n n", M column by column, q, free remarks. */
base_status lcp_read_siconos(const char *path, lcp_file_problem *out, base_error *err);

/* Matrix Market M (coordinate or array, general or symmetric) and q (array or coordinate n x 1).
 * Stored as CSC; as dense when the file is an array. */
base_status lcp_read_mtx(const char *m_path, const char *q_path, lcp_file_problem *out,
                         base_error *err);

/* numpy's .npz (read_npz.c): M dense, or the parts of scipy.sparse.save_npz; q; lo and hi, optional. A sparse M is
 * stored as CSC. BASE_EINVAL also: an array of another name. */
base_status lcp_read_npz(const char *path, lcp_file_problem *out, base_error *err);

/* The same, written: lcp_read_npz reads it back to the same bits. BASE_EUNSUPPORTED: cones, or more than 2 GiB. */
base_status lcp_write_npz(const char *path, const lcp_problem *p, base_error *err);

/* A Matrix Market vector of known length n into x[n]. */
base_status lcp_read_mtx_vector(const char *path, int n, double *x, base_error *err);
base_status lcp_write_mtx_vector(const char *path, int n, const double *x, base_error *err);

void lcp_file_problem_free(lcp_file_problem *f);
