/* One scene of the case format. */
#include "problems/read/read_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

typedef base_status (*read_item)(scene_spec *s, json_t *v, int index, base_error *err);

static base_status read_items(scene_spec *s, const node *n, const char *key, int max,
                              read_item read) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, key, max, &list, &count));
  for (int i = 0; i < count; i++) {
    BASE_TRY(read(s, json_array_get(list, (size_t)i), i, n->err));
  }
  return BASE_OK;
}

typedef base_status (*read_tie)(scene_spec *s, const name_index *names, json_t *v, int index,
                                base_error *err);

static base_status read_tied(scene_spec *s, const name_index *names, const node *n, const char *key,
                             read_tie read) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, key, READ_ITEMS, &list, &count));
  for (int i = 0; i < count; i++) {
    BASE_TRY(read(s, names, json_array_get(list, (size_t)i), i, n->err));
  }
  return BASE_OK;
}

/* What acts on bodies, by their names. */
static base_status read_ties(scene_spec *s, const node *n) {
  name_index names;
  BASE_TRY(name_index_open(&names, s, n->err));
  base_status status = read_tied(s, &names, n, "loads", read_load);
  if (status == BASE_OK) {
    status = read_tied(s, &names, n, "joints", read_joint);
  }
  name_index_close(&names);
  return status;
}

static base_status read_coefficient(const node *n, const char *key, spec_coefficient *c) {
  json_t *v = json_object_get(n->v, key), *list;
  if (v == NULL) {
    return BASE_OK;
  }
  node o;
  int count;
  BASE_TRY(node_open(&o, v, n->err, "%s: %s", n->where, key));
  BASE_TRY(node_keys(&o, "default|pairs"));
  BASE_TRY(node_real(&o, "default", &c->dflt));
  BASE_TRY(node_list(&o, "pairs", READ_ITEMS, &list, &count));
  for (int i = 0; i < count; i++) {
    const json_t *p = json_array_get(list, (size_t)i);
    char a[SPEC_NAME], b[SPEC_NAME];
    double value = 0.0;
    if (!json_is_array(p) || json_array_size(p) != 3) {
      return BAD(&o, "%s: pair %d: need two names and a number", o.where, i + 1);
    }
    BASE_TRY(node_string(&o, json_array_get(p, 0), "pairs", a, sizeof a));
    BASE_TRY(node_string(&o, json_array_get(p, 1), "pairs", b, sizeof b));
    BASE_TRY(node_number(&o, json_array_get(p, 2), "pairs", &value));
    BASE_TRY(spec_add_pair(c, a, b, value, n->err));
  }
  return BASE_OK;
}

static base_status read_no_collision(scene_spec *s, json_t *v, int index, base_error *err) {
  node n = {v, "", err};
  char a[SPEC_NAME], b[SPEC_NAME];
  (void)index;
  memcpy(n.where, "no_collision", sizeof "no_collision");
  BASE_TRY(read_pair_names(&n, v, "pair", a, b));
  return spec_add_no_collision(s, a, b, err);
}

/* Words of `needs`; the dimension follows from `dim`. An empty list declares, too. */
static base_status read_needs(scene_spec *s, const node *n) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "needs", EFFECT_COUNT, &list, &count));
  s->declares = list != NULL;
  for (int i = 0; i < count; i++) {
    char word[32];
    unsigned bit = 0;
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "needs", word, sizeof word));
    const bool dimension = strcmp(word, "third_dimension") == 0;
    for (int k = 0; k < EFFECT_COUNT; k++) {
      bit |= (strcmp(effect_name(k), word) == 0) ? 1u << k : 0u;
    }
    if (bit == 0 && !dimension) {
      return BAD(n, "%s: needs '%s': no such effect", n->where, word);
    }
    s->effects |= bit;
  }
  return BASE_OK;
}

static bool is_angular(const char *var) {
  const char *dot = strchr(var, '.');
  return dot != NULL && (strncmp(dot + 1, "angle", 5) == 0 || strncmp(dot + 1, "omega", 5) == 0);
}

/* What spins at the start, or is observed to turn, calls for rotation whether `needs` says so or
 * not. */
static void add_rotation(scene_spec *s) {
  bool turns = false;
  for (int i = 0; i < s->n_body; i++) {
    const double *w = s->body[i].omega;
    turns = turns || (!s->body[i].kinematic && (w[0] != 0.0 || w[1] != 0.0 || w[2] != 0.0));
  }
  for (int i = 0; i < s->n_check; i++) {
    turns = turns || is_angular(s->check[i].var);
  }
  for (int i = 0; i < s->n_observe; i++) {
    turns = turns || is_angular(s->observe[i]);
  }
  if (turns && (s->declares || s->effects != 0)) {
    s->effects |= EFFECT_ROTATION;
  }
}

static base_status read_steps(scene_spec *s, const node *n) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "hs", SPEC_STEPS, &list, &count));
  for (int i = 0; i < count; i++) {
    BASE_TRY(node_number(n, json_array_get(list, (size_t)i), "hs", &s->h[i]));
  }
  s->n_h = (list != NULL) ? count : s->n_h;
  return BASE_OK;
}

