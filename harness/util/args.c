#include "harness/util/args.h"

#include "lcp/base/fields.h"
#include "lcp/base/nearest.h"
#include "lcp/base/output.h"

#include <math.h>
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

/* With every verb; harness/cli/cli.c takes them away before it begins. */
static const arg_option shared[] = {
    {.name = "--plugin",
     .kind = ARG_LIST,
     .value = "FILE.so",
     .help = "loads a solver of one's own, as LCPBENCH_PLUGINS does (files parted by colons)"},
};

int args_count(const arg_table *t) {
  return t->n_option + BASE_COUNT(shared);
}

const arg_option *args_at(const arg_table *t, int i) {
  return (i < t->n_option) ? &t->option[i] : &shared[i - t->n_option];
}

static void *member(const arg_option *o, void *options) {
  return (char *)options + o->offset;
}

const char *args_range(const arg_option *o, char *buf, size_t cap) {
  buf[0] = '\0';
  if (o->unit == NULL) {
    return buf;
  }
  const char *low = o->above ? "above" : (o->max > 0.0) ? "from" : "of at least";
  const int used = (o->min > -HUGE_VAL) ? snprintf(buf, cap, "[%s], %s %.6g", o->unit, low, o->min)
                                        : snprintf(buf, cap, "[%s]", o->unit);
  if (o->max > 0.0) {
    (void)snprintf(buf + used, cap - (size_t)used, "%s %.6g", o->above ? ", at most" : " to",
                   o->max);
  }
  return buf;
}

static base_status in_range(const arg_option *o, const char *text, double x, base_error *err) {
  char range[96];
  const bool low = o->above ? x > o->min : x >= o->min;
  if (o->unit == NULL || (low && (o->max <= 0.0 || x <= o->max))) {
    return BASE_OK;
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s %.100s: need a number %s", o->name, text,
                   args_range(o, range, sizeof range) + strlen(o->unit) + 4);
}

static base_status not_a(const char *what, const arg_option *o, const char *value,
                         base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%s %s: need %s", o->name, value, what);
}

static base_status store(const arg_option *o, void *to, const char *value, base_error *err) {
  double x = 0.0;
  int i = 0;
  switch (o->kind) {
  case ARG_TEXT:
    if (o->unit != NULL) { /* a number that somebody else reads again */
      if (!base_parse_real(value, &x)) {
        return not_a("a finite number", o, value, err);
      }
      BASE_TRY(in_range(o, value, x, err));
    }
    *(const char **)to = value;
    return BASE_OK;
  case ARG_OUTPUT:
    *(const char **)to = value;
    return BASE_OK;
  case ARG_FLAG:
    *(bool *)to = true;
    return BASE_OK;
  case ARG_REAL:
    if (!base_parse_real(value, &x)) {
      return not_a("a finite number", o, value, err);
    }
    *(double *)to = x;
    return in_range(o, value, x, err);
  case ARG_INT:
    if (!base_parse_int(value, &i)) {
      return not_a("an integer", o, value, err);
    }
    *(int *)to = i;
    return in_range(o, value, i, err);
  case ARG_SECONDS:
    if (!args_seconds(value, &x)) {
      return not_a("seconds, or 30s, 10m, 2h", o, value, err);
    }
    *(double *)to = x;
    return in_range(o, value, x, err);
  case ARG_BYTES:
    if (!args_bytes(value, &x)) {
      return not_a("bytes, or 500M, 2G", o, value, err);
    }
    *(double *)to = x;
    return in_range(o, value, x, err);
  case ARG_LIST:
    break;
  }
  arg_list *list = to;
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

const char *args_typed(const char *option, const char *value) {
  char name[64];
  variable_of(option, name, sizeof name);
  return (value != getenv(name)) ? value : NULL;
}

static base_status take_environment(const arg_table *t, void *options, base_error *err) {
  for (int i = 0; i < t->n_option; i++) {
    char name[64];
    variable_of(t->option[i].name, name, sizeof name);
    const char *value = getenv(name);
    arg_option o = t->option[i];
    o.name = name; /* for errors */
    if (value == NULL || *value == '\0' || o.kind == ARG_LIST) {
      continue;
    }
    if (o.kind == ARG_FLAG && strcmp(value, "0") != 0 && strcmp(value, "1") != 0) {
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need 1, or 0 for not", name, value);
    }
    if (o.kind != ARG_FLAG || *value == '1') {
      BASE_TRY(store(&o, member(&o, options), value, err));
    }
  }
  return BASE_OK;
}

static base_status unknown_option(const arg_table *t, const char *text, size_t len,
                                  base_error *err) {
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(text, len);
  for (int i = 0; i < args_count(t); i++) {
    base_nearest_offer(&near, args_at(t, i)->name);
  }
  return BASE_FAIL(err, BASE_EINVAL, "%.*s: unknown option%s", (int)len, text,
                   base_nearest_hint(&near, hint));
}

/* Is the option, which is no flag or list, among the first n words already? */
static bool given_before(const arg_table *t, const arg_option *o, int n, char **argv) {
  bool given = false;
  for (int i = 0; i < n && !given && o->kind != ARG_FLAG && o->kind != ARG_LIST; i++) {
    const size_t len = strcspn(argv[i], "=");
    const arg_option *one = find(t, argv[i], len);
    given = one == o;
    i += one != NULL && one->kind != ARG_FLAG && argv[i][len] == '\0'; /* its value */
  }
  return given;
}

static base_status take_option(const arg_table *t, void *options, int argc, char **argv, int *i,
                               base_error *err) {
  const char *text = argv[*i];
  const size_t len = strcspn(text, "=");
  const arg_option *o = find(t, text, len);
  if (o == NULL) {
    return unknown_option(t, text, len, err);
  }
  if (given_before(t, o, *i, argv)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: need it once, it is given twice", o->name);
  }
  const char *value = (text[len] == '=') ? text + len + 1 : NULL;
  if (o->kind == ARG_FLAG) {
    return (value == NULL) ? store(o, member(o, options), "", err)
                           : BASE_FAIL(err, BASE_EINVAL, "%s: takes no value", o->name);
  }
  if (value == NULL) {
    if (*i + 1 >= argc) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: needs a value", o->name);
    }
    value = argv[++*i];
  }
  return store(o, member(o, options), value, err);
}

