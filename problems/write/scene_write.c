#include "problems/write/scene_write.h"

#include "problems/write/scene_json.h"

#include <math.h>
#include <string.h>

#define BAD(e, ...) BASE_FAIL(e, BASE_EUNSUPPORTED, __VA_ARGS__)

/* jansson frees a value that it cannot keep, and a missing value makes the whole tree NULL only where
 * memory ran out: `whole` remembers. */
typedef struct tree {
  const scene_spec *s;
  bool whole;
} tree;

static void put(tree *t, json_t *o, const char *key, json_t *value) {
  t->whole = json_object_set_new(o, key, value) == 0 && t->whole;
}

static void add(tree *t, json_t *list, json_t *value) {
  t->whole = json_array_append_new(list, value) == 0 && t->whole;
}

static void put_real(tree *t, json_t *o, const char *key, double x) {
  put(t, o, key, json_real(x));
}

/* What the reader takes where nothing is given is left out. */
static void put_unless(tree *t, json_t *o, const char *key, double x, double usual) {
  if (x != usual) {
    put_real(t, o, key, x);
  }
}

static void put_text(tree *t, json_t *o, const char *key, const char *text) {
  if (text[0] != '\0') {
    put(t, o, key, json_string(text));
  }
}

static json_t *vector(tree *t, const double *x, int n) {
  json_t *list = json_array();
  for (int i = 0; i < n; i++) {
    add(t, list, json_real(x[i]));
  }
  return list;
}

static void put_vector(tree *t, json_t *o, const char *key, const double *x, int n) {
  put(t, o, key, vector(t, x, n));
}

static void put_moving(tree *t, json_t *o, const char *key, const double *x, int n) {
  for (int i = 0; i < n; i++) {
    if (x[i] != 0.0) {
      put_vector(t, o, key, x, n);
      return;
    }
  }
}

static json_t *names(tree *t, const spec_pair *p) {
  json_t *list = json_array();
  add(t, list, json_string(p->a));
  add(t, list, json_string(p->b));
  return list;
}

/* ---- bodies ------------------------------------------------------------------------------------ */

static json_t *shape_tree(tree *t, const spec_shape *p);

static void put_spatial(tree *t, json_t *o, const double *quat, double angle) {
  if (t->s->dim == 2) {
    put_unless(t, o, "angle", angle, 0.0);
  } else {
    put_vector(t, o, "quat", quat, 4);
  }
}

static json_t *parts_tree(tree *t, const spec_shape *p) {
  json_t *list = json_array();
  for (int i = 0; i < p->n_part; i++) {
    const spec_part *part = &p->part[i];
    json_t *o = json_object();
    put(t, o, "shape", shape_tree(t, &part->shape));
    put_vector(t, o, "pos", part->pos, t->s->dim);
    put_spatial(t, o, part->quat, 2.0 * atan2(part->quat[3], part->quat[0]));
    put_unless(t, o, "compliance", part->compliance, 0.0);
    add(t, list, o);
  }
  return list;
}

static json_t *vertices_tree(tree *t, const spec_shape *p) {
  json_t *list = json_array();
  for (int i = 0; i < p->n_vertex; i++) {
    add(t, list, vector(t, p->vertex[i], 2));
  }
  return list;
}

