/* harness/measure/problem_source.h - a complementarity problem from the text a user gives: a family with
 * parameters ("murty:n=12"), or a file: x.dat (Siconos text: LCP, mixed LCP, friction), x.hdf5
 * (FCLIB), both with ":facets=N" behind them for a polyhedral cone, NAME.M.mtx (Matrix Market, with
 * NAME.q.mtx or a q of its own), x.npz (numpy: M, q, bounds), or -, standard input, told by how it begins. */
#pragma once

#include "lcp/io/lcp_read.h"
#include "problems/families/known_lcp.h"
#include "problems/import/import.h"

typedef struct problem_source {
  char name[1100];       /* as given */
  lcp_file_problem file; /* Matrix Market and Siconos LCPs */
  known_lcp known;       /* families */
  import_posed import;   /* Siconos text but LCPs, FCLIB */
  const lcp_problem *p;  /* the problem, in one of the three */
} problem_source;

/* A file of another code, by its ending: .dat, .hdf5, .h5. */
bool problem_is_import(const char *path);
/* Does the text name a file, not a family? */
bool problem_is_file(const char *text);

/* "FILE.dat:facets=8" (also .hdf5, .h5): the file, and its facets; any other text whole, and 0. */
base_status problem_file(const char *text, char *path, size_t cap, int *facets, base_error *err);

/* Is it a friction problem, whose answers have a residual on the true cone? */
bool problem_source_has_cone(const problem_source *s);
/* That residual (import.h), also of problems with facets. */
base_status problem_source_judge_cone(const problem_source *s, const double *z, lcp_verdict *out,
                                      base_error *err);

/* q_path: the Matrix Market vector; NULL: beside M. facets: of friction problems; 0: those of the
 * text, else the exact cone. BASE_EINVAL: either is given where it has no meaning. */
base_status problem_source_open(const char *text, const char *q_path, int facets,
                                problem_source *out, base_error *err);
void problem_source_close(problem_source *s);
