/* formulations/row_form.h - what `coulomb` and `boxed` share: the unknowns are the impulses of the
 * active rows themselves, z = lambda, M = C, q = r + b_n. They differ in the sets. */
#pragma once

#include "formulations/boxed/boxed_bounds.h"
#include "formulations/bristle.h"
#include "formulations/row_matrix.h"

typedef struct row_options {
  int storage; /* row_storage */
  int level;   /* form_level */
  int joints;  /* 0 eliminated, 1 kept as free rows */
  int activation, restitution, distribution;
  form_repair repair;
  int outer;              /* boxed: most solves in a step */
  double outer_tol;       /* boxed: what moved bounds change, over the largest impulse [1] */
  double bristle, damper; /* boxed: of friction rows [N/m], [N s/m]; both 0: rigid */
} row_options;

struct row_form {
  form_assembly a;
  contact_memory memory;
  row_matrix matrix;
  row_options opt;
  formulation_start start;
  formulation_reader reader;
  double *q, *z0, *lambda, *lo, *hi; /* n_row */
  double *normal;                    /* n_contact: lambda_n behind the bounds [N s] */
  double *move; /* boxed: how far the answer's lambda_n is from them; n_contact */
  boxed_bounds bounds;
  double *w, *diagonal, *scratch; /* boxed: M z + q, diag M; n_row each, and a product's own */
  double *deflection, *soft; /* boxed: of bristles [m], their compliance 1/G [1/kg]; n_row each */
  double *mu;                /* boxed: of friction rows; n_row */
  int *copies;               /* boxed: of each contact (form_bristle_sharers); n_contact */
  form_bristle_key *bodies;  /* scratch of that; n_contact */
  lcp_block *block;          /* at most 4 a contact, 1 a joint */
  int n_block;
  bool round_cone; /* friction is against the slip */
  bool done;
  formulation_answer answer;
  int cap_row, cap_group;
  size_t cap_scratch;
  void *mem; /* owned */
};

base_status row_form_begin(row_form *s, const contact_set *c, const row_options *opt,
                           formulation_start start, base_error *err);
/* Cone row dimensions and coefficients of contact i: friction, torsion, rolling. */
int row_form_parts(const row_form *s, int i, int dim[LCP_PARTS_MAX], double mu[LCP_PARTS_MAX]);
void row_form_rows(const void *state, formulation_rows *out);
/* Impulses of the step into the answer; modes and memory. */
void row_form_finish(row_form *s, const double *lambda, bool solved);
void row_form_answer(const void *state, formulation_answer *out);
void row_form_close(void *state);

/* What the descriptors of formulations by rows share; what is not named row_form_ is their own. */
#define ROW_FORM_PARTS                                                                             \
  .fields = fields, .n_fields = BASE_COUNT(fields), .options_size = sizeof(options),               \
  .state_size = sizeof(row_form), .memory = offsetof(row_form, memory),                            \
  .reader = offsetof(row_form, reader), .dimension = dimension, .close = row_form_close,           \
  .begin = begin, .assemble = assemble, .rows = row_form_rows, .recover = recover,                 \
  .answer = row_form_answer

#define ROW_FORM_FIELDS(T)                                                                         \
  FORM_STORAGE_FIELD(T),                                                                           \
      BASE_FIELD_CHOICE(T, level, "velocity|position", 0, "level of the normal rows"),             \
      FORM_JOINTS_FIELD(T), FORM_ACTIVATION_FIELD(T), FORM_DISTRIBUTION_FIELD(T),                  \
      BASE_FIELD_CHOICE(T, restitution, "newton|none", 0, "law of impact"),                        \
      FORM_PUSH_FIELDS(T, 0), FORM_JOINT_PUSH_FIELD(T)
