/* linear/lapack_status.h - how functions of LAPACKE that take their own memory ended. */
#pragma once

#include "lcp/base/status.h"

#include <lapacke.h>

/* BASE_OK, BASE_ENOMEM; BASE_EEXTERNAL for all else (info of the function: not a number, singular, no convergence). */
static inline base_status lin_lapack_status(lapack_int info) {
  return (info == 0) ? BASE_OK : (info == LAPACK_WORK_MEMORY_ERROR) ? BASE_ENOMEM : BASE_EEXTERNAL;
}
