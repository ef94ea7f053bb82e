#include "harness/measure/effects_rules.h"

#include "problems/spec/spec_check.h"
#include "problems/vec.h"
#include "problems/world/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const unsigned turning = EFFECT_ROTATION | EFFECT_GYROSCOPIC | EFFECT_SPATIAL;

/* ---- late contacts --------------------------------------------------------------------------- */

/* Energy that the scene may come to have over the run [J]. */
static double energy_most(const scene_spec *s, const world *w, double T) {
  const double g = v3_norm(s->gravity);
  double weight = 0.0;
  for (int i = 0; i < s->n_body; i++) {
    weight += s->body[i].kinematic ? 0.0 : s->body[i].mass * g;
  }
  const double fall = world_surface_speed(w) * T + 0.5 * g * T * T;
  return world_kinetic(w) + weight * fall;
}

/* Do the two sides of some contact have these names? A side of the set touches where it is closed. */
static bool touches(const world *w, const contact_set *c, const char *a, const char *b) {
  for (int i = 0; i < c->n_contact; i++) {
    const char *x;
    const char *y;
    world_contact_pair(w, c->id[i], &x, &y);
    const bool same =
        (strcmp(x, a) == 0 && strcmp(y, b) == 0) || (strcmp(x, b) == 0 && strcmp(y, a) == 0);
    if (same && c->gap[i] <= 1e-6 * world_size(w)) {
      return true;
    }
  }
  return false;
}

/* Where bodies are without the radius that holds them: from the spec's shape, generously. */
static double radius_of(const spec_shape *s) {
  double r =
      s->r + sqrt(s->half[0] * s->half[0] + s->half[1] * s->half[1] + s->half[2] * s->half[2]);
  for (int i = 0; i < s->n_vertex; i++) {
    r = fmax(r, hypot(s->vertex[i][0], s->vertex[i][1]));
  }
  for (int i = 0; i < s->n_part; i++) {
    r = fmax(r, v3_norm(s->part[i].pos) + radius_of(&s->part[i].shape));
  }
  return r;
}

static bool late(const scene_spec *s, const world *w, const contact_set *c, double T) {
  const double E = energy_most(s, w, T);
  for (int i = 0; i < s->n_body; i++) {
    const spec_body *a = &s->body[i];
    const double ra = radius_of(&a->shape);
    const double va = sqrt(2.0 * E / a->mass);
    for (int k = 0; k < s->n_static; k++) {
      const spec_static *plane = &s->fixed[k];
      const double away = v3_dot(plane->normal, a->pos) - plane->offset - ra;
      if (away < va * T && !touches(w, c, a->name, plane->name)) {
        return true;
      }
    }
    for (int k = i + 1; k < s->n_body; k++) {
      const spec_body *b = &s->body[k];
      double d[3];
      v3_sub(a->pos, b->pos, d);
      const double away = v3_norm(d) - ra - radius_of(&b->shape);
      if (away < (va + sqrt(2.0 * E / b->mass)) * T && !touches(w, c, a->name, b->name)) {
        return true;
      }
    }
  }
  return false;
}

/* ---- what may turn --------------------------------------------------------------------------- */

/* Contacts of one body with the half-spaces. */
typedef struct feet {
  int n;
  double (*x)[3]; /* points [m] */
  double normal[3];
  double mu;
  bool one_plane;
} feet;

static void find_feet(const world *w, const contact_set *c, int body, feet *f) {
  f->n = 0;
  f->mu = 0.0;
  f->one_plane = true;
  for (int i = 0; i < c->n_contact; i++) {
    if (c->body[2 * i] != body || c->body[2 * i + 1] >= 0) {
      f->one_plane = f->one_plane && c->body[2 * i + 1] != body;
      continue;
    }
    const double *n = c->frame + 9 * (ptrdiff_t)i;
    if (f->n == 0) {
      v3_copy(n, f->normal);
    }
    f->one_plane =
        f->one_plane && v3_dot(n, f->normal) > 1.0 - 1e-9 && c->gap[i] <= 1e-6 * world_size(w);
    f->mu = fmax(f->mu, c->mu_static[i]);
    world_contact_point(w, i, f->x[f->n++]);
  }
}

/* Does the centre x keep clear of the line through feet i and j, in the plane of the feet, where that is an edge of
 * them? */
static bool clear_of_edge(const feet *f, const double x[3], int i, int j) {
  double along[3], out[3], d[3];
  v3_sub(f->x[j], f->x[i], along);
  v3_cross(along, f->normal, out);
  const double length = v3_norm(out);
  if (!(length > 0.0)) {
    return true;
  }
  for (int k = 0; k < f->n; k++) {
    v3_sub(f->x[k], f->x[i], d);
    if (v3_dot(d, out) > 1e-9 * length * length) {
      return true; /* feet beyond it: no edge */
    }
  }
  v3_sub(x, f->x[i], d);
  return -v3_dot(d, out) / length > f->mu * fabs(v3_dot(d, f->normal)) * (1.0 + 1e-9);
}

