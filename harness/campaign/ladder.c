#include "harness/campaign/ladder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double steepest = 4.0; /* an exponent beyond that is taken for noise */

static size_t name_length(const char *problem) {
  return strcspn(problem, ":@");
}

bool ladder_same_family(const char *a, const char *b) {
  const size_t n = name_length(a);
  if (strncmp(a, b, n) != 0 || n != name_length(b)) {
    return false;
  }
  const char *rest_a = strchr(a + n, '@');
  const char *rest_b = strchr(b + n, '@');
  return (rest_a == NULL || rest_b == NULL) ? rest_a == rest_b : strcmp(rest_a, rest_b) == 0;
}

/* The options of a problem from `at` on: key, its length and its text; false: no more. */
static bool next_option(const char **at, const char **key, int *length, const char **value) {
  while (**at != '\0' && **at != '@') {
    *key = *at;
    *length = (int)strcspn(*at, "=,@");
    *at += *length;
    const bool valued = **at == '=';
    *value = *at + valued;
    *at = *value + strcspn(*value, ",@");
    *at += **at == ',';
    if (valued) {
      return true;
    }
  }
  return false;
}

static const char *options_of(const char *problem) {
  const char *at = problem + name_length(problem);
  return at + (*at == ':');
}

/* The value of a key of that length, where it is a number. */
static double value_of(const char *problem, const char *key, int length, double missing) {
  const char *at = options_of(problem);
  const char *name;
  const char *text;
  int n;
  while (next_option(&at, &name, &n, &text)) {
    if (n == length && strncmp(name, key, (size_t)n) == 0) {
      char *end;
      const double value = strtod(text, &end);
      return (end == text + strcspn(text, ",@")) ? value : missing;
    }
  }
  return missing;
}

double ladder_value(const char *problem, const char *key, double missing) {
  return value_of(problem, key, (int)strlen(key), missing);
}

void ladder_begin(ladder *l, const char *problem) {
  const char *at = options_of(problem);
  const char *key;
  const char *text;
  int length;
  l->n = 0;
  while (l->n < LADDER_NUMBERS && next_option(&at, &key, &length, &text)) {
    const double asked = value_of(problem, key, length, 0.0);
    const bool is_duration = length == 8 && strncmp(key, "duration", 8) == 0;
    if (asked > 0.0 && !is_duration) {
      const size_t digits = strspn(text, "0123456789");
      l->number[l->n++] = (ladder_number){.key = key,
                                          .length = length,
                                          .asked = asked,
                                          .whole = digits == strcspn(text, ",@"),
                                          .low = HUGE_VAL,
                                          .high = -HUGE_VAL};
    }
  }
}

void ladder_add(ladder *l, const char *problem, double t) {
  for (int i = 0; i < l->n; i++) {
    ladder_number *k = &l->number[i];
    const double value = value_of(problem, k->key, k->length, 0.0);
    if (value > 0.0) {
      const double x = log(value);
      const double y = log(t);
      k->n += 1.0;
      k->x += x;
      k->y += y;
      k->xx += x * x;
      k->xy += x * y;
      k->low = fmin(k->low, x);
      k->high = fmax(k->high, x);
    }
  }
}

static double slope(const ladder_number *k) {
  if (!(k->high > k->low)) {
    return k->whole ? 1.0 : 0.0;
  }
  const double fitted = (k->n * k->xy - k->x * k->y) / (k->n * k->xx - k->x * k->x);
  return fmin(fmax(fitted, 0.0), steepest);
}

double ladder_growth(const ladder *l, const char *problem) {
  double growth = 1.0;
  for (int i = 0; i < l->n; i++) {
    const ladder_number *k = &l->number[i];
    const double value = value_of(problem, k->key, k->length, 0.0);
    growth *= (value > 0.0) ? pow(k->asked / value, slope(k)) : 1.0;
  }
  return growth;
}

double ladder_distance(const ladder *l, const char *problem) {
  double far = 0.0;
  for (int i = 0; i < l->n; i++) {
    const ladder_number *k = &l->number[i];
    const double value = value_of(problem, k->key, k->length, 0.0);
    far += (value > 0.0) ? fabs(log(k->asked / value)) : 0.0;
  }
  return far;
}
