/* world_observe.c - what can be asked of a world: quantities by name, energies, poses, names. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <stdlib.h>

/* ---- quantities by name ---------------------------------------------------------------------- */

/* "x", "y", "z" -> 0, 1, 2; else -1. */
static int component(const char *s) {
  return (s[0] >= 'x' && s[0] <= 'z' && s[1] == '\0') ? s[0] - 'x' : -1;
}

static double along(const double *x, const double *dir) {
  return (dir != NULL) ? v3_dot(x, dir) : v3_norm(x);
}

/* "pos" and "vel" with or without ".x". */
static bool vector_part(const char *quantity, const char *name, const double *x, const double *dir,
                        double *value) {
  const size_t len = strlen(name);
  if (strncmp(quantity, name, len) != 0) {
    return false;
  }
  if (quantity[len] == '\0') {
    *value = along(x, dir);
    return true;
  }
  const int k = (quantity[len] == '.') ? component(quantity + len + 1) : -1;
  if (k >= 0) {
    *value = x[k];
  }
  return k >= 0;
}

static bool body_quantity(const world *w, const body *b, const char *q, const double *dir,
                          double *value) {
  int k = component(q);
  if (k >= 0) {
    *value = b->at.x[k];
    return true;
  }
  k = (q[0] == 'v') ? component(q + 1) : -1;
  if (k >= 0) {
    *value = b->v[k];
    return true;
  }
  if (w->dim == 2 && strcmp(q, "angle") == 0) {
    *value = b->angle;
    return true;
  }
  if (w->dim == 2 && strcmp(q, "omega") == 0 && dir == NULL) {
    *value = b->v[5];
    return true;
  }
  if (strcmp(q, "speed") == 0) {
    *value = v3_norm(b->v);
    return true;
  }
  if (strcmp(q, "energy") == 0) {
    *value = body_kinetic(b, w->dim);
    return true;
  }
  return vector_part(q, "pos", b->at.x, dir, value) || vector_part(q, "vel", b->v, dir, value) ||
         vector_part(q, "omega", b->v + 3, dir, value);
}

static bool scene_quantity(const world *w, const char *var, const double *dir, double *value) {
  double x[3];
  if (strcmp(var, "energy") == 0) {
    *value = world_energy(w);
    return true;
  }
  if (strcmp(var, "kinetic") == 0) {
    *value = world_kinetic(w);
    return true;
  }
  if (strncmp(var, "angular_momentum", 16) == 0) {
    world_angular_momentum(w, x);
    return vector_part(var, "angular_momentum", x, dir, value);
  }
  if (strncmp(var, "momentum", 8) == 0) {
    world_momentum(w, x);
    return vector_part(var, "momentum", x, dir, value);
  }
  return false;
}

bool world_observe(const world *w, const char *var, const double *dir, double *value) {
  if (w->model != NULL && model_observe(w, var, value)) {
    return true;
  }
  const char *dot = strchr(var, '.');
  if (dot != NULL) {
    for (int i = 0; i < w->n_body; i++) {
      const char *name = w->spec.body[i].name;
      if (strlen(name) == (size_t)(dot - var) && strncmp(name, var, (size_t)(dot - var)) == 0) {
        return body_quantity(w, &w->body[i], dot + 1, dir, value);
      }
    }
  }
  return scene_quantity(w, var, dir, value);
}

const char *world_observe_unit(const char *var) {
  static const struct {
    const char *name, *unit;
  } units[] = {{"energy", "J"},     {"kinetic", "J"}, {"angular_momentum", "N m s"},
               {"momentum", "N s"}, {"angle", "rad"}, {"omega", "rad/s"},
               {"vel", "m/s"},      {"speed", "m/s"}, {"vx", "m/s"},
               {"vy", "m/s"},       {"vz", "m/s"},    {"v", "1/s"},
               {"pos", "m"},        {"x", "m"},       {"y", "m"},
               {"z", "m"}};
  const char *dot = strchr(var, '.');
  const char *q = (dot != NULL) ? dot + 1 : var;
  const size_t len = strcspn(q, ".");
  for (int i = 0; i < BASE_COUNT(units); i++) {
    if (strlen(units[i].name) == len && strncmp(units[i].name, q, len) == 0) {
      return units[i].unit;
    }
  }
  return "1";
}

