#include "lcp/base/nearest.h"

#include <stdio.h>
#include <string.h>

enum { EDIT = 4 }; /* what a letter counts in a distance */

static int lower(char c) {
  return (c >= 'A' && c <= 'Z') ? c - 'A' + 'a' : c;
}

static int least(int a, int b) {
  return (a < b) ? a : b;
}

static int edits(const char *a, int n, const char *b, int m) {
  int row[3][BASE_NEAREST_WORD + 1]; /* two letters back, one back, this one */
  for (int j = 0; j <= m; j++) {
    row[1][j] = j;
  }
  for (int i = 1; i <= n; i++) {
    row[2][0] = i;
    for (int j = 1; j <= m; j++) {
      const int same = lower(a[i - 1]) == lower(b[j - 1]);
      int d = least(row[1][j - 1] + (same ? 0 : 1), least(row[1][j], row[2][j - 1]) + 1);
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
          lower(a[i - 2]) == lower(b[j - 1])) {
        d = least(d, row[0][j - 2] + 1);
      }
      row[2][j] = d;
    }
    memcpy(row[0], row[1], sizeof row[0]);
    memcpy(row[1], row[2], sizeof row[1]);
  }
  return row[1][m];
}

static int distance(const char *word, const char *name) {
  const int n = (int)strnlen(word, BASE_NEAREST_WORD);
  const int m = (int)strnlen(name, BASE_NEAREST_WORD);
  int common = 0;
  while (common < n && common < m && lower(word[common]) == lower(name[common])) {
    common++;
  }
  const int shorter = least(n, m);
  const int d = EDIT * edits(word, n, name, m);
  return (shorter >= 3 && common == shorter) ? least(d, EDIT + 1) : d;
}

base_nearest base_nearest_to(const char *text, size_t len) {
  base_nearest n = {.best = ""};
  (void)snprintf(n.word, sizeof n.word, "%.*s", (int)len, text);
  const int letters = (int)strlen(n.word);
  n.distance = EDIT * least((letters + 2) / 3, letters - 1) + 2;
  return n;
}

void base_nearest_offer(base_nearest *n, const char *name) {
  const int d = distance(n->word, name);
  if (d < n->distance) {
    n->distance = d;
    (void)snprintf(n->best, sizeof n->best, "%s", name);
  }
}

void base_nearest_offer_words(base_nearest *n, const char *words) {
  while (*words != '\0') {
    char word[BASE_NEAREST_WORD];
    const size_t len = strcspn(words, "|");
    (void)snprintf(word, sizeof word, "%.*s", (int)len, words);
    base_nearest_offer(n, word);
    words += len + (words[len] == '|');
  }
}

const char *base_nearest_hint(const base_nearest *n, char buf[BASE_NEAREST_HINT]) {
  buf[0] = '\0';
  if (n->best[0] != '\0') {
    (void)snprintf(buf, BASE_NEAREST_HINT, "; did you mean '%s'?", n->best);
  }
  return buf;
}

const char *base_nearest_word(const char *text, const char *words, char buf[BASE_NEAREST_HINT]) {
  base_nearest n = base_nearest_to(text, strlen(text));
  base_nearest_offer_words(&n, words);
  return base_nearest_hint(&n, buf);
}
