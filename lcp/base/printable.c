#include "lcp/base/printable.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Bytes of the UTF-8 character at c that may be shown as it is; 0: the first is to be escaped. */
static size_t shown(const unsigned char *c) {
  static const struct {
    unsigned char mask, lead;
  } forms[] = {{0x80, 0x00}, {0xe0, 0xc0}, {0xf0, 0xe0}, {0xf8, 0xf0}};
  static const unsigned long first[] = {0x20, 0xa0, 0x800,
                                        0x10000}; /* below: control or too long */
  for (size_t n = 1; n <= 4; n++) {
    if ((c[0] & forms[n - 1].mask) != forms[n - 1].lead) {
      continue;
    }
    unsigned long code = c[0] & (unsigned char)~forms[n - 1].mask;
    for (size_t k = 1; k < n; k++) {
      if ((c[k] & 0xc0) != 0x80) {
        return 0;
      }
      code = code << 6 | (c[k] & 0x3f);
    }
    const bool bad =
        code < first[n - 1] || code == 0x7f || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff;
    return bad ? 0 : n;
  }
  return 0;
}

const char *base_printable(const char *text, char *buf, size_t cap) {
  size_t used = 0;
  for (const unsigned char *c = (const unsigned char *)text; *c != '\0';) {
    char one[8];
    const size_t n = shown(c);
    if (n > 0) {
      (void)snprintf(one, sizeof one, "%.*s", (int)n, (const char *)c);
    } else if (*c == '\n' || *c == '\t' || *c == '\r') {
      (void)snprintf(one, sizeof one, "\\%c", (*c == '\n') ? 'n' : (*c == '\t') ? 't' : 'r');
    } else {
      (void)snprintf(one, sizeof one, "\\x%02x", *c);
    }
    const size_t len = strlen(one);
    if (used + len >= cap) {
      break;
    }
    memcpy(buf + used, one, len);
    used += len;
    c += (n > 0) ? n : 1;
  }
  buf[used] = '\0';
  return buf;
}
