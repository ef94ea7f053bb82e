/* problems/import/import.h - complementarity problems from the files of other codes. */
#pragma once

#include "lcp/lcp_judge.h"
#include "problems/import/friction_problem.h"

typedef enum import_kind {
  IMPORT_UNKNOWN,
  IMPORT_LCP,      /* Siconos text LCP: lcp_read_siconos */
  IMPORT_MLCP,     /* Siconos text mixed LCP */
  IMPORT_FRICTION, /* Siconos text friction problem */
  IMPORT_FCLIB,    /* HDF5 */
} import_kind;

/* What a file is, by its first numbers or its signature. BASE_EIO if it cannot be opened; a file
 * that is none of these is IMPORT_UNKNOWN. */
base_status import_detect(const char *path, import_kind *kind, base_error *err);

/* Siconos text MLCP: equations become LCP_FREE blocks, the rest orthants. */
base_status import_mlcp(const char *path, known_lcp *out, base_error *err);

/* Any of them as a problem to solve: friction on the exact cone (facets = 0) or posed with that
 * many facets; global ones are condensed. Beside a problem with facets stands the exact cone that its answer is
 * judged on. */
typedef struct import_posed {
  known_lcp posed;
  known_lcp cone;   /* empty (no unknowns) unless facets were asked of a friction problem */
  int rows, facets; /* of a friction problem; 0: it is none, or posed on the cone */
} import_posed;

base_status import_pose(const char *path, int facets, import_posed *out, base_error *err);
void import_posed_free(import_posed *p);

/* Residual of an answer z of p->posed on the true cone: De Saxce's natural map of the friction
 * problem [m/s], with the rest of the verdict. BASE_EUNSUPPORTED if `cone` is empty. */
base_status import_judge_cone(const import_posed *p, const double *z, lcp_verdict *out,
                              base_error *err);
