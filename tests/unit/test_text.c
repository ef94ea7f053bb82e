/* Words of a shell, text for a terminal, names that are nearly right. */
#include "tests/support/check.h"

#include "harness/util/shell.h"
#include "lcp/base/nearest.h"
#include "lcp/base/printable.h"
#include "lcp/base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const hostile[] = {
    "plain",  "two words",   "",           "it's",
    "'",      "''quoted''",  "new\nline",  "tab\tand\rmore",
    "$(id)",  "`id`",        "$HOME",      "a\\b",
    "back\\", "100%\n",      "%s\n%d",     "\x1b[31mred",
    "\x7f",   "#x",          "-x",         "--y",
    "*",      "\"",          "\"\n\"",     "'\n'\\047",
    "\n\nx",  "caf\xc3\xa9", "\xff\n\xfe", "!x",
    "~",      "a;b&c|d>e",
};

static void words_come_back(void **state) {
  (void)state;
  char line[8192] = "";
  char *word[BASE_COUNT(hostile) + 1];
  for (int i = 0; i < BASE_COUNT(hostile); i++) {
    const size_t used = strlen(line);
    line[used] = ' ';
    const size_t need = shell_quote(hostile[i], line + used + 1, sizeof line - used - 1);
    assert_int_equal(need, strlen(line) - used - 1);
  }
  assert_null(strchr(line, '\n'));
  assert_int_equal(shell_split(line, word, BASE_COUNT(word)), BASE_COUNT(hostile));
  for (int i = 0; i < BASE_COUNT(hostile); i++) {
    assert_string_equal(word[i], hostile[i]);
  }
}

/* The shell itself is the judge; words that end with a line break cannot be told to it. */
static void the_shell_reads_what_was_meant(void **state) {
  (void)state;
  for (int i = 0; i < BASE_COUNT(hostile); i++) {
    char command[512] = "printf '%s.' ";
    char got[128] = "";
    if (!shell_can_quote(hostile[i])) {
      assert_int_equal(hostile[i][strlen(hostile[i]) - 1], '\n');
      continue;
    }
    const size_t used = strlen(command);
    assert_true(shell_quote(hostile[i], command + used, sizeof command - used) <
                sizeof command - used);
    FILE *from = popen(command, "r");
    assert_non_null(from);
    const size_t n = fread(got, 1, sizeof got - 1, from);
    assert_int_equal(pclose(from), 0);
    assert_true(n > 0 && got[n - 1] == '.');
    got[n - 1] = '\0';
    assert_string_equal(got, hostile[i]);
  }
}

static void quoting_is_cut_and_counted(void **state) {
  (void)state;
  char few[6];
  assert_int_equal(shell_quote("it's long", few, sizeof few), 14);
  assert_string_equal(few, "'it'\\");
  char text[] = "lcpbench solve 'a b'";
  char *word[3];
  assert_int_equal(shell_split(text, word, 3), 2);
  assert_null(word[2]);
}

static void is_printed(const char *text, const char *want) {
  char buf[256];
  assert_string_equal(base_printable(text, buf, sizeof buf), want);
}

static void control_characters_are_escaped(void **state) {
  (void)state;
  is_printed("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80",
             "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80");
  is_printed("\x1b[2J\n\t\r\x01\x7f", "\\x1b[2J\\n\\t\\r\\x01\\x7f");
  is_printed("\xc2\x9b"
             "1m",
             "\\xc2\\x9b"
             "1m"); /* C1: what some terminals take for ESC [ */
  is_printed("\x9b"
             "1m",
             "\\x9b"
             "1m");
  is_printed("\xc0\xaf \xed\xa0\x80 \xf5\x80\x80\x80 \xe2\x82", "\\xc0\\xaf \\xed\\xa0\\x80 "
                                                                "\\xf5\\x80\\x80\\x80 \\xe2\\x82");
  char few[6];
  assert_string_equal(base_printable("abc\x1b", few, sizeof few), "abc");
}

static void hint_is(const char *text, const char *words, const char *want) {
  char buf[BASE_NEAREST_HINT];
  char full[BASE_NEAREST_HINT] = "";
  if (want[0] != '\0') {
    (void)snprintf(full, sizeof full, "; did you mean '%s'?", want);
  }
  assert_string_equal(base_nearest_word(text, words, buf), full);
}

static void the_nearest_name_is_proposed(void **state) {
  (void)state;
  const char *solvers = "lemke|pgs|pgs_sm|nsgs|newton|interior_point|ppm";
  hint_is("lemk", solvers, "lemke");              /* left out */
  hint_is("lemkee", solvers, "lemke");            /* too many */
  hint_is("lomke", solvers, "lemke");             /* another */
  hint_is("lmeke", solvers, "lemke");             /* swapped */
  hint_is("LEMKE", solvers, "lemke");             /* upper case */
  hint_is("interior", solvers, "interior_point"); /* the beginning */
  hint_is("newton_fast", solvers, "newton");
  hint_is("psg", solvers, "pgs");
  hint_is("pgs_s", solvers, "pgs_sm");
  hint_is("xyzzy", solvers, "");
  hint_is("x", "y|z", "");
  hint_is("", solvers, "");
  char buf[BASE_NEAREST_HINT];
  char word[300];
  memset(word, 'a', sizeof word - 1);
  word[sizeof word - 1] = '\0';
  assert_string_equal(base_nearest_word(word, solvers, buf), "");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(words_come_back),
      cmocka_unit_test(the_shell_reads_what_was_meant),
      cmocka_unit_test(quoting_is_cut_and_counted),
      cmocka_unit_test(control_characters_are_escaped),
      cmocka_unit_test(the_nearest_name_is_proposed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
