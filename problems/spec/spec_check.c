#include "problems/spec/spec_check.h"

#include "problems/spec/name_index.h"
#include "problems/vec.h"

#include <string.h>

#define BAD(...) BASE_FAIL(err, BASE_EINVAL, __VA_ARGS__)

/* ---- names ---------------------------------------------------------------------------------- */

/* Refuses empty names, such as are used twice, and the one that stands for any. */
static base_status check_names(const scene_spec *s, const name_index *k, base_error *err) {
  for (int i = 0; i < k->n; i++) {
    const char *name = k->entry[i].name;
    if (name[0] == '\0' || strchr(name, '.') != NULL || strcmp(name, SPEC_ANY) == 0) {
      return BAD(
          "scene '%s': body or static %d named '%s': need a name without '.' that is not '*'",
          s->id, k->entry[i].side, name);
    }
    if (i > 0 && strcmp(name, k->entry[i - 1].name) == 0) {
      return BAD("scene '%s': the name '%s' is used twice", s->id, name);
    }
  }
  return BASE_OK;
}

/* ---- coefficients, loads, joints ------------------------------------------------------------- */

static base_status check_pair(const scene_spec *s, const name_index *k, const char *what,
                              const spec_pair *p, base_error *err) {
  if (name_index_find(k, p->a) < 0 || name_index_find(k, p->b) < 0) {
    return BAD("scene '%s': %s of pair %s-%s: no body or static named '%s'", s->id, what, p->a,
               p->b, (name_index_find(k, p->a) >= 0) ? p->b : p->a);
  }
  if (strcmp(p->a, p->b) == 0) {
    return BAD("scene '%s': %s of pair %s-%s: need two different names", s->id, what, p->a, p->b);
  }
  return BASE_OK;
}

static base_status check_coefficient(const scene_spec *s, const name_index *k, const char *what,
                                     const spec_coefficient *c, double lo, double hi,
                                     base_error *err) {
  if (!(c->dflt >= lo && c->dflt <= hi) || !isfinite(c->dflt)) {
    return BAD("scene '%s': %s default = %g, need a value in [%g, %g]", s->id, what, c->dflt, lo,
               hi);
  }
  for (int i = 0; i < c->n_pair; i++) {
    const spec_pair *p = &c->pair[i];
    BASE_TRY(check_pair(s, k, what, p, err));
    if (!(p->value >= 0.0 && p->value <= hi) || !isfinite(p->value)) {
      return BAD("scene '%s': %s of pair %s-%s = %g, need a value in [0, %g]", s->id, what, p->a,
                 p->b, p->value, hi);
    }
  }
  return BASE_OK;
}

static base_status check_coefficients(const scene_spec *s, const name_index *k, base_error *err) {
  const double any = HUGE_VAL;
  BASE_TRY(check_coefficient(s, k, "friction", &s->friction, 0.0, any, err));
  /* -1: same as static */
  BASE_TRY(check_coefficient(s, k, "friction_kinetic", &s->friction_kinetic, -1.0, any, err));
  BASE_TRY(check_coefficient(s, k, "restitution", &s->restitution, 0.0, 1.0, err));
  BASE_TRY(check_coefficient(s, k, "rolling", &s->rolling, 0.0, any, err));
  BASE_TRY(check_coefficient(s, k, "torsion", &s->torsion, 0.0, any, err));
  for (int i = 0; i < s->n_no_collision; i++) {
    BASE_TRY(check_pair(s, k, "no_collision", &s->no_collision[i], err));
  }
  return BASE_OK;
}

static base_status check_load(const scene_spec *s, int i, base_error *err) {
  const spec_load *l = &s->load[i];
  if (l->body < 0 || l->body >= s->n_body || l->other < -1 || l->other >= s->n_body) {
    return BAD("scene '%s': load %d acts on no body of the scene", s->id, i + 1);
  }
  const bool fine = spec_all_finite(l->force, 3) && spec_all_finite(l->torque, 3) &&
                    spec_all_finite(l->dir, 3) && isfinite(l->rate) && isfinite(l->rest) &&
                    spec_all_finite(l->anchor, 3) && spec_all_finite(l->anchor_vel, 3) &&
                    spec_all_finite(l->offset, 3) && spec_all_finite(l->other_offset, 3) &&
                    isfinite(l->omega) && isfinite(l->phase);
  if (!fine) {
    return BAD("scene '%s': load %d on '%s' has a number that is not finite", s->id, i + 1,
               s->body[l->body].name);
  }
  if (!(l->k >= 0.0) || !(l->c >= 0.0) || !isfinite(l->k) || !isfinite(l->c)) {
    return BAD("scene '%s': load %d on '%s': stiffness %g and damping %g must be >= 0", s->id,
               i + 1, s->body[l->body].name, l->k, l->c);
  }
  const bool needs_dir =
      l->kind == SPEC_FORCE_RAMP || l->kind == SPEC_FORCE_SINE || l->kind == SPEC_SPRING;
  if (needs_dir && !(fabs(v3_norm(l->dir) - 1.0) <= 1e-6)) {
    return BAD("scene '%s': load %d on '%s': dir has length %g, need 1", s->id, i + 1,
               s->body[l->body].name, v3_norm(l->dir));
  }
  if (l->kind == SPEC_SPRING_PAIR && l->other == l->body) {
    return BAD("scene '%s': load %d ties '%s' to itself", s->id, i + 1, s->body[l->body].name);
  }
  if (l->kind == SPEC_TORSION_SPRING && s->dim != 2) {
    return BAD("scene '%s': load %d: a torsion spring is planar, dim is %d", s->id, i + 1, s->dim);
  }
  return BASE_OK;
}

