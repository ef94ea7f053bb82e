#include "problems/read/node.h"

#include "lcp/base/nearest.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define BAD(...) BASE_FAIL(n->err, BASE_EINVAL, __VA_ARGS__)

base_status node_open(node *n, json_t *v, base_error *err, const char *where, ...) {
  n->v = v;
  n->err = err;
  va_list args;
  va_start(args, where);
  (void)vsnprintf(n->where, sizeof n->where, where, args); /* a cut name still names */
  va_end(args);
  if (!json_is_object(v)) {
    return BAD("%s: need an object", n->where);
  }
  return BASE_OK;
}

/* Index of `text` among the words of "a|b|c", -1 if it is not there. */
static int word_index(const char *words, const char *text) {
  const size_t len = strlen(text);
  const char *w = words;
  for (int i = 0; w != NULL; i++) {
    const char *bar = strchr(w, '|');
    const size_t n = (bar != NULL) ? (size_t)(bar - w) : strlen(w);
    if (n == len && strncmp(w, text, n) == 0) {
      return i;
    }
    w = (bar != NULL) ? bar + 1 : NULL;
  }
  return -1;
}

base_status node_keys(const node *n, const char *known) {
  void *iter = json_object_iter(n->v);
  while (iter != NULL) {
    const char *key = json_object_iter_key(iter);
    if (word_index(known, key) < 0) {
      char hint[BASE_NEAREST_HINT];
      return BAD("%s: unknown key '%.40s'%s", n->where, key, base_nearest_word(key, known, hint));
    }
    iter = json_object_iter_next(n->v, iter);
  }
  return BASE_OK;
}

bool node_has(const node *n, const char *key) {
  return json_object_get(n->v, key) != NULL;
}

base_status node_need(const node *n, const char *key) {
  return node_has(n, key) ? BASE_OK : BAD("%s: needs '%s'", n->where, key);
}

base_status node_number(const node *n, const json_t *v, const char *what, double *out) {
  if (!json_is_number(v)) {
    return BAD("%s: %s: need a number", n->where, what);
  }
  *out = json_number_value(v);
  if (!isfinite(*out)) {
    return BAD("%s: %s: need a finite number", n->where, what);
  }
  return BASE_OK;
}

base_status node_string(const node *n, const json_t *v, const char *what, char *out, size_t cap) {
  if (!json_is_string(v)) {
    return BAD("%s: %s: need a text", n->where, what);
  }
  const char *text = json_string_value(v);
  if (strlen(text) >= cap) {
    return BAD("%s: %s: text of %zu characters, need at most %zu", n->where, what, strlen(text),
               cap - 1);
  }
  memcpy(out, text, strlen(text) + 1);
  return BASE_OK;
}

base_status node_real(const node *n, const char *key, double *out) {
  const json_t *v = json_object_get(n->v, key);
  return (v == NULL) ? BASE_OK : node_number(n, v, key, out);
}

base_status node_int(const node *n, const char *key, int *out) {
  if (!node_has(n, key)) {
    return BASE_OK;
  }
  double x = 0.0;
  BASE_TRY(node_real(n, key, &x));
  if (x != floor(x) || fabs(x) > INT_MAX) {
    return BAD("%s: %s = %g: need an integer", n->where, key, x);
  }
  *out = (int)x;
  return BASE_OK;
}

base_status node_bool(const node *n, const char *key, bool *out) {
  const json_t *v = json_object_get(n->v, key);
  if (v == NULL) {
    return BASE_OK;
  }
  if (!json_is_boolean(v)) {
    return BAD("%s: %s: need true or false", n->where, key);
  }
  *out = json_is_true(v);
  return BASE_OK;
}

base_status node_text(const node *n, const char *key, char *out, size_t cap) {
  const json_t *v = json_object_get(n->v, key);
  return (v == NULL) ? BASE_OK : node_string(n, v, key, out, cap);
}

base_status node_list(const node *n, const char *key, int max, json_t **out, int *count) {
  *out = NULL;
  *count = 0;
  json_t *v = json_object_get(n->v, key);
  if (v == NULL) {
    return BASE_OK;
  }
  if (!json_is_array(v)) {
    return BAD("%s: %s: need a list", n->where, key);
  }
  if (json_array_size(v) > (size_t)max) {
    return BAD("%s: %s: %zu items, need at most %d", n->where, key, json_array_size(v), max);
  }
  *out = v;
  *count = (int)json_array_size(v);
  return BASE_OK;
}

base_status node_vector(const node *n, const char *key, int count, double *out) {
  json_t *v;
  int size;
  BASE_TRY(node_list(n, key, INT_MAX, &v, &size));
  if (v == NULL) {
    return BASE_OK;
  }
  if (size != count) {
    return BAD("%s: %s: need %d numbers, has %d", n->where, key, count, size);
  }
  for (int i = 0; i < count; i++) {
    BASE_TRY(node_number(n, json_array_get(v, (size_t)i), key, &out[i]));
  }
  return BASE_OK;
}

base_status node_choice(const node *n, const char *key, const char *words, int *out) {
  char text[64];
  if (!node_has(n, key)) {
    return BASE_OK;
  }
  BASE_TRY(node_text(n, key, text, sizeof text));
  const int index = word_index(words, text);
  if (index < 0) {
    char hint[BASE_NEAREST_HINT];
    return BAD("%s: %s '%s': need one of %s%s", n->where, key, text, words,
               base_nearest_word(text, words, hint));
  }
  *out = index;
  return BASE_OK;
}
