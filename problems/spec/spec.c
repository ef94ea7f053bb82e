#include "problems/spec/spec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void spec_init(scene_spec *s) {
  memset(s, 0, sizeof *s);
  s->dim = 2;
  s->contact_multiplicity = 1;
  s->n_h = 1;
  s->h[0] = 0.01;
  s->order = 1;
  s->friction_kinetic.dflt = -1.0;
}

static void free_shape(spec_shape *p) {
  for (int i = 0; i < p->n_part; i++) {
    free(p->part[i].shape.vertex);
  }
  free(p->part);
  free(p->vertex);
}

void spec_free(scene_spec *s) {
  for (int i = 0; i < s->n_body; i++) {
    free_shape(&s->body[i].shape);
  }
  free(s->body);
  free(s->fixed);
  free(s->friction.pair);
  free(s->friction_kinetic.pair);
  free(s->restitution.pair);
  free(s->rolling.pair);
  free(s->torsion.pair);
  free(s->load);
  free(s->joint);
  free(s->no_collision);
  free(s->check);
  free(s->off);
  free(s->model_param);
  memset(s, 0, sizeof *s);
}

/* Items an array of n holds: the power of two at or above n, so that it need not be stored. */
static size_t capacity(int n) {
  size_t cap = 1;
  while (cap < (size_t)n) {
    cap *= 2;
  }
  return cap;
}

/* A copy of n items on the heap in *to (a pointer to any object pointer), NULL for none; false
 * without memory. */
static bool clone(void *to, const void *from, int n, size_t size) {
  void *copy = NULL;
  bool ok = true;
  if (n > 0) {
    copy = malloc(capacity(n) * size);
    ok = (copy != NULL);
    if (ok) {
      memcpy(copy, from, (size_t)n * size);
    }
  }
  memcpy(to, &copy, sizeof copy);
  return ok;
}

#define CLONE(to, from, n) clone(&(to), (from), (n), sizeof *(from))

/* Vertices and parts become the shape's own, or NULL; false without memory. */
static bool own_shape(spec_shape *p) {
  const spec_shape from = *p;
  bool ok = CLONE(p->vertex, from.vertex, from.n_vertex);
  ok = CLONE(p->part, from.part, from.n_part) & ok;
  p->n_part = (p->part != NULL) ? p->n_part : 0;
  for (int i = 0; i < p->n_part; i++) {
    ok =
        CLONE(p->part[i].shape.vertex, from.part[i].shape.vertex, from.part[i].shape.n_vertex) & ok;
  }
  return ok;
}

base_status spec_copy(const scene_spec *from, scene_spec *to, base_error *err) {
  *to = *from;
  bool ok = CLONE(to->body, from->body, from->n_body);
  to->n_body = ok ? to->n_body : 0;
  /* no short circuit: every pointer must become our own before spec_free may run */
  for (int i = 0; i < to->n_body; i++) {
    ok = own_shape(&to->body[i].shape) & ok;
  }
  ok = CLONE(to->fixed, from->fixed, from->n_static) & ok;
  ok = CLONE(to->friction.pair, from->friction.pair, from->friction.n_pair) & ok;
  ok =
      CLONE(to->friction_kinetic.pair, from->friction_kinetic.pair, from->friction_kinetic.n_pair) &
      ok;
  ok = CLONE(to->restitution.pair, from->restitution.pair, from->restitution.n_pair) & ok;
  ok = CLONE(to->rolling.pair, from->rolling.pair, from->rolling.n_pair) & ok;
  ok = CLONE(to->torsion.pair, from->torsion.pair, from->torsion.n_pair) & ok;
  ok = CLONE(to->load, from->load, from->n_load) & ok;
  ok = CLONE(to->joint, from->joint, from->n_joint) & ok;
  ok = CLONE(to->no_collision, from->no_collision, from->n_no_collision) & ok;
  ok = CLONE(to->check, from->check, from->n_check) & ok;
  ok = CLONE(to->off, from->off, from->n_off) & ok;
  ok = clone(&to->model_param, from->model_param, from->model_param_size > 0,
             from->model_param_size) &
       ok;
  if (!ok) {
    spec_free(to);
    return BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory for a copy", from->id);
  }
  return BASE_OK;
}

