#include "harness/measure/export_lcp.h"

#include "lcp/io/lcp_read.h"
#include "problems/import/friction_problem.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static base_status write_matrix(const char *path, const lcp_csc *m, base_error *err) {
  FILE *to = fopen(path, "w");
  bool good = to != NULL;
  if (good) {
    (void)fprintf(to, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", m->n_row,
                  m->n_col, m->colptr[m->n_col]);
    for (int j = 0; j < m->n_col; j++) {
      for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
        (void)fprintf(to, "%d %d %.17g\n", m->rowind[k] + 1, j + 1, m->val[k]);
      }
    }
    good = ferror(to) == 0;
    good = fclose(to) == 0 && good;
  }
  return good ? BASE_OK : BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

base_status export_lcp_mtx(const lcp_problem *p, const char *out, base_error *err) {
  char path[1100];
  lcp_csc m;
  if (lcp_problem_sets(p) != 1u << LCP_ORTHANT) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: Matrix Market holds plain LCPs only", out);
  }
  BASE_TRY(lcp_matrix_to_csc(&p->M, &m, err));
  (void)snprintf(path, sizeof path, "%.1024s.M.mtx", out);
  const base_status done = write_matrix(path, &m, err);
  lcp_csc_free(&m);
  BASE_TRY(done);
  (void)snprintf(path, sizeof path, "%.1024s.q.mtx", out);
  return lcp_write_mtx_vector(path, p->M.n, p->q, err);
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
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s: friction text holds cones of 2, 3 or 5 rows, all alike", path);
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
