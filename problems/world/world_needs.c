/* world_needs.c - which effects a motion needs, before any step of it is taken. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

unsigned world_axis_needs(int axis, int dim) {
  const bool turns = axis >= 3;
  const bool in_plane = dim == 2 || axis == 0 || axis == 2 || axis == 4;
  return (turns ? EFFECT_ROTATION : 0u) | (in_plane ? 0u : EFFECT_SPATIAL);
}

void world_side_motion(const world *w, int side, const double *v_next, const double *at,
                       double *velocity, double *spin) {
  memset(velocity, 0, 3 * sizeof *velocity);
  memset(spin, 0, 3 * sizeof *spin);
  if (side >= w->n_body) {
    v3_copy(world_has(w, EFFECT_MOTION) ? w->spec.fixed[side - w->n_body].surface_velocity : spin,
            velocity);
    return;
  }
  const body *b = &w->body[side];
  double arm[3], v[AXES];
  memcpy(v, b->v, sizeof v);
  if (b->driven) {
    body_driven(b, w->t + w->h, v);
  }
  for (int k = 0; k < b->n_dof; k++) {
    v[b->axis[k]] = v_next[b->dof + k];
  }
  v3_sub(at, b->at.x, arm);
  v3_copy(v + 3, spin);
  v3_cross(spin, arm, velocity);
  v3_add_scaled(velocity, 1.0, v, velocity);
}

void world_contact_motion(const world *w, int i, const double *v_next, double *velocity,
                          double *spin) {
  const contact_item *c = &w->store.item[w->store.key[i].item];
  double ub[3], wb[3];
  world_side_motion(w, c->a, v_next, c->x, velocity, spin);
  world_side_motion(w, c->b, v_next, c->x, ub, wb);
  v3_sub(velocity, ub, velocity);
  v3_sub(spin, wb, spin);
}

unsigned world_moved_by(const scene_spec *s, unsigned effects) {
  unsigned moved = 0;
  for (int i = 0; i < s->n_body; i++) {
    const spec_body *b = &s->body[i];
    for (int k = 0; k < AXES; k++) {
      const double v = (k < 3) ? b->vel[k] : b->omega[k - 3];
      const double a = (k < 3 && b->kinematic) ? b->acc[k] : b->prescribed_a[k];
      if (v != 0.0 || a != 0.0 || b->prescribed_v0[k] != 0.0) {
        moved |= world_axis_needs(k, s->dim);
      }
    }
  }
  for (int i = 0; i < s->n_static; i++) { /* belts */
    for (int k = 0; k < 3; k++) {
      moved |= (s->fixed[i].surface_velocity[k] != 0.0) ? world_axis_needs(k, s->dim) : 0u;
    }
  }
  return moved & effects;
}

bool world_turns_out_of_plane(const world *w) {
  bool out = false;
  for (int i = 0; w->dim == 3 && w->model == NULL && !out && i < w->n_body; i++) {
    double I[9];
    body_inertia(&w->body[i], w->dim, I);
    out = fmax(fabs(I[1]), fabs(I[5])) > 1e-14 * fmax(I[0], fmax(I[4], I[8]));
  }
  return out;
}

unsigned world_moves(const world *w, unsigned effects, double least) {
  unsigned moves = 0;
  for (int i = 0; i < w->n_body && w->model == NULL; i++) {
    const body *b = &w->body[i];
    for (int k = 0; k < AXES; k++) {
      const double reach = (k < 3) ? 1.0 : fmax(b->bound, w->size);
      moves |= (fabs(b->v[k]) * reach > least) ? world_axis_needs(k, w->dim) : 0u;
    }
  }
  return moves & effects;
}

/* A normal neither in the plane nor across it pushes out of it. */
static bool leans(const double *n) {
  const double across = fabs(n[1]);
  return across > 1e-14 && across < 1.0 - 1e-14;
}

/* Velocity of the first side over the second where bodies go without contacts: against the normal, and what slides. */
static void free_velocity(const world *w, int i, double *press, double *slide) {
  const double *n = w->store.frame + 9 * (ptrdiff_t)i;
  double u[3], spin[3];
  world_contact_motion(w, i, w->store.v_free, u, spin);
  const double along = v3_dot(u, n);
  v3_add_scaled(u, -along, n, u);
  *press = fmax(-along, 0.0);
  *slide = v3_norm(u);
}

/* Of the contacts from `first` on of one body, its first side. *end: behind the last of them. */
static void foresee_body(const world *w, int first, unsigned effects, double change[EFFECT_COUNT],
                         world_growth *grown, int *end) {
  const set_store *s = &w->store;
  const int own = s->item[s->key[first].item].a;
  const double *normal = NULL;
  double rubs = 0.0, across = 0.0;
  bool parallel = true; /* else normal forces may stop the sliding */
  int i = first;
  for (; i < w->set.n_contact && s->item[s->key[i].item].a == own; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const double *n = s->frame + 9 * (ptrdiff_t)i;
    double press, slide;
    if (s->gap[i] > w->set.tol) {
      continue;
    }
    free_velocity(w, i, &press, &slide);
    normal = (normal != NULL) ? normal : n;
    parallel = parallel && v3_dot(n, normal) > 1.0 - 1e-6;
    rubs = fmax(rubs, fmin(pair_value(&w->mu, c->a, c->b) * press, slide));
    if (w->dim == 3 && leans(n)) {
      across = fmax(across, press);
    }
  }
  rubs = (parallel && (effects & EFFECT_FRICTION) != 0) ? rubs : 0.0;
  across = ((effects & EFFECT_SPATIAL) != 0) ? across : 0.0;
  change[EFFECT_FRICTION_BIT] = fmax(change[EFFECT_FRICTION_BIT], rubs);
  change[EFFECT_SPATIAL_BIT] = fmax(change[EFFECT_SPATIAL_BIT], across);
  for (int k = first; k < i; k++) {
    const contact_item *c = &s->item[s->key[k].item];
    for (int side = 0; side < 2 && s->gap[k] <= w->set.tol; side++) {
      const int at = (side == 0) ? c->a : c->b;
      if (at < w->n_body) {
        grown[at].moved = fmax(grown[at].moved, rubs + across);
      }
    }
  }
  *end = i;
}

void world_foreseen(const world *w, unsigned effects, double change[EFFECT_COUNT],
                    world_growth *grown) {
  memset(change, 0, EFFECT_COUNT * sizeof *change);
  for (int i = 0; i < w->n_body; i++) {
    grown[i].moved = grown[i].spun = 0.0;
  }
  for (int i = 0; i < w->set.n_contact;) {
    foresee_body(w, i, effects, change, grown, &i);
  }
}
