#include "harness/util/args.h"

#include "lcp/base/fields.h"
#include "lcp/base/nearest.h"
#include "lcp/base/output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Number with one optional unit letter out of `units`, whose factors are in `factor`. */
static bool scaled(const char *text, const char *units, const double *factor, double *out) {
  char number[64];
  size_t len = strlen(text);
  double scale = 1.0;
  if (len == 0 || len >= sizeof number) {
    return false;
  }
  const char *unit = strchr(units, text[len - 1]);
  if (unit != NULL) {
    scale = factor[unit - units];
    len--;
  }
  memcpy(number, text, len);
  number[len] = '\0';
  double x;
  if (!base_parse_real(number, &x) || x < 0) {
    return false;
  }
  *out = x * scale;
  return true;
}

bool args_seconds(const char *text, double *seconds) {
  static const double factor[] = {1, 60, 3600};
  return scaled(text, "smh", factor, seconds);
}

bool args_bytes(const char *text, double *bytes) {
  static const double factor[] = {1, 1024.0, 1048576.0, 1073741824.0};
  return scaled(text, "BKMG", factor, bytes);
}

static base_status store(const arg_option *o, const char *value, base_error *err) {
  switch (o->kind) {
  case ARG_TEXT:
  case ARG_OUTPUT:
    *(const char **)o->to = value;
    return BASE_OK;
  case ARG_FLAG:
    *(bool *)o->to = true;
    return BASE_OK;
  case ARG_REAL:
    if (!base_parse_real(value, o->to)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s %s: need a finite number", o->name, value);
    }
    return BASE_OK;
  case ARG_INT:
    if (!base_parse_int(value, o->to)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s %s: need an integer", o->name, value);
    }
    return BASE_OK;
  case ARG_SECONDS:
    if (!args_seconds(value, o->to)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s %s: need seconds, or 30s, 10m, 2h", o->name, value);
    }
    return BASE_OK;
  case ARG_BYTES:
    if (!args_bytes(value, o->to)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s %s: need bytes, or 500M, 2G", o->name, value);
    }
    return BASE_OK;
  case ARG_LIST:
    break;
  }
  arg_list *list = o->to;
  if (list->count == ARG_LIST_MAX) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: given more than %d times", o->name, ARG_LIST_MAX);
  }
  list->item[list->count++] = value;
  return BASE_OK;
}

static const arg_option *find(const arg_table *t, const char *text, size_t len) {
  for (int i = 0; i < t->n_option; i++) {
    if (strlen(t->option[i].name) == len && strncmp(t->option[i].name, text, len) == 0) {
      return &t->option[i];
    }
  }
  return NULL;
}

/* LCPBENCH_TIME_LIMIT for --time-limit. */
static void variable_of(const char *option, char *name, size_t cap) {
  size_t used = (size_t)snprintf(name, cap, "LCPBENCH_");
  for (const char *c = option + 2; *c != '\0' && used + 1 < cap; c++) {
    const bool lower = *c >= 'a' && *c <= 'z';
    name[used++] = (char)(lower ? *c - 'a' + 'A' : *c == '-' ? '_' : *c);
  }
  name[used] = '\0';
}

static base_status take_environment(const arg_table *t, base_error *err) {
  for (int i = 0; i < t->n_option; i++) {
    char name[64];
    variable_of(t->option[i].name, name, sizeof name);
    const char *value = getenv(name);
    const arg_option o = {name, t->option[i].kind, t->option[i].to}; /* errors name the variable */
    if (value == NULL || *value == '\0' || o.kind == ARG_LIST) {
      continue;
    }
    if (o.kind == ARG_FLAG && strcmp(value, "0") != 0 && strcmp(value, "1") != 0) {
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need 1, or 0 for not", name, value);
    }
    if (o.kind != ARG_FLAG || *value == '1') {
      BASE_TRY(store(&o, value, err));
    }
  }
  return BASE_OK;
}

static base_status unknown_option(const arg_table *t, const char *text, size_t len,
                                  base_error *err) {
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(text, len);
  for (int i = 0; i < t->n_option; i++) {
    base_nearest_offer(&near, t->option[i].name);
  }
  return BASE_FAIL(err, BASE_EINVAL, "%.*s: unknown option%s", (int)len, text,
                   base_nearest_hint(&near, hint));
}

static base_status take_option(const arg_table *t, int argc, char **argv, int *i, base_error *err) {
  const char *text = argv[*i];
  const size_t len = strcspn(text, "=");
  const arg_option *o = find(t, text, len);
  if (o == NULL) {
    return unknown_option(t, text, len, err);
  }
  const char *value = (text[len] == '=') ? text + len + 1 : NULL;
  if (o->kind == ARG_FLAG) {
    return (value == NULL) ? store(o, "", err)
                           : BASE_FAIL(err, BASE_EINVAL, "%s: takes no value", o->name);
  }
  if (value == NULL) {
    if (*i + 1 >= argc) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: needs a value", o->name);
    }
    value = argv[++*i];
  }
  return store(o, value, err);
}

static const char *output_of(const arg_option *o) {
  return (o->kind == ARG_OUTPUT) ? *(const char **)o->to : NULL;
}

static bool same_place(const char *a, const char *b) {
  return strcmp(a, b) == 0 || (base_out_is_stdout(a) && base_out_is_stdout(b));
}

/* Of two files under one name one would be lost. */
static base_status check_outputs(const arg_table *t, base_error *err) {
  for (int i = 0; i < t->n_option; i++) {
    const char *one = output_of(&t->option[i]);
    for (int k = 0; one != NULL && k < i; k++) {
      const char *other = output_of(&t->option[k]);
      if (other != NULL && same_place(one, other)) {
        return BASE_FAIL(err, BASE_EINVAL, "%s and %s write to the same place, %s",
                         t->option[k].name, t->option[i].name, one);
      }
    }
  }
  return BASE_OK;
}

bool args_take_stdout(const arg_table *t) {
  for (int i = 0; i < t->n_option; i++) {
    const char *path = output_of(&t->option[i]);
    if (path != NULL && base_out_is_stdout(path)) {
      return true;
    }
  }
  return false;
}

base_status args_parse(const arg_table *t, int argc, char **argv, const char **positional,
                       int *n_positional, base_error *err) {
  *n_positional = 0;
  BASE_TRY(take_environment(t, err));
  bool ended = false; /* no options behind a -- */
  for (int i = 0; i < argc; i++) {
    const bool option = !ended && strncmp(argv[i], "--", 2) == 0;
    if (option && argv[i][2] == '\0') {
      ended = true;
      continue;
    }
    if (!option && *n_positional == t->max_positional) {
      return BASE_FAIL(err, BASE_EINVAL, "'%s': unexpected argument", argv[i]);
    }
    if (!option) {
      positional[(*n_positional)++] = argv[i];
      continue;
    }
    BASE_TRY(take_option(t, argc, argv, &i, err));
  }
  if (*n_positional < t->min_positional) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is missing", t->positional_name);
  }
  return check_outputs(t, err);
}
