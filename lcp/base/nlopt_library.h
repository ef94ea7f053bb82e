/* base/nlopt_library.h - NLopt, loaded when a solve or a calibration asks for it. */
#pragma once

#include "lcp/base/library.h"

#include <nlopt.h>

/* clang-format off */
#define NLOPT_SYMBOLS(X) \
  X(nlopt_create) \
  X(nlopt_destroy) \
  X(nlopt_get_numevals) \
  X(nlopt_optimize) \
  X(nlopt_set_initial_step) \
  X(nlopt_set_lower_bounds) \
  X(nlopt_set_maxeval) \
  X(nlopt_set_maxtime) \
  X(nlopt_set_min_objective) \
  X(nlopt_set_upper_bounds) \
  X(nlopt_set_xtol_rel) \
  X(nlopt_version)
/* clang-format on */
BASE_LIBRARY(nlopt, NLOPT_SYMBOLS, LCPBENCH_LIB_NLOPT, "NLopt's optimiser")
