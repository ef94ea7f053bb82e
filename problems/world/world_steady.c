/* world_steady.c - what a step makes of bodies that are not where they should be: does a deviation keep its velocity, by how much does it
 * grow, do contacts act alike with it? */
#include "problems/vec.h"
#include "problems/world/world_residual.h"

static const double turning =
    1e-8; /* of the speed of a body, and of what gravity gives it in a step: rounding */

/* Do the loads not depend on places? */
static bool loads_stay(const world *w) {
  for (int k = 0; k < w->spec.n_load; k++) {
    const spec_load_kind kind = w->spec.load[k].kind;
    if (kind != SPEC_FORCE && kind != SPEC_FORCE_RAMP && kind != SPEC_FORCE_SINE) {
      return false;
    }
  }
  return true;
}

/* Does body i turn at the start of the step, or at its end? */
static bool turns(const world *w, int i, const double *v_next) {
  const body *b = &w->body[i];
  double speed[3], spin[3];
  world_side_motion(w, i, v_next, b->at.x, speed, spin);
  const double most = fmax(v3_norm(spin), v3_norm(b->v + 3));
  return b->bound * most > turning * (v3_norm(speed) + w->h * v3_norm(w->spec.gravity));
}

static bool parallel(const double *n, const double *d) {
  return fabs(v3_dot(n, d)) > (1.0 - 1e-12) * v3_norm(d);
}

/* Is n the normal of a face of the piece, whose body is at `at`? */
static bool is_face_of(const piece *p, const pose *at, const double *n) {
  bool face = false;
  double R[9], d[3], edge[3];
  m3_mul(at->R, p->rot, R);
  for (int k = 0; k < 3 && p->kind == PIECE_BOX && !face; k++) {
    const double axis[3] = {R[k], R[3 + k], R[6 + k]};
    face = parallel(n, axis);
  }
  for (int k = 0; k < p->n_vertex && p->kind == PIECE_POLYGON && !face; k++) {
    v3_sub(p->vertex + 3 * (ptrdiff_t)((k + 1) % p->n_vertex), p->vertex + 3 * (ptrdiff_t)k, edge);
    m3_mul_vec(at->R, edge, d);
    face = fabs(v3_dot(n, d)) < 1e-6 * v3_norm(d);
  }
  return face;
}

/* Is n the normal of a face of side i that does not turn? */
static bool is_still_face(const world *w, int i, const double *n, const double *v_next) {
  if (i >= w->n_body) {
    return true; /* a plane */
  }
  const body *b = &w->body[i];
  bool face = false;
  for (int k = 0; k < b->n_piece && !face; k++) {
    face = is_face_of(&w->piece[b->first_piece + k], &b->at, n);
  }
  return face && !turns(w, i, v_next);
}

/* Of the side of a contact that pushes with f: what counts as going with places. */
static void add_press(const world *w, int side, bool turned, const double *f) {
  if (side < w->n_body) {
    residual *r = world_residual(w, side);
    r->press += (turned || r->firm == 0.0) ? v3_norm(f) : 0.0;
  }
}

/* Impulses that go with the places of the bodies, onto each: of contacts whose normal turns, and on bodies that may. */
static void add_presses(const world *w, const double *v_next, const double *impulse) {
  const set_store *s = &w->store;
  for (int i = 0; i < w->n_body; i++) {
    world_residual(w, i)->press = 0.0;
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const double *n = s->frame + 9 * (ptrdiff_t)i;
    if (!(impulse[s->row_start[i]] > 0.0)) {
      continue;
    }
    double f[3], m[3];
    world_contact_impulse(w, i, impulse, f, m);
    const bool turned = !is_still_face(w, c->b, n, v_next) && !is_still_face(w, c->a, n, v_next);
    add_press(w, c->a, turned, f);
    add_press(w, c->b, turned, f);
  }
}

/* Do bodies push each other? */
static bool shared(const world *w, const double *impulse) {
  const set_store *s = &w->store;
  bool some = false;
  for (int i = 0; i < w->set.n_contact && !some; i++) {
    some = impulse[s->row_start[i]] > 0.0 && s->item[s->key[i].item].b < w->n_body;
  }
  return some;
}

/* Adds what body i makes of deviations. tied: what acts on it may go with its place. Of what turns with w by some angle more, velocities
 * on its contacts differ by w times that, in a step of h by h w^2 times the place. */
static void add_body(const world *w, int i, bool tied, const double *v_next, world_growth *g) {
  const body *b = &w->body[i];
  double speed[3], spin[3], turn = 0.0;
  if (!world_is_ball(w, i)) {
    world_side_motion(w, i, v_next, b->at.x, speed, spin);
    turn = fmax(v3_norm(spin), v3_norm(b->v + 3));
  }
  const double falls = tied ? w->h * v3_norm(w->spec.gravity) / w->size : 0.0;
  const double pushed = fmax(falls, world_residual(w, i)->press / (b->mass * w->size));
  if (pushed > 0.0 || tied) {
    g->place = fmax(g->place, pushed + w->h * turn * turn);
  }
  g->speed = (w->dim == 3) ? fmax(g->speed, w->h * turn) : g->speed;
}

