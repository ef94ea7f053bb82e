#include "harness/measure/effects_plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* "12:" at *text: the step, and *text behind it. */
static base_status read_from(const char **text, long last, long *from, base_error *err) {
  char *end;
  *from = strtol(*text, &end, 10);
  if (end == *text || *end != ':' || *from <= last) {
    return BASE_FAIL(err, BASE_EINVAL, "effects '%.60s': need STEP:EFFECTS with a step above %ld",
                     *text, last);
  }
  *text = end + 1;
  return BASE_OK;
}

static const char sleeping[] = "+sleep";

/* Is it one of the words of the text? Less it then. */
static bool take_sleep(char *text, size_t cap) {
  const size_t own = strlen(sleeping);
  char *at = text;
  while (strncmp(at, sleeping, own) != 0 || (at[own] != '\0' && at[own] != ',')) {
    at += strcspn(at, ",");
    if (*at == '\0') {
      return false;
    }
    at++;
  }
  if (strcmp(text, sleeping) == 0) {
    (void)snprintf(text, cap, "declared");
  } else if (at > text) {
    memmove(at - 1, at + own, strlen(at + own) + 1); /* with the comma before it */
  } else {
    memmove(at, at + own + 1, strlen(at + own)); /* with that behind it */
  }
  return true;
}

base_status effects_plan_parse(unsigned declared, const char *text, effects_plan *out,
                               base_error *err) {
  char word[EFFECTS_TEXT];
  *out = (effects_plan){0};
  for (;;) {
    const size_t len = strcspn(text, "/");
    effects_span *s = &out->span[out->n];
    if (out->n == EFFECTS_SPANS || len >= sizeof word) {
      return BASE_FAIL(err, BASE_EINVAL, "effects: need at most %d changes of at most %d letters",
                       EFFECTS_SPANS - 1, EFFECTS_TEXT - 1);
    }
    memcpy(word, text, len);
    word[len] = '\0';
    if (out->n == 0) {
      out->sleep = take_sleep(word, sizeof word);
    } else if (strstr(word, sleeping) != NULL) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "effects '%.60s': %s holds for the whole run, need it in the first text",
                       word, sleeping);
    }
    const char *effects = word;
    if (out->n > 0) {
      BASE_TRY(read_from(&effects, s[-1].from, &s->from, err));
    }
    BASE_TRY(effects_override(declared, effects, &s->effects, err));
    out->n++;
    if (text[len] == '\0') {
      return BASE_OK;
    }
    text += len + 1;
  }
}

void effects_plan_print(const effects_plan *p, unsigned declared, char text[EFFECTS_TEXT]) {
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; k < p->n && used < EFFECTS_TEXT; k++) {
    const unsigned differs = p->span[k].effects ^ declared;
    const bool sleep = p->sleep && k == 0;
    if (k > 0) {
      used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "/%ld:", p->span[k].from);
    }
    if (differs == 0 && !sleep && used < EFFECTS_TEXT) {
      used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "declared");
    }
    const char *comma = "";
    for (int i = 0; i < EFFECT_COUNT && used < EFFECTS_TEXT; i++) {
      if ((differs & 1u << i) != 0) {
        const char sign = ((declared & 1u << i) != 0) ? '-' : '+';
        used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "%s%c%s", comma, sign,
                                 effect_name(i));
        comma = ",";
      }
    }
    if (sleep && used < EFFECTS_TEXT) {
      used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "%s%s", comma, sleeping);
    }
  }
}

unsigned effects_plan_union(const effects_plan *p) {
  unsigned all = 0;
  for (int k = 0; k < p->n; k++) {
    all |= p->span[k].effects;
  }
  return all;
}

unsigned effects_plan_at(const effects_plan *p, long done) {
  int k = 0;
  while (k + 1 < p->n && p->span[k + 1].from <= done) {
    k++;
  }
  return p->span[k].effects;
}