static base_status read_not_applicable(scene_spec *s, const node *n) {
  json_t *list;
  BASE_TRY(node_list(n, "not_applicable", SPEC_FORMS, &list, &s->n_not_applicable));
  for (int i = 0; i < s->n_not_applicable; i++) {
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "not_applicable", s->not_applicable[i],
                         SPEC_NAME));
  }
  return BASE_OK;
}

static base_status read_observed(scene_spec *s, const node *n) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "observe", SPEC_OBSERVE, &list, &count));
  for (int i = 0; i < count; i++) {
    char var[2 * SPEC_NAME];
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "observe", var, sizeof var));
    BASE_TRY(spec_add_observe(s, var, n->err));
  }
  return BASE_OK;
}

static base_status read_acceleration(scene_spec *s, const node *n) {
  json_t *v = json_object_get(n->v, "acceleration_level");
  if (v == NULL) {
    return BASE_OK;
  }
  node a;
  BASE_TRY(node_open(&a, v, n->err, "%s: acceleration_level", n->where));
  BASE_TRY(node_keys(&a, "p|b|regime|mu_crit"));
  s->acceleration.given = true;
  BASE_TRY(node_real(&a, "p", &s->acceleration.p));
  BASE_TRY(node_real(&a, "b", &s->acceleration.b));
  BASE_TRY(node_real(&a, "mu_crit", &s->acceleration.mu_crit));
  return node_text(&a, "regime", s->acceleration.regime, sizeof s->acceleration.regime);
}

static base_status read_iterative(scene_spec *s, const node *n) {
  json_t *v = json_object_get(n->v, "iterative");
  if (v == NULL) {
    return BASE_OK;
  }
  node i;
  BASE_TRY(node_open(&i, v, n->err, "%s: iterative", n->where));
  BASE_TRY(node_keys(&i, "method|rho|value|sweeps_to_1e6|pass_"));
  BASE_TRY(node_real(&i, "value", &s->sweep_rate));
  return node_real(&i, "sweeps_to_1e6", &s->sweeps_to_1e6);
}

/* Where the isotropic cone ends up instead of the faceted one: checks for `coulomb`, within the
 * tolerance of the faceted check of the same quantity. */
static base_status read_isotropic(scene_spec *s, const node *n) {
  json_t *v = json_object_get(n->v, "isotropic");
  if (v == NULL) {
    return BASE_OK;
  }
  node o;
  BASE_TRY(node_open(&o, v, n->err, "%s: isotropic", n->where));
  BASE_TRY(node_keys(&o, "x|y|z"));
  static const char *const words[] = {"x", "y", "z"};
  for (int i = 0; i < BASE_COUNT(words); i++) {
    if (!node_has(&o, words[i])) {
      continue;
    }
    char var[2 * SPEC_NAME];
    spec_tolerance tol = {0};
    (void)snprintf(var, sizeof var, "%s.%s", s->n_body > 0 ? s->body[0].name : "", words[i]);
    for (int k = 0; k < s->n_check; k++) {
      tol = (strcmp(s->check[k].var, var) == 0 && s->check[k].kind == CHECK_STATE) ? s->check[k].tol
                                                                                   : tol;
    }
    spec_check *c;
    BASE_TRY(spec_add_check(s, CHECK_STATE, var, &c, n->err));
    c->t = s->duration;
    c->tol = tol;
    BASE_TRY(node_real(&o, words[i], &c->value));
    BASE_TRY(spec_check_only(c, "coulomb", n->err));
  }
  return BASE_OK;
}

static base_status read_offs(scene_spec *s, const node *n) {
  json_t *v = json_object_get(n->v, "if_off");
  if (v == NULL) {
    return BASE_OK;
  }
  if (!json_is_object(v)) {
    return BAD(n, "%s: if_off: need an object", n->where);
  }
  const char *name;
  json_t *item;
  json_object_foreach(v, name, item) {
    BASE_TRY(read_off(s, name, item, n->err));
  }
  return BASE_OK;
}

/* Scalar compliant contact at rest (MATHEMATICS S17): mass m on a floor of stiffness k,
 * long enough for the implicit Euler factor 1/sqrt(1 + k h^2/m) a step to reach 1e-8. */
