#include "harness/control/features.h"

#include "problems/world/world.h"

#include <math.h>
#include <string.h>

static const char *const names[FEATURES] = {"bodies",      "contacts",  "per_body", "redundant",
                                            "sliding",     "closing",   "spatial",  "friction",
                                            "restitution", "resisting", "joints",   "moving"};

/* Slower than this share of the fastest body counts as at rest. */
static const double slow = 1e-6;

const char *features_name(int i) {
  return (i >= 0 && i < FEATURES) ? names[i] : NULL;
}

double features_of_name(const features *f, const char *name) {
  for (int i = 0; i < FEATURES; i++) {
    if (strcmp(names[i], name) == 0) {
      return f->x[i];
    }
  }
  return 0.0;
}

static double share(int n, int of) {
  return (of > 0) ? (double)n / of : 0.0;
}

static void of_set(const world *w, const contact_set *c, features *out) {
  const double still = slow * world_surface_speed(w);
  int sliding = 0;
  int closing = 0;
  bool friction = false;
  bool restitution = false;
  bool resisting = false;
  for (int i = 0; i < c->n_contact; i++) {
    const double *u = c->u_before + c->row_start[i];
    double tangential = 0.0;
    for (int k = 1; k <= c->rows[i].tangent; k++) {
      tangential = fmax(tangential, fabs(u[k]));
    }
    sliding += tangential > still;
    closing += u[0] < -still;
    friction = friction || c->rows[i].tangent > 0;
    restitution = restitution || (c->restitution != NULL && c->restitution[i] > 0.0);
    resisting = resisting || c->rows[i].torsion + c->rows[i].rolling > 0;
  }
  const int joint_rows = c->n_row - c->row_start[c->n_contact];
  const double per_body = share(c->n_contact, c->n_body);
  const double x[FEATURES] = {0.25 * log2(1.0 + c->n_body),
                              0.25 * log2(1.0 + c->n_contact),
                              0.5 * log2(1.0 + per_body),
                              fmin(share(c->n_contact + joint_rows, c->n_dof), 2.0),
                              share(sliding, c->n_contact),
                              share(closing, c->n_contact),
                              c->dim == 3,
                              friction,
                              restitution,
                              resisting,
                              joint_rows > 0,
                              world_max_speed(w) > 0.0};
  memcpy(out->x, x, sizeof x);
}

base_status features_of(const scene_spec *spec, unsigned effects, double h, features *out,
                        base_error *err) {
  world *w;
  contact_set c;
  BASE_TRY(world_open_over(&w, spec, effects, err));
  const base_status done = world_contacts(w, h, -1.0, &c, err);
  if (done == BASE_OK) {
    of_set(w, &c, out);
    /* what no contact shows yet stands in the scene's coefficients */
    const unsigned occurring = world_occurring(w);
    out->x[7] = fmax(out->x[7], (occurring & EFFECT_FRICTION) != 0);
    out->x[8] = fmax(out->x[8], (occurring & EFFECT_RESTITUTION) != 0);
    out->x[9] = fmax(out->x[9], (occurring & (EFFECT_ROLLING | EFFECT_TORSION)) != 0);
  }
  world_close(w);
  return done;
}

double features_distance(const features *a, const features *b) {
  double sum = 0.0;
  for (int i = 0; i < FEATURES; i++) {
    sum += (a->x[i] - b->x[i]) * (a->x[i] - b->x[i]);
  }
  return sqrt(sum);
}
