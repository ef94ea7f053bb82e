#include "harness/cli/help.h"

#include "harness/util/version.h"

#include <string.h>

static const char *const ending =
    "A FILE to be written may be -, standard output; what else would stand there goes to stderr.\n"
    "A PROBLEM or SCENE that is - is read from standard input. Behind -- there are no options.\n"
    "An option that is not given is taken from the environment: --memory-limit from\n"
    "LCPBENCH_MEMORY_LIMIT.";

static const struct exit_words {
  int code;
  const char *words;
} exits[] = {
    {CLI_OK, "done: solved and verified, every check passed, every cell measured"},
    {CLI_INTERNAL, "internal error, or standard output could not be written"},
    {CLI_USAGE, "usage, bad input, or a file that cannot be read or written"},
    {CLI_HONEST, "honest failure: not solved, not verified, a prediction missed"},
    {CLI_INTERRUPTED, "stopped by SIGTERM; the same command goes on, or begins again (simulate)"},
    {CLI_SIGINT_EXIT, "stopped by Ctrl-C; the same command goes on, or begins again (simulate)"}};

void help_usage(FILE *to, const cli_verb *v) {
  const arg_table *t = v->args;
  (void)fprintf(to, "%s%s%s%s%s", v->name, t->positional_name[0] != '\0' ? " " : "",
                t->min_positional == 0 && t->max_positional > 0 ? "[" : "", t->positional_name,
                t->min_positional == 0 && t->max_positional > 0 ? "]" : "");
  for (int i = 0; i < args_count(t); i++) {
    const arg_option *o = args_at(t, i);
    (void)fprintf(to, " %s%s%s%s%s%s", o->needed ? "" : "[", o->name, o->value != NULL ? " " : "",
                  o->value != NULL ? o->value : "", o->needed ? "" : "]",
                  o->kind == ARG_LIST ? "..." : "");
  }
}

void help_verb(FILE *to, const cli_verb *v) {
  const arg_table *t = v->args;
  char range[96];
  (void)fputs("lcpbench ", to);
  help_usage(to, v);
  (void)fprintf(to, "\n    %s\n\n", v->help);
  if (t->max_positional > 0) {
    (void)fprintf(to, "  %s\n      %s\n", t->positional_name, t->positional_help);
  }
  for (int i = 0; i < args_count(t); i++) {
    const arg_option *o = args_at(t, i);
    (void)args_range(o, range, sizeof range);
    (void)fprintf(to, "  %s%s%s%s%s\n      %s\n", o->name, o->value != NULL ? " " : "",
                  o->value != NULL ? o->value : "", range[0] != '\0' ? "  " : "", range, o->help);
  }
}

void help_all(FILE *to) {
  int n;
  const cli_verb *const *verb = cli_verbs(&n);
  (void)fprintf(to, "lcpbench %s - benchmarks of contact formulations and LCP solvers\n\n",
                harness_version());
  for (int i = 0; i < n; i++) {
    (void)fputs("  lcpbench ", to);
    help_usage(to, verb[i]);
    (void)fprintf(to, "\n      %s\n", verb[i]->help);
  }
  (void)fprintf(to,
                "\n`lcpbench help WORD` explains a verb, a solver, a formulation, a scene or a "
                "family with every option.\n%s\nExit codes:\n",
                ending);
  for (int i = 0; i < BASE_COUNT(exits); i++) {
    (void)fprintf(to, "  %3d  %s\n", exits[i].code, exits[i].words);
  }
}

void help_fields(FILE *to, const base_field *f, int n) {
  char number[3][32];
  for (int i = 0; i < n; i++) {
    if (f[i].kind == BASE_CHOICE) {
      const char *word = f[i].words;
      for (int k = 0; k < (int)f[i].dflt; k++) {
        word += strcspn(word, "|") + 1;
      }
      (void)fprintf(to, "  %s=%.*s  %s\n      %s\n", f[i].name, (int)strcspn(word, "|"), word,
                    f[i].words, f[i].help);
      continue;
    }
    base_real_print(f[i].dflt, number[0], sizeof number[0]);
    base_real_print(f[i].min, number[1], sizeof number[1]);
    base_real_print(f[i].max, number[2], sizeof number[2]);
    (void)fprintf(to, "  %s=%s  [%s], %s%s to %s\n      %s\n", f[i].name, number[0], f[i].unit,
                  f[i].kind == BASE_INT ? "integer from " : "from ", number[1], number[2],
                  f[i].help);
  }
}

/* Text in man(7): hyphens that are typed, and no line that begins like a request. */
static void put_roff(FILE *to, const char *text) {
  if (*text == '.' || *text == '\'') {
    (void)fputs("\\&", to);
  }
  for (const char *c = text; *c != '\0'; c++) {
    if (*c == '-' || *c == '\\') {
      (void)fputs(*c == '-' ? "\\-" : "\\e", to);
    } else {
      (void)fputc(*c, to);
    }
  }
}

static void put_term(FILE *to, const char *name, const char *value, const char *range,
                     const char *words) {
  (void)fputs(".TP\n\\fB", to);
  put_roff(to, name);
  (void)fputs("\\fR", to);
  if (value != NULL) {
    (void)fputs(" \\fI", to);
    put_roff(to, value);
    (void)fputs("\\fR", to);
  }
  (void)fputs(range[0] != '\0' ? "  " : "", to);
  put_roff(to, range);
  (void)fputc('\n', to);
  put_roff(to, words);
  (void)fputc('\n', to);
}

static void put_verb(FILE *to, const cli_verb *v) {
  char range[96];
  const arg_table *t = v->args;
  (void)fprintf(to, ".SS %s\n", v->name);
  put_roff(to, v->help);
  (void)fputs(".\n", to);
  if (t->max_positional > 0) {
    put_term(to, "", t->positional_name, "", t->positional_help);
  }
  for (int i = 0; i < args_count(t); i++) {
    const arg_option *o = args_at(t, i);
    put_term(to, o->name, o->value, args_range(o, range, sizeof range), o->help);
  }
}

void help_man(FILE *to) {
  int n;
  const cli_verb *const *verb = cli_verbs(&n);
  (void)fprintf(
      to,
      ".TH LCPBENCH 1 \"\" \"lcpbench %s\" \"User Commands\"\n.SH NAME\nlcpbench \\- "
      "benchmarks of contact formulations and LCP solvers\n.SH SYNOPSIS\n\\fBlcpbench\\fR "
      "\\fIVERB\\fR [\\fIARGUMENT\\fR...]\n.SH VERBS\n",
      harness_version());
  for (int i = 0; i < n; i++) {
    put_verb(to, verb[i]);
  }
  (void)fputs(".SH NOTES\n", to);
  put_roff(to, ending);
  (void)fputs("\n.SH EXIT STATUS\n", to);
  for (int i = 0; i < BASE_COUNT(exits); i++) {
    char code[12];
    (void)snprintf(code, sizeof code, "%d", exits[i].code);
    put_term(to, code, NULL, "", exits[i].words);
  }
}