static base_status read_compliant(scene_spec *s, const node *n) {
  node p;
  double k = 0.0, m = 0.0, h = 0.0, g = 0.0, kappa = 0.0;
  BASE_TRY(node_need(n, "params"));
  BASE_TRY(node_open(&p, json_object_get(n->v, "params"), n->err, "%s: params", n->where));
  BASE_TRY(node_keys(&p, "k|m|h|g|kappa"));
  BASE_TRY(node_real(&p, "k", &k));
  BASE_TRY(node_real(&p, "m", &m));
  BASE_TRY(node_real(&p, "h", &h));
  BASE_TRY(node_real(&p, "g", &g));
  BASE_TRY(node_real(&p, "kappa", &kappa));
  if (!(k > 0.0) || !(m > 0.0) || !(h > 0.0)) {
    return BAD(&p, "%s: k, m and h must be positive", p.where);
  }
  const double up[2] = {0.0, 1.0};
  spec_body *b;
  s->gravity[1] = -g;
  s->friction.dflt = 0.5;
  s->contact_stiffness = k;
  s->effects |= EFFECT_CONTACT;
  s->duration = h * ceil(fmax(100.0, 2.0 * log(1e8) / log1p(k * h * h / m)));
  BASE_TRY(spec_add_body(s, "mass", &b, n->err));
  b->mass = m;
  b->lock = SPEC_RZ;
  return spec_add_static(s, "floor", up, 0.0, NULL, n->err);
}

static const char scene_keys[] =
    "id|title|dim|gravity|gravity_off|bodies|static|friction|friction_kinetic|restitution|rolling|"
    "torsion|loads|joints|no_collision|contact_multiplicity|T|hs|nd|order|needs|observe|checks|"
    "if_off|not_applicable|expect_status|formula|note|source|isotropic|acceleration_level|"
    "iterative|equal_to|long|kind|params";

static base_status read_head(scene_spec *s, const node *n) {
  char expect[32] = "";
  int kind = -1;
  bool gravity_off = false;
  BASE_TRY(node_text(n, "title", s->title, sizeof s->title));
  BASE_TRY(node_text(n, "formula", s->formula, sizeof s->formula));
  BASE_TRY(node_text(n, "note", s->note, sizeof s->note));
  BASE_TRY(node_text(n, "source", s->note, sizeof s->note));
  BASE_TRY(node_choice(n, "kind", "compliant_contact", &kind));
  if (kind < 0) {
    BASE_TRY(node_need(n, "dim"));
    BASE_TRY(node_need(n, "T"));
  }
  BASE_TRY(node_int(n, "dim", &s->dim));
  if (s->dim != 2 && s->dim != 3) {
    return BAD(n, "%s: dim = %d, need 2 or 3", n->where, s->dim);
  }
  BASE_TRY(node_real(n, "T", &s->duration));
  BASE_TRY(node_vector(n, "gravity", s->dim, s->gravity));
  BASE_TRY(node_bool(n, "gravity_off", &gravity_off));
  if (gravity_off) {
    memset(s->gravity, 0, sizeof s->gravity);
  }
  BASE_TRY(read_steps(s, n));
  BASE_TRY(node_int(n, "nd", &s->facets));
  BASE_TRY(node_int(n, "order", &s->order));
  BASE_TRY(node_bool(n, "long", &s->is_long));
  BASE_TRY(node_int(n, "contact_multiplicity", &s->contact_multiplicity));
  BASE_TRY(node_text(n, "expect_status", expect, sizeof expect));
  s->expect_unsolved = strcmp(expect, "infeasible_or_unsolved") == 0;
  if (expect[0] != '\0' && !s->expect_unsolved) {
    return BAD(n, "%s: expect_status '%s': need infeasible_or_unsolved", n->where, expect);
  }
  return (kind < 0) ? BASE_OK : read_compliant(s, n);
}

base_status read_scene(json_t *v, scene_spec *s, base_error *err) {
  node n;
  spec_init(s);
  BASE_TRY(node_open(&n, v, err, "scene"));
  BASE_TRY(node_need(&n, "id"));
  BASE_TRY(node_text(&n, "id", s->id, sizeof s->id));
  BASE_TRY(node_open(&n, v, err, "scene '%s'", s->id));
  BASE_TRY(node_keys(&n, scene_keys));
  BASE_TRY(read_head(s, &n));
  BASE_TRY(read_needs(s, &n));
  BASE_TRY(read_items(s, &n, "bodies", READ_BODIES, read_body));
  BASE_TRY(read_items(s, &n, "static", READ_ITEMS, read_static));
  BASE_TRY(read_coefficient(&n, "friction", &s->friction));
  BASE_TRY(read_coefficient(&n, "friction_kinetic", &s->friction_kinetic));
  BASE_TRY(read_coefficient(&n, "restitution", &s->restitution));
  BASE_TRY(read_coefficient(&n, "rolling", &s->rolling));
  BASE_TRY(read_coefficient(&n, "torsion", &s->torsion));
  BASE_TRY(read_ties(s, &n));
  BASE_TRY(read_items(s, &n, "no_collision", READ_ITEMS, read_no_collision));
  BASE_TRY(read_not_applicable(s, &n));
  BASE_TRY(read_observed(s, &n));
  BASE_TRY(read_items(s, &n, "checks", READ_ITEMS, read_check));
  BASE_TRY(read_offs(s, &n));
  BASE_TRY(read_isotropic(s, &n));
  BASE_TRY(read_acceleration(s, &n));
  BASE_TRY(read_iterative(s, &n));
  add_rotation(s);
  return BASE_OK;
}