/* ---- energies and momenta --------------------------------------------------------------------- */

double world_kinetic(const world *w) {
  if (w->model != NULL) {
    return model_energy(w, true);
  }
  double T = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    if (body_is_free(&w->body[i])) {
      T += body_kinetic(&w->body[i], w->dim);
    }
  }
  return T;
}

double world_energy(const world *w) {
  if (w->model != NULL) {
    return model_energy(w, false);
  }
  double E = world_kinetic(w) + world_load_energy(w);
  for (int i = 0; world_has(w, EFFECT_GRAVITY) && i < w->n_body; i++) {
    if (body_is_free(&w->body[i])) {
      E -= w->body[i].mass * v3_dot(w->spec.gravity, w->body[i].at.x);
    }
  }
  return E;
}

void world_momentum(const world *w, double p[3]) {
  p[0] = p[1] = p[2] = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    if (body_is_free(&w->body[i])) {
      v3_add_scaled(p, w->body[i].mass, w->body[i].v, p);
    }
  }
}

void world_angular_momentum(const world *w, double L[3]) {
  L[0] = L[1] = L[2] = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    double I[9], spin[3], orbit[3];
    if (!body_is_free(b)) {
      continue;
    }
    body_inertia(b, w->dim, I);
    m3_mul_vec(I, b->v + 3, spin);
    v3_cross(b->at.x, b->v, orbit);
    v3_add_scaled(L, 1.0, spin, L);
    v3_add_scaled(L, b->mass, orbit, L);
  }
}

double world_min_gap(world *w) {
  double gap = HUGE_VAL;
  if (w->model != NULL) {
    return model_min_gap(w);
  }
  if (!world_has(w, EFFECT_CONTACT)) {
    return gap;
  }
  return (detect_min_gap(w, &gap, NULL) == BASE_OK) ? gap : (double)NAN;
}

base_status world_depth(world *w, double *depth, base_error *err) {
  *depth = 0.0;
  if (w->model != NULL) {
    *depth = fmax(0.0, -model_min_gap(w));
    return BASE_OK;
  }
  return world_has(w, EFFECT_CONTACT) ? detect_depth(w, depth, err) : BASE_OK;
}

double world_max_speed(const world *w) {
  double best = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const double v = v3_norm(w->body[i].v);
    best = (v > best || isnan(v)) ? v : best;
  }
  for (int k = 0; w->model != NULL && k < w->n_dof; k++) {
    best = fmax(best, fabs(w->qv[k]));
  }
  return best;
}

double world_speed_at(const world *w, const double *v) {
  double best = 0.0;
  for (int i = 0; w->model == NULL && i < w->n_body; i++) {
    const body *b = &w->body[i];
    double part[2] = {0.0, 0.0};
    for (int k = 0; k < b->n_dof; k++) {
      part[b->axis[k] >= 3] = hypot(part[b->axis[k] >= 3], v[b->dof + k]);
    }
    best = fmax(best, part[0] + part[1] * b->bound);
  }
  for (int k = 0; w->model != NULL && k < w->n_dof; k++) {
    best = fmax(best, fabs(v[k]));
  }
  return best;
}

bool world_may_rest(const world *w) {
  bool rests = !(world_max_speed(w) > 0.0);
  for (int i = 0; rests && i < w->n_body; i++) {
    rests = !w->body[i].driven && !(v3_norm(w->body[i].v + 3) > 0.0);
  }
  return rests && !(world_has(w, EFFECT_LOADS) && spec_loads_vary(&w->spec));
}

double world_meeting_speed(const world *w) {
  double best = 0.0;
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = &w->store.item[w->store.key[i].item];
    const int side[2] = {c->a, c->b};
    for (int k = 0; k < 2; k++) {
      const body *b = (side[k] < w->n_body) ? &w->body[side[k]] : NULL;
      best = (b != NULL) ? fmax(best, v3_norm(b->v) + b->bound * v3_norm(b->v + 3)) : best;
    }
  }
  return best;
}

