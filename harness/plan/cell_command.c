/* The command that reruns a cell, and the cell that a command names. */
#include "harness/plan/cell_command.h"

#include "harness/measure/registry.h"
#include "lcp/base/fields.h"

#include <stdio.h>
#include <string.h>

static size_t put_option(char *buf, size_t cap, size_t used, const char *name, const char *value) {
  if (value[0] == '\0' || used >= cap) {
    return used;
  }
  return used + (size_t)snprintf(buf + used, cap - used, " --%s '%s'", name, value);
}

double plan_solver_limit(const campaign_limits *l) {
  return l->time * 4.0 / 5.0; /* 1.2, not 1.2000000000000002, of 1.5 */
}

/* The solver as the cell names it, and the limit it was told where that is lower than its own. */
static void solver_text(const cell *c, const campaign_limits *l, char *buf, size_t cap) {
  solver_choice s;
  char number[32];
  (void)snprintf(buf, cap, "%s", c->solver);
  if (solver_choose(c->solver, &s, NULL) == BASE_OK &&
      solver_choice_limit(&s, plan_solver_limit(l))) {
    const size_t used = strlen(buf);
    base_real_print(plan_solver_limit(l), number, sizeof number);
    (void)snprintf(buf + used, cap - used, "%smax_seconds=%s",
                   strchr(c->solver, ':') != NULL ? "," : ":", number); /* the last one counts */
  }
  solver_choice_free(&s);
}

void cell_command(const cell *c, const campaign_limits *l, char *buf, size_t cap) {
  const bool is_scene = c->formulation[0] != '\0';
  char solver[400];
  solver_text(c, l, solver, sizeof solver);
  size_t used =
      (size_t)snprintf(buf, cap, "lcpbench %s '%s'", is_scene ? "simulate" : "solve", c->problem);
  used = put_option(buf, cap, used, "formulation", c->formulation);
  used = put_option(buf, cap, used, "solver", solver);
  used = put_option(buf, cap, used, "tol", c->tol);
  if (is_scene) {
    used = put_option(buf, cap, used, "step", c->step);
    used = put_option(buf, cap, used, "duration", c->duration);
    used = put_option(buf, cap, used, "start", strcmp(c->start, "cold") == 0 ? "" : c->start);
    used = put_option(buf, cap, used, "effects",
                      strcmp(c->effects, "declared") == 0 ? "" : c->effects);
    (void)put_option(buf, cap, used, "contact-order",
                     strcmp(c->contact_order, "given") == 0 ? "" : c->contact_order);
  }
}

int cell_command_split(char *text, char **word, int cap) {
  int n = 0;
  char *at = text;
  while (*at != '\0' && n + 1 < cap) {
    at += strspn(at, " ");
    const bool quoted = *at == '\'';
    at += quoted ? 1 : 0;
    if (*at == '\0') {
      break;
    }
    word[n++] = at;
    at += strcspn(at, quoted ? "'" : " ");
    if (*at != '\0') {
      *at++ = '\0';
    }
  }
  word[n] = NULL;
  return n;
}

base_status cell_of_command(char *text, cell *c, base_error *err) {
  char *word[CELL_WORDS];
  const int n = cell_command_split(text, word, CELL_WORDS);
  *c = (cell){.part = "",
              .formulation = "",
              .solver = "",
              .step = "",
              .duration = "",
              .tol = "",
              .start = "cold",
              .effects = "declared",
              .contact_order = "given",
              .skip = ""};
  const struct {
    const char *name, **to;
  } options[] = {{"--formulation", &c->formulation},
                 {"--solver", &c->solver},
                 {"--tol", &c->tol},
                 {"--step", &c->step},
                 {"--duration", &c->duration},
                 {"--start", &c->start},
                 {"--effects", &c->effects},
                 {"--contact-order", &c->contact_order}};
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
