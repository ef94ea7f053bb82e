/* Bodies, shapes and fixed half-spaces of the case format. */
#include "problems/read/read_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

/* ---- shapes --------------------------------------------------------------------------------- */

static base_status read_shape(const scene_spec *s, const char *owner, json_t *v, spec_shape *p,
                              base_error *err);

static base_status read_vertices(const node *n, spec_shape *p) {
  json_t *list;
  int count;
  BASE_TRY(node_need(n, "vertices"));
  BASE_TRY(node_list(n, "vertices", SPEC_VERTICES, &list, &count));
  BASE_TRY(spec_shape_vertices(p, count, n->err));
  for (int i = 0; i < p->n_vertex; i++) {
    const json_t *pair = json_array_get(list, (size_t)i);
    if (!json_is_array(pair) || json_array_size(pair) != 2) {
      return BAD(n, "%s: vertex %d: need two numbers", n->where, i + 1);
    }
    BASE_TRY(node_number(n, json_array_get(pair, 0), "vertices", &p->vertex[i][0]));
    BASE_TRY(node_number(n, json_array_get(pair, 1), "vertices", &p->vertex[i][1]));
  }
  return BASE_OK;
}

static base_status read_pose(const scene_spec *s, const node *n, double *pos, double *quat,
                             double *angle) {
  BASE_TRY(node_vector(n, "pos", s->dim, pos));
  if (s->dim == 2) {
    return node_real(n, "angle", angle);
  }
  return node_vector(n, "quat", 4, quat);
}

/* A body or a part that is given one has some: 0 would stand for what is not given. */
static base_status read_compliance(const node *n, double *compliance) {
  BASE_TRY(node_real(n, "compliance", compliance));
  if (node_has(n, "compliance") && !(*compliance > 0.0)) {
    return BAD(n, "%s: compliance = %g, need > 0", n->where, *compliance);
  }
  return BASE_OK;
}

static base_status read_parts(const scene_spec *s, const char *owner, const node *n,
                              spec_shape *p) {
  json_t *list;
  int count;
  BASE_TRY(node_need(n, "parts"));
  BASE_TRY(node_list(n, "parts", SPEC_PARTS, &list, &count));
  p->part = calloc((size_t)count + 1, sizeof *p->part);
  if (p->part == NULL) {
    return BASE_FAIL(n->err, BASE_ENOMEM, "%s: no memory for %d parts", n->where, count);
  }
  for (int i = 0; i < count; i++) {
    node part;
    spec_part *to = &p->part[i];
    double angle = 0.0;
    to->quat[0] = 1.0;
    BASE_TRY(
        node_open(&part, json_array_get(list, (size_t)i), n->err, "%s: part %d", n->where, i + 1));
    BASE_TRY(
        node_keys(&part, s->dim == 2 ? "shape|pos|angle|compliance" : "shape|pos|quat|compliance"));
    BASE_TRY(node_need(&part, "shape"));
    BASE_TRY(read_pose(s, &part, to->pos, to->quat, &angle));
    BASE_TRY(read_compliance(&part, &to->compliance));
    if (s->dim == 2) {
      to->quat[0] = cos(angle / 2.0);
      to->quat[3] = sin(angle / 2.0);
    }
    json_t *shape = json_object_get(part.v, "shape");
    node kind; /* a compound inside would own memory that nobody frees */
    BASE_TRY(node_open(&kind, shape, n->err, "%s: shape", part.where));
    char type[32] = "";
    BASE_TRY(node_text(&kind, "type", type, sizeof type));
    if (strcmp(type, "compound") == 0) {
      return BAD(n, "%s: a compound inside a compound", part.where);
    }
    p->n_part = i + 1; /* the scene owns what has been read of it, also where the rest fails */
    BASE_TRY(read_shape(s, owner, shape, &to->shape, n->err));
  }
  return BASE_OK;
}

enum {
  T_POINT,
  T_DISC,
  T_SPHERE,
  T_BOX,
  T_ROD,
  T_CAPSULE,
  T_DISC3D,
  T_CYLINDER,
  T_POLYGON,
  T_COMPOUND
};
static const char types[] = "point|disc|sphere|box|rod|capsule|disc3d|cylinder|polygon|compound";

typedef struct shape_row {
  spec_shape_kind kind;
  int dim; /* 0: both */
  const char *keys;
} shape_row;

