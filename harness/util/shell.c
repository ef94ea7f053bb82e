#include "harness/util/shell.h"

#include <stdio.h>
#include <string.h>

static const char substitution[] = "\"$(printf '";
static const char substitution_end[] = "')\"";

static bool is_control(char c) {
  return ((unsigned char)c < 0x20 && c != '\0') || c == 0x7f;
}

static bool has_control(const char *word) {
  while (*word != '\0' && !is_control(*word)) {
    word++;
  }
  return *word != '\0';
}

bool shell_can_quote(const char *word) {
  const size_t n = strlen(word);
  return n == 0 || word[n - 1] != '\n';
}

typedef struct sink {
  char *buf;
  size_t cap, used;
} sink;

static void put(sink *s, const char *text) {
  const size_t left = (s->used < s->cap) ? s->cap - s->used : 0;
  s->used += (size_t)snprintf(left > 0 ? s->buf + s->used : NULL, left, "%s", text);
}

static void put_char(sink *s, char c) {
  const char text[] = {c, '\0'};
  put(s, text);
}

size_t shell_quote(const char *word, char *buf, size_t cap) {
  sink s = {.cap = cap};
  s.buf = buf;
  const bool control = has_control(word);
  put(&s, control ? substitution : "'");
  for (const char *c = word; *c != '\0'; c++) {
    char octal[8];
    if (!control && *c == '\'') {
      put(&s, "'\\''");
    } else if (control && (is_control(*c) || *c == '\'' || *c == '\\' || *c == '%')) {
      (void)snprintf(octal, sizeof octal, "\\%03o", (unsigned)(unsigned char)*c);
      put(&s, octal);
    } else {
      put_char(&s, *c);
    }
  }
  put(&s, control ? substitution_end : "'");
  return s.used;
}

/* Reads behind `substitution`: octal escapes become their bytes. */
static const char *take_substitution(const char *at, char **to) {
  while (*at != '\0' && *at != '\'') {
    unsigned code = 0;
    if (at[0] == '\\' && at[1] >= '0' && at[1] <= '7') {
      int k = 1;
      for (; k <= 3 && at[k] >= '0' && at[k] <= '7'; k++) {
        code = 8 * code + (unsigned)(at[k] - '0');
      }
      *(*to)++ = (char)code;
      at += k;
    } else {
      *(*to)++ = *at++;
    }
  }
  const size_t end = strlen(substitution_end);
  return (strncmp(at, substitution_end, end) == 0) ? at + end : at + strlen(at);
}

int shell_split(char *text, char **word, int cap) {
  int n = 0;
  const char *at = text + strspn(text, " ");
  char *to = text; /* never ahead of what is read: words only get shorter */
  while (*at != '\0' && n + 1 < cap) {
    word[n++] = to;
    while (*at != '\0' && *at != ' ') {
      if (strncmp(at, substitution, strlen(substitution)) == 0) {
        at = take_substitution(at + strlen(substitution), &to);
      } else if (*at == '\'') {
        for (at++; *at != '\0' && *at != '\'';) {
          *to++ = *at++;
        }
        at += (*at == '\'') ? 1 : 0;
      } else {
        at += (*at == '\\' && at[1] != '\0') ? 1 : 0;
        *to++ = *at++;
      }
    }
    at += strspn(at, " ");
    *to++ = '\0';
  }
  word[n] = NULL;
  return n;
}

static size_t left(const shell_line *l) {
  return (l->used < l->cap) ? l->cap - l->used : 0;
}

static char *end_of(const shell_line *l) {
  return (left(l) > 0) ? l->buf + l->used : NULL;
}

void shell_put(shell_line *l, const char *text) {
  l->used += (size_t)snprintf(end_of(l), left(l), "%s", text);
}

void shell_put_word(shell_line *l, const char *word) {
  l->used += shell_quote(word, end_of(l), left(l));
}

void shell_put_option(shell_line *l, const char *name, const char *value) {
  if (value != NULL && value[0] != '\0') {
    shell_put(l, " --");
    shell_put(l, name);
    shell_put(l, " ");
    shell_put_word(l, value);
  }
}
