#include "lcp/solvers/mixing.h"

#include <string.h>

void lcp_mixing_layout(lcp_mixing *s, const lcp_capacity *cap, base_arena *a) {
  lin_anderson_layout(&s->anderson, cap->n, a);
  s->plain = BASE_ARRAY(a, double, cap->n);
}

void lcp_mixing_begin(lcp_mixing *s, int n) {
  lin_anderson_begin(&s->anderson, n);
  s->length = HUGE_VAL;
}

base_status lcp_mixing_next(lcp_mixing *s, const double *step, double *x, lcp_work *work) {
  const int n = s->anderson.n;
  base_error unused;
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    sum += step[i] * step[i];
  }
  const double length = sqrt(sum);
  if (!(length <= 2.0 * s->length)) {
    memcpy(x, s->plain, (size_t)n * sizeof *x);
    lcp_mixing_begin(s, n);
    work->fallbacks++;
    return BASE_OK;
  }
  s->length = length;
  for (int i = 0; i < n; i++) {
    s->plain[i] = x[i] + step[i];
  }
  return lin_anderson_next(&s->anderson, step, 1, x, &unused);
}