static json_t *shape_tree(tree *t, const spec_shape *p) {
  const int dim = t->s->dim;
  json_t *o = json_object();
  switch (p->kind) {
  case SPEC_POINT:
    put(t, o, "type", json_string("point"));
    break;
  case SPEC_SPHERE:
    put(t, o, "type", json_string(dim == 2 ? "disc" : "sphere"));
    put_real(t, o, "r", p->r);
    break;
  case SPEC_BOX:
    put(t, o, "type", json_string("box"));
    put_vector(t, o, "half", p->half, dim);
    break;
  case SPEC_ROD:
    put(t, o, "type", json_string(p->r > 0.0 ? "capsule" : "rod"));
    put_real(t, o, "half_length", p->half[0]);
    if (p->r > 0.0) {
      put_real(t, o, "r", p->r);
    }
    break;
  case SPEC_DISC3D:
    put(t, o, "type", json_string(p->half[2] > 0.0 ? "cylinder" : "disc3d"));
    put_real(t, o, "r", p->r);
    if (p->half[2] > 0.0) {
      put_real(t, o, "half_height", p->half[2]);
    }
    break;
  case SPEC_POLYGON:
    put(t, o, "type", json_string("polygon"));
    put(t, o, "vertices", vertices_tree(t, p));
    break;
  case SPEC_COMPOUND:
    put(t, o, "type", json_string("compound"));
    put(t, o, "parts", parts_tree(t, p));
    break;
  }
  return o;
}

static const char *const dof_words[] = {"x", "y", "z", "rx", "ry", "rz"};

static json_t *lock_tree(tree *t, unsigned lock) {
  json_t *list = json_array();
  for (int i = 0; i < BASE_COUNT(dof_words); i++) {
    if (lock & (1u << i)) {
      add(t, list, json_string(dof_words[i]));
    }
  }
  return list;
}

static json_t *prescribed_tree(tree *t, const spec_body *b) {
  json_t *o = json_object();
  for (int i = 0; i < BASE_COUNT(dof_words); i++) {
    if (b->prescribed & (1u << i)) {
      json_t *motion = json_object();
      put_real(t, motion, "v0", b->prescribed_v0[i]);
      put_real(t, motion, "a", b->prescribed_a[i]);
      put(t, o, dof_words[i], motion);
    }
  }
  return o;
}

static void put_spin(tree *t, json_t *o, const double *omega) {
  if (t->s->dim == 2) {
    put_unless(t, o, "omega", omega[2], 0.0);
  } else {
    put_moving(t, o, "omega", omega, 3);
  }
}

static json_t *kinematic_tree(tree *t, const spec_body *b) {
  json_t *o = json_object();
  put_vector(t, o, "vel", b->vel, t->s->dim);
  put_moving(t, o, "acc", b->acc, t->s->dim);
  put_spin(t, o, b->omega);
  return o;
}

static void put_free(tree *t, json_t *o, const spec_body *b) {
  const int dim = t->s->dim;
  put_real(t, o, "mass", b->mass);
  if (b->inertia[0] > 0.0) {
    put(t, o, "inertia", dim == 2 ? json_real(b->inertia[0]) : vector(t, b->inertia, 3));
  }
  put_moving(t, o, "vel", b->vel, dim);
  put_spin(t, o, b->omega);
}

static json_t *body_tree(tree *t, const spec_body *b) {
  json_t *o = json_object();
  put_text(t, o, "name", b->name);
  put(t, o, "shape", shape_tree(t, &b->shape));
  put_vector(t, o, "pos", b->pos, t->s->dim);
  put_spatial(t, o, b->quat, b->angle);
  if (b->kinematic) {
    put(t, o, "kinematic", kinematic_tree(t, b));
  } else {
    put_free(t, o, b);
  }
  if (b->lock) {
    put(t, o, "lock", lock_tree(t, b->lock));
  }
  if (b->prescribed) {
    put(t, o, "prescribed", prescribed_tree(t, b));
  }
  put_real(t, o, "compliance", b->compliance);
  return o;
}

static json_t *static_tree(tree *t, const spec_static *p) {
  json_t *o = json_object();
  put_text(t, o, "name", p->name);
  put_vector(t, o, "normal", p->normal, t->s->dim);
  put_real(t, o, "offset", p->offset);
  put_moving(t, o, "surface_velocity", p->surface_velocity, t->s->dim);
  put_real(t, o, "compliance", p->compliance);
  return o;
}

/* ---- loads and joints -------------------------------------------------------------------------- */

static void put_spring(tree *t, json_t *o, const spec_load *l) {
  put_real(t, o, "k", l->k);
  put_real(t, o, "c", l->c);
}

