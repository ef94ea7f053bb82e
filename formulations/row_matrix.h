/* formulations/row_matrix.h - the Delassus matrix C = J W J' of the active rows as an lcp_matrix:
 * dense, compressed columns, or the factors themselves, never multiplied out. */
#pragma once

#include "formulations/assembly.h"

typedef enum row_storage { ROW_AUTO, ROW_DENSE, ROW_CSC, ROW_FACTORED } row_storage;

typedef struct row_matrix {
  lcp_matrix M; /* view of the arrays below */
  lcp_factored factored;
  lcp_csc shift; /* of factored */
  double *val, *jac;
  int *colptr, *rowind, *body, *jac_start;
  int cap_n, cap_group;
  size_t cap_val, cap_jac;
  void *mem, *val_mem; /* owned */
} row_matrix;

/* What `storage` is for this set: ROW_AUTO becomes ROW_FACTORED where factors pay, and stays for row_matrix_build otherwise. */
row_storage row_storage_of(row_storage storage, const contact_set *c);

/* The assembly that the storage needs; `eliminate`: without joints (not for ROW_FACTORED, form_storage_without_joints). */
base_status row_assembly_begin(form_assembly *a, const contact_set *c, row_storage storage,
                               bool eliminate, const form_rule *rule, contact_memory *memory,
                               base_error *err);

/* Large matrices without joints have their factors beside them. ROW_FACTORED takes an assembly of own blocks only, with its joints still in it:
 * joints that were eliminated cannot be expressed by factors. */
base_status row_matrix_build(row_matrix *m, const form_assembly *a, row_storage storage,
                             base_error *err);
/* Adds add[n_row] >= 0 to the diagonal of the matrix that was built, as S where it is in factors; once. */
void row_matrix_soften(row_matrix *m, const double *add);
void row_matrix_close(row_matrix *m);
