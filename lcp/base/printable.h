/* base/printable.h - text of unknown origin for a terminal: control characters (C0, DEL, and C1 in UTF-8)
 * and bytes that are not UTF-8 become \n, \t, \r or \xHH, so that a message is one line and moves no
 * cursor. */
#pragma once

#include <stddef.h>

/* Writes what fits of it into buf[cap], cap > 0, NUL-terminated, and returns buf. Four bytes for each of
 * text always suffice. */
const char *base_printable(const char *text, char *buf, size_t cap);
