#include "harness/measure/export_lcp.h"

#include "lcp/base/output.h"
#include "lcp/io/lcp_read.h"
#include "problems/import/friction_problem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXPORT_NAME = 1000 }; /* of a file, without what is put behind it */

static void print_matrix(FILE *to, const lcp_csc *m) {
  (void)fprintf(to, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", m->n_row,
                m->n_col, m->colptr[m->n_col]);
  for (int j = 0; j < m->n_col; j++) {
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      (void)fprintf(to, "%d %d %.17g\n", m->rowind[k] + 1, j + 1, m->val[k]);
    }
  }
}

base_status export_lcp_mtx(const lcp_problem *p, const char *out, base_error *err) {
  char path[1100];
  lcp_csc m;
  base_out file;
  if (lcp_problem_sets(p) != 1u << LCP_ORTHANT) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%.300s: Matrix Market holds plain LCPs only", out);
  }
  if (strlen(out) > EXPORT_NAME) {
    return BASE_FAIL(err, BASE_EINVAL, "%.80s...: longer than %d characters", out, EXPORT_NAME);
  }
  (void)snprintf(path, sizeof path, "%s.q.mtx", out);
  BASE_TRY(lcp_write_mtx_vector(path, p->M.n, p->q, err));
  (void)snprintf(path, sizeof path, "%s.M.mtx", out);
  BASE_TRY(lcp_matrix_to_csc(&p->M, &m, err));
  base_status done = base_out_open(&file, path, err);
  if (done == BASE_OK) {
    print_matrix(file.to, &m);
    done = base_out_close(&file, true, err);
  }
  lcp_csc_free(&m);
  return done;
}

/* ---- Siconos text ------------------------------------------------------------------------------*/

static bool is_free(const lcp_problem *p, int block) {
  return p->n_block > 0 && p->block[block].set == LCP_FREE;
}

/* What a mixed LCP begins with: the flags "M whole, not in parts", the numbers of equations and of
 * inequalities, where runs of one kind start and end, and a flag per run (1: complementarity). */
static void print_runs(FILE *to, const lcp_problem *p) {
  int free = 0;
  for (int b = 0; b < p->n_block; b++) {
    free += is_free(p, b) ? p->block[b].size : 0;
  }
  (void)fprintf(to, "1\n0\n%d\n%d\n0", free, p->M.n - free);
  for (int b = 0; b < p->n_block; b++) {
    if (b + 1 == p->n_block || is_free(p, b) != is_free(p, b + 1)) {
      (void)fprintf(to, " %d", p->block[b].start + p->block[b].size);
    }
  }
  const char *before = "\n";
  for (int b = 0; b < p->n_block; b++) {
    if (b + 1 == p->n_block || is_free(p, b) != is_free(p, b + 1)) {
      (void)fprintf(to, "%s%d", before, is_free(p, b) ? 0 : 1);
      before = " ";
    }
  }
  (void)fputc('\n', to);
}

static void print_columns(FILE *to, const double *x, int n, int n_col) {
  for (int j = 0; j < n_col; j++) {
    for (int i = 0; i < n; i++) {
      (void)fprintf(to, "%.17g%c", x[(size_t)j * (size_t)n + (size_t)i], (i + 1 < n) ? ' ' : '\n');
    }
  }
}

base_status export_lcp_text(const lcp_problem *p, const char *path, base_error *err) {
  const unsigned plain = 1u << LCP_ORTHANT;
  const unsigned sets = lcp_problem_sets(p);
  const int n = p->M.n;
  if ((sets & ~(plain | 1u << LCP_FREE)) != 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: LCP text holds orthants and equations only",
                     path);
  }
  double *M = malloc((size_t)n * (size_t)n * sizeof *M + 1);
  if (M == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %d x %d numbers", path, n, n);
  }
  lcp_matrix_to_dense(&p->M, M);
  base_out out;
  const base_status opened = base_out_open(&out, path, err);
  if (opened != BASE_OK) {
    free(M);
    return opened;
  }
  if (sets == plain) {
    (void)fprintf(out.to, "%d\n", n);
  } else {
    print_runs(out.to, p);
  }
  (void)fprintf(out.to, "0\n%d\n%d\n%d\t%d\n", n, n, n, n); /* dense, and its size twice */
  print_columns(out.to, M, n, n);
  print_columns(out.to, p->q, n, 1);
  free(M);
  return base_out_close(&out, true, err);
}

/* 2, 3 or 5 rows a contact; 0: no friction problem of this kind. */
static int rows_of(const lcp_block *b) {
  if (b->set != LCP_CONE || b->n_part < 1 || b->n_part > 2) {
    return 0;
  }
  if (b->n_part == 1) {
    return (b->part_dim[0] == 1 || b->part_dim[0] == 2) ? 1 + b->part_dim[0] : 0;
  }
  return (b->part_dim[0] == 2 && b->part_dim[1] == 2) ? 5 : 0;
}

base_status export_lcp_friction(const lcp_problem *p, const char *path, base_error *err) {
  const int rows = (p->n_block > 0) ? rows_of(&p->block[0]) : 0;
  bool good = rows > 0 && rows * p->n_block == p->M.n;
  for (int i = 0; good && i < p->n_block; i++) {
    good = rows_of(&p->block[i]) == rows && p->block[i].start == rows * i;
  }
  if (!good) {
    return BASE_FAIL(
        err, BASE_EUNSUPPORTED,
        "%s: no file format here holds this problem: friction text has cones of 2, 3 or 5 "
        "rows, all alike, and nothing beside them",
        path);
  }
  friction_problem f = {.rows = rows, .n_contact = p->n_block};
  f.q = malloc((size_t)p->M.n * sizeof *f.q);
  f.mu = malloc((size_t)p->n_block * sizeof *f.mu);
  f.mu_r = (rows == 5) ? malloc((size_t)p->n_block * sizeof *f.mu_r) : NULL;
  base_status done = BASE_OK;
  if (f.q == NULL || f.mu == NULL || (rows == 5 && f.mu_r == NULL)) {
    done = BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %d contacts", path, p->n_block);
  } else {
    memcpy(f.q, p->q, (size_t)p->M.n * sizeof *f.q);
    for (int i = 0; i < p->n_block; i++) {
      f.mu[i] = p->block[i].part_mu[0];
      if (f.mu_r != NULL) {
        f.mu_r[i] = p->block[i].part_mu[1];
      }
    }
    done = lcp_matrix_to_csc(&p->M, &f.W, err);
  }
  if (done == BASE_OK) {
    done = friction_write_siconos(path, &f, err);
  }
  friction_free(&f);
  return done;
}