static json_t *load_tree(tree *t, const spec_load *l) {
  static const char *const words[] = {
      [SPEC_FORCE] = "constant_force",  [SPEC_FORCE_RAMP] = "force_ramp",
      [SPEC_FORCE_SINE] = "force_sine", [SPEC_SPRING] = "spring_to_moving_anchor",
      [SPEC_SPRING_PAIR] = "spring",    [SPEC_TORSION_SPRING] = "torsion_spring",
  };
  const int dim = t->s->dim;
  json_t *o = json_object();
  put(t, o, "type", json_string(words[l->kind]));
  put_text(t, o, "body", t->s->body[l->body].name);
  switch (l->kind) {
  case SPEC_FORCE:
    put_vector(t, o, "force", l->force, dim);
    put(t, o, "torque", dim == 2 ? json_real(l->torque[2]) : vector(t, l->torque, 3));
    break;
  case SPEC_FORCE_RAMP:
    put_vector(t, o, "dir", l->dir, dim);
    put_real(t, o, "rate", l->rate);
    break;
  case SPEC_FORCE_SINE:
    put_vector(t, o, "dir", l->dir, dim);
    put_real(t, o, "amplitude", l->rate);
    put_real(t, o, "omega", l->omega);
    put_real(t, o, "phase", l->phase);
    break;
  case SPEC_SPRING:
    put_spring(t, o, l);
    put_vector(t, o, "dir", l->dir, dim);
    put_vector(t, o, "anchor0", l->anchor, dim);
    put_vector(t, o, "anchor_vel", l->anchor_vel, dim);
    break;
  case SPEC_SPRING_PAIR:
    put_text(t, o, "other", t->s->body[l->other].name);
    put_spring(t, o, l);
    put_real(t, o, "rest", l->rest);
    put_vector(t, o, "offset", l->offset, dim);
    put_vector(t, o, "other_offset", l->other_offset, dim);
    break;
  case SPEC_TORSION_SPRING:
    put_spring(t, o, l);
    put_real(t, o, "rest", l->rest);
    break;
  }
  return o;
}

static json_t *joint_tree(tree *t, const spec_joint *j) {
  static const char *const words[] = {
      [SPEC_BALL] = "ball",   [SPEC_HINGE] = "hinge",       [SPEC_SLIDER] = "slider",
      [SPEC_FIXED] = "fixed", [SPEC_DISTANCE] = "distance",
  };
  const int dim = t->s->dim;
  json_t *o = json_object();
  put_text(t, o, "name", j->name);
  put(t, o, "type", json_string(words[j->kind]));
  put_text(t, o, "body", t->s->body[j->body].name);
  put_text(t, o, "other", j->other < 0 ? "world" : t->s->body[j->other].name);
  put_vector(t, o, "anchor", j->anchor, dim);
  if (j->kind == SPEC_DISTANCE) {
    put_vector(t, o, "other_anchor", j->other_anchor, dim);
  }
  put_moving(t, o, "axis", j->axis, dim);
  return o;
}

/* ---- checks ------------------------------------------------------------------------------------ */

static void put_tolerance(tree *t, json_t *o, const spec_tolerance *tol) {
  json_t *own = json_object(), *reg = json_object();
  put_unless(t, own, "abs", tol->abs, 0.0);
  put_unless(t, own, "h", tol->h, 0.0);
  put_unless(t, own, "h2", tol->h2, 0.0);
  put_unless(t, own, "inv_h", tol->inv_h, 0.0);
  put_unless(t, reg, "h", tol->reg_h, 0.0);
  put_unless(t, reg, "v", tol->reg_v, 0.0);
  put_unless(t, reg, "d", tol->reg_d, 0.0);
  put(t, o, "tol", own);
  put(t, o, "reg", reg);
  put_unless(t, o, "rel", tol->rel, 0.0);
}

