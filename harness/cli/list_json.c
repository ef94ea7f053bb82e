#include "harness/cli/list_json.h"

#include "harness/measure/check_eval.h"
#include "harness/util/json_out.h"

#include <string.h>

static json_t *words_json(const char *words) {
  json_t *all = json_array();
  for (const char *at = words; at != NULL;) {
    const char *bar = strchr(at, '|');
    const size_t n = (bar != NULL) ? (size_t)(bar - at) : strlen(at);
    (void)json_array_append_new(all, json_stringn(at, n));
    at = (bar != NULL) ? bar + 1 : NULL;
  }
  return all;
}

static json_t *field_json(const base_field *f) {
  static const char *const kinds[] = {"integer", "real", "choice"};
  json_t *o = json_object();
  json_out_text(o, "name", f->name);
  json_out_text(o, "kind", kinds[f->kind]);
  json_out_text(o, "unit", f->unit);
  json_t *words = words_json(f->words);
  if (f->kind == BASE_CHOICE) {
    (void)json_object_set(o, "default", json_array_get(words, (size_t)f->dflt));
    (void)json_object_set(o, "words", words);
  } else if (f->kind == BASE_INT) {
    json_out_int(o, "default", (long long)f->dflt);
    json_out_int(o, "min", (long long)f->min);
    json_out_int(o, "max", (long long)f->max);
  } else {
    json_out_real(o, "default", f->dflt);
    json_out_real(o, "min", f->min);
    json_out_real(o, "max", f->max);
  }
  json_decref(words);
  json_out_text(o, "help", f->help);
  return o;
}

/* Parameters: name, kind (integer, real, choice), unit, default, min, max (null for choices), words (null for
 * numbers), help. */
static json_t *fields_json(const base_field *f, int n) {
  json_t *all = json_array();
  for (int i = 0; i < n; i++) {
    (void)json_array_append_new(all, field_json(&f[i]));
  }
  return all;
}

/* The names of the blocks that a mask of 1u << lcp_set holds. */
static json_t *sets_json(unsigned mask) {
  json_t *all = json_array();
  for (int set = 0; lcp_set_name(set) != NULL; set++) {
    if ((mask & 1u << set) != 0) {
      (void)json_array_append_new(all, json_string(lcp_set_name(set)));
    }
  }
  return all;
}

void list_solver_more(json_t *o, const lcp_solver *s) {
  json_out_text(o, "words", s->words);
  json_out_text(o, "when", s->when);
  (void)json_object_set_new(o, "exact", json_boolean(s->exact));
  (void)json_object_set_new(o, "warm", json_boolean(s->warm));
  (void)json_object_set_new(o, "peer", json_boolean(s->peer));
  (void)json_object_set_new(o, "sets", sets_json(s->sets));
}

static json_t *effects_json(unsigned mask) {
  json_t *all = json_array();
  for (int bit = 0; bit < EFFECT_COUNT; bit++) {
    if ((mask & (1u << bit)) != 0) {
      (void)json_array_append_new(all, json_string(effect_name(bit)));
    }
  }
  return all;
}

void list_formulation_more(json_t *o, const formulation *f) {
  json_t *apart = json_array(), *model = json_array();
  for (const char *at = f->apart; at != NULL && *at != '\0';) {
    const size_t n = strcspn(at, " ");
    (void)json_array_append_new(apart, json_stringn(at, n));
    at += n + strspn(at + n, " ");
  }
  for (int i = 0; formulation_model_word(i) != NULL; i++) {
    if ((f->model & 1u << i) != 0) {
      (void)json_array_append_new(model, json_string(formulation_model_word(i)));
    }
  }
  json_out_text(o, "words", f->words);
  json_out_text(o, "when", f->when);
  (void)json_object_set_new(o, "apart", apart);
  (void)json_object_set_new(o, "model", model);
  (void)json_object_set_new(o, "polyhedral", json_boolean(f->model & FORM_CONE_POLYHEDRAL));
  (void)json_object_set_new(o, "compliant", json_boolean(f->model & FORM_PENALTY));
  (void)json_object_set_new(o, "normal_only", json_boolean(f->model & FORM_NORMAL_ONLY));
  (void)json_object_set_new(o, "frictionless", json_boolean(!(f->model & FORM_FRICTION)));
  (void)json_object_set_new(o, "forces", json_boolean(f->model & FORM_ACCELERATION));
  (void)json_object_set_new(o, "solver", json_boolean(f->sets != 0));
  (void)json_object_set_new(o, "sets", sets_json(f->sets));
  json_t *lacks = effects_json(f->lacks);
  if ((f->lacks & FORM_COORDINATES) != 0) {
    (void)json_array_append_new(lacks, json_string("coordinates"));
  }
  (void)json_object_set_new(o, "lacks", lacks);
}