static const shape_row rows[] = {
    [T_POINT] = {SPEC_POINT, 0, "type"},
    [T_DISC] = {SPEC_SPHERE, 2, "type|r"},
    [T_SPHERE] = {SPEC_SPHERE, 3, "type|r"},
    [T_BOX] = {SPEC_BOX, 0, "type|half"},
    [T_ROD] = {SPEC_ROD, 0, "type|half_length"},
    [T_CAPSULE] = {SPEC_ROD, 0, "type|half_length|r"},
    [T_DISC3D] = {SPEC_DISC3D, 3, "type|r"},
    [T_CYLINDER] = {SPEC_DISC3D, 3, "type|r|half_height"},
    [T_POLYGON] = {SPEC_POLYGON, 2, "type|vertices"},
    [T_COMPOUND] = {SPEC_COMPOUND, 0, "type|parts"},
};

static base_status read_shape(const scene_spec *s, const char *owner, json_t *v, spec_shape *p,
                              base_error *err) {
  node n;
  int type = 0;
  BASE_TRY(node_open(&n, v, err, "%s: shape", owner));
  BASE_TRY(node_need(&n, "type"));
  BASE_TRY(node_choice(&n, "type", types, &type));
  const shape_row *row = &rows[type];
  if (row->dim != 0 && row->dim != s->dim) {
    return BAD(&n, "%s: a %s is for dim %d, the scene has %d", n.where,
               json_string_value(json_object_get(v, "type")), row->dim, s->dim);
  }
  BASE_TRY(node_keys(&n, row->keys));
  p->kind = row->kind;
  BASE_TRY(node_real(&n, "r", &p->r));
  BASE_TRY(node_vector(&n, "half", s->dim, p->half));
  BASE_TRY(node_real(&n, "half_length", &p->half[0]));
  BASE_TRY(node_real(&n, "half_height", &p->half[2]));
  if (type == T_POLYGON) {
    return read_vertices(&n, p);
  }
  return (type == T_COMPOUND) ? read_parts(s, owner, &n, p) : BASE_OK;
}

/* ---- bodies --------------------------------------------------------------------------------- */

static const char *const dof_words[] = {"x", "y", "z", "rx", "ry", "rz"};

/* "x" .. "rz", or "rot" for every rotation of the dimension; 0 if unknown. */
static unsigned dof_bit(const scene_spec *s, const char *word) {
  if (strcmp(word, "rot") == 0) {
    return (s->dim == 2) ? SPEC_RZ : SPEC_ROT;
  }
  for (int i = 0; i < BASE_COUNT(dof_words); i++) {
    if (strcmp(word, dof_words[i]) == 0) {
      return 1u << i;
    }
  }
  return 0;
}

static base_status read_lock(const scene_spec *s, const node *n, spec_body *b) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "lock", 6, &list, &count));
  for (int i = 0; i < count; i++) {
    char word[16];
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "lock", word, sizeof word));
    const unsigned bit = dof_bit(s, word);
    if (bit == 0) {
      return BAD(n, "%s: lock '%s': need x, y, z, rx, ry, rz or rot", n->where, word);
    }
    b->lock |= bit;
  }
  return BASE_OK;
}

static base_status read_prescribed(const node *n, spec_body *b) {
  json_t *v = json_object_get(n->v, "prescribed");
  if (v == NULL) {
    return BASE_OK;
  }
  node p;
  BASE_TRY(node_open(&p, v, n->err, "%s: prescribed", n->where));
  BASE_TRY(node_keys(&p, "x|y|z|rx|ry|rz"));
  for (int i = 0; i < BASE_COUNT(dof_words); i++) {
    json_t *motion = json_object_get(v, dof_words[i]);
    if (motion == NULL) {
      continue;
    }
    node m;
    BASE_TRY(node_open(&m, motion, n->err, "%s: %s", p.where, dof_words[i]));
    BASE_TRY(node_keys(&m, "v0|a"));
    BASE_TRY(node_real(&m, "v0", &b->prescribed_v0[i]));
    BASE_TRY(node_real(&m, "a", &b->prescribed_a[i]));
    b->prescribed |= 1u << i;
  }
  return BASE_OK;
}

static base_status read_spin(const scene_spec *s, const node *n, double *omega) {
  return (s->dim == 2) ? node_real(n, "omega", &omega[2]) : node_vector(n, "omega", 3, omega);
}