static base_status check_joint(const scene_spec *s, int i, base_error *err) {
  const spec_joint *j = &s->joint[i];
  if (j->body < 0 || j->body >= s->n_body || j->other < -1 || j->other >= s->n_body ||
      j->other == j->body) {
    return BAD("scene '%s': joint '%s' needs two different bodies, or one and the world", s->id,
               j->name);
  }
  if (!spec_all_finite(j->anchor, 3) || !spec_all_finite(j->other_anchor, 3) ||
      !spec_all_finite(j->axis, 3)) {
    return BAD("scene '%s': joint '%s' has a number that is not finite", s->id, j->name);
  }
  const bool needs_axis = j->kind == SPEC_SLIDER || (j->kind == SPEC_HINGE && s->dim == 3);
  if (needs_axis && !(fabs(v3_norm(j->axis) - 1.0) <= 1e-6)) {
    return BAD("scene '%s': joint '%s': axis has length %g, need 1", s->id, j->name,
               v3_norm(j->axis));
  }
  if (j->kind == SPEC_DISTANCE) {
    const double d[3] = {j->anchor[0] - j->other_anchor[0], j->anchor[1] - j->other_anchor[1],
                         j->anchor[2] - j->other_anchor[2]};
    if (!(v3_norm(d) > 0.0)) {
      return BAD("scene '%s': joint '%s': its two anchors coincide", s->id, j->name);
    }
  }
  return BASE_OK;
}

/* ---- checks --------------------------------------------------------------------------------- */

/* Is `quantity` one that "body.quantity" may observe (x, y, z, vx, vy, vz, pos, vel, angle, omega,
 * omega.x, ...) in this dimension? */
static bool quantity_known(const char *quantity, int dim) {
  static const char *const both[] = {"x", "y", "vx", "vy", "pos", "vel", "angle", "omega"};
  static const char *const spatial[] = {"z", "vz", "omega.x", "omega.y", "omega.z"};
  for (int i = 0; i < BASE_COUNT(both); i++) {
    if (strcmp(quantity, both[i]) == 0) {
      return true;
    }
  }
  for (int i = 0; dim == 3 && i < BASE_COUNT(spatial); i++) {
    if (strcmp(quantity, spatial[i]) == 0) {
      return true;
    }
  }
  return false;
}

static base_status check_var(const scene_spec *s, const name_index *k, const char *var,
                             base_error *err) {
  if (s->model != NULL || var[0] == '\0') {
    return BASE_OK; /* the model knows its own names */
  }
  const char *dot = strchr(var, '.');
  char body[2 * SPEC_NAME] = "";
  if (dot != NULL) {
    memcpy(body, var, (size_t)(dot - var));
  }
  if (dot == NULL || name_index_find(k, body) < 0) {
    return BAD("scene '%s': '%s' names no body; need body.quantity", s->id, var);
  }
  if (!quantity_known(dot + 1, s->dim)) {
    return BAD("scene '%s': '%s': unknown quantity '%s' in dim %d", s->id, var, dot + 1, s->dim);
  }
  return BASE_OK;
}

static bool needs_var(const spec_check *c) {
  const spec_check_kind k = c->kind;
  const bool of_var = k == CHECK_EVENT_TIME && (c->event == EVENT_STOP || c->event == EVENT_START ||
                                                c->event == EVENT_SIGN_CHANGE);
  return of_var || k == CHECK_STATE || k == CHECK_STATE_AFTER_STEPS || k == CHECK_MAX_DRIFT ||
         k == CHECK_WINDOW_MAX || k == CHECK_WINDOW_MIN || k == CHECK_MIN_CHANGE;
}