/* Makes room for item n in *items (a pointer to any object pointer) and zeroes it. */
static void *grow(void *items, int n, size_t size) {
  void *all;
  memcpy(&all, items, sizeof all);
  if (n == 0 || capacity(n) == (size_t)n) {
    all = realloc(all, capacity(n + 1) * size);
    if (all == NULL) {
      return NULL;
    }
    memcpy(items, &all, sizeof all);
  }
  unsigned char *item = (unsigned char *)all + (size_t)n * size;
  memset(item, 0, size);
  return item;
}

#define GROW(items, n) grow(&(items), (n), sizeof *(items))

static base_status no_room(const scene_spec *s, const char *what, int n, base_error *err) {
  return BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory for %s %d", s->id, what, n + 1);
}

base_status spec_text(char *to, size_t cap, const char *from, const char *what, base_error *err) {
  const size_t len = strlen(from);
  if (len >= cap) {
    return BASE_FAIL(err, BASE_EINVAL, "%s '%.24s...': need at most %zu characters, has %zu", what,
                     from, cap - 1, len);
  }
  memcpy(to, from, len + 1);
  return BASE_OK;
}

base_status spec_add_body(scene_spec *s, const char *name, spec_body **out, base_error *err) {
  spec_body *b = GROW(s->body, s->n_body);
  if (b == NULL) {
    return no_room(s, "body", s->n_body, err);
  }
  BASE_TRY(spec_text(b->name, sizeof b->name, name, "body", err));
  b->quat[0] = 1.0;
  b->compliance = 1.0;
  s->n_body++;
  *out = b;
  return BASE_OK;
}

base_status spec_shape_vertices(spec_shape *p, int n, base_error *err) {
  p->vertex = calloc(capacity(n), sizeof *p->vertex);
  if (p->vertex == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d vertices", n);
  }
  p->n_vertex = n;
  return BASE_OK;
}

base_status spec_add_static(scene_spec *s, const char *name, const double *normal, double offset,
                            spec_static **out, base_error *err) {
  spec_static *p = GROW(s->fixed, s->n_static);
  if (p == NULL) {
    return no_room(s, "static", s->n_static, err);
  }
  BASE_TRY(spec_text(p->name, sizeof p->name, name, "static", err));
  for (int k = 0; k < s->dim; k++) {
    p->normal[k] = normal[k];
  }
  p->offset = offset;
  p->compliance = 1.0;
  s->n_static++;
  if (out != NULL) {
    *out = p;
  }
  return BASE_OK;
}

base_status spec_add_load(scene_spec *s, spec_load **out, base_error *err) {
  spec_load *l = GROW(s->load, s->n_load);
  if (l == NULL) {
    return no_room(s, "load", s->n_load, err);
  }
  l->other = -1;
  s->n_load++;
  *out = l;
  return BASE_OK;
}

base_status spec_add_joint(scene_spec *s, const char *name, spec_joint **out, base_error *err) {
  spec_joint *j = GROW(s->joint, s->n_joint);
  if (j == NULL) {
    return no_room(s, "joint", s->n_joint, err);
  }
  BASE_TRY(spec_text(j->name, sizeof j->name, name, "joint", err));
  j->other = -1;
  s->n_joint++;
  *out = j;
  return BASE_OK;
}

static base_status start_check(spec_check *c, spec_check_kind kind, const char *var,
                               base_error *err) {
  c->kind = kind;
  c->t1 = HUGE_VAL;
  return spec_text(c->var, sizeof c->var, var != NULL ? var : "", "check var", err);
}

base_status spec_add_check(scene_spec *s, spec_check_kind kind, const char *var, spec_check **out,
                           base_error *err) {
  spec_check *c = GROW(s->check, s->n_check);
  if (c == NULL) {
    return no_room(s, "check", s->n_check, err);
  }
  BASE_TRY(start_check(c, kind, var, err));
  s->n_check++;
  *out = c;
  return BASE_OK;
}

base_status spec_add_state(scene_spec *s, const char *var, double t, double value, double abs,
                           double h_coef, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_STATE, var, &c, err));
  c->t = t;
  c->value = value;
  c->tol.abs = abs;
  c->tol.h = h_coef;
  return BASE_OK;
}

