/* formulations/row_form.h - what `coulomb` and `boxed` share: the unknowns are the impulses of the
 * active rows themselves, z = lambda, M = C, q = r + b_n. They differ in the sets. */
#pragma once

#include "formulations/row_matrix.h"

typedef struct row_options {
  int storage; /* row_storage */
  int level;   /* form_level */
  int joints;  /* 0 eliminated, 1 kept as free rows */
  int activation, restitution;
  double push, push_speed, rest, joint_push;
  int outer;        /* boxed: most solves in a step */
  double outer_tol; /* boxed: what moved bounds change, over the largest impulse [1] */
} row_options;

typedef struct row_form {
  form_assembly a;
  contact_memory memory;
  row_matrix matrix;
  row_options opt;
  formulation_start start;
  double *q, *z0, *lambda, *lo, *hi; /* n_row */
  double *normal;                    /* n_contact: lambda_n behind the bounds [N s] */
  double *w, *diagonal, *scratch;    /* boxed: M z + q, diag M; n_row each, and a product's own */
  lcp_block *block;                  /* at most 4 a contact, 1 a joint */
  int n_block;
  bool done;
  formulation_answer answer;
  int cap_row, cap_group;
  size_t cap_scratch;
  void *mem; /* owned */
} row_form;

base_status row_form_begin(row_form *s, const contact_set *c, const row_options *opt,
                           formulation_start start, base_error *err);
/* mu of active contact i: the kinetic one where it slipped a step ago. */
double row_form_friction(const row_form *s, int i);
/* Cone row dimensions and coefficients of contact i: friction, torsion, rolling. */
int row_form_parts(const row_form *s, int i, int dim[LCP_PARTS_MAX], double mu[LCP_PARTS_MAX]);
/* Impulses of the step into the answer; modes and memory. */
void row_form_finish(row_form *s, const double *lambda, bool solved);
void row_form_answer(const void *state, formulation_answer *out);
void row_form_close(void *state);

#define ROW_FORM_FIELDS(T)                                                                         \
  BASE_FIELD_CHOICE(T, storage, "auto|dense|csc|factored", 0, "matrix handed to the solver"),      \
      BASE_FIELD_CHOICE(T, level, "velocity|position", 0, "level of the normal rows"),             \
      BASE_FIELD_CHOICE(T, joints, "eliminated|mixed", 0, "or free rows (always when factored)"),  \
      BASE_FIELD_CHOICE(T, activation, "closed|moreau", 0, "gap, or gap half a step ahead"),       \
      BASE_FIELD_CHOICE(T, restitution, "newton|none", 0, "law of impact"),                        \
      BASE_FIELD(T, push, BASE_REAL, "1", 0, 0, 1, "share of an overlap removed a step"),          \
      BASE_FIELD(T, push_speed, BASE_REAL, "m/s", 1e9, 0, 1e9, "limit of that speed"),             \
      BASE_FIELD(T, rest, BASE_REAL, "1", 2, 0, 1e6, "approach in steps of load: no bounce"),      \
      BASE_FIELD(T, joint_push, BASE_REAL, "1", 0.2, 0, 1, "share of a joint error removed")
