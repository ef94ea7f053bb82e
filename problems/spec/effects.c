#include "problems/spec/effects.h"

#include "lcp/base/nearest.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define NAME_(id, text, words)  text,
#define WORDS_(id, text, words) words,
static const char *const names[] = {EFFECT_LIST(NAME_)};
static const char *const plain[] = {EFFECT_LIST(WORDS_)};

const char *effect_name(int bit) {
  return (bit >= 0 && bit < EFFECT_COUNT) ? names[bit] : "unknown";
}

const char *effect_words(int bit) {
  return (bit >= 0 && bit < EFFECT_COUNT) ? plain[bit] : "unknown";
}

void effects_print(unsigned mask, char *buf, size_t cap) {
  size_t used = 0;
  if (cap > 0) {
    buf[0] = '\0';
  }
  for (int i = 0; i < EFFECT_COUNT && used < cap; i++) {
    if ((mask & (1u << i)) != 0) {
      used += (size_t)snprintf(buf + used, cap - used, "%s%s", used > 0 ? " " : "", names[i]);
    }
  }
}

static int find_effect(const char *name, size_t len) {
  for (int i = 0; i < EFFECT_COUNT; i++) {
    if (strlen(names[i]) == len && strncmp(names[i], name, len) == 0) {
      return i;
    }
  }
  return -1;
}

base_status effects_override(unsigned declared, const char *spec, unsigned *out, base_error *err) {
  *out = declared;
  if (strcmp(spec, "declared") == 0) {
    return BASE_OK;
  }
  if (strcmp(spec, "all") == 0) {
    *out = (1u << EFFECT_COUNT) - 1u;
    return BASE_OK;
  }
  while (*spec != '\0') {
    const size_t len = strcspn(spec, ",");
    const int bit = (len > 1) ? find_effect(spec + 1, len - 1) : -1;
    if ((*spec != '-' && *spec != '+') || bit < 0) {
      char hint[BASE_NEAREST_HINT];
      const bool sign = *spec == '-' || *spec == '+';
      base_nearest near = base_nearest_to(spec + (sign ? 1 : 0), len - (sign ? 1 : 0));
      for (int i = 0; i < EFFECT_COUNT; i++) {
        base_nearest_offer(&near, names[i]);
      }
      base_nearest_offer_words(&near, sign ? "" : "declared|all");
      return BASE_FAIL(err, BASE_EINVAL,
                       "effects '%.*s': need declared, all, or -NAME/+NAME of a known effect%s",
                       (int)len, spec, base_nearest_hint(&near, hint));
    }
    *out = (*spec == '+') ? *out | (1u << bit) : *out & ~(1u << bit);
    spec += len + (spec[len] == ',');
  }
  return BASE_OK;
}
