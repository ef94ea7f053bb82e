/* harness/problem_source.h - a complementarity problem from the text a user gives: a family with
 * parameters ("murty:n=12"), or a file: x.dat (Siconos text: LCP, mixed LCP, friction), x.hdf5
 * (FCLIB), NAME.M.mtx (Matrix Market, with NAME.q.mtx or a q of its own). */
#pragma once

#include "lcp/io/lcp_read.h"
#include "problems/known_lcp.h"

typedef struct problem_source {
  char name[256];        /* as given */
  lcp_file_problem file; /* Matrix Market and Siconos LCPs */
  known_lcp known;       /* families and imports */
  const lcp_problem *p;  /* the problem, in one of the two */
} problem_source;

/* q_path: the Matrix Market vector; NULL: beside M. facets: of friction problems; 0: exact cone. */
base_status problem_source_open(const char *text, const char *q_path, int facets,
                                problem_source *out, base_error *err);
void problem_source_close(problem_source *s);
