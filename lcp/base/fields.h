/* base/fields.h - named, typed, range-checked members of an options struct.
 *
 * Solver options, formulation options and scene parameters all use the same
 * table, so the command line, the defaults, the documentation and the string
 * stored with every result come from one place.
 */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

typedef enum base_kind {
  BASE_INT,    /* int */
  BASE_REAL,   /* double */
  BASE_CHOICE, /* int: index into `words` */
} base_kind;

typedef struct base_field {
  const char *name; /* command-line and CSV spelling; never renamed */
  const char *unit; /* "1", "m", "N s", ... */
  base_kind kind;
  size_t offset; /* of an int or a double inside the options struct */
  double dflt, min, max;
  const char *words; /* BASE_CHOICE: "first|second|third"; else NULL */
  const char *const *
      preset; /* BASE_CHOICE: what each word sets of the other fields, "name=value,..." or NULL; such a word
                                may be given alone, and before all others; else NULL */
  const char *help; /* one sentence */
} base_field;

#define BASE_FIELD_NAMED(T, member, name_, kind_, unit_, dflt_, min_, max_, help_)                 \
  {                                                                                                \
    .name = (name_), .unit = (unit_), .kind = (kind_), .offset = offsetof(T, member),              \
    .dflt = (dflt_), .min = (min_), .max = (max_), .help = (help_)                                 \
  }
#define BASE_FIELD(T, member, kind_, unit_, dflt_, min_, max_, help_)                              \
  BASE_FIELD_NAMED(T, member, #member, kind_, unit_, dflt_, min_, max_, help_)
/* dflt_ is the index of the default word. */
#define BASE_FIELD_CHOICE(T, member, words_, dflt_, help_)                                         \
  {                                                                                                \
    .name = #member, .unit = "1", .kind = BASE_CHOICE, .offset = offsetof(T, member),              \
    .dflt = (dflt_), .words = (words_), .help = (help_)                                            \
  }

/* preset_: one text a word, see base_field. */
#define BASE_FIELD_PRESET(T, member, words_, dflt_, preset_, help_)                                \
  {                                                                                                \
    .name = #member, .unit = "1", .kind = BASE_CHOICE, .offset = offsetof(T, member),              \
    .dflt = (dflt_), .words = (words_), .preset = (preset_), .help = (help_)                       \
  }

void base_fields_default(const base_field *f, int nf, void *opt);

/* Parses `text` into the field called `name`; rejects unknown names and values
 * outside [min, max] or not among the words (no silent clamping). */
base_status base_fields_set(const base_field *f, int nf, void *opt, const char *name,
                            const char *text, base_error *err);

/* Parses "name=value,name=value" (empty or NULL: nothing to do); the first may be the word of a preset alone. A name given twice
 * is refused. */
base_status base_fields_parse(const base_field *f, int nf, void *opt, const char *text,
                              base_error *err);

/* Writes "name=value,..." of all fields in table order, numbers in shortest form that reads back
 * to the same double; returns the length needed, as snprintf does. */
size_t base_fields_print(const base_field *f, int nf, const void *opt, char *buf, size_t cap);

/* Writes x in the fewest digits (15 to 17) that read back exactly. buf >= 32 bytes. */
void base_real_print(double x, char *buf, size_t cap);

/* Whole-string conversions, locale-independent ('.' decimal point); false if `text` is not
 * exactly one finite number. */
bool base_parse_real(const char *text, double *x);
bool base_parse_int(const char *text, int *x);
