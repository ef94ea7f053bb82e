#include "problems/write/scene_json.h"

#include "lcp/base/fields.h"

#include <stdlib.h>

enum { INDENT = 2 };

static void print_value(FILE *to, json_t *v, int depth);

static void print_text(FILE *to, json_t *v) {
  char *text = json_dumps(v, JSON_ENCODE_ANY);
  (void)fputs(text != NULL ? text : "null", to);
  free(text);
}

static bool is_flat(json_t *list) {
  for (size_t i = 0; i < json_array_size(list); i++) {
    json_t *item = json_array_get(list, i);
    if (json_is_array(item) || json_is_object(item)) {
      return false;
    }
  }
  return true;
}

static void new_line(FILE *to, int depth) {
  (void)fprintf(to, "\n%*s", INDENT * depth, "");
}

static void print_list(FILE *to, json_t *list, int depth) {
  const bool flat = is_flat(list);
  (void)fputc('[', to);
  for (size_t i = 0; i < json_array_size(list); i++) {
    (void)fputs((i == 0) ? "" : (flat ? ", " : ","), to);
    if (!flat) {
      new_line(to, depth + 1);
    }
    print_value(to, json_array_get(list, i), depth + 1);
  }
  if (!flat) {
    new_line(to, depth);
  }
  (void)fputc(']', to);
}

static void print_object(FILE *to, json_t *o, int depth) {
  const char *key;
  json_t *item;
  bool first = true;
  if (json_object_size(o) == 0) {
    (void)fputs("{}", to);
    return;
  }
  (void)fputc('{', to);
  json_object_foreach(o, key, item) {
    (void)fputs(first ? "" : ",", to);
    new_line(to, depth + 1);
    (void)fprintf(to, "\"%s\": ", key);
    print_value(to, item, depth + 1);
    first = false;
  }
  new_line(to, depth);
  (void)fputc('}', to);
}

static void print_value(FILE *to, json_t *v, int depth) {
  char number[32];
  if (json_is_object(v)) {
    print_object(to, v, depth);
  } else if (json_is_array(v)) {
    print_list(to, v, depth);
  } else if (json_is_real(v)) {
    base_real_print(json_real_value(v), number, sizeof number);
    (void)fputs(number, to);
  } else {
    print_text(to, v);
  }
}

void scene_json_print(FILE *to, json_t *v) {
  print_value(to, v, 0);
  (void)fputc('\n', to);
}
