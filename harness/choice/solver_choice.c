#include "harness/choice/solver_choice.h"

#include "lcp/base/nearest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const lcp_solver *const *extra_solvers; /* set once at start, read-only afterwards */

enum { ADDED_MAX = 32 };
static const lcp_solver *added[ADDED_MAX]; /* as long as solvers are added: before any is chosen */
static int n_added;

void registry_extend(const lcp_solver *const *extra) {
  extra_solvers = extra;
}

const lcp_solver *registry_solver(int i) {
  int count;
  const lcp_solver *const *own = lcp_solvers(&count);
  if (i < count) {
    return own[i];
  }
  i -= count;
  for (int k = 0; extra_solvers != NULL && extra_solvers[k] != NULL; k++, i--) {
    if (i == 0) {
      return extra_solvers[k];
    }
  }
  return (i < n_added) ? added[i] : NULL;
}

base_status registry_add(const lcp_solver *s, base_error *err) {
  if (registry_solver_find(s->name) != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "a solver '%s' is there already", s->name);
  }
  if (n_added == ADDED_MAX) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: %d solvers have been added, no more can be", s->name,
                     ADDED_MAX);
  }
  added[n_added++] = s;
  return BASE_OK;
}

const lcp_solver *registry_solver_find(const char *name) {
  const lcp_solver *s;
  for (int i = 0; (s = registry_solver(i)) != NULL; i++) {
    if (strcmp(s->name, name) == 0) {
      return s;
    }
  }
  return NULL;
}

base_status choice_split(const char *text, char name[64], const char **options, base_error *err) {
  const size_t len = strcspn(text, ":");
  if (len == 0 || len >= 64) {
    return BASE_FAIL(err, BASE_EINVAL, "'%.80s': need NAME or NAME:option=value,...", text);
  }
  memcpy(name, text, len);
  name[len] = '\0';
  *options = text + len + (text[len] == ':');
  return BASE_OK;
}

base_status choice_options(const char *name, const base_field *f, int nf, size_t size,
                           const char *text, void **opt, base_error *err) {
  *opt = calloc(1, size > 0 ? size : 1);
  if (*opt == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for its options", name);
  }
  base_fields_default(f, nf, *opt);
  base_error why = {0};
  const base_status s = base_fields_parse(f, nf, *opt, text, &why);
  if (s != BASE_OK) {
    free(*opt);
    *opt = NULL;
    return BASE_FAIL(err, s, "%s: %s", name, why.text);
  }
  return BASE_OK;
}

base_status choice_set(const char *name, const base_field *f, int nf, void *opt, const char *option,
                       const char *value, base_error *err) {
  base_error why = {0};
  const base_status s = base_fields_set(f, nf, opt, option, value, &why);
  return (s == BASE_OK) ? BASE_OK : BASE_FAIL(err, s, "%s: %s", name, why.text);
}

base_status solver_choose(const char *text, solver_choice *out, base_error *err) {
  *out = (solver_choice){0};
  char name[64];
  const char *options = NULL;
  BASE_TRY(choice_split(text, name, &options, err));
  const lcp_solver *s = registry_solver_find(name);
  if (s == NULL) {
    char hint[BASE_NEAREST_HINT];
    base_nearest near = base_nearest_to(name, strlen(name));
    for (int i = 0; (s = registry_solver(i)) != NULL; i++) {
      base_nearest_offer(&near, s->name);
    }
    return BASE_FAIL(err, BASE_EINVAL, "solver '%s': unknown; see lcpbench list solvers%s", name,
                     base_nearest_hint(&near, hint));
  }
  BASE_TRY(choice_options(name, s->fields, s->n_fields, s->options_size, options, &out->opt, err));
  out->solver = s;
  (void)base_fields_print(s->fields, s->n_fields, out->opt, out->config, sizeof out->config);
  return BASE_OK;
}

base_status solver_choice_set(solver_choice *c, const char *option, const char *value,
                              base_error *err) {
  const lcp_solver *s = c->solver;
  BASE_TRY(choice_set(s->name, s->fields, s->n_fields, c->opt, option, value, err));
  (void)base_fields_print(s->fields, s->n_fields, c->opt, c->config, sizeof c->config);
  return BASE_OK;
}

bool solver_choice_limit(solver_choice *c, double seconds) {
  const lcp_solver *s = c->solver;
  for (int i = 0; i < s->n_fields; i++) {
    const base_field *f = &s->fields[i];
    if (strcmp(f->name, "max_seconds") != 0 || f->kind != BASE_REAL) {
      continue;
    }
    unsigned char *at = (unsigned char *)c->opt + f->offset;
    double own;
    memcpy(&own, at, sizeof own);
    if (own > seconds) {
      memcpy(at, &seconds, sizeof seconds);
      (void)base_fields_print(s->fields, s->n_fields, c->opt, c->config, sizeof c->config);
    }
    return own > seconds;
  }
  return false;
}

void solver_choice_free(solver_choice *c) {
  free(c->opt);
  *c = (solver_choice){0};
}
