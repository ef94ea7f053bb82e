/* lcp/io/lcp_text.h - a whole text file in memory, read number by number, with line numbers for
 * messages. Locale-independent. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

typedef struct lcp_text {
  const char *path; /* borrowed */
  char *data;       /* owned, NUL-terminated */
  size_t size;      /* [bytes] */
  const char *at;   /* next character */
  long line;        /* of `at`, from 1 */
} lcp_text;

/* Reads a regular file of at most 2 GiB. A file with a NUL byte is refused. */
base_status lcp_text_open(lcp_text *t, const char *path, base_error *err);
void lcp_text_close(lcp_text *t);

/* Next white-space separated finite number; `what` names it in the message. */
base_status lcp_text_real(lcp_text *t, const char *what, double *x, base_error *err);
base_status lcp_text_int(lcp_text *t, const char *what, long lo, long hi, long *x, base_error *err);

/* Next word (up to 63 characters) without consuming it; "" at the end. */
void lcp_text_peek(const lcp_text *t, char word[64]);
void lcp_text_skip_line(lcp_text *t);

/* BASE_EINVAL unless what is left of the file can hold `count` more numbers: each takes at least
 * one digit and one separator. */
base_status lcp_text_holds(const lcp_text *t, double count, const char *what, base_error *err);
