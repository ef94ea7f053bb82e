/* problems/import/import.h - complementarity problems from the files of other codes. */
#pragma once

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
 * many facets; global ones are condensed. *out is freed with known_lcp_free. */
base_status import_problem(const char *path, int facets, known_lcp *out, base_error *err);
