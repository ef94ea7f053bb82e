/* formulations/gsl_library.h - GSL's integrators, loaded when a formulation that integrates opens. */
#pragma once

#include "lcp/base/library.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <gsl/gsl_version.h>

/* clang-format off */
#define GSL_SYMBOLS(X) \
  X(gsl_odeiv2_control_init) \
  X(gsl_odeiv2_driver_alloc_y_new) \
  X(gsl_odeiv2_driver_free) \
  X(gsl_odeiv2_evolve_apply) \
  X(gsl_odeiv2_evolve_reset) \
  X(gsl_odeiv2_step_alloc) \
  X(gsl_odeiv2_step_apply) \
  X(gsl_odeiv2_step_bsimp) \
  X(gsl_odeiv2_step_free) \
  X(gsl_odeiv2_step_msbdf) \
  X(gsl_odeiv2_step_reset) \
  X(gsl_odeiv2_step_rk8pd) \
  X(gsl_odeiv2_step_rkf45) \
  X(gsl_set_error_handler_off) \
  X(gsl_strerror) \
  X(gsl_version)
/* clang-format on */
BASE_LIBRARY(gsl, GSL_SYMBOLS, LCPBENCH_LIB_GSL, "GSL's integrator")

/* The library, which returns its errors from here on instead of ending the program. */
static inline base_status gsl_integrators(gsl_library *table, base_error *err) {
  BASE_TRY(gsl_open(table, err));
  (void)table->gsl_set_error_handler_off();
  return BASE_OK;
}
