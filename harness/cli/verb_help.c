/* lcpbench help: what a word of this build means, with every option. */
#include "formulations/formulation.h"
#include "harness/cli/cli.h"
#include "harness/cli/help.h"
#include "harness/measure/registry.h"
#include "lcp/base/nearest.h"
#include "problems/families/family.h"
#include "problems/scenes/scene.h"

#include <string.h>

typedef struct help_options {
  bool man;
} help_options;

static const arg_option options[] = {
    ARG(help_options, man, "--man", ARG_FLAG, NULL, "prints the manual page, for man -l"),
};
static const arg_table args = {options, BASE_COUNT(options),
                               0,       1,
                               "WORD",  "a verb, a solver, a formulation, a scene or a family"};

/* A component with what it says of itself; "" and NULL are left out. */
typedef struct component {
  const char *kind, *name, *title, *words, *when;
  const base_field *fields;
  int n_fields;
} component;

static component of_solver(const lcp_solver *s) {
  return (component){"solver", s->name, s->title, s->words, s->when, s->fields, s->n_fields};
}

static component of_formulation(const formulation *f) {
  return (component){"formulation", f->name, f->title, f->words, f->when, f->fields, f->n_fields};
}

static component of_scene(const scene *s) {
  return (component){"scene", s->name, s->title, s->about, NULL, s->fields, s->n_fields};
}

static component of_family(const lcp_family *f) {
  return (component){"family of problems", f->name, f->title, f->about, NULL, f->fields,
                     f->n_fields};
}

/* The i-th component of the build; false past the end. */
static bool component_at(int i, component *out) {
  int n_solver = 0;
  int n[3];
  const formulation *const *form = formulations(&n[0]);
  const scene *const *sc = scenes(&n[1]);
  const lcp_family *const *family = lcp_families(&n[2]);
  while (registry_solver(n_solver) != NULL) {
    n_solver++;
  }
  if (i < n_solver) {
    *out = of_solver(registry_solver(i));
  } else if ((i -= n_solver) < n[0]) {
    *out = of_formulation(form[i]);
  } else if ((i -= n[0]) < n[1]) {
    *out = of_scene(sc[i]);
  } else if ((i -= n[1]) < n[2]) {
    *out = of_family(family[i]);
  } else {
    return false;
  }
  return true;
}

static void print_component(const component *c) {
  (void)printf("%s %s: %s\n", c->kind, c->name, c->title);
  if (c->words != NULL && c->words[0] != '\0') {
    (void)printf("    %s\n", c->words);
  }
  if (c->when != NULL && c->when[0] != '\0') {
    (void)printf("    When: %s\n", c->when);
  }
  (void)printf("\n");
  help_fields(stdout, c->fields, c->n_fields);
}

/* One word may name more than one thing; all are told. */
static base_status explain(const char *word, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(word, strlen(word));
  int n;
  int found = 0;
  component c;
  const cli_verb *const *verb = cli_verbs(&n);
  for (int i = 0; i < n; i++) {
    base_nearest_offer(&near, verb[i]->name);
    if (strcmp(verb[i]->name, word) == 0) {
      help_verb(stdout, verb[i]);
      found++;
    }
  }
  for (int i = 0; component_at(i, &c); i++) {
    base_nearest_offer(&near, c.name);
    if (strcmp(c.name, word) == 0) {
      print_component(&c);
      found++;
    }
  }
  return (found > 0) ? BASE_OK
                     : BASE_FAIL(err, BASE_EINVAL,
                                 "help '%.100s': need a verb or the name of a component%s", word,
                                 base_nearest_hint(&near, hint));
}

static int run(int argc, char **argv) {
  help_options o = {0};
  const char *word = NULL;
  int n;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, &word, &n, &err);
  if (done == BASE_OK && o.man && n > 0) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--man: the manual page is of the whole program");
  }
  if (done == BASE_OK && n > 0) {
    done = explain(word, &err);
  } else if (done == BASE_OK) {
    (o.man ? help_man : help_all)(stdout);
  }
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_help;
const cli_verb verb_help = {
    .name = "help",
    .args = &args,
    .help = "explains the program, or one word of it with every option, its unit and its range",
    .run = run,
};
