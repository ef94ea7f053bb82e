/* library/library.h - what the files of the C library share: the public header over the internal types. */
#pragma once

#include "include/lcpbench/lcpbench.h"
#include "lcp/lcp_problem.h"

/* The public lcp_problem is the first member of this; the library owns every array. */
typedef struct library_problem {
  lcp_problem p;
  int *colptr, *rowind; /* LCP_CSC */
  double *val;          /* n*n column-major, or colptr[n] */
  bool row_major;       /* as dense values are handed in */
  double *q;            /* n */
  double *lo, *hi;      /* n, as asked for; used on box blocks */
  lcp_block *block;     /* n, as many as there may be */
  int n_cone;
  lcp_block *cone; /* n_cone */
} library_problem;

/* Keeps the line of err for lcp_last_error and gives the public code of its status. */
int library_failed(const base_error *err);

/* The same for a line of its own. */
int library_unsolved(const char *format, ...) BASE_PRINTF(1, 2);
