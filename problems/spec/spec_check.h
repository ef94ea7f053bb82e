/* problems/spec/spec_check.h - parts of spec_check_all (spec.h), each naming the culprit and the rule. */
#pragma once

#include "problems/spec/spec.h"

#include <math.h>

static inline bool spec_all_finite(const double *x, int n) {
  bool finite = true;
  for (int i = 0; i < n; i++) {
    finite = finite && isfinite(x[i]);
  }
  return finite;
}

/* Is a rotation left to the body? */
static inline bool spec_can_rotate(const scene_spec *s, const spec_body *b) {
  const unsigned rot = (s->dim == 2) ? SPEC_RZ : SPEC_ROT;
  return (b->lock & rot) != rot;
}

base_status spec_check_body(const scene_spec *s, const spec_body *b, base_error *err);
base_status spec_check_static(const scene_spec *s, const spec_static *p, base_error *err);