static bool stands(const feet *f, const double x[3], int dim) {
  if (!f->one_plane || f->n < dim) {
    return false;
  }
  if (dim == 2) { /* feet to both sides of the centre, far enough */
    double left = 0.0;
    double right = 0.0;
    double height = 0.0;
    for (int k = 0; k < f->n; k++) {
      double d[3];
      v3_sub(f->x[k], x, d);
      const double t = d[0] * f->normal[1] - d[1] * f->normal[0];
      left = fmin(left, t);
      right = fmax(right, t);
      height = fmax(height, -v3_dot(d, f->normal));
    }
    return fmin(-left, right) > f->mu * height * (1.0 + 1e-9);
  }
  bool edge = false;
  for (int i = 0; i < f->n; i++) {
    for (int j = 0; j < f->n; j++) {
      if (i != j && !clear_of_edge(f, x, i, j)) {
        return false;
      }
      edge = edge || i != j;
    }
  }
  return edge;
}

static bool turns_over(const scene_spec *s, const spec_body *b) {
  const double *I = b->inertia;
  return s->dim == 3 && v3_norm(b->omega) > 0.0 && I[0] != I[1] && I[1] != I[2] && I[0] != I[2];
}

static base_status may_turn(const scene_spec *s, const world *w, const contact_set *c,
                            bool *unstable, base_error *err) {
  feet f = {.x = malloc(((size_t)c->n_contact + 1) * sizeof *f.x)};
  if (f.x == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "effects: no memory for %d contacts", c->n_contact);
  }
  *unstable = false;
  for (int i = 0, free_body = 0; i < s->n_body && !*unstable; i++) {
    const spec_body *b = &s->body[i];
    find_feet(w, c, free_body++, &f);
    *unstable =
        b->lock != 0 || turns_over(s, b) || (spec_can_rotate(s, b) && !stands(&f, b->pos, s->dim));
  }
  free(f.x);
  return BASE_OK;
}

/* ---- what acts from the start ---------------------------------------------------------------- */

/* Friction, rolling and torsion whose coefficients at closed contacts (over the size of the smallest body) exceed the level: what
 * they change is of the size of their coefficient. */
static unsigned acting(const world *w, const contact_set *c, double level) {
  const double size = world_size(w);
  unsigned acts = 0;
  for (int i = 0; i < c->n_contact; i++) {
    if (c->gap[i] > 1e-6 * size) {
      continue;
    }
    acts |= (c->mu_static[i] > level) ? EFFECT_FRICTION : 0u;
    acts |= (c->mu_rolling != NULL && c->mu_rolling[i] > level * size) ? EFFECT_ROLLING : 0u;
    acts |= (c->mu_torsion != NULL && c->mu_torsion[i] > level * size) ? EFFECT_TORSION : 0u;
  }
  return acts;
}

/* ---- the rules ------------------------------------------------------------------------------- */

static base_status judge(const scene_spec *s, world *w, const effects_span *span,
                         effects_verdict *out, base_error *err) {
  contact_set c;
  bool unstable = false;
  BASE_TRY(world_contacts(w, span->h, -1.0, &c, err));
  const bool driven = (world_occurring(w) & (EFFECT_LOADS | EFFECT_MOTION)) != 0;
  out->all = driven                           ? "loads"
             : s->n_joint > 0                 ? "joints"
             : late(s, w, &c, span->duration) ? "late"
                                              : NULL;
  if (out->all == NULL) {
    BASE_TRY(may_turn(s, w, &c, &unstable, err));
    out->unstable = unstable ? turning : 0u;
    out->acting = acting(w, &c, span->level);
  }
  return BASE_OK;
}

base_status effects_rules(const scene_spec *spec, const effects_span *span, effects_verdict *out,
                          base_error *err) {
  world *w;
  *out = (effects_verdict){0};
  if (spec->model != NULL) {
    out->all = "coordinates";
    return BASE_OK;
  }
  BASE_TRY(world_open(&w, spec, spec->effects, err));
  const base_status done = judge(spec, w, span, out, err);
  world_close(w);
  return done;
}

const char *effects_rule(const effects_verdict *v, unsigned bit) {
  if (v->all != NULL) {
    return v->all;
  }
  return ((v->acting & bit) != 0) ? "acts" : ((v->unstable & bit) != 0) ? "unstable" : NULL;
}