/* Does some body turn? What does, or may go with its place, does not stand firmly. */
static bool any_turns(const world *w, bool tied, const double *v_next) {
  bool some = false;
  for (int i = 0; i < w->n_body; i++) {
    const bool turned = !world_is_ball(w, i) && turns(w, i, v_next);
    some = some || turned;
    if (turned || tied) {
      world_residual(w, i)->firm = 0.0;
    }
  }
  return some;
}

world_growth world_grown(const world *w, unsigned effects, const double *v_next,
                         const double *impulse) {
  const bool tied = w->n_joint > 0 || !loads_stay(w);
  const bool firm = !tied && world_stands_firmly(w, effects, impulse);
  const bool turned = any_turns(w, tied, v_next);
  world_growth g = {.shared = tied || shared(w, impulse), .turned = !firm || turned};
  if (g.shared || g.turned) {
    add_presses(w, v_next, impulse);
    for (int i = 0; i < w->n_body; i++) {
      add_body(w, i, tied, v_next, &g);
    }
  }
  return g;
}

double world_swing(const world *w) {
  double most = 1.0;
  for (int i = 0; i < w->n_body && w->model == NULL; i++) {
    const body *b = &w->body[i];
    if (!w->spec.body[i].kinematic && !world_is_ball(w, i)) {
      most = fmax(most, sqrt(1.0 + b->bound * b->bound * b->mass / world_least_inertia(w, i)));
    }
  }
  return most;
}

/* ---- impacts ---------------------------------------------------------------------------------- */

/* Of contact i, at the dofs' velocities v: what its sides part with along the normal [m/s]. */
static double parting(const world *w, int i, const double *v) {
  const contact_item *c = &w->store.item[w->store.key[i].item];
  double ua[3], ub[3], spin[3];
  world_side_motion(w, c->a, v, c->x, ua, spin);
  world_side_motion(w, c->b, v, c->x, ub, spin);
  v3_sub(ua, ub, ua);
  return v3_dot(ua, w->store.frame + 9 * (ptrdiff_t)i);
}

/* Do the contacts that carry body `own` push along the normal of contact i, or across it? */
static bool upright(const world *w, int i, int own, const double *impulse) {
  const set_store *s = &w->store;
  for (int k = 0; k < w->set.n_contact; k++) {
    if (impulse[s->row_start[k]] > 0.0 && s->item[s->key[k].item].a == own) {
      const double d = fabs(v3_dot(s->frame + 9 * (ptrdiff_t)i, s->frame + 9 * (ptrdiff_t)k));
      if (d > 1e-9 && d < 1.0 - 1e-9) {
        return false;
      }
    }
  }
  return true;
}

/* Contact i, which an approach at `before` meets: does it bounce, or not, by more than `unsure` [m/s]? An approach of some steps of load
 * is rest; how many is the formulation's to say. */
static bool bounces_alike(const world *w, int i, double before, double unsure,
                          const double *impulse) {
  static const double fewest = 1.0, most = 4.0;
  if (w->set.restitution == NULL || w->set.restitution[i] == 0.0) {
    return true;
  }
  const double gain = fmax(0.0, before - parting(w, i, w->store.v_free));
  const bool decided = -before < fewest * gain - unsure || -before > most * gain + unsure;
  return decided && upright(w, i, w->store.item[w->store.key[i].item].a, impulse);
}

bool world_contacts_alike(const world *w, const double *v_next, const double *impulse, double place,
                          double speed) {
  static const unsigned laws = EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION;
  const double tol = w->set.tol;
  for (int i = 0; i < w->set.n_contact; i++) {
    const int row = w->store.row_start[i];
    const double before = w->store.u_before[row], after = parting(w, i, v_next);
    const double unsure = 2.0 * speed + turning * (fabs(before) + w->h * v3_norm(w->spec.gravity));
    const bool carries = impulse[row] > 0.0;
    const bool pressed = !carries || before - parting(w, i, w->store.v_free) > unsure;
    const bool rests = pressed && fabs(before) <= unsure && fabs(after) <= unsure;
    const double gap = w->store.gap[i], gap_before = gap - w->h * before; /* of the last step */
    const bool passes = !carries && (after > unsure || gap > place + 100.0 * tol);
    const bool closed = gap_before <= tol - place, open = gap_before > tol + place;
    const bool hits =
        gap <= tol - place && (closed || open) && bounces_alike(w, i, before, unsure, impulse);
    if (!rests && !passes && !hits) {
      return false;
    }
  }
  return (w->effects & laws) == 0;
}
