/* world_forces.c - gravity and loads, taken explicitly at the start of the step.
 *
 * With q+ = q + h v+ this makes a spring symplectic Euler: exact in the mean, stable for
 * h sqrt(k/m) < 2. A spring or damper beyond that bound between its two ends is refused, not damped. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

/* World point of `local` on body b, or `local` itself on the world. */
static void point_on(const world *w, int b, const double *local, double *x, double *v) {
  if (b < 0) {
    v3_copy(local, x);
    v[0] = v[1] = v[2] = 0.0;
    return;
  }
  const body *y = &w->body[b];
  double arm[3];
  m3_mul_vec(y->at.R, local, arm);
  v3_add_scaled(y->at.x, 1.0, arm, x);
  v3_cross(y->v + 3, arm, v);
  v3_add_scaled(y->v, 1.0, v, v);
}

static void apply(const world *w, int b, const double *at, const double *force, double s,
                  double *f) {
  if (b < 0) {
    return;
  }
  double arm[3], torque[3];
  v3_sub(at, w->body[b].at.x, arm);
  v3_cross(arm, force, torque);
  v3_add_scaled(f + 6 * (ptrdiff_t)b, s, force, f + 6 * (ptrdiff_t)b);
  v3_add_scaled(f + 6 * (ptrdiff_t)b + 3, s, torque, f + 6 * (ptrdiff_t)b + 3);
}

/* Spring to a moving anchor: elongation along dir; where dir is zero, the distance. */
typedef struct stretch {
  double at[3], other[3]; /* ends */
  double dir[3];          /* from other to at */
  double length, rate;    /* elongation beyond rest [m], its rate [m/s] */
} stretch;

static void stretch_of(const world *w, const spec_load *l, stretch *s) {
  double v[3], vo[3], d[3];
  point_on(w, l->body, l->offset, s->at, v);
  if (l->kind == SPEC_SPRING_PAIR) {
    point_on(w, l->other, l->other_offset, s->other, vo);
  } else {
    v3_add_scaled(l->anchor, w->t, l->anchor_vel, s->other);
    v3_copy(l->anchor_vel, vo);
  }
  v3_sub(s->at, s->other, d);
  v3_sub(v, vo, v);
  const double far = v3_norm(d), fixed = v3_norm(l->dir);
  if (l->kind == SPEC_SPRING && fixed > 0.0) {
    v3_scale(1.0 / fixed, l->dir, s->dir);
  } else if (far > 0.0) {
    v3_scale(1.0 / far, d, s->dir);
  } else {
    memset(s->dir, 0, sizeof s->dir);
  }
  s->length = v3_dot(s->dir, d) - l->rest;
  s->rate = v3_dot(s->dir, v);
}

static double twist_of(const world *w, const spec_load *l, double *rate) {
  const body *b = &w->body[l->body];
  *rate = b->v[5] - ((l->other >= 0) ? w->body[l->other].v[5] : 0.0);
  return b->angle - ((l->other >= 0) ? w->body[l->other].angle : 0.0) - l->rest;
}

static double damping_of(const world *w, const spec_load *l) {
  return world_has(w, EFFECT_DAMPING) ? l->c : 0.0;
}

static void load_wrench(const world *w, const spec_load *l, double *f) {
  const double *centre = w->body[l->body].at.x;
  double *own = f + 6 * (ptrdiff_t)l->body;
  switch (l->kind) {
  case SPEC_FORCE:
    v3_add_scaled(own, 1.0, l->force, own);
    v3_add_scaled(own + 3, 1.0, l->torque, own + 3);
    break;
  case SPEC_FORCE_RAMP:
    apply(w, l->body, centre, l->dir, l->rate * w->t, f);
    break;
  case SPEC_FORCE_SINE:
    apply(w, l->body, centre, l->dir, l->rate * sin(l->omega * w->t + l->phase), f);
    break;
  case SPEC_SPRING:
  case SPEC_SPRING_PAIR: {
    stretch s;
    stretch_of(w, l, &s);
    const double tension = l->k * s.length + damping_of(w, l) * s.rate;
    apply(w, l->body, s.at, s.dir, -tension, f);
    if (l->kind == SPEC_SPRING_PAIR) {
      apply(w, l->other, s.other, s.dir, tension, f);
    }
    break;
  }
  case SPEC_TORSION_SPRING: {
    double rate;
    const double twist = twist_of(w, l, &rate);
    const double torque = l->k * twist + damping_of(w, l) * rate;
    own[5] -= torque;
    if (l->other >= 0) {
      f[6 * (ptrdiff_t)l->other + 5] += torque;
    }
    break;
  }
  }
}

