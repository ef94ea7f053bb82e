/* world_curve.c - h (dJ/dt) v of every row. Of contacts by displacing the configuration along the motion
 * by +d and -d seconds at fixed velocities: (u(+d) - u(-d)) / (2 d); of joints in closed form
 * (world_joints.c). */
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Displacement in steps. The truncation is of second order in it, the rounding 1e-16 over it. */
static const double reach_in_steps = 1e-3;
/* What turns by less in a step stands still [rad]. */
static const double still = 1e-10;

static base_status look(world *w, double h, double margin, const double *config, const double *v,
                        curve_store *k, base_error *err) {
  contact_set c;
  world_set_state(w, w->t, config, v);
  BASE_TRY(world_contacts(w, h, margin, &c, err));
  BASE_TRY(world_reserve(w, PER_SEEN, (size_t)c.n_contact, err));
  BASE_TRY(world_reserve(w, PER_SEEN_ROW, (size_t)c.n_row, err));
  k->n_contact = c.n_contact;
  if (c.n_contact == 0) {
    return BASE_OK;
  }
  memcpy(k->id, c.id, (size_t)c.n_contact * sizeof *k->id);
  memcpy(k->row_start, c.row_start, ((size_t)c.n_contact + 1) * sizeof *k->row_start);
  memcpy(k->u, c.u_before, (size_t)c.row_start[c.n_contact] * sizeof *k->u);
  return BASE_OK;
}

/* Rows of contact id, or NULL; ids ascend, so the cursor only moves forward. */
static const double *rows_of(const curve_store *k, uint64_t id, int *cursor) {
  while (*cursor < k->n_contact && k->id[*cursor] < id) {
    ++*cursor;
  }
  const bool found = *cursor < k->n_contact && k->id[*cursor] == id;
  return found ? k->u + k->row_start[*cursor] : NULL;
}

static void difference(world *w, double d, contact_set *c) {
  int a = 0, b = 0;
  memset(w->curve, 0, (size_t)c->n_row * sizeof *w->curve);
  for (int i = 0; i < c->n_contact; i++) {
    const int first = c->row_start[i];
    const double *ahead = rows_of(&w->ahead, c->id[i], &a);
    const double *behind = rows_of(&w->behind, c->id[i], &b);
    const double over = (ahead != NULL && behind != NULL) ? 2.0 * d : d;
    if (ahead == NULL && behind == NULL) {
      continue;
    }
    for (int r = 0; r < c->row_start[i + 1] - first; r++) {
      const double here = c->u_before[first + r];
      const double from = (behind != NULL) ? behind[r] : here;
      const double to = (ahead != NULL) ? ahead[r] : here;
      w->curve[first + r] = c->h * (to - from) / over;
    }
  }
  const int joints = c->row_start[c->n_contact];
  for (int r = joints; r < c->n_row; r++) {
    w->curve[r] = c->h * w->store.joint_curve[r - joints];
  }
  c->u_curve = w->curve;
}

base_status world_contacts_curved(world *w, double h, double margin, contact_set *out,
                                  base_error *err) {
  const size_t nc = (size_t)world_n_config(w), nv = (size_t)world_n_dof(w);
  const double d = reach_in_steps * h;
  BASE_TRY(world_reserve(w, PER_DISPLACED, 3 * nc + nv, err));
  double *config = w->displaced, *rate = config + nc, *moved = rate + nc, *v = moved + nc;
  world_get_state(w, config, v);
  world_config_rate(w, config, v, rate);
  for (int side = -1; side <= 1; side += 2) {
    for (size_t i = 0; i < nc; i++) {
      moved[i] = config[i] + side * d * rate[i];
    }
    const base_status s = look(w, h, margin, moved, v, (side > 0) ? &w->ahead : &w->behind, err);
    if (s != BASE_OK) {
      world_set_state(w, w->t, config, v);
      return s;
    }
  }
  world_set_state(w, w->t, config, v);
  BASE_TRY(world_contacts(w, h, margin, out, err));
  BASE_TRY(world_reserve(w, PER_CURVE, (size_t)out->n_row, err));
  difference(w, d, out);
  return BASE_OK;
}

bool world_turns(const world *w, double h) {
  double most = (w->model != NULL) ? HUGE_VAL : 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    most = b->round ? most : fmax(most, v3_norm(b->v + 3));
    for (int k = b->first_piece; k < b->first_piece + b->n_piece; k++) {
      const piece *p = &w->piece[k];
      most = (p->r > 0.0) ? fmax(most, v3_norm(b->v) / p->r) : most;
    }
  }
  return most * h > still;
}

/* Rows of contact i from the first on that obey its frame at the end of the step: all where it holds, or slips by less than the frame turns;
 * else friction is along the slip where it acts, and the normal only. */
static int turned_rows(const contact_set *c, int i, const double *curve) {
  double slip = 0.0;
  double turn = 0.0;
  for (int k = 1; k <= c->rows[i].tangent; k++) {
    slip = hypot(slip, c->u_before[c->row_start[i] + k]);
    turn = hypot(turn, curve[k]);
  }
  return (c->gap[i] > c->tol) ? 0 : 1 + ((slip <= turn) ? c->rows[i].tangent : 0);
}

base_status world_contacts_turned(world *w, double h, double margin, contact_set *out,
                                  base_error *err) {
  BASE_TRY(world_contacts_curved(w, h, margin, out, err));
  for (int i = 0; i < out->n_group; i++) {
    const int first = out->row_start[i];
    const bool contact = i < out->n_contact;
    const int n = contact ? turned_rows(out, i, w->curve + first) : out->row_start[i + 1] - first;
    for (int k = 0; k < n; k++) {
      w->store.u_drift[first + k] += w->curve[first + k];
    }
  }
  return BASE_OK;
}
