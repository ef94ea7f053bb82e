/* base/library.h - libraries that are loaded when they are asked for.
 *
 * What few runs need (HDF5 with its 30 libraries, CHOLMOD with a second LAPACK, GSL, NLopt) would cost every start of the
 * program. Such a library is listed once, in a header of its own, as the symbols that are used:
 *
 *   #define NLOPT_SYMBOLS(X) X(nlopt_create) X(nlopt_destroy) ...
 *   BASE_LIBRARY(nlopt, NLOPT_SYMBOLS, LCPBENCH_LIB_NLOPT, "SQP")
 *
 * makes the struct nlopt_library, whose members are pointers to them by the types of the library's header, and nlopt_open, which
 * fills it. */
#pragma once

#include "lcp/base/status.h"

/* Loads the shared library `file`, or finds it loaded, and puts the addresses of name[0..count-1] into the pointers that `table`
 * consists of. BASE_EEXTERNAL: not there, or without one of them; the line says for whose sake. It stays loaded. */
base_status base_library_open(const char *file, const char *purpose, const char *const *name,
                              int count, void *table, base_error *err);

#define BASE_LIBRARY_MEMBER_(symbol) __typeof__(&(symbol)) symbol;
#define BASE_LIBRARY_NAME_(symbol)   #symbol,
#define BASE_LIBRARY(id, SYMBOLS, file, purpose)                                                   \
  typedef struct id##_library {                                                                    \
    SYMBOLS(BASE_LIBRARY_MEMBER_)                                                                  \
  } id##_library;                                                                                  \
  static inline base_status id##_open(id##_library *table, base_error *err) {                      \
    static const char *const name[] = {SYMBOLS(BASE_LIBRARY_NAME_)};                               \
    _Static_assert(sizeof(id##_library) == sizeof name, "pointers only");                          \
    return base_library_open(file, purpose, name, BASE_COUNT(name), table, err);                   \
  }
