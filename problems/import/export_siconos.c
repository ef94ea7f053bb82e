/* Siconos' text: dense where every entry is stored, CSparse' triplet printout elsewhere, with 17
 * digits so that it reads back to the same bits. */
#include "lcp/base/output.h"
#include "problems/import/friction_problem.h"

static void print_vector(FILE *f, const double *x, int n) {
  for (int i = 0; i < n; i++) {
    (void)fprintf(f, "%.17g%c", x[i], (i + 1 < n) ? ' ' : '\n');
  }
}

static void print_matrix(FILE *f, const lcp_csc *A) {
  const int nnz = A->colptr[A->n_col];
  const bool dense = (double)nnz == (double)A->n_row * A->n_col;
  (void)fprintf(f, "%d\n%d\n%d\n", dense ? 0 : 2, A->n_row, A->n_col);
  if (dense) {
    (void)fprintf(f, "%d\t%d\n", A->n_row, A->n_col);
    for (int j = 0; j < A->n_col; j++) {
      print_vector(f, A->val + A->colptr[j], A->n_row);
    }
    return;
  }
  (void)fprintf(f, "1\nCSparse Version 3 printout\ntriplet: %d-by-%d, nzmax: %d nnz: %d\n",
                A->n_row, A->n_col, nnz, nnz);
  for (int j = 0; j < A->n_col; j++) {
    for (int at = A->colptr[j]; at < A->colptr[j + 1]; at++) {
      (void)fprintf(f, "    %d %d : %.17g\n", A->rowind[at], j, A->val[at]);
    }
  }
}

base_status friction_write_siconos(const char *path, const friction_problem *p, base_error *err) {
  const int n = p->rows * p->n_contact;
  BASE_TRY(friction_check(p, err));
  if (p->n_joint > 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: friction text has no joints", path);
  }
  if (p->global && p->M.n_col == n) {
    return BASE_FAIL(
        err, BASE_EUNSUPPORTED,
        "%s: friction text tells a global problem by its size, which is %d of dofs and of "
        "rows here",
        path, n);
  }
  base_out out;
  BASE_TRY(base_out_open(&out, path, err));
  FILE *f = out.to;
  (void)fprintf(f, "%d\n%d\n", p->rows, p->n_contact);
  print_matrix(f, p->global ? &p->M : &p->W);
  if (p->global) {
    print_matrix(f, &p->H);
    print_vector(f, p->f, p->M.n_col);
  }
  print_vector(f, p->global ? p->w : p->q, n);
  print_vector(f, p->mu, p->n_contact);
  if (p->rows == 5) {
    print_vector(f, p->mu_r, p->n_contact);
  }
  return base_out_close(&out, true, err);
}
