/* harness/util/shell.h - words of a POSIX shell's command line that fit in one line of a file.
 *
 * A word is put between single quotes, a quote in it as '\''. A word with a control character becomes
 * "$(printf '...')" with octal escapes, which every POSIX shell turns back into the same bytes. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Can it be written so? Not where it ends with a line break, which $(...) drops. */
bool shell_can_quote(const char *word);

/* Writes the word, quoted, into buf[cap] and returns the length it needs, as snprintf does. */
size_t shell_quote(const char *word, char *buf, size_t cap);

/* A command as far as it is written, in buf[cap]; `used` counts what it needs. */
typedef struct shell_line {
  char *buf;
  size_t cap, used;
} shell_line;

void shell_put(shell_line *l, const char *text);      /* as it is */
void shell_put_word(shell_line *l, const char *word); /* quoted */
/* " --NAME 'VALUE'"; nothing where the value is NULL or empty. */
void shell_put_option(shell_line *l, const char *name, const char *value);

/* Takes such a line apart in place: at most cap - 1 words and a NULL; returns their number. Words that
 * shell_quote wrote, and plain ones between spaces, come out as they went in. */
int shell_split(char *text, char **word, int cap);
