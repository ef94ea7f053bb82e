/* harness/problem_source.h - a complementarity problem from the text a user gives: a file
 * (x.dat Siconos text, M.mtx Matrix Market) or a family with parameters. */
#pragma once

#include "lcp/io/lcp_read.h"

typedef struct problem_source {
  lcp_file_problem file;
  char name[256]; /* as given */
} problem_source;

/* q_path: the Matrix Market vector; NULL: NAME.q.mtx beside NAME.M.mtx. */
base_status problem_source_open(const char *text, const char *q_path, problem_source *out,
                                base_error *err);
void problem_source_close(problem_source *s);