static base_status read_kinematic(const scene_spec *s, const node *n, spec_body *b) {
  json_t *v = json_object_get(n->v, "kinematic");
  if (v == NULL) {
    return BASE_OK;
  }
  node k;
  BASE_TRY(node_open(&k, v, n->err, "%s: kinematic", n->where));
  BASE_TRY(node_keys(&k, "vel|acc|omega"));
  if (node_has(n, "vel") || node_has(n, "omega")) {
    return BAD(n, "%s: '%s' beside kinematic: need it inside", n->where,
               node_has(n, "vel") ? "vel" : "omega");
  }
  b->kinematic = true;
  BASE_TRY(node_vector(&k, "vel", s->dim, b->vel));
  BASE_TRY(node_vector(&k, "acc", s->dim, b->acc));
  return read_spin(s, &k, b->omega);
}

/* Given, or that of the homogeneous solid; a point without inertia does not rotate. */
static base_status read_inertia(const scene_spec *s, const node *n, spec_body *b) {
  if (node_has(n, "inertia")) {
    return (s->dim == 2) ? node_real(n, "inertia", b->inertia)
                         : node_vector(n, "inertia", 3, b->inertia);
  }
  if (b->shape.kind == SPEC_POINT) {
    b->lock |= (s->dim == 2) ? SPEC_RZ : SPEC_ROT;
    return BASE_OK;
  }
  if (b->kinematic) {
    return BASE_OK;
  }
  base_error inner = {0};
  const base_status status = spec_solid_inertia(&b->shape, s->dim, b->mass, b->inertia, &inner);
  return (status == BASE_OK) ? BASE_OK : BASE_FAIL(n->err, status, "%s: %s", n->where, inner.text);
}

base_status read_body(scene_spec *s, json_t *v, int index, base_error *err) {
  node n;
  BASE_TRY(node_open(&n, v, err, "scene '%s': body %d", s->id, index + 1));
  char name[SPEC_NAME];
  BASE_TRY(node_need(&n, "name"));
  BASE_TRY(node_text(&n, "name", name, sizeof name));
  BASE_TRY(node_open(&n, v, err, "scene '%s': body '%s'", s->id, name));
  BASE_TRY(node_keys(&n, s->dim == 2 ? "name|shape|mass|inertia|pos|angle|vel|omega|lock|"
                                       "prescribed|kinematic|compliance"
                                     : "name|shape|mass|inertia|pos|quat|vel|omega|lock|"
                                       "prescribed|kinematic|compliance"));
  BASE_TRY(node_need(&n, "shape"));
  BASE_TRY(node_need(&n, "pos"));
  spec_body *b;
  BASE_TRY(spec_add_body(s, name, &b, err));
  BASE_TRY(read_pose(s, &n, b->pos, b->quat, &b->angle));
  BASE_TRY(read_shape(s, n.where, json_object_get(v, "shape"), &b->shape, err));
  BASE_TRY(node_vector(&n, "vel", s->dim, b->vel));
  BASE_TRY(read_spin(s, &n, b->omega));
  BASE_TRY(read_lock(s, &n, b));
  BASE_TRY(read_prescribed(&n, b));
  BASE_TRY(read_kinematic(s, &n, b));
  BASE_TRY(read_compliance(&n, &b->compliance));
  if (b->kinematic) {
    b->mass = 1.0; /* plays no part */
  } else {
    BASE_TRY(node_need(&n, "mass"));
  }
  BASE_TRY(node_real(&n, "mass", &b->mass));
  return read_inertia(s, &n, b);
}

base_status read_static(scene_spec *s, json_t *v, int index, base_error *err) {
  node n;
  BASE_TRY(node_open(&n, v, err, "scene '%s': static %d", s->id, index + 1));
  BASE_TRY(node_keys(&n, "name|type|normal|offset|surface_velocity|compliance"));
  BASE_TRY(node_need(&n, "name"));
  BASE_TRY(node_need(&n, "normal"));
  char name[SPEC_NAME];
  int type = 0;
  double normal[3] = {0.0}, offset = 0.0;
  BASE_TRY(node_text(&n, "name", name, sizeof name));
  BASE_TRY(node_choice(&n, "type", "plane", &type));
  BASE_TRY(node_vector(&n, "normal", s->dim, normal));
  BASE_TRY(node_real(&n, "offset", &offset));
  spec_static *p;
  BASE_TRY(spec_add_static(s, name, normal, offset, &p, err));
  BASE_TRY(node_real(&n, "compliance", &p->compliance));
  return node_vector(&n, "surface_velocity", s->dim, p->surface_velocity);
}
