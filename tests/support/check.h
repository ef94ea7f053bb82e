/* tests/support/check.h - cmocka plus the comparisons numerical tests need.
 *
 * cmocka 1.1.5's assert_float_equal casts to float; never use it here.
 */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
/* the four headers above must precede: */
#include "tests/support/heap_count.h"

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of n cases: all of them; under sanitizers, where each runs the same code ten times as slowly, a third. */
#if defined(__SANITIZE_ADDRESS__)
#define CHECK_FEWER(n) (((n) + 2) / 3)
#else
#define CHECK_FEWER(n) (n)
#endif

/* |got - want| <= tol, with NaN failing; prints 17 digits. */
#define check_close(got, want, tol) check_close_at((got), (want), (tol), #got, __FILE__, __LINE__)

/* LCP_TEST_TOL_SCALE=0 makes every comparison print its true residual. */
static inline double check_tol_scale(void) {
  const char *text = getenv("LCP_TEST_TOL_SCALE");
  return (text != NULL) ? strtod(text, NULL) : 1.0;
}

static inline void check_close_at(double got, double want, double tol, const char *what,
                                  const char *file, int line) {
  if (!(fabs(got - want) <= tol * check_tol_scale())) {
    print_error("%s = %.17g, want %.17g +- %.3g\n", what, got, want, tol);
    _fail(file, line);
  }
}

/* A descriptor's words for a reader: one sentence, and not what another one says. */
static inline void check_sentence(const char *name, const char *text, const char *before) {
  const size_t n = (text != NULL) ? strlen(text) : 0;
  if (n < 12 || n > 140 || text[n - 1] != '.' || text[0] < 'A' || text[0] > 'Z') {
    fail_msg("%s: '%s' is no sentence of 12 to 140 characters", name, n > 0 ? text : "");
  }
  if (before != NULL && strcmp(text, before) == 0) {
    fail_msg("%s: another component says '%s' too", name, text);
  }
}

#define check_ok(call, err)                                                                        \
  do {                                                                                             \
    if ((call) != BASE_OK) {                                                                       \
      fail_msg("%s: %s", (err)->where, (err)->text);                                               \
    }                                                                                              \
  } while (0)
