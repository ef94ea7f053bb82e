/* linear/cholmod_library.h - CHOLMOD, loaded when a sparse factor or an ordering asks for it. */
#pragma once

#include "lcp/base/library.h"

#include <suitesparse/cholmod.h>

/* clang-format off */
#define CHOLMOD_SYMBOLS(X) \
  X(cholmod_add) \
  X(cholmod_allocate_dense) \
  X(cholmod_allocate_sparse) \
  X(cholmod_analyze) \
  X(cholmod_copy) \
  X(cholmod_factorize) \
  X(cholmod_finish) \
  X(cholmod_free_dense) \
  X(cholmod_free_factor) \
  X(cholmod_free_sparse) \
  X(cholmod_metis) \
  X(cholmod_solve) \
  X(cholmod_sort) \
  X(cholmod_spsolve) \
  X(cholmod_ssmult) \
  X(cholmod_start) \
  X(cholmod_transpose)
/* clang-format on */
BASE_LIBRARY(cholmod, CHOLMOD_SYMBOLS, LCPBENCH_LIB_CHOLMOD, "a sparse factor")

/* The library and what its functions are handed. */
typedef struct cholmod_session {
  cholmod_library of;
  cholmod_common common;
} cholmod_session;

/* Ends with of.cholmod_finish(&common). It prints nothing. */
static inline base_status cholmod_begin(cholmod_session *c, base_error *err) {
  BASE_TRY(cholmod_open(&c->of, err));
  (void)c->of.cholmod_start(&c->common);
  c->common.print = 0;
  return BASE_OK;
}
