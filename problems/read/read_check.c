/* What must come out: checks and switched-off answers of the case format. */
#include "lcp/base/nearest.h"
#include "problems/read/read_scene.h"
#include "problems/vec.h"

#include <math.h>
#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

base_status read_pair_names(const node *n, json_t *v, const char *what, char *a, char *b) {
  if (!json_is_array(v) || json_array_size(v) != 2) {
    return BAD(n, "%s: %s: need two names", n->where, what);
  }
  BASE_TRY(node_string(n, json_array_get(v, 0), what, a, SPEC_NAME));
  return node_string(n, json_array_get(v, 1), what, b, SPEC_NAME);
}

static base_status read_tolerance(const node *n, spec_tolerance *tol) {
  json_t *v = json_object_get(n->v, "tol");
  node t;
  if (v != NULL) {
    BASE_TRY(node_open(&t, v, n->err, "%s: tol", n->where));
    BASE_TRY(node_keys(&t, "abs|h|h2|inv_h"));
    BASE_TRY(node_real(&t, "abs", &tol->abs));
    BASE_TRY(node_real(&t, "h", &tol->h));
    BASE_TRY(node_real(&t, "h2", &tol->h2));
    BASE_TRY(node_real(&t, "inv_h", &tol->inv_h));
  }
  v = json_object_get(n->v, "reg");
  if (v != NULL) {
    BASE_TRY(node_open(&t, v, n->err, "%s: reg", n->where));
    BASE_TRY(node_keys(&t, "h|v|d"));
    BASE_TRY(node_real(&t, "h", &tol->reg_h));
    BASE_TRY(node_real(&t, "v", &tol->reg_v));
    BASE_TRY(node_real(&t, "d", &tol->reg_d));
  }
  return node_real(n, "rel", &tol->rel);
}

static base_status read_direction(const scene_spec *s, const node *n, spec_check *c) {
  c->has_dir = node_has(n, "dir");
  BASE_TRY(node_vector(n, "dir", s->dim, c->dir));
  if (c->has_dir && !(v3_norm(c->dir) > 0.0)) {
    return BAD(n, "%s: dir has length 0", n->where);
  }
  return BASE_OK;
}

static base_status read_forms(const node *n, spec_check *c) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "forms", SPEC_FORMS, &list, &count));
  for (int i = 0; i < count; i++) {
    char name[SPEC_NAME];
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "forms", name, sizeof name));
    BASE_TRY(spec_check_only(c, name, n->err));
  }
  return BASE_OK;
}

static base_status read_pairs(const node *n, spec_check *c) {
  json_t *pair = json_object_get(n->v, "pair"), *list;
  int count;
  if (pair != NULL) {
    c->n_pair = 1;
    return read_pair_names(n, pair, "pair", c->pair[0].a, c->pair[0].b);
  }
  BASE_TRY(node_list(n, "pairs", SPEC_PAIRS, &list, &count));
  for (int i = 0; i < count; i++) {
    BASE_TRY(
        read_pair_names(n, json_array_get(list, (size_t)i), "pairs", c->pair[i].a, c->pair[i].b));
  }
  c->n_pair = count;
  return BASE_OK;
}

/* A note is kept where no source is given. */
static base_status read_remark(const node *n, spec_check *c) {
  BASE_TRY(node_text(n, "note", c->source, sizeof c->source));
  return node_text(n, "source", c->source, sizeof c->source);
}

/* What a kind of check reads besides forms, nd and remarks. */
enum {
  READS_VAR = 1,
  READS_VALUE = 2, /* compares with it; the others are bounds, of their tolerance alone */
  READS_TOL = 4,
  READS_REL = 8, /* of a bound there is nothing to be a share of */
  READS_WINDOW = 16,
  READS_STEPS = 32,
  READS_PAIR = 64,
  READS_EVENT = 128,
  READS_NUMBER = READS_VALUE | READS_TOL | READS_REL,
  READS_FORCE = READS_NUMBER | READS_WINDOW | READS_PAIR
};