/* The keys that a check shares with the answer for an effect switched off. */
static void put_answer(tree *t, json_t *o, const spec_check *c) {
  put_text(t, o, "var", c->var);
  if (c->has_dir) {
    put_vector(t, o, "dir", c->dir, t->s->dim);
  }
  put_real(t, o, "t", c->t);
  put_real(t, o, "value", c->value);
  put_tolerance(t, o, &c->tol);
  json_t *forms = json_array();
  for (int i = 0; i < c->n_form; i++) {
    add(t, forms, json_string(c->form[i]));
  }
  put(t, o, "forms", forms);
  if (c->nd > 0) {
    put(t, o, "nd", json_integer(c->nd));
  }
  put_text(t, o, "source", c->source);
}

static void put_window(tree *t, json_t *o, const spec_check *c) {
  put_real(t, o, "t0", c->t0);
  if (isfinite(c->t1)) {
    put_real(t, o, "t1", c->t1);
  }
}

static void put_pairs(tree *t, json_t *o, const spec_check *c) {
  json_t *pairs = json_array();
  for (int i = 0; i < c->n_pair; i++) {
    add(t, pairs, names(t, &c->pair[i]));
  }
  put(t, o, "pairs", pairs);
}

static json_t *check_tree(tree *t, const spec_check *c) {
  static const char *const events[] = {
      [EVENT_FIRST_CONTACT] = "first_contact",
      [EVENT_STOP] = "stop",
      [EVENT_START] = "start",
      [EVENT_LEAVE] = "leave",
      [EVENT_SIGN_CHANGE] = "sign_change",
  };
  json_t *o = json_object();
  put(t, o, "type", json_string(spec_check_name(c->kind)));
  put_answer(t, o, c);
  put_window(t, o, c);
  if (c->kind == CHECK_STATE_AFTER_STEPS) {
    put(t, o, "n", json_integer(c->n));
    put_real(t, o, "dvalue_dh", c->dvalue_dh);
  }
  if (c->n_pair > 0) {
    put_pairs(t, o, c);
  }
  if (c->tangential) {
    put(t, o, "component", json_string("tangential"));
  }
  if (c->kind == CHECK_EVENT_TIME) {
    put(t, o, "event", json_string(events[c->event]));
    put_real(t, o, "threshold", c->threshold);
  }
  return o;
}

/* Answers stand under the name of their effect, so that there is one of each. */
static base_status offs_tree(tree *t, json_t *into, base_error *err) {
  for (int i = 0; i < t->s->n_off; i++) {
    const spec_off *off = &t->s->off[i];
    int bit = 0;
    while (bit < EFFECT_COUNT && off->effect != 1u << bit) {
      bit++;
    }
    if (bit == EFFECT_COUNT || json_object_get(into, effect_name(bit)) != NULL) {
      return BAD(err, "scene '%s': if_off: a scene file holds one answer for each effect",
                 t->s->id);
    }
    json_t *o = json_object();
    put_answer(t, o, &off->check);
    put(t, into, effect_name(bit), o);
  }
  return BASE_OK;
}

/* ---- the scene --------------------------------------------------------------------------------- */

static json_t *coefficient_tree(tree *t, const spec_coefficient *c) {
  json_t *o = json_object();
  put_real(t, o, "default", c->dflt);
  json_t *pairs = json_array();
  for (int i = 0; i < c->n_pair; i++) {
    json_t *pair = names(t, &c->pair[i]);
    add(t, pair, json_real(c->pair[i].value));
    add(t, pairs, pair);
  }
  put(t, o, "pairs", pairs);
  return o;
}

static void put_coefficients(tree *t, json_t *o) {
  put(t, o, "friction", coefficient_tree(t, &t->s->friction));
  if (t->s->friction_kinetic.dflt >= 0.0 || t->s->friction_kinetic.n_pair > 0) {
    put(t, o, "friction_kinetic", coefficient_tree(t, &t->s->friction_kinetic));
  }
  put(t, o, "restitution", coefficient_tree(t, &t->s->restitution));
  put(t, o, "rolling", coefficient_tree(t, &t->s->rolling));
  put(t, o, "torsion", coefficient_tree(t, &t->s->torsion));
}