/* Force and torque of gravity and loads on every body: f[6 n_body]. */
static void sum_wrenches(const world *w, double *f) {
  const double g = world_has(w, EFFECT_GRAVITY) ? 1.0 : 0.0;
  for (int b = 0; b < w->n_body; b++) {
    double *own = f + 6 * (ptrdiff_t)b;
    memset(own, 0, 6 * sizeof *own);
    v3_scale(g * w->body[b].mass, w->spec.gravity, own);
  }
  if (world_has(w, EFFECT_LOADS)) {
    for (int i = 0; i < w->spec.n_load; i++) {
      load_wrench(w, &w->spec.load[i], f);
    }
  }
}

double world_load_energy(const world *w) {
  double e = 0.0;
  if (!world_has(w, EFFECT_LOADS)) {
    return e;
  }
  for (int i = 0; i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    if (l->kind == SPEC_SPRING || l->kind == SPEC_SPRING_PAIR) {
      stretch s;
      stretch_of(w, l, &s);
      e += 0.5 * l->k * s.length * s.length;
    } else if (l->kind == SPEC_TORSION_SPRING) {
      double rate;
      const double twist = twist_of(w, l, &rate);
      e += 0.5 * l->k * twist * twist;
    }
  }
  return e;
}

base_status loads_check(const world *w, base_error *err) {
  for (int i = 0; i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    if (l->body < 0 || l->body >= w->n_body || l->other >= w->n_body) {
      return BASE_FAIL(err, BASE_EINVAL, "load %d: no body %d", i, l->body);
    }
    if (l->kind == SPEC_TORSION_SPRING && w->dim == 3) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "load %d: torsion springs are planar", i);
    }
  }
  return BASE_OK;
}

/* 1/m of one end of a spring [1/kg, or 1/(kg m^2)]. */
static double mobility_of(const world *w, const spec_load *l, int b) {
  if (b < 0 || w->body[b].n_dof == 0) {
    return 0.0;
  }
  const body *y = &w->body[b];
  return 1.0 / ((l->kind == SPEC_TORSION_SPRING) ? y->inertia[2] : y->mass);
}

static bool is_spring(const spec_load *l) {
  return l->kind == SPEC_SPRING || l->kind == SPEC_SPRING_PAIR || l->kind == SPEC_TORSION_SPRING;
}

/* Explicit springs and dampers: refuses steps beyond a + 2 b < 4, a = h^2 k/m, b = h c/m, 1/m the sum over
 * both ends. There l^2 - (2 - a - b) l + 1 - b, of the step of one spring alone, has a root l <= -1 (Jury's
 * criterion); several springs on one body may need less. */
static base_status check_stiffness(const world *w, double h, base_error *err) {
  for (int i = 0; i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    if (!is_spring(l)) {
      continue;
    }
    const double inverse = mobility_of(w, l, l->body) + mobility_of(w, l, l->other);
    const double reach = h * (h * l->k + 2.0 * damping_of(w, l)) * inverse;
    if (reach >= 4.0) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "load %d: explicit spring needs h^2 k/m + 2 h c/m < 4, has %.3g", i + 1,
                       reach);
    }
  }
  return BASE_OK;
}

double world_longest_step(const world *w) {
  double longest = HUGE_VAL;
  for (int i = 0; world_has(w, EFFECT_LOADS) && i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    const double inverse =
        is_spring(l) ? mobility_of(w, l, l->body) + mobility_of(w, l, l->other) : 0.0;
    const double c = is_spring(l) ? damping_of(w, l) : 0.0;
    if (inverse > 0.0 && (l->k > 0.0 || c > 0.0)) {
      /* the root of h^2 k + 2 h c = 4 / inverse */
      const double h = 4.0 / (inverse * (c + sqrt(c * c + 4.0 * l->k / inverse)));
      longest = fmin(longest, h);
    }
  }
  return longest;
}

/* The largest force of a load; of a spring what a place that is off by the smallest body makes of it. */
static double force_of(const world *w, const spec_load *l) {
  switch (l->kind) {
  case SPEC_FORCE:
    return v3_norm(l->force) + v3_norm(l->torque) / w->size;
  case SPEC_FORCE_RAMP:
    return fabs(l->rate) * w->spec.duration;
  case SPEC_FORCE_SINE:
    return fabs(l->rate);
  case SPEC_TORSION_SPRING:
    return l->k / w->size;
  default:
    return l->k * w->size;
  }
}

double world_most_acceleration(const world *w) {
  double force = 0.0;
  double lightest = HUGE_VAL;
  for (int i = 0; world_has(w, EFFECT_LOADS) && i < w->spec.n_load; i++) {
    force += force_of(w, &w->spec.load[i]);
  }
  for (int i = 0; i < w->n_body; i++) {
    lightest = (w->body[i].n_dof > 0) ? fmin(lightest, w->body[i].mass) : lightest;
  }
  return v3_norm(w->spec.gravity) + force / lightest;
}

