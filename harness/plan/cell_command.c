/* The command that reruns a cell, and the cell that a command names. */
#include "harness/plan/cell_command.h"

#include "harness/choice/plugins.h"
#include "harness/measure/registry.h"
#include "harness/util/shell.h"
#include "lcp/base/fields.h"

#include <stdio.h>
#include <string.h>

double plan_solver_limit(const campaign_limits *l) {
  return l->time * 4.0 / 5.0; /* 1.2, not 1.2000000000000002, of 1.5 */
}

/* The file of the solver where that is a plug-in. */
static const char *plugin_of(const cell *c) {
  solver_choice s;
  const plugin_file *f = NULL;
  if (solver_choose(c->solver, &s, NULL) == BASE_OK) {
    f = plugins_of(s.solver);
  }
  solver_choice_free(&s);
  return (f != NULL) ? f->path : "";
}

/* The solver as the cell names it, and the limit it was told in the place of its own where that is higher. */
static void solver_text(const cell *c, const campaign_limits *l, char *buf, size_t cap) {
  static const char limit[] = "max_seconds=";
  solver_choice s;
  if (solver_choose(c->solver, &s, NULL) != BASE_OK ||
      !solver_choice_limit(&s, plan_solver_limit(l))) {
    (void)snprintf(buf, cap, "%s", c->solver);
  } else {
    const char *own = strstr(c->solver, limit);
    char number[32];
    base_real_print(plan_solver_limit(l), number, sizeof number);
    if (own != NULL) {
      own += sizeof limit - 1;
      (void)snprintf(buf, cap, "%.*s%s%s", (int)(own - c->solver), c->solver, number,
                     own + strcspn(own, ","));
    } else {
      (void)snprintf(buf, cap, "%s%s%s%s", c->solver, strchr(c->solver, ':') != NULL ? "," : ":",
                     limit, number);
    }
  }
  solver_choice_free(&s);
}

size_t cell_command(const cell *c, const campaign_limits *limits, char *buf, size_t cap) {
  const bool is_scene = c->formulation[0] != '\0';
  char solver[400];
  shell_line l = {.cap = cap};
  l.buf = buf;
  solver_text(c, limits, solver, sizeof solver);
  shell_put(&l, is_scene ? "lcpbench simulate " : "lcpbench solve ");
  shell_put_word(&l, c->problem);
  shell_put_option(&l, "formulation", c->formulation);
  shell_put_option(&l, "solver", solver);
  shell_put_option(&l, "plugin", plugin_of(c));
  shell_put_option(&l, "tol", c->tol);
  shell_put_option(&l, "start", strcmp(c->start, "cold") == 0 ? "" : c->start);
  if (is_scene) {
    shell_put_option(&l, "step", c->step);
    shell_put_option(&l, "duration", c->duration);
    shell_put_option(&l, "effects", strcmp(c->effects, "declared") == 0 ? "" : c->effects);
    shell_put_option(&l, "contact-order",
                     strcmp(c->contact_order, "given") == 0 ? "" : c->contact_order);
    shell_put_option(&l, "islands", strcmp(c->islands, "off") == 0 ? "" : c->islands);
  }
  return l.used;
}

base_status cell_of_command(char *text, cell *c, base_error *err) {
  char *word[CELL_WORDS];
  const char *plugin;
  const int n = shell_split(text, word, CELL_WORDS);
  *c = (cell){.part = "",
              .formulation = "",
              .solver = "",
              .step = "",
              .duration = "",
              .tol = "",
              .start = "cold",
              .effects = "declared",
              .contact_order = "given",
              .islands = "off",
              .skip = ""};
  const struct {
    const char *name, **to;
  } options[] = {{"--plugin", &plugin}, /* loaded as for any verb; not of the cell */
                 {"--formulation", &c->formulation},
                 {"--solver", &c->solver},
                 {"--tol", &c->tol},
                 {"--step", &c->step},
                 {"--duration", &c->duration},
                 {"--start", &c->start},
                 {"--effects", &c->effects},
                 {"--contact-order", &c->contact_order},
                 {"--islands", &c->islands}};
  if (n < 3 || n % 2 == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "not a command of a cell: %.100s", text);
  }
  c->problem = word[2];
  for (int i = 3; i < n; i += 2) {
    int k = 0;
    while (k < BASE_COUNT(options) && strcmp(options[k].name, word[i]) != 0) {
      k++;
    }
    if (k == BASE_COUNT(options)) {
      return BASE_FAIL(err, BASE_EINVAL, "command of a cell: unknown option %.60s", word[i]);
    }
    *options[k].to = word[i + 1];
  }
  return BASE_OK;
}
