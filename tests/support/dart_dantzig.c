#include "tests/support/dart_dantzig.h"

#include <dlfcn.h>
#include <math.h>
#include <string.h>

/* dart::external::ode::dSolveLCP(n, A, x, b, w, nub, lo, hi, findex, early): A x = b + w, rows of A padded to multiples of
 * four; A, b, lo and hi are overwritten. */
typedef bool (*solve_lcp)(int, double *, double *, double *, double *, int, double *, double *,
                          int *, bool);

static solve_lcp function(void) {
  static solve_lcp found;
  static bool looked;
  if (!looked) {
    looked = true;
    void *library = dlopen("libdart-external-odelcpsolver.so.6.12", RTLD_NOW);
    void *at = (library == NULL)
                   ? NULL
                   : dlsym(library, "_ZN4dart8external3ode9dSolveLCPEiPdS2_S2_S2_iS2_S2_Pib");
    memcpy(&found, &at, sizeof found);
  }
  return found;
}

bool dart_dantzig_is_here(void) {
  return function() != NULL;
}

static size_t padded(int n) {
  return ((size_t)n + 3) / 4 * 4;
}

size_t dart_dantzig_work(int n) {
  return padded(n) * ((size_t)n + 4);
}

bool dart_dantzig(int n, const double *M, const double *q, double *z, double *work) {
  const size_t width = padded(n);
  double *b = work + width * (size_t)n, *w = b + width, *lo = w + width, *hi = lo + width;
  for (int i = 0; i < n; ++i) {
    memcpy(work + width * (size_t)i, M + (size_t)n * (size_t)i, sizeof *M * (size_t)n);
    z[i] = 0;
    b[i] = -q[i];
    lo[i] = 0;
    hi[i] = HUGE_VAL;
  }
  return function()(n, work, z, b, w, 0, lo, hi, NULL, false);
}