double world_shortest_period(const world *w) {
  double fastest = 0.0;
  for (int i = 0; world_has(w, EFFECT_LOADS) && i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    fastest = (l->kind == SPEC_FORCE_SINE) ? fmax(fastest, fabs(l->omega)) : fastest;
  }
  return (fastest > 0.0) ? 8.0 * atan(1.0) / fastest : HUGE_VAL;
}

/* Of what a free body that turns about its middle axis is off it: |omega| sqrt((I2 - I1) (I3 - I2) / (I1 I3)), by Euler's equations. */
static double growth_of(const body *b) {
  double O[3]; /* in body axes */
  m3_tmul_vec(b->at.R, b->v + 3, O);
  for (int k = 0; k < 3; k++) {
    const double first = b->inertia[(k + 1) % 3] - b->inertia[k];
    const double second = b->inertia[k] - b->inertia[(k + 2) % 3];
    const double others = b->inertia[(k + 1) % 3] * b->inertia[(k + 2) % 3];
    if (first * second > 0.0 && others > 0.0) {
      return fabs(O[k]) * sqrt(first * second / others);
    }
  }
  return 0.0;
}

/* Can a body leave the axis that it turns about? Not where it is driven or held about one, nor where a joint to the world keeps its axis. */
static bool turns_freely(const world *w, int i) {
  const body *b = &w->body[i];
  int n = 0;
  for (int k = 0; k < b->n_dof; k++) {
    n += b->axis[k] >= 3;
  }
  bool free = n == 3;
  for (int k = 0; k < w->n_joint && free; k++) {
    const joint_data *j = &w->joint[k];
    const bool keeps = j->kind != SPEC_BALL && j->kind != SPEC_DISTANCE;
    free = !(keeps && ((j->a == i && j->b < 0) || (j->b == i && j->a < 0)));
  }
  return free;
}

double world_growth_rate(const world *w) {
  double most = 0.0;
  for (int i = 0; w->dim == 3 && world_has(w, EFFECT_GYROSCOPIC) && i < w->n_body; i++) {
    const double growth = growth_of(&w->body[i]);
    most = (growth > most && turns_freely(w, i)) ? growth : most;
  }
  return most;
}

base_status world_free_motion(world *w, double h, base_error *err) {
  set_store *s = &w->store;
  double *f = s->wrench;
  if (world_has(w, EFFECT_LOADS)) {
    BASE_TRY(check_stiffness(w, h, err));
  }
  sum_wrenches(w, f);
  for (int i = 0; i < w->n_free; i++) {
    const body *b = &w->body[w->free_body[i]];
    double *inverse = s->inv_mass + s->mass_start[i];
    BASE_TRY(body_mass_block(b, w->dim, s->mass + s->mass_start[i], inverse, err));
    BASE_TRY(body_free_velocity(b, w->dim, world_has(w, EFFECT_GYROSCOPIC), h, inverse,
                                f + 6 * (ptrdiff_t)w->free_body[i], s->v_free + b->dof, err));
    for (int k = 0; k < b->n_dof; k++) {
      s->v[b->dof + k] = b->v[b->axis[k]];
    }
  }
  return BASE_OK;
}

/* Gyroscopic torque is taken at the current state here: an integrator with error control asks for
 * the derivative, not for a step. */
static void subtract_gyroscopic(const world *w, const body *b, double f[6]) {
  if (w->dim == 3 && world_has(w, EFFECT_GYROSCOPIC)) {
    double I[9], L[3], c[3];
    body_inertia(b, w->dim, I);
    m3_mul_vec(I, b->v + 3, L);
    v3_cross(b->v + 3, L, c);
    v3_sub(f + 3, c, f + 3);
  }
}

base_status world_acceleration(world *w, double *a, base_error *err) {
  set_store *s = &w->store;
  if (w->model != NULL) {
    return model_acceleration(w, a, err);
  }
  double *f = s->wrench;
  sum_wrenches(w, f);
  for (int i = 0; i < w->n_free; i++) {
    const body *b = &w->body[w->free_body[i]];
    double *wrench = f + 6 * (ptrdiff_t)w->free_body[i];
    double *inverse = s->inv_mass + s->mass_start[i];
    BASE_TRY(body_mass_block(b, w->dim, s->mass + s->mass_start[i], inverse, err));
    subtract_gyroscopic(w, b, wrench);
    for (int k = 0; k < b->n_dof; k++) {
      double sum = 0.0;
      for (int l = 0; l < b->n_dof; l++) {
        sum += inverse[l * b->n_dof + k] * wrench[b->axis[l]];
      }
      a[b->dof + k] = sum;
    }
  }
  return BASE_OK;
}
