/* Loads and joints of the case format. */
#include "problems/read/read_scene.h"

#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

/* Index of the body named under key; `world` is -1 where that is allowed. */
static base_status read_body_name(const scene_spec *s, const name_index *names, const node *n,
                                  const char *key, bool world_allowed, int *out) {
  char name[SPEC_NAME];
  if (!node_has(n, key) && world_allowed) {
    *out = -1;
    return BASE_OK;
  }
  BASE_TRY(node_need(n, key));
  BASE_TRY(node_text(n, key, name, sizeof name));
  const int side = name_index_find(names, name);
  *out = (side < s->n_body) ? side : -1;
  if (*out < 0 && !(world_allowed && strcmp(name, "world") == 0)) {
    return BAD(n, "%s: no body named '%s'", n->where, name);
  }
  return BASE_OK;
}

typedef struct load_row {
  spec_load_kind kind;
  const char *keys;
  const char *force[2]; /* without any of them there is no force */
} load_row;

static const char load_types[] = "constant_force|force_ramp|force_sine|spring_to_moving_anchor|"
                                 "spring|torsion_spring";
static const load_row load_rows[] = {
    {SPEC_FORCE, "body|type|force|torque", {"force", "torque"}},
    {SPEC_FORCE_RAMP, "body|type|dir|rate", {"rate"}},
    {SPEC_FORCE_SINE, "body|type|dir|amplitude|omega|phase", {"amplitude"}},
    {SPEC_SPRING, "body|type|k|c|dir|anchor0|anchor_vel", {"k", "c"}},
    {SPEC_SPRING_PAIR, "body|type|other|k|c|rest|offset|other_offset", {"k", "c"}},
    {SPEC_TORSION_SPRING, "body|type|k|c|rest", {"k", "c"}},
};

static base_status need_force(const node *n, const load_row *row) {
  const char *other = row->force[1];
  if (other == NULL || node_has(n, row->force[0])) {
    return node_need(n, row->force[0]);
  }
  return node_has(n, other) ? BASE_OK
                            : BAD(n, "%s: needs '%s' or '%s'", n->where, row->force[0], other);
}

base_status read_load(scene_spec *s, const name_index *names, json_t *v, int index,
                      base_error *err) {
  node n;
  int type = 0;
  BASE_TRY(node_open(&n, v, err, "scene '%s': load %d", s->id, index + 1));
  BASE_TRY(node_need(&n, "type"));
  BASE_TRY(node_choice(&n, "type", load_types, &type));
  BASE_TRY(node_keys(&n, load_rows[type].keys));
  spec_load *l;
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = load_rows[type].kind;
  BASE_TRY(read_body_name(s, names, &n, "body", false, &l->body));
  if (l->kind == SPEC_SPRING_PAIR) {
    BASE_TRY(read_body_name(s, names, &n, "other", false, &l->other));
  }
  BASE_TRY(need_force(&n, &load_rows[type]));
  BASE_TRY(node_vector(&n, "force", s->dim, l->force));
  BASE_TRY(s->dim == 2 ? node_real(&n, "torque", &l->torque[2])
                       : node_vector(&n, "torque", 3, l->torque));
  const json_t *dir = json_object_get(v, "dir");
  /* a planar direction may come with a third component that must then be zero */
  BASE_TRY(node_vector(&n, "dir", json_array_size(dir) == 3 ? 3 : s->dim, l->dir));
  if (s->dim == 2 && l->dir[2] != 0.0) {
    return BAD(&n, "%s: dir leaves the plane", n.where);
  }
  BASE_TRY(node_real(&n, "rate", &l->rate));
  BASE_TRY(node_real(&n, "amplitude", &l->rate));
  BASE_TRY(node_real(&n, "omega", &l->omega));
  BASE_TRY(node_real(&n, "phase", &l->phase));
  BASE_TRY(node_real(&n, "k", &l->k));
  BASE_TRY(node_real(&n, "c", &l->c));
  BASE_TRY(node_real(&n, "rest", &l->rest));
  BASE_TRY(node_vector(&n, "anchor0", s->dim, l->anchor));
  BASE_TRY(node_vector(&n, "anchor_vel", s->dim, l->anchor_vel));
  BASE_TRY(node_vector(&n, "offset", s->dim, l->offset));
  return node_vector(&n, "other_offset", s->dim, l->other_offset);
}

base_status read_joint(scene_spec *s, const name_index *names, json_t *v, int index,
                       base_error *err) {
  node n;
  int type = 0;
  BASE_TRY(node_open(&n, v, err, "scene '%s': joint %d", s->id, index + 1));
  BASE_TRY(node_keys(&n, "name|type|body|other|anchor|other_anchor|axis"));
  BASE_TRY(node_need(&n, "type"));
  BASE_TRY(node_need(&n, "anchor"));
  BASE_TRY(node_choice(&n, "type", "ball|hinge|slider|fixed|distance", &type));
  char name[SPEC_NAME] = "";
  BASE_TRY(node_text(&n, "name", name, sizeof name));
  spec_joint *j;
  BASE_TRY(spec_add_joint(s, name, &j, err));
  static const spec_joint_kind kinds[] = {SPEC_BALL, SPEC_HINGE, SPEC_SLIDER, SPEC_FIXED,
                                          SPEC_DISTANCE};
  j->kind = kinds[type];
  if (j->kind != SPEC_DISTANCE && node_has(&n, "other_anchor")) {
    return BAD(&n, "%s: 'other_anchor' is for a distance alone", n.where);
  }
  BASE_TRY(read_body_name(s, names, &n, "body", false, &j->body));
  BASE_TRY(read_body_name(s, names, &n, "other", true, &j->other));
  BASE_TRY(node_vector(&n, "anchor", s->dim, j->anchor));
  BASE_TRY(node_vector(&n, "other_anchor", s->dim, j->other_anchor));
  return node_vector(&n, "axis", s->dim, j->axis);
}
