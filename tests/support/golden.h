/* tests/support/golden.h - small problems with answers worked by hand, and small members of the
 * registered families. */
#pragma once

#include "problems/families/family.h"

typedef struct golden {
  const char *name;
  lcp_problem p;
  known_answer answer;
  const double *z; /* a solution, NULL: not stated */
  bool easy;       /* well conditioned, symmetric positive definite: nobody may miss it */
} golden;

/* Builds the list once; valid for the life of the process. */
const golden *goldens(int *count);