static const char *text_of(const arg_option *o, const void *options) {
  return *(const char *const *)(const void *)((const char *)options + o->offset);
}

static const char *output_of(const arg_option *o, const void *options) {
  return (o->kind == ARG_OUTPUT) ? text_of(o, options) : NULL;
}

/* A list that is needed and not given may come from the environment, as one item. */
static base_status list_of_environment(const arg_option *o, void *options, base_error *err) {
  char name[64];
  variable_of(o->name, name, sizeof name);
  const char *value = getenv(name);
  return (value != NULL && *value != '\0') ? store(o, member(o, options), value, err) : BASE_OK;
}

static base_status check_needed(const arg_table *t, void *options, base_error *err) {
  for (int i = 0; i < t->n_option; i++) {
    const arg_option *o = &t->option[i];
    if (!o->needed) {
      continue;
    }
    const arg_list *list = (o->kind == ARG_LIST) ? member(o, options) : NULL;
    if (list != NULL && list->count == 0) {
      BASE_TRY(list_of_environment(o, options, err));
    }
    const bool given = (list != NULL) ? list->count > 0 : text_of(o, options) != NULL;
    if (!given) {
      return BASE_FAIL(err, BASE_EINVAL, "%s %s is missing: %s", o->name, o->value, o->help);
    }
  }
  return BASE_OK;
}

static bool same_place(const char *a, const char *b) {
  return strcmp(a, b) == 0 || (base_out_is_stdout(a) && base_out_is_stdout(b));
}

/* Of two files under one name one would be lost. */
static base_status check_outputs(const arg_table *t, const void *options, base_error *err) {
  for (int i = 0; i < t->n_option; i++) {
    const char *one = output_of(&t->option[i], options);
    for (int k = 0; one != NULL && k < i; k++) {
      const char *other = output_of(&t->option[k], options);
      if (other != NULL && same_place(one, other)) {
        return BASE_FAIL(err, BASE_EINVAL, "%s and %s write to the same place, %s",
                         t->option[k].name, t->option[i].name, one);
      }
    }
  }
  return BASE_OK;
}

bool args_take_stdout(const arg_table *t, const void *options) {
  for (int i = 0; i < t->n_option; i++) {
    const char *path = output_of(&t->option[i], options);
    if (path != NULL && base_out_is_stdout(path)) {
      return true;
    }
  }
  return false;
}

base_status args_parse(const arg_table *t, void *options, int argc, char **argv,
                       const char **positional, int *n_positional, base_error *err) {
  *n_positional = 0;
  BASE_TRY(take_environment(t, options, err));
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
    BASE_TRY(take_option(t, options, argc, argv, &i, err));
  }
  if (*n_positional < t->min_positional) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is missing", t->positional_name);
  }
  BASE_TRY(check_needed(t, options, err));
  return check_outputs(t, options, err);
}
