/* world_residual.c - axes and what acts on them in a step, as world_omitted.c, world_feet.c, world_standing.c and
 * world_steady.c count it. */
#include "problems/world/world_residual.h"

#include "problems/vec.h"

unsigned world_free_axes(const world *w, int i, unsigned effects) {
  const spec_body *s = &w->spec.body[i];
  return s->kinematic ? 0u : body_axes(w->dim, effects) & ~(s->lock | s->prescribed);
}

unsigned world_locked_now(const world *w, int i, unsigned effects) {
  return world_free_axes(w, i, effects) & ~world_free_axes(w, i, w->effects);
}

bool world_is_ball(const world *w, int i) {
  const body *b = &w->body[i];
  const piece *p = &w->piece[b->first_piece];
  return b->n_piece == 1 && p->kind == PIECE_POINT && v3_norm(p->vertex) == 0.0 &&
         (w->dim == 2 || (b->inertia[0] == b->inertia[1] && b->inertia[1] == b->inertia[2]));
}

void world_contact_impulse(const world *w, int i, const double *impulse, double *f, double *m) {
  static const double z[3] = {0, 0, 1};
  const set_store *s = &w->store;
  const double *frame = s->frame + 9 * (ptrdiff_t)i;
  const double *row = impulse + s->row_start[i];
  const contact_rows r = s->rows[i];
  memset(m, 0, 3 * sizeof *m);
  v3_scale(*row++, frame, f);
  for (int k = 0; k < r.tangent; k++) {
    v3_add_scaled(f, *row++, frame + 3 + 3 * (ptrdiff_t)k, f);
  }
  if (r.torsion > 0) {
    v3_add_scaled(m, *row++, frame, m);
  }
  if (r.rolling == 1) {
    v3_add_scaled(m, *row, (w->dim == 2) ? z : frame + 6, m);
  }
  for (int k = 0; r.rolling == 2 && k < 2; k++) {
    v3_add_scaled(m, *row++, frame + 3 + 3 * (ptrdiff_t)k, m);
  }
}

/* ---- what acts ------------------------------------------------------------------------------- */

static void push(const world *w, int side, const double *at, const double *impulse, double sign) {
  if (side < 0 || side >= w->n_body) {
    return;
  }
  double arm[3], moment[3];
  double *f = world_residual(w, side)->wrench;
  v3_sub(at, w->body[side].at.x, arm);
  v3_cross(arm, impulse, moment);
  v3_add_scaled(f, sign, impulse, f);
  v3_add_scaled(f + 3, sign, moment, f + 3);
}

static void twist(const world *w, int side, const double *moment, double sign) {
  if (side >= 0 && side < w->n_body) {
    double *f = world_residual(w, side)->wrench;
    v3_add_scaled(f + 3, sign, moment, f + 3);
  }
}

static void add_contacts(const world *w, const double *impulse) {
  const set_store *s = &w->store;
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    double f[3], m[3];
    world_contact_impulse(w, i, impulse, f, m);
    push(w, c->a, c->x, f, 1.0);
    push(w, c->b, c->x, f, -1.0);
    twist(w, c->a, m, 1.0);
    twist(w, c->b, m, -1.0);
  }
}

static void add_joints(const world *w, const double *impulse) {
  joint_row row[JOINT_ROWS_MAX];
  const double *p = impulse + w->store.row_start[w->set.n_contact];
  for (int i = 0; i < w->n_joint; i++) {
    const joint_data *j = &w->joint[i];
    const int n = joint_rows_posed(w, j, row);
    for (int k = 0; k < n; k++, p++) {
      double f[3];
      v3_scale(*p, row[k].d, f);
      if (row[k].angular) {
        twist(w, j->a, f, 1.0);
        twist(w, j->b, f, -1.0);
      } else {
        push(w, j->a, row[k].p_a, f, 1.0);
        push(w, j->b, row[k].p_b, f, -1.0);
      }
    }
  }
}

/* Gravity and loads, as they were taken at the start of the step, and omega x I omega; of what sleeps nothing, as its contacts are not there. */
static void add_loads(const world *w) {
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    residual *r = world_residual(w, i);
    double *f = r->wrench;
    for (int k = 0; k < AXES; k++) {
      f[k] = (b->sleeps == 0) ? w->h * w->store.wrench[AXES * (ptrdiff_t)i + k] : 0.0;
    }
    if (w->dim == 3 && b->spins) {
      double I[9], L[3], c[3];
      body_inertia(b, w->dim, I);
      m3_mul_vec(I, b->v + 3, L);
      v3_cross(b->v + 3, L, c);
      v3_add_scaled(f + 3, -w->h, c, f + 3);
    }
    memcpy(r->load, f, sizeof r->load);
  }
}

void world_add_wrenches(const world *w, const double *impulse) {
  add_loads(w);
  add_contacts(w, impulse);
  add_joints(w, impulse);
}
