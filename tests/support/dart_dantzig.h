/* tests/support/dart_dantzig.h - Dantzig's method as the engines have it: dSolveLCP of ODE in the copy that DART ships as a
 * library of its own (Debian: libdart-external-odelcpsolver6.12), looked for when the program runs. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* False where the library is not there; everything below then must not be called. */
bool dart_dantzig_is_here(void);

size_t dart_dantzig_work(int n); /* doubles of scratch */

/* w = M z + q, z >= 0, w >= 0, z'w = 0 for symmetric dense M (column-major, n x n). What the library says of its success; it
 * says true on singular M with a wrong z. */
bool dart_dantzig(int n, const double *M, const double *q, double *z, double *work);