static void put_head(tree *t, json_t *o) {
  const scene_spec *s = t->s;
  put_text(t, o, "id", s->id);
  put_text(t, o, "title", s->title);
  put_text(t, o, "formula", s->formula);
  put_text(t, o, "note", s->note);
  put(t, o, "dim", json_integer(s->dim));
  put_real(t, o, "T", s->duration);
  put_vector(t, o, "hs", s->h, s->n_h);
  put_vector(t, o, "gravity", s->gravity, s->dim);
  if (s->facets > 0) {
    put(t, o, "nd", json_integer(s->facets));
  }
  put(t, o, "order", json_integer(s->order));
  put(t, o, "long", json_boolean(s->is_long));
  put(t, o, "contact_multiplicity", json_integer(s->contact_multiplicity));
  if (s->expect_unsolved) {
    put(t, o, "expect_status", json_string("infeasible_or_unsolved"));
  }
  json_t *needs = json_array();
  for (int bit = 0; bit < EFFECT_COUNT; bit++) {
    if (s->effects & (1u << bit)) {
      add(t, needs, json_string(effect_name(bit)));
    }
  }
  put(t, o, "needs", needs);
}

static void put_lists(tree *t, json_t *o) {
  const scene_spec *s = t->s;
  json_t *bodies = json_array(), *planes = json_array(), *loads = json_array();
  json_t *joints = json_array(), *apart = json_array();
  for (int i = 0; i < s->n_body; i++) {
    add(t, bodies, body_tree(t, &s->body[i]));
  }
  for (int i = 0; i < s->n_static; i++) {
    add(t, planes, static_tree(t, &s->fixed[i]));
  }
  for (int i = 0; i < s->n_load; i++) {
    add(t, loads, load_tree(t, &s->load[i]));
  }
  for (int i = 0; i < s->n_joint; i++) {
    add(t, joints, joint_tree(t, &s->joint[i]));
  }
  for (int i = 0; i < s->n_no_collision; i++) {
    add(t, apart, names(t, &s->no_collision[i]));
  }
  put(t, o, "bodies", bodies);
  put(t, o, "static", planes);
  put(t, o, "loads", loads);
  put(t, o, "joints", joints);
  put(t, o, "no_collision", apart);
}

static void put_expected(tree *t, json_t *o) {
  const scene_spec *s = t->s;
  json_t *observe = json_array(), *checks = json_array(), *not_for = json_array();
  for (int i = 0; i < s->n_observe; i++) {
    add(t, observe, json_string(s->observe[i]));
  }
  for (int i = 0; i < s->n_check; i++) {
    add(t, checks, check_tree(t, &s->check[i]));
  }
  for (int i = 0; i < s->n_not_applicable; i++) {
    add(t, not_for, json_string(s->not_applicable[i]));
  }
  put(t, o, "not_applicable", not_for);
  put(t, o, "observe", observe);
  put(t, o, "checks", checks);
}

base_status scene_write(FILE *to, const scene_spec *s, base_error *err) {
  if (s->model != NULL || s->contact_stiffness > 0.0) {
    return BAD(err, "scene '%s': a scene file holds no %s", s->id,
               s->model != NULL ? "mechanism in generalised coordinates" : "compliant contact");
  }
  tree t = {s, true};
  json_t *o = json_object(), *offs = json_object();
  put_head(&t, o);
  put_lists(&t, o);
  put_coefficients(&t, o);
  put_expected(&t, o);
  base_status done = offs_tree(&t, offs, err);
  put(&t, o, "if_off", offs);
  if (done == BASE_OK && !t.whole) {
    done = BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory to write it", s->id);
  }
  if (done == BASE_OK) {
    scene_json_print(to, o);
    done =
        ferror(to) ? BASE_FAIL(err, BASE_EIO, "scene '%s': could not be written", s->id) : BASE_OK;
  }
  json_decref(o);
  return done;
}
