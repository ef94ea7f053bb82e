/* harness/util/args.h - command-line options by table. An option given neither on the command line
 * nor in the table's default may come from the environment: --memory-limit is LCPBENCH_MEMORY_LIMIT; a flag
 * is 1 or 0 there, a list is taken only where it is needed, as one item. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum arg_kind {
  ARG_TEXT, /* const char * */
  ARG_OUTPUT, /* const char *: a file to be written, as base_out_open takes it; - is standard output */
  ARG_FLAG,    /* bool */
  ARG_REAL,    /* double */
  ARG_INT,     /* int */
  ARG_SECONDS, /* double; 30, 30s, 10m, 2h */
  ARG_BYTES,   /* double; 500M, 2G */
  ARG_LIST,    /* arg_list, may be repeated */
} arg_kind;

enum { ARG_LIST_MAX = 32 };
typedef struct arg_list {
  int count;
  const char *item[ARG_LIST_MAX];
} arg_list;

typedef struct arg_option {
  const char *name; /* "--solver" */
  arg_kind kind;
  size_t offset; /* of its member in the options of the verb */
  const char *
      value; /* what stands behind it: "FILE", "cold|previous"; NULL for a flag. SOLVER, FORMULATION, SCENE,
                        PROBLEM, CAMPAIGN and words between bars are completed by the shell */
  const char *help; /* one sentence */
  bool needed;      /* of text and lists: refused where it is missing */
  const char *
      unit; /* of a number, which is then held to the range, also where it is kept as text; NULL: none */
  double min, max; /* max 0: no upper limit */
  bool above;      /* min itself is out of the range */
} arg_option;

/* One row of a verb's table; behind the sentence: .unit = "s", .min = 0, ... */
#define ARG(T, member_, name_, kind_, value_, ...)                                                 \
  {                                                                                                \
    .name = (name_), .kind = (kind_), .offset = offsetof(T, member_), .value = (value_),           \
    .help = __VA_ARGS__                                                                            \
  }

typedef struct arg_table {
  const arg_option *option;
  int n_option;
  int min_positional, max_positional;
  const char *positional_name; /* for messages and help: "PROBLEM" */
  const char *positional_help; /* one sentence */
} arg_table;

/* The options of a verb: those of its table, then those that every verb has and that are taken before it begins
 * (--plugin). Help, manual page, completion and hints go over these. */
int args_count(const arg_table *t);
const arg_option *args_at(const arg_table *t, int i); /* 0 <= i < args_count(t) */

/* Fills the options (a struct of the type the table was made for, with the defaults in it) and up to
 * max_positional positional arguments (views into argv). Behind a -- all are positional. BASE_EINVAL names the
 * culprit, and the option that it was probably meant for; also where a number is out of its range, where a needed
 * option is missing, where one that is no flag or list is given twice, and where two options write to the same place. */
base_status args_parse(const arg_table *t, void *options, int argc, char **argv,
                       const char **positional, int *n_positional, base_error *err);

/* The value that args_parse gave an option; NULL where that came from the environment. For an option that needs another one: on the command
 * line it is refused without that, in the environment it is for the commands that have both. */
const char *args_typed(const char *option, const char *value);

/* Does an option of the table write to standard output? What would stand there goes to stderr. */
bool args_take_stdout(const arg_table *t, const void *options);

/* "[s], above 0": unit and range of an option; "" where it has none. */
const char *args_range(const arg_option *o, char *buf, size_t cap);

bool args_seconds(const char *text, double *seconds);
bool args_bytes(const char *text, double *bytes);
