/* base/status.h - the one error vocabulary of the suite.
 *
 * Two ideas are kept apart everywhere:
 *   base_status  something is wrong with the call or the machine (bad argument,
 *                no memory, unreadable file); the caller must react.
 *   lcp_outcome  what a solver found out about a well-posed call (lcp_outcome.h);
 *                "iteration limit" is a measurement, not an error.
 */
#pragma once

#include <stddef.h>

#define BASE_STATUS_LIST(X)                                                                        \
  X(BASE_OK, "ok")                                                                                 \
  X(BASE_EINVAL, "argument outside its documented range")                                          \
  X(BASE_ENOMEM, "workspace or heap exhausted")                                                    \
  X(BASE_EIO, "file could not be read or written")                                                 \
  X(BASE_EUNSUPPORTED, "combination not offered by this component")                                \
  X(BASE_EEXTERNAL, "third-party library reported a failure")

#define BASE_ENUM_(id, text) id,
typedef enum base_status { BASE_STATUS_LIST(BASE_ENUM_) BASE_STATUS_COUNT } base_status;

/* Detail of a failure. Caller-owned, may be NULL wherever it is accepted. */
typedef struct base_error {
  base_status code;
  const char *where; /* function name, static storage */
  char text[400];    /* one line, no newline */
} base_error;

const char *base_status_text(base_status s);

#if defined(__GNUC__)
#define BASE_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define BASE_PRINTF(fmt, args)
#endif

/* Fills *err (if not NULL) and returns `code`, so a failure is one statement. The macro names the
 * code once more so that an analyser that sees one file at a time knows what is returned. */
base_status base_fail(base_error *err, base_status code, const char *where, const char *fmt, ...)
    BASE_PRINTF(4, 5);
#define BASE_FAIL(err, code, ...)                                                                  \
  ((void)base_fail((err), (code), __func__, __VA_ARGS__), (base_status)(code))

/* Early return is safe because nothing between two statements owns heap memory. */
#define BASE_TRY(expr)                                                                             \
  do {                                                                                             \
    const base_status base_try_ = (expr);                                                          \
    if (base_try_ != BASE_OK) {                                                                    \
      return base_try_;                                                                            \
    }                                                                                              \
  } while (0)

#define BASE_COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))
