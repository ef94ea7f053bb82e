#include "harness/measure/combination_plan.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SPAN_TEXT = CHOICE_CONFIG };

/* The step that the text at *from begins with, LONG_MAX behind the last; *rest: the text behind it. */
static base_status next_step(const char *from, long last, long *step, const char **rest,
                             base_error *err) {
  char *end;
  *step = LONG_MAX;
  *rest = from;
  if (*from == '\0') {
    return BASE_OK;
  }
  *step = strtol(from + 1, &end, 10);
  *rest = end + 1;
  return (end > from + 1 && *end == ':' && *step > last)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "'%.100s': need /STEPS:NAME with more steps than %ld",
                         from, last);
}

/* One of the two texts: what stands at `at`, up to the slash at `end`. */
typedef struct cursor {
  const char *at, *end;
} cursor;

static cursor cursor_at(const char *text) {
  return (cursor){text, text + strcspn(text, "/")};
}

static base_status word_of(const cursor *c, char word[SPAN_TEXT], base_error *err) {
  if (c->end - c->at >= SPAN_TEXT) {
    return BASE_FAIL(err, BASE_EINVAL, "'%.60s...': need at most %d letters", c->at, SPAN_TEXT - 1);
  }
  (void)snprintf(word, SPAN_TEXT, "%.*s", (int)(c->end - c->at), c->at);
  return BASE_OK;
}

static base_status append(combination_plan *p, long from, const cursor *form, const cursor *solver,
                          const char *tol, base_error *err) {
  char word[SPAN_TEXT];
  if (p->n == COMBINATION_SPANS) {
    return BASE_FAIL(err, BASE_EINVAL, "formulation and solver: need at most %d changes",
                     COMBINATION_SPANS - 1);
  }
  combination_span *s = &p->span[p->n++];
  s->from = from;
  BASE_TRY(word_of(form, word, err));
  BASE_TRY(formulation_choose(word, &s->form, err));
  BASE_TRY(word_of(solver, word, err));
  BASE_TRY(solver_choose(word, &s->solver, err));
  return (tol != NULL) ? solver_choice_set(&s->solver, "tol", tol, err) : BASE_OK;
}

base_status combination_plan_parse(const char *forms, const char *solvers, const char *tol,
                                   combination_plan *out, base_error *err) {
  cursor form = cursor_at(forms);
  cursor with = cursor_at(solvers);
  long at = 0;
  *out = (combination_plan){0};
  BASE_TRY(append(out, at, &form, &with, tol, err));
  while (*form.end != '\0' || *with.end != '\0') {
    long form_step, solver_step;
    const char *next_form, *next_solver;
    BASE_TRY(next_step(form.end, at, &form_step, &next_form, err));
    BASE_TRY(next_step(with.end, at, &solver_step, &next_solver, err));
    at = (form_step < solver_step) ? form_step : solver_step;
    form = (form_step == at) ? cursor_at(next_form) : form;
    with = (solver_step == at) ? cursor_at(next_solver) : with;
    BASE_TRY(append(out, at, &form, &with, tol, err));
  }
  return BASE_OK;
}

const combination_span *combination_plan_at(const combination_plan *p, long done) {
  int k = 0;
  while (k + 1 < p->n && p->span[k + 1].from <= done) {
    k++;
  }
  return &p->span[k];
}

void combination_plan_free(combination_plan *p) {
  for (int k = 0; k < p->n; k++) {
    formulation_choice_free(&p->span[k].form);
    solver_choice_free(&p->span[k].solver);
  }
  *p = (combination_plan){0};
}
