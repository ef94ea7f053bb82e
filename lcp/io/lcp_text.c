#include "lcp/io/lcp_text.h"

#include "lcp/base/input.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static base_status read_all(FILE *f, lcp_text *t, base_error *err) {
  const long from = ftell(f); /* behind a byte-order mark */
  const long end = (from >= 0 && fseek(f, 0, SEEK_END) == 0) ? ftell(f) : -1;
  if (end < from || end - from > 0x7fffffffL || fseek(f, from, SEEK_SET) != 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: need a file of at most 2 GiB", t->path);
  }
  t->size = (size_t)(end - from);
  t->data = malloc(t->size + 1);
  if (t->data == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %zu bytes", t->path, t->size);
  }
  if (fread(t->data, 1, t->size, f) != t->size) {
    return BASE_FAIL(err, BASE_EIO, "%s: could not be read: %s", t->path, strerror(errno));
  }
  t->data[t->size] = '\0';
  if (strlen(t->data) != t->size) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: has a NUL byte, need a text file", t->path);
  }
  t->at = t->data;
  return BASE_OK;
}

base_status lcp_text_open(lcp_text *t, const char *path, base_error *err) {
  *t = (lcp_text){.path = path, .line = 1};
  FILE *f;
  BASE_TRY(base_in_text(path, &f, err));
  const base_status s = read_all(f, t, err);
  (void)fclose(f);
  if (s != BASE_OK) {
    lcp_text_close(t);
  }
  return s;
}

void lcp_text_close(lcp_text *t) {
  free(t->data);
  t->data = NULL;
  t->at = NULL;
}

static bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

static void skip_space(lcp_text *t) {
  while (is_space(*t->at)) {
    t->line += (*t->at == '\n');
    t->at++;
  }
}

void lcp_text_peek(const lcp_text *t, char word[64]) {
  const char *c = t->at;
  while (is_space(*c)) {
    c++;
  }
  int n = 0;
  while (n < 63 && c[n] != '\0' && !is_space(c[n])) {
    word[n] = c[n];
    n++;
  }
  word[n] = '\0';
}

void lcp_text_skip_line(lcp_text *t) {
  while (*t->at != '\0' && *t->at != '\n') {
    t->at++;
  }
  if (*t->at == '\n') {
    t->at++;
    t->line++;
  }
}

static base_status bad(const lcp_text *t, const char *what, const char *rule, base_error *err) {
  char word[64];
  lcp_text_peek(t, word);
  if (word[0] == '\0') {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: file ends where %s should stand", t->path, t->line,
                     what);
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: %s is '%s': need %s", t->path, t->line, what, word,
                   rule);
}

base_status lcp_text_real(lcp_text *t, const char *what, double *x, base_error *err) {
  skip_space(t);
  char *end;
  const double value = strtod(t->at, &end);
  if (end == t->at || !isfinite(value) || (*end != '\0' && !is_space(*end))) {
    return bad(t, what, "a finite number", err);
  }
  *x = value;
  t->at = end;
  return BASE_OK;
}

base_status lcp_text_int(lcp_text *t, const char *what, long lo, long hi, long *x,
                         base_error *err) {
  skip_space(t);
  char *end;
  errno = 0;
  const long value = strtol(t->at, &end, 10);
  if (end == t->at || errno != 0 || (*end != '\0' && !is_space(*end)) || value < lo || value > hi) {
    char rule[80];
    (void)snprintf(rule, sizeof rule, "an integer in %ld..%ld", lo, hi);
    return bad(t, what, rule, err);
  }
  *x = value;
  t->at = end;
  return BASE_OK;
}

base_status lcp_text_holds(const lcp_text *t, double count, const char *what, base_error *err) {
  const double left = (double)(t->size - (size_t)(t->at - t->data));
  if (2.0 * count > left + 1.0) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "%s:%ld: %s announces %.0f numbers, the file has %.0f bytes left", t->path,
                     t->line, what, count, left);
  }
  return BASE_OK;
}
