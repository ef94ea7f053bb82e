/* harness/measure/check_eval.h - judges a finished simulation by a check of its scene.
 *
 * |got - expected| <= abs + h h-coefficient + h^2 h2-coefficient + inv_h / h + rel |expected|, and
 * for regularised friction additionally reg.h h + reg.v v_s + reg.d delta (RESIDUALS 6), with
 * the regularisation velocity v_s and the saturation deflection delta that the run really had. */
#pragma once

#include "harness/measure/series.h"

typedef struct check_context {
  const series *record;
  double h;          /* [s] */
  bool regularised;  /* the formulation stands for "regularized" */
  double v_slip;     /* v_s, largest over the run [m/s] */
  double deflection; /* delta, largest over the run [m] */
  bool finite;       /* no NaN or Inf in any state */
} check_context;

typedef struct check_result {
  bool ok;
  bool known; /* false: the check could not be evaluated; see reason */
  double got, expected, error, tolerance;
  double time; /* where it was evaluated [s] */
  char reason[96];
} check_result;

void check_evaluate(const spec_check *c, const check_context *ctx, check_result *out);

/* "state block.x", "contact_force block/floor normal", ... */
void check_label(const spec_check *c, char *buf, size_t cap);
