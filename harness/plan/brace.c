#include "harness/plan/plan.h"

#include <stdio.h>
#include <string.h>

enum { BRACE_TEXT = 512 };

base_status brace_expand(const char *text, text_list *out, base_error *err) {
  const char *open = strchr(text, '{');
  if (open == NULL) {
    return text_list_add(out, text, err);
  }
  const char *close = strchr(open, '}');
  if (close == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "'%.80s': a brace is not closed", text);
  }
  for (const char *item = open + 1; item <= close;) {
    const size_t len = strcspn(item, ",}");
    char one[BRACE_TEXT];
    const int wrote = snprintf(one, sizeof one, "%.*s%.*s%s", (int)(open - text), text, (int)len,
                               item, close + 1);
    if (wrote < 0 || (size_t)wrote >= sizeof one) {
      return BASE_FAIL(err, BASE_EINVAL, "'%.80s': longer than %d characters", text, BRACE_TEXT);
    }
    BASE_TRY(brace_expand(one, out, err));
    item += len + 1;
  }
  return BASE_OK;
}
