/* harness/measure/answers.h - the answers of all solves of a cell, in one compact file, so that verdicts can be
 * recomputed without the solvers.
 *
 * File: "LCPBANS1", then per solve int32 n, int32 word, int32 n_proof, a bit per unknown (1: not zero),
 * the nonzero doubles of z, and n_proof doubles of the certificate of infeasibility; native byte
 * order. word >= 0 is the solver's claim (lcp_outcome); word < 0 is the error -word (base_status)
 * that it returned instead of an answer. */
#pragma once

#include "lcp/base/output.h"
#include "lcp/lcp_solver.h"

typedef struct answers {
  base_out write; /* of answers_create */
  FILE *file;     /* of answers_open */
  char path[1100];
  double *proof; /* of the answer last taken; owned */
  int proof_cap;
} answers;

/* The file gets its name when it is closed whole. */
base_status answers_create(answers *a, const char *path, base_error *err);

/* The answer z[n] with the solver's claim; or the error it returned where n unknowns were asked for. */
base_status answers_put(answers *a, int n, const double *z, const lcp_result *claim,
                        base_error *err);
base_status answers_put_failure(answers *a, int n, base_status failed, base_error *err);

/* keep: false discards what was written. */
base_status answers_close(answers *a, bool keep, base_error *err);

base_status answers_open(answers *a, const char *path, base_error *err);

/* The next answer into z[n] and claim (outcome and proof; no work). BASE_EINVAL when the file holds no
 * further answer or one of another size; the stored error where the solver returned one. */
base_status answers_take(answers *a, int n, double *z, lcp_result *claim, base_error *err);

/* BASE_EINVAL if answers are left over. */
base_status answers_finish(answers *a, base_error *err);