static const unsigned reads[CHECK_COUNT] = {
    [CHECK_STATE] = READS_VAR | READS_NUMBER,
    [CHECK_STATE_AFTER_STEPS] = READS_VAR | READS_NUMBER | READS_STEPS,
    [CHECK_MAX_DRIFT] = READS_VAR | READS_TOL | READS_WINDOW,
    [CHECK_WINDOW_MAX] = READS_VAR | READS_NUMBER | READS_WINDOW,
    [CHECK_WINDOW_MIN] = READS_VAR | READS_NUMBER | READS_WINDOW,
    [CHECK_MIN_CHANGE] = READS_VAR | READS_VALUE,
    [CHECK_MAX_PENETRATION] = READS_TOL,
    [CHECK_CONTACT_FORCE] = READS_FORCE,
    [CHECK_CONTACT_FORCE_SUM] = READS_FORCE,
    [CHECK_EVENT_TIME] = READS_VAR | READS_NUMBER | READS_PAIR | READS_EVENT,
    [CHECK_ENERGY_NONINCREASE] = READS_TOL,
    [CHECK_ENERGY_GROWTH_REL] = READS_TOL,
    [CHECK_ENERGY_DRIFT_REL] = READS_TOL,
    [CHECK_ANGULAR_MOMENTUM_DRIFT_REL] = READS_TOL,
    [CHECK_MOMENTUM_X] = READS_NUMBER,
    [CHECK_MAX_SPEED] = READS_TOL,
    [CHECK_STATIC_DEFLECTION] = READS_NUMBER,
    [CHECK_BRISTLE_DEFLECTION] = READS_TOL | READS_REL, /* its value is a text */
};

/* Refuses what the kind does not read and would pass over in silence. A number that says nothing, as `value: 0` of a bound, may
 * stand: written scenes have them. */
static base_status check_reads(const node *n, const spec_check *c) {
  const spec_tolerance *t = &c->tol;
  const struct {
    const char *key;
    unsigned read;
    bool says;
  } keys[] = {
      {"var", READS_VAR, c->var[0] != '\0'},
      {"dir", READS_VAR, c->has_dir},
      {"value", READS_VALUE, c->value != 0.0},
      {"tol", READS_TOL, t->abs != 0.0 || t->h != 0.0 || t->h2 != 0.0 || t->inv_h != 0.0},
      {"reg", READS_TOL, t->reg_h != 0.0 || t->reg_v != 0.0 || t->reg_d != 0.0},
      {"rel", READS_REL, t->rel != 0.0},
      {"t0", READS_WINDOW, c->t0 != 0.0},
      {"t1", READS_WINDOW, node_has(n, "t1")},
      {"n", READS_STEPS, node_has(n, "n")},
      {"dvalue_dh", READS_STEPS, c->dvalue_dh != 0.0},
      {"pair", READS_PAIR, node_has(n, "pair")},
      {"pairs", READS_PAIR, c->n_pair > 0},
      {"component", READS_WINDOW | READS_PAIR, node_has(n, "component")},
      {"event", READS_EVENT, node_has(n, "event")},
      {"threshold", READS_EVENT, node_has(n, "threshold")},
  };
  for (int i = 0; i < BASE_COUNT(keys); i++) {
    if (keys[i].says && (reads[c->kind] & keys[i].read) != keys[i].read) {
      const bool bound = keys[i].read == READS_VALUE && (reads[c->kind] & READS_TOL) != 0;
      return BAD(n, "%s: '%s' says nothing in a %s check%s", n->where, keys[i].key,
                 spec_check_name(c->kind), bound ? ": its tol is the bound" : "");
    }
  }
  return BASE_OK;
}

static base_status read_value(const node *n, spec_check *c) {
  const json_t *v = json_object_get(n->v, "value");
  if (c->kind == CHECK_BRISTLE_DEFLECTION &&
      json_is_string(v)) { /* the harness knows the formula */
    return node_string(n, v, "value", c->source, sizeof c->source);
  }
  if ((reads[c->kind] & READS_VALUE) != 0) {
    BASE_TRY(node_need(n, "value"));
  }
  return node_real(n, "value", &c->value);
}

