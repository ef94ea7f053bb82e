#include "lcp/base/fields.h"

#include "lcp/base/nearest.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void store(const base_field *f, void *opt, double value) {
  unsigned char *at = (unsigned char *)opt + f->offset;
  if (f->kind == BASE_REAL) {
    memcpy(at, &value, sizeof value);
  } else {
    const int i = (int)value;
    memcpy(at, &i, sizeof i);
  }
}

static double load(const base_field *f, const void *opt) {
  const unsigned char *at = (const unsigned char *)opt + f->offset;
  if (f->kind == BASE_REAL) {
    double x;
    memcpy(&x, at, sizeof x);
    return x;
  }
  int i;
  memcpy(&i, at, sizeof i);
  return i;
}

/* Start and length of word `index` of "a|b|c"; NULL when there is none. */
static const char *word_at(const char *words, int index, size_t *len) {
  const char *w = words;
  for (int i = 0; w != NULL; i++) {
    const char *bar = strchr(w, '|');
    if (i == index) {
      *len = (bar != NULL) ? (size_t)(bar - w) : strlen(w);
      return w;
    }
    w = (bar != NULL) ? bar + 1 : NULL;
  }
  return NULL;
}

static int word_index(const char *words, const char *text) {
  size_t len;
  const char *w;
  for (int i = 0; (w = word_at(words, i, &len)) != NULL; i++) {
    if (strlen(text) == len && strncmp(w, text, len) == 0) {
      return i;
    }
  }
  return -1;
}

void base_fields_default(const base_field *f, int nf, void *opt) {
  for (int i = 0; i < nf; i++) {
    store(&f[i], opt, f[i].dflt);
  }
}

/* strtod and printf follow LC_NUMERIC; the suite never calls setlocale, so the
 * "C" locale holds and '.' is the decimal point. */
bool base_parse_real(const char *text, double *x) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(value)) {
    return false;
  }
  *x = value;
  return true;
}

bool base_parse_int(const char *text, int *x) {
  char *end;
  errno = 0;
  const long value = strtol(text, &end, 10);
  if (end == text || *end != '\0' || errno != 0 || value < INT_MIN || value > INT_MAX) {
    return false;
  }
  *x = (int)value;
  return true;
}

static base_status set_number(const base_field *f, void *opt, const char *text, base_error *err) {
  double value = 0.0;
  if (f->kind == BASE_INT) {
    int i;
    double real;
    if (base_parse_int(text, &i)) {
      value = i;
    } else if (base_parse_real(text, &real) && real == floor(real) && fabs(real) <= INT_MAX) {
      value = real; /* 1e6 is a fair way to write an integer */
    } else {
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need an integer", f->name, text);
    }
  } else if (!base_parse_real(text, &value)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need a finite number", f->name, text);
  }
  if (!(value >= f->min && value <= f->max)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need a value in [%g, %g]", f->name, text, f->min,
                     f->max);
  }
  store(f, opt, value);
  return BASE_OK;
}

base_status base_fields_set(const base_field *f, int nf, void *opt, const char *name,
                            const char *text, base_error *err) {
  for (int i = 0; i < nf; i++) {
    if (strcmp(f[i].name, name) != 0) {
      continue;
    }
    if (f[i].kind != BASE_CHOICE) {
      return set_number(&f[i], opt, text, err);
    }
    const int index = word_index(f[i].words, text);
    if (index < 0) {
      char hint[BASE_NEAREST_HINT];
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need one of %s%s", name, text, f[i].words,
                       base_nearest_word(text, f[i].words, hint));
    }
    store(&f[i], opt, index);
    return base_fields_parse(f, nf, opt, (f[i].preset != NULL) ? f[i].preset[index] : NULL, err);
  }
  char known[240] = "";
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(name, strlen(name));
  for (int i = 0; i < nf; i++) {
    base_nearest_offer(&near, f[i].name);
    const size_t used = strlen(known);
    (void)snprintf(known + used, sizeof known - used, "%s%s", i > 0 ? ", " : "", f[i].name);
  }
  return BASE_FAIL(err, BASE_EINVAL, "unknown option '%s'%s known are %s", name,
                   base_nearest_hint(&near, hint)[0] != '\0' ? hint : ":", nf > 0 ? known : "none");
}

/* The field of which `word` is a preset; NULL: none is. */
static const base_field *preset_of(const base_field *f, int nf, const char *word) {
  for (int i = 0; i < nf; i++) {
    if (f[i].preset != NULL && word_index(f[i].words, word) >= 0) {
      return &f[i];
    }
  }
  return NULL;
}

static bool is_preset(const base_field *f, int nf, const char *name) {
  for (int i = 0; i < nf; i++) {
    if (f[i].preset != NULL && strcmp(f[i].name, name) == 0) {
      return true;
    }
  }
  return false;
}

/* Does an item from `first` to `text` have this name? */
static bool named_before(const char *first, const char *text, const char *name) {
  const size_t len = strlen(name);
  bool found = false;
  for (const char *item = first; item < text && !found; item += strcspn(item, ",") + 1) {
    found = strncmp(item, name, len) == 0 && item[len] == '=';
  }
  return found;
}

base_status base_fields_parse(const base_field *f, int nf, void *opt, const char *text,
                              base_error *err) {
  const char *const first = text;
  while (text != NULL && *text != '\0') {
    char item[160];
    const size_t len = strcspn(text, ",");
    if (len >= sizeof item) {
      return BASE_FAIL(err, BASE_EINVAL, "option longer than %zu characters: '%.40s...'",
                       sizeof item - 1, text);
    }
    memcpy(item, text, len);
    item[len] = '\0';
    char *eq = strchr(item, '=');
    const base_field *preset = (eq == NULL) ? preset_of(f, nf, item) : NULL;
    if (eq == NULL && preset == NULL) {
      return BASE_FAIL(err, BASE_EINVAL, "'%s': need name=value", item);
    }
    if (eq != NULL) {
      *eq = '\0';
    }
    const char *name = (preset != NULL) ? preset->name : item;
    const char *value = (eq != NULL) ? eq + 1 : item;
    if (text != first && is_preset(f, nf, name)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need it first, it sets other options", name,
                       value);
    }
    if (named_before(first, text, name)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s=%s: need it once, it is given twice", name, value);
    }
    BASE_TRY(base_fields_set(f, nf, opt, name, value, err));
    text += len + (text[len] == ',');
  }
  return BASE_OK;
}

void base_real_print(double x, char *buf, size_t cap) {
  for (int digits = 15; digits <= 17; digits++) {
    (void)snprintf(buf, cap, "%.*g", digits, x);
    if (strtod(buf, NULL) == x) {
      return;
    }
  }
}

size_t base_fields_print(const base_field *f, int nf, const void *opt, char *buf, size_t cap) {
  size_t used = 0;
  if (cap > 0) {
    buf[0] = '\0';
  }
  for (int i = 0; i < nf; i++) {
    char number[32];
    const char *value = number;
    int len = 0;
    const double x = load(&f[i], opt);
    if (f[i].kind == BASE_CHOICE) {
      size_t n = 0;
      value = word_at(f[i].words, (int)x, &n);
      len = (int)n;
    } else {
      base_real_print(x, number, sizeof number);
      len = (int)strlen(number);
    }
    const int wrote = snprintf(used < cap ? buf + used : NULL, used < cap ? cap - used : 0,
                               "%s%s=%.*s", i > 0 ? "," : "", f[i].name, len, value);
    used += (size_t)wrote;
  }
  return used;
}