base_status spec_add_off(scene_spec *s, unsigned effect_bit, const char *var, double t,
                         double value, double abs, double h_coef, base_error *err) {
  spec_off *o = GROW(s->off, s->n_off);
  if (o == NULL) {
    return no_room(s, "if_off", s->n_off, err);
  }
  BASE_TRY(start_check(&o->check, CHECK_STATE, var, err));
  o->effect = effect_bit;
  o->check.t = t;
  o->check.value = value;
  o->check.tol.abs = abs;
  o->check.tol.h = h_coef;
  s->n_off++;
  return BASE_OK;
}

static base_status fill_pair(spec_pair *p, const char *a, const char *b, double value,
                             base_error *err) {
  BASE_TRY(spec_text(p->a, sizeof p->a, a, "pair", err));
  BASE_TRY(spec_text(p->b, sizeof p->b, b, "pair", err));
  p->value = value;
  return BASE_OK;
}

base_status spec_add_pair(spec_coefficient *c, const char *a, const char *b, double value,
                          base_error *err) {
  spec_pair *p = GROW(c->pair, c->n_pair);
  if (p == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "pair %s-%s: no memory", a, b);
  }
  BASE_TRY(fill_pair(p, a, b, value, err));
  c->n_pair++;
  return BASE_OK;
}

base_status spec_add_no_collision(scene_spec *s, const char *a, const char *b, base_error *err) {
  spec_pair *p = GROW(s->no_collision, s->n_no_collision);
  if (p == NULL) {
    return no_room(s, "no_collision", s->n_no_collision, err);
  }
  BASE_TRY(fill_pair(p, a, b, 0.0, err));
  s->n_no_collision++;
  return BASE_OK;
}

base_status spec_add_observe(scene_spec *s, const char *var, base_error *err) {
  if (s->n_observe == SPEC_OBSERVE) {
    return BASE_FAIL(err, BASE_EINVAL, "scene '%s': more than %d observed quantities", s->id,
                     SPEC_OBSERVE);
  }
  BASE_TRY(spec_text(s->observe[s->n_observe], sizeof s->observe[0], var, "observe", err));
  s->n_observe++;
  return BASE_OK;
}

base_status spec_check_only(spec_check *c, const char *formulation, base_error *err) {
  if (c->n_form == SPEC_FORMS) {
    return BASE_FAIL(err, BASE_EINVAL, "check of '%s': more than %d formulations", c->var,
                     SPEC_FORMS);
  }
  BASE_TRY(spec_text(c->form[c->n_form], sizeof c->form[0], formulation, "forms", err));
  c->n_form++;
  return BASE_OK;
}

/* The anchor of a load that has none does not move. */
static bool varies(const spec_load *l) {
  const double *v = l->anchor_vel;
  const bool swings = l->kind == SPEC_FORCE_SINE && l->omega != 0.0;
  return ((l->kind == SPEC_FORCE_RAMP || swings) && l->rate != 0.0) || v[0] != 0.0 || v[1] != 0.0 ||
         v[2] != 0.0;
}

bool spec_loads_vary(const scene_spec *s) {
  bool some = false;
  for (int i = 0; i < s->n_load && !some; i++) {
    some = varies(&s->load[i]);
  }
  return some;
}

int spec_find_body(const scene_spec *s, const char *name) {
  for (int i = 0; i < s->n_body; i++) {
    if (strcmp(s->body[i].name, name) == 0) {
      return i;
    }
  }
  return -1;
}

#define NAME_(id, text) text,
static const char *const check_names[] = {SPEC_CHECK_LIST(NAME_)};

const char *spec_check_name(spec_check_kind k) {
  return ((int)k >= 0 && k < CHECK_COUNT) ? check_names[k] : "unknown";
}

bool spec_check_names(const spec_check *c, const char *word) {
  for (int i = 0; i < c->n_form; i++) {
    if (strcmp(c->form[i], word) == 0) {
      return true;
    }
  }
  return false;
}

bool spec_check_applies(const spec_check *c, const char *formulation, const char *stands_for,
                        int facets) {
  const bool listed = c->n_form == 0 || spec_check_names(c, formulation) ||
                      (stands_for[0] != '\0' && spec_check_names(c, stands_for));
  return listed && (c->nd == 0 || facets == 0 || c->nd == facets);
}