static base_status find_kind(const node *n, spec_check_kind *kind) {
  char type[48];
  BASE_TRY(node_need(n, "type"));
  BASE_TRY(node_text(n, "type", type, sizeof type));
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(type, strlen(type));
  for (int k = 0; k < CHECK_COUNT; k++) {
    const char *name = spec_check_name((spec_check_kind)k);
    if (strcmp(type, name) == 0) {
      *kind = (spec_check_kind)k;
      return BASE_OK;
    }
    base_nearest_offer(&near, name);
  }
  return BAD(n, "%s: unknown check type '%s'%s", n->where, type, base_nearest_hint(&near, hint));
}

base_status read_check(scene_spec *s, json_t *v, int index, base_error *err) {
  node n;
  spec_check_kind kind = CHECK_STATE;
  BASE_TRY(node_open(&n, v, err, "scene '%s': check %d", s->id, index + 1));
  BASE_TRY(find_kind(&n, &kind));
  BASE_TRY(node_keys(&n, "type|var|dir|t|t0|t1|n|value|dvalue_dh|tol|reg|rel|forms|nd|pair|pairs|"
                         "component|event|threshold|note|source"));
  spec_check *c;
  char var[2 * SPEC_NAME] = "";
  BASE_TRY(node_text(&n, "var", var, sizeof var));
  BASE_TRY(spec_add_check(s, kind, var, &c, err));
  BASE_TRY(read_direction(s, &n, c));
  c->t = s->duration;
  BASE_TRY(node_real(&n, "t", &c->t));
  BASE_TRY(node_real(&n, "t0", &c->t0));
  BASE_TRY(node_real(&n, "t1", &c->t1));
  BASE_TRY(node_int(&n, "n", &c->n));
  if (kind == CHECK_STATE_AFTER_STEPS && c->n < 1) {
    return BAD(&n, "%s: n = %d steps, need at least 1", n.where, c->n);
  }
  BASE_TRY(read_remark(&n, c));
  BASE_TRY(read_value(&n, c));
  BASE_TRY(node_real(&n, "dvalue_dh", &c->dvalue_dh));
  BASE_TRY(read_tolerance(&n, &c->tol));
  BASE_TRY(read_forms(&n, c));
  BASE_TRY(node_int(&n, "nd", &c->nd));
  BASE_TRY(read_pairs(&n, c));
  int component = 0, event = (int)EVENT_FIRST_CONTACT;
  BASE_TRY(node_choice(&n, "component", "normal|tangential", &component));
  c->tangential = (component == 1);
  BASE_TRY(node_choice(&n, "event", "first_contact|stop|start|leave|sign_change", &event));
  c->event = (spec_event)event;
  BASE_TRY(node_real(&n, "threshold", &c->threshold));
  return check_reads(&n, c);
}

base_status read_off(scene_spec *s, const char *name, json_t *v, base_error *err) {
  node n;
  unsigned bit = 0;
  BASE_TRY(node_open(&n, v, err, "scene '%s': if_off '%s'", s->id, name));
  for (int i = 0; i < EFFECT_COUNT; i++) {
    bit |= (strcmp(effect_name(i), name) == 0) ? 1u << i : 0u;
  }
  if (bit == 0) {
    return BAD(&n, "%s: no such effect", n.where);
  }
  BASE_TRY(node_keys(&n, "var|dir|t|value|tol|reg|rel|forms|nd|note|source"));
  char var[2 * SPEC_NAME] = "";
  double t = s->duration;
  BASE_TRY(node_need(&n, "var"));
  BASE_TRY(node_need(&n, "value"));
  BASE_TRY(node_text(&n, "var", var, sizeof var));
  BASE_TRY(node_real(&n, "t", &t));
  BASE_TRY(spec_add_off(s, bit, var, t, 0.0, 0.0, 0.0, err));
  spec_check *c = &s->off[s->n_off - 1].check;
  BASE_TRY(read_direction(s, &n, c));
  BASE_TRY(node_real(&n, "value", &c->value));
  BASE_TRY(read_tolerance(&n, &c->tol));
  BASE_TRY(read_forms(&n, c));
  BASE_TRY(node_int(&n, "nd", &c->nd));
  return read_remark(&n, c);
}
