/* lcpbench complete: what may stand next on a command line, for the shells. */
#include "formulations/formulation.h"
#include "harness/cli/cli.h"
#include "harness/measure/registry.h"
#include "harness/plan/campaign.h"
#include "lcp/base/nearest.h"
#include "problems/families/family.h"
#include "problems/scenes/scene.h"

#include <ctype.h>
#include <glob.h>
#include <stdio.h>
#include <string.h>

enum { WORDS_MAX = 256 };

typedef struct complete_options {
  const char *shell;
} complete_options;

static const arg_option options[] = {
    ARG(complete_options, shell, "--shell", ARG_TEXT, "bash|zsh|fish",
        "prints the lines that switch completion on in this shell"),
};
static const arg_table args = {
    options,   BASE_COUNT(options),
    0,         WORDS_MAX,
    "WORD...", "the words behind lcpbench, the last of them as far as it is typed; behind --"};

static const struct shell {
  const char *name, *lines;
} shells[] = {
    {"bash", "_lcpbench() {\n"
             "  local IFS=$'\\n'\n"
             "  COMPREPLY=($(lcpbench complete -- \"${COMP_WORDS[@]:1:COMP_CWORD}\" 2>/dev/null))\n"
             "}\n"
             "complete -o default -F _lcpbench lcpbench\n"},
    {"zsh", "#compdef lcpbench\n"
            "_lcpbench() {\n"
            "  local -a found\n"
            "  found=(${(f)\"$(lcpbench complete -- ${words[2,CURRENT]} 2>/dev/null)\"})\n"
            "  if (( $#found )); then compadd -- $found; else _files; fi\n"
            "}\n"
            "compdef _lcpbench lcpbench\n"},
    {"fish", "complete -c lcpbench -a '(lcpbench complete -- (commandline -opc)[2..] "
             "(commandline -ct) 2>/dev/null)'\n"},
};

static void offer(const char *name, const char *typed) {
  if (strncmp(name, typed, strlen(typed)) == 0) {
    (void)printf("%s\n", name);
  }
}

static void offer_campaigns(const char *typed) {
  char pattern[600];
  char name[256];
  glob_t found;
  (void)snprintf(pattern, sizeof pattern, "%s/*.yaml", campaign_directory());
  if (glob(pattern, 0, NULL, &found) != 0) {
    return;
  }
  for (size_t i = 0; i < found.gl_pathc; i++) {
    const char *file = strrchr(found.gl_pathv[i], '/') + 1;
    (void)snprintf(name, sizeof name, "%.*s", (int)(strlen(file) - strlen(".yaml")), file);
    offer(name, typed);
  }
  globfree(&found);
}

/* What a word in capitals stands for; files are the shell's own business. */
static void offer_kind(const char *kind, size_t len, const char *typed) {
  static const char *const known[] = {"SOLVER",  "FORMULATION", "SCENE", "CAMPAIGN",
                                      "PROBLEM", "KIND",        "WORD"};
  static const char *const lists[] = {"problems",  "scenes",  "formulations", "solvers",
                                      "campaigns", "effects", "situations",   "compat"};
  int k = 0;
  int n = 0;
  while (k < BASE_COUNT(known) && (strlen(known[k]) != len || strncmp(known[k], kind, len) != 0)) {
    k++;
  }
  const bool any = k == 6;
  if (k == 0 || any) {
    for (int i = 0; registry_solver(i) != NULL; i++) {
      offer(registry_solver(i)->name, typed);
    }
  }
  if (k == 1 || any) {
    const formulation *const *all = formulations(&n);
    for (int i = 0; i < n; i++) {
      offer(all[i]->name, typed);
    }
  }
  if (k == 2 || any) {
    const scene *const *all = scenes(&n);
    for (int i = 0; i < n; i++) {
      offer(all[i]->name, typed);
    }
  }
  if (k == 3) {
    offer_campaigns(typed);
  }
  if (k == 4 || any) {
    const lcp_family *const *all = lcp_families(&n);
    for (int i = 0; i < n; i++) {
      offer(all[i]->name, typed);
    }
  }
  for (int i = 0; k == 5 && i < BASE_COUNT(lists); i++) {
    offer(lists[i], typed);
  }
}

/* "cold|previous", "failed|all|SOLVER" or "SCENE": each of the words is offered, or stands for names. */
static void offer_value(const char *value, const char *typed) {
  while (*value != '\0') {
    const size_t len = strcspn(value, "|");
    if (isupper((unsigned char)value[0])) {
      offer_kind(value, len, typed);
    } else {
      char word[64];
      (void)snprintf(word, sizeof word, "%.*s", (int)len, value);
      offer(word, typed);
    }
    value += len + (value[len] == '|');
  }
}

static const arg_option *option_of(const arg_table *t, const char *name) {
  for (int i = 0; i < args_count(t); i++) {
    if (strcmp(args_at(t, i)->name, name) == 0) {
      return args_at(t, i);
    }
  }
  return NULL;
}

static void offer_verbs(const char *typed) {
  int n;
  const cli_verb *const *verb = cli_verbs(&n);
  for (int i = 0; i < n; i++) {
    offer(verb[i]->name, typed);
  }
}

static void complete(const char *const *word, int n) {
  const char *typed = (n > 0) ? word[n - 1] : "";
  const cli_verb *verb = (n > 1) ? cli_verb_find(word[0]) : NULL;
  if (n <= 1) {
    offer_verbs(typed);
  }
  if (verb == NULL) {
    return;
  }
  const arg_option *before = (n > 2) ? option_of(verb->args, word[n - 2]) : NULL;
  if (before != NULL && before->kind != ARG_FLAG) {
    offer_value(before->value, typed);
    return;
  }
  for (int i = 0; strncmp(typed, "--", 2) == 0 && i < args_count(verb->args); i++) {
    offer(args_at(verb->args, i)->name, typed);
  }
  if (typed[0] != '-') {
    if (strcmp(verb->name, "help") == 0) {
      offer_verbs(typed);
    }
    offer_value(verb->args->positional_name, typed);
  }
}

static base_status print_shell(const char *name, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  for (int i = 0; i < BASE_COUNT(shells); i++) {
    if (strcmp(shells[i].name, name) == 0) {
      (void)fputs(shells[i].lines, stdout);
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "--shell %.100s: need bash, zsh or fish%s", name,
                   base_nearest_word(name, "bash|zsh|fish", hint));
}

static int run(int argc, char **argv) {
  complete_options o = {0};
  const char *word[WORDS_MAX];
  int n;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, word, &n, &err);
  if (done == BASE_OK && o.shell != NULL && n > 0) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--shell: takes no words");
  }
  if (done == BASE_OK && o.shell != NULL) {
    done = print_shell(o.shell, &err);
  } else if (done == BASE_OK) {
    complete(word, n);
  }
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_complete;
const cli_verb verb_complete = {
    .name = "complete",
    .args = &args,
    .help =
        "prints what may stand next on a command line; `lcpbench complete --shell bash` switches"
        " it on",
    .run = run,
};