double world_surface_speed(const world *w) {
  double best = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    best = fmax(best, v3_norm(b->v) + v3_norm(b->v + 3) * b->bound);
  }
  return best;
}

double world_size(const world *w) {
  return w->size;
}

bool world_of_points(const world *w) {
  bool points = w->model == NULL && w->n_body > 0;
  for (int i = 0; points && i < w->n_body; i++) {
    points = !(w->body[i].bound > 0.0);
  }
  return points;
}

/* NaN is below nothing. */
static bool all_below(double limit, const double *x, int n) {
  bool below = true;
  for (int k = 0; k < n; k++) {
    below = below && fabs(x[k]) < limit;
  }
  return below;
}

bool world_below(const world *w, double limit) {
  bool below = true;
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    below = below && all_below(limit, b->at.x, 3) && all_below(limit, b->v, 6) &&
            all_below(limit, b->quat, 4) && all_below(limit, &b->angle, 1);
  }
  if (w->model != NULL) {
    below = below && all_below(limit, w->q, w->n_dof) && all_below(limit, w->qv, w->n_dof);
  }
  return below;
}

bool world_finite(const world *w) {
  return world_below(w, HUGE_VAL);
}

/* ---- names, poses, contact points ------------------------------------------------------------- */

static const char *side_name(const world *w, int side) {
  if (side < w->n_body) {
    return w->spec.body[side].name;
  }
  return (side < w->n_body + w->spec.n_static) ? w->spec.fixed[side - w->n_body].name : "";
}

void world_contact_pair(const world *w, uint64_t id, const char **a, const char **b) {
  if (w->model != NULL) {
    mech_contact c = {0};
    w->model->contact(w->spec.model_param, (int)(id >> ID_COPY_BITS), &c);
    *a = c.a;
    *b = c.b;
    return;
  }
  const uint64_t mask = ((uint64_t)1 << ID_SIDE_BITS) - 1;
  *a = side_name(w, (int)((id >> ID_SIDE_A_SHIFT) & mask));
  *b = side_name(w, (int)((id >> ID_SIDE_B_SHIFT) & mask));
}

int world_n_body(const world *w) {
  return (w->model != NULL) ? w->model->n_body : w->n_body;
}

const char *world_body_name(const world *w, int i) {
  return (w->model != NULL) ? w->model->body_name[i] : w->spec.body[i].name;
}

void world_body_pose(const world *w, int i, double pos[3], double quat[4]) {
  if (w->model != NULL) {
    w->model->pose(w->spec.model_param, w->q, i, pos, quat);
    return;
  }
  const body *b = &w->body[i];
  v3_copy(b->at.x, pos);
  if (w->dim == 3) {
    memcpy(quat, b->quat, sizeof b->quat);
  } else {
    quat[0] = cos(0.5 * b->angle);
    quat[1] = quat[2] = 0.0;
    quat[3] = sin(0.5 * b->angle);
  }
}

void world_body_velocity(const world *w, int i, double vel[3], double omega[3]) {
  for (int k = 0; k < 3; k++) {
    vel[k] = (w->model != NULL) ? 0.0 : w->body[i].v[k];
    omega[k] = (w->model != NULL) ? 0.0 : w->body[i].v[3 + k];
  }
}

void world_contact_point(const world *w, int contact, double point[3]) {
  v3_copy(w->store.point + 3 * (ptrdiff_t)contact, point);
}

void world_contact_force(const world *w, int contact, double force[3]) {
  const contact_set *c = &w->set;
  const double *impulse = w->store.impulse + c->row_start[contact];
  const double *frame = w->store.frame + 9 * (ptrdiff_t)contact;
  force[0] = force[1] = force[2] = 0.0;
  for (int k = 0; k <= c->rows[contact].tangent; k++) {
    v3_add_scaled(force, impulse[k] / c->h, frame + 3 * (ptrdiff_t)k, force);
  }
}
