#include "harness/measure/registry.h"

#include "lcp/base/nearest.h"
#include "problems/read/scene_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

base_status formulation_choose(const char *text, formulation_choice *out, base_error *err) {
  *out = (formulation_choice){0};
  char name[64];
  const char *options = NULL;
  BASE_TRY(choice_split(text, name, &options, err));
  const formulation *f = formulation_find(name);
  if (f == NULL) {
    char hint[BASE_NEAREST_HINT];
    base_nearest near = base_nearest_to(name, strlen(name));
    int count;
    const formulation *const *all = formulations(&count);
    for (int i = 0; i < count; i++) {
      base_nearest_offer(&near, all[i]->name);
    }
    return BASE_FAIL(err, BASE_EINVAL,
                     "formulation '%s': unknown; see lcpbench list formulations%s", name,
                     base_nearest_hint(&near, hint));
  }
  BASE_TRY(choice_options(name, f->fields, f->n_fields, f->options_size, options, &out->opt, err));
  out->form = f;
  (void)base_fields_print(f->fields, f->n_fields, out->opt, out->config, sizeof out->config);
  return BASE_OK;
}

base_status formulation_choice_set(formulation_choice *c, const char *option, const char *value,
                                   base_error *err) {
  const formulation *f = c->form;
  BASE_TRY(choice_set(f->name, f->fields, f->n_fields, c->opt, option, value, err));
  (void)base_fields_print(f->fields, f->n_fields, c->opt, c->config, sizeof c->config);
  return BASE_OK;
}

bool formulation_choice_has(const formulation_choice *c, const char *option) {
  for (int i = 0; i < c->form->n_fields; i++) {
    if (strcmp(c->form->fields[i].name, option) == 0) {
      return true;
    }
  }
  return false;
}

int formulation_choice_facets(const formulation_choice *c) {
  for (int i = 0; i < c->form->n_fields; i++) {
    const base_field *f = &c->form->fields[i];
    if (strcmp(f->name, "facets") == 0 && f->kind == BASE_INT) {
      int facets;
      memcpy(&facets, (const unsigned char *)c->opt + f->offset, sizeof facets);
      return facets;
    }
  }
  return 0;
}

void formulation_choice_free(formulation_choice *c) {
  free(c->opt);
  *c = (formulation_choice){0};
}

/* The name of a formulation, or what one stands for. */
static bool is_word(const char *word, base_nearest *near) {
  int count;
  const formulation *const *all = formulations(&count);
  for (int i = 0; i < count; i++) {
    const char *as = all[i]->stands_for;
    if (strcmp(word, all[i]->name) == 0 || (as != NULL && strcmp(word, as) == 0)) {
      return true;
    }
    base_nearest_offer(near, all[i]->name);
  }
  return false;
}

static base_status check_word(const scene_spec *s, const char *where, const char *word,
                              base_error *err) {
  base_nearest near = base_nearest_to(word, strlen(word));
  if (is_word(word, &near)) {
    return BASE_OK;
  }
  char hint[BASE_NEAREST_HINT];
  return BASE_FAIL(err, BASE_EINVAL,
                   "scene '%s': %s '%s': no such formulation; see lcpbench list formulations%s",
                   s->id, where, word, base_nearest_hint(&near, hint));
}

static base_status check_forms(const scene_spec *s, const char *what, int index,
                               const spec_check *c, base_error *err) {
  char where[64];
  (void)snprintf(where, sizeof where, "%s %d: forms", what, index + 1);
  for (int i = 0; i < c->n_form; i++) {
    BASE_TRY(check_word(s, where, c->form[i], err));
  }
  return BASE_OK;
}

base_status formulation_words(const scene_spec *s, base_error *err) {
  for (int i = 0; i < s->n_check; i++) {
    BASE_TRY(check_forms(s, "check", i, &s->check[i], err));
  }
  for (int i = 0; i < s->n_off; i++) {
    BASE_TRY(check_forms(s, "if_off", i, &s->off[i].check, err));
  }
  for (int i = 0; i < s->n_not_applicable; i++) {
    BASE_TRY(check_word(s, "not_applicable", s->not_applicable[i], err));
  }
  return BASE_OK;
}

base_status scene_open(const char *text, scene_spec *out, base_error *err) {
  BASE_TRY(scene_load(text, out, err));
  base_error inner = {0};
  const base_status status = formulation_words(out, &inner);
  if (status != BASE_OK) {
    spec_free(out);
    return BASE_FAIL(err, status, "%s: %s", text, inner.text);
  }
  return BASE_OK;
}