static json_t *tolerance_json(const spec_tolerance *t) {
  json_t *o = json_object();
  json_out_real(o, "abs", t->abs);
  json_out_real(o, "h", t->h);
  json_out_real(o, "h2", t->h2);
  json_out_real(o, "inv_h", t->inv_h);
  json_out_real(o, "rel", t->rel);
  json_out_real(o, "reg_h", t->reg_h);
  json_out_real(o, "reg_v", t->reg_v);
  json_out_real(o, "reg_d", t->reg_d);
  return o;
}

/* Of the value that a check compares. */
static const char *check_unit(const spec_check *c) {
  switch (c->kind) {
  case CHECK_CONTACT_FORCE:
  case CHECK_CONTACT_FORCE_SUM:
    return "N";
  case CHECK_EVENT_TIME:
    return "s";
  case CHECK_ENERGY_NONINCREASE:
    return "J";
  case CHECK_MOMENTUM_X:
    return "kg m/s";
  case CHECK_MAX_SPEED:
    return "m/s";
  case CHECK_MAX_PENETRATION:
  case CHECK_STATIC_DEFLECTION:
  case CHECK_BRISTLE_DEFLECTION:
    return "m";
  default:
    return (c->var[0] != '\0') ? world_observe_unit(c->var) : "1";
  }
}

static json_t *prediction_json(const spec_check *c) {
  char label[200];
  check_label(c, label, sizeof label);
  const bool timed = c->kind == CHECK_STATE || c->kind == CHECK_MIN_CHANGE;
  const bool valued = c->kind != CHECK_ENERGY_NONINCREASE && c->kind != CHECK_FINITE;
  json_t *o = json_object();
  json_out_text(o, "quantity", label);
  json_out_text(o, "unit", check_unit(c));
  json_out_real(o, "time_s", timed ? c->t : HUGE_VAL);
  json_out_real(o, "value", valued ? c->value : HUGE_VAL);
  (void)json_object_set_new(o, "tolerance", tolerance_json(&c->tol));
  json_t *forms = json_array();
  for (int i = 0; i < c->n_form; i++) {
    (void)json_array_append_new(forms, json_string(c->form[i]));
  }
  (void)json_object_set_new(o, "formulations", forms);
  json_out_text(o, "source", c->source);
  return o;
}

static json_t *observables_json(const scene_spec *s) {
  json_t *all = json_array();
  for (int i = 0; i < s->n_observe; i++) {
    json_t *o = json_object();
    json_out_text(o, "name", s->observe[i]);
    json_out_text(o, "unit", world_observe_unit(s->observe[i]));
    (void)json_array_append_new(all, o);
  }
  return all;
}

static void put_spec(json_t *o, const scene_spec *s) {
  json_out_int(o, "dim", s->dim);
  json_out_real(o, "duration_s", s->duration);
  json_out_real(o, "step_s", s->h[0]);
  json_out_int(o, "bodies", s->n_body);
  (void)json_object_set_new(o, "effects", effects_json(s->effects));
  (void)json_object_set_new(o, "observables", observables_json(s));
  json_t *all = json_array();
  for (int i = 0; i < s->n_check; i++) {
    (void)json_array_append_new(all, prediction_json(&s->check[i]));
  }
  (void)json_object_set_new(o, "predictions", all);
}

base_status list_scene_json(const scene *s, json_t **out, base_error *err) {
  scene_spec spec;
  BASE_TRY(scene_build(s->name, &spec, err));
  json_t *o = json_object();
  json_out_text(o, "name", s->name);
  json_out_text(o, "title", s->title);
  json_out_text(o, "kind", "scene");
  json_out_text(o, "about", s->about);
  json_out_text(o, "cite", s->cite);
  json_out_text(o, "situation", scene_situation_name(s->situation));
  (void)json_object_set_new(o, "redundant", json_boolean(s->redundant));
  (void)json_object_set_new(o, "solvable", json_boolean(!spec.expect_unsolved));
  (void)json_object_set_new(o, "parameters", fields_json(s->fields, s->n_fields));
  put_spec(o, &spec);
  spec_free(&spec);
  *out = o;
  return BASE_OK;
}
