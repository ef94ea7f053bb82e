/* harness/measure/registry.h - formulations by "NAME:option=value,..." text; solvers are in solver_choice.h. */
#pragma once

#include "formulations/formulation.h"
#include "harness/choice/solver_choice.h"
#include "problems/spec/spec.h"

typedef struct formulation_choice {
  const formulation *form;
  void *opt;
  char config[CHOICE_CONFIG];
} formulation_choice;

base_status formulation_choose(const char *text, formulation_choice *out, base_error *err);
base_status formulation_choice_set(formulation_choice *c, const char *option, const char *value,
                                   base_error *err);
bool formulation_choice_has(const formulation_choice *c, const char *option);
/* Facets of the friction cone, 0 where the formulation has none. */
int formulation_choice_facets(const formulation_choice *c);
void formulation_choice_free(formulation_choice *c);

/* Refuses a word of `forms` or `not_applicable` that no formulation goes by: it would switch its check off without a sound. */
base_status formulation_words(const scene_spec *s, base_error *err);
/* scene_load of a scene that is to be run: formulation_words holds. */
base_status scene_open(const char *text, scene_spec *out, base_error *err);