static base_status check_check(const scene_spec *s, const name_index *k, const spec_check *c,
                               base_error *err) {
  const char *kind = spec_check_name(c->kind);
  if (needs_var(c) && c->var[0] == '\0') {
    return BAD("scene '%s': check %s needs a var", s->id, kind);
  }
  if (c->kind == CHECK_EVENT_TIME && !needs_var(c) && c->var[0] != '\0') {
    return BAD("scene '%s': check %s of '%s': contact begins and ends between bodies, not in a var",
               s->id, kind, c->var);
  }
  BASE_TRY(check_var(s, k, c->var, err));
  const spec_tolerance *t = &c->tol;
  const double tol[] = {t->abs, t->h, t->h2, t->inv_h, t->reg_h, t->reg_v, t->reg_d, t->rel};
  for (int i = 0; i < BASE_COUNT(tol); i++) {
    if (!(tol[i] >= 0.0) || !isfinite(tol[i])) {
      return BAD("scene '%s': check %s of '%s': a tolerance is %g, need >= 0", s->id, kind, c->var,
                 tol[i]);
    }
  }
  if (!isfinite(c->value) || !isfinite(c->dvalue_dh) || !(c->t >= 0.0) || !(c->t0 >= 0.0) ||
      !(c->t1 >= c->t0)) {
    return BAD("scene '%s': check %s of '%s': value or time is not finite or out of order", s->id,
               kind, c->var);
  }
  if (c->t > s->duration * (1.0 + 1e-12)) {
    return BAD("scene '%s': check %s of '%s' at t = %g is after the end T = %g", s->id, kind,
               c->var, c->t, s->duration);
  }
  const bool of_force = c->kind == CHECK_CONTACT_FORCE || c->kind == CHECK_CONTACT_FORCE_SUM;
  if (of_force && c->n_pair < 1) {
    return BAD("scene '%s': check %s needs a pair", s->id, kind);
  }
  for (int i = 0; i < c->n_pair; i++) {
    const spec_pair *pair = &c->pair[i];
    if (strcmp(pair->b, SPEC_ANY) != 0) {
      BASE_TRY(check_pair(s, k, kind, pair, err));
    } else if (name_index_find(k, pair->a) < 0) {
      return BAD("scene '%s': %s of pair %s-%s: no body or static named '%s'", s->id, kind, pair->a,
                 pair->b, pair->a);
    }
  }
  return BASE_OK;
}

/* ---- all ------------------------------------------------------------------------------------ */

static base_status check_frame(const scene_spec *s, base_error *err) {
  if (s->dim != 2 && s->dim != 3) {
    return BAD("scene '%s': dim = %d, need 2 or 3", s->id, s->dim);
  }
  if (s->n_body == 0 && s->model == NULL) {
    return BAD("scene '%s' is empty: need at least one body", s->id);
  }
  if (!(s->duration > 0.0) || !isfinite(s->duration)) {
    return BAD("scene '%s': T = %g, need a finite time > 0", s->id, s->duration);
  }
  if (!spec_all_finite(s->gravity, 3)) {
    return BAD("scene '%s': gravity is not finite", s->id);
  }
  if (s->contact_multiplicity < 1 || s->contact_multiplicity > SPEC_COPIES) {
    return BAD("scene '%s': contact_multiplicity = %d, need 1 to %d", s->id,
               s->contact_multiplicity, SPEC_COPIES);
  }
  if (s->n_h < 1 || s->n_h > SPEC_STEPS) {
    return BAD("scene '%s': need 1 to %d steps in hs, has %d", s->id, SPEC_STEPS, s->n_h);
  }
  for (int i = 0; i < s->n_h; i++) {
    if (!(s->h[i] > 0.0) || !isfinite(s->h[i])) {
      return BAD("scene '%s': step h = %g, need a finite time > 0", s->id, s->h[i]);
    }
  }
  if (s->facets != 0 && (s->facets < 3 || s->facets > 256)) {
    return BAD("scene '%s': nd = %d, need 3 to 256 facets", s->id, s->facets);
  }
  if (!(s->contact_stiffness >= 0.0) || !isfinite(s->contact_stiffness)) {
    return BAD("scene '%s': contact stiffness = %g, need >= 0", s->id, s->contact_stiffness);
  }
  return BASE_OK;
}

static base_status check_parts_of(scene_spec *s, const name_index *k, base_error *err) {
  for (int i = 0; i < s->n_body; i++) {
    BASE_TRY(spec_check_body(s, &s->body[i], err));
  }
  for (int i = 0; i < s->n_static; i++) {
    BASE_TRY(spec_check_static(s, &s->fixed[i], err));
  }
  BASE_TRY(check_coefficients(s, k, err));
  for (int i = 0; i < s->n_load; i++) {
    BASE_TRY(check_load(s, i, err));
  }
  for (int i = 0; i < s->n_joint; i++) {
    BASE_TRY(check_joint(s, i, err));
  }
  for (int i = 0; i < s->n_check; i++) {
    BASE_TRY(check_check(s, k, &s->check[i], err));
  }
  for (int i = 0; i < s->n_off; i++) {
    BASE_TRY(check_check(s, k, &s->off[i].check, err));
  }
  for (int i = 0; i < s->n_observe; i++) {
    BASE_TRY(check_var(s, k, s->observe[i], err));
  }
  return spec_settle_effects(s, err);
}

base_status spec_check_all(scene_spec *s, base_error *err) {
  BASE_TRY(check_frame(s, err));
  name_index names;
  BASE_TRY(name_index_open(&names, s, err));
  base_status status = check_names(s, &names, err);
  if (status == BASE_OK) {
    status = check_parts_of(s, &names, err);
  }
  name_index_close(&names);
  return status;
}
