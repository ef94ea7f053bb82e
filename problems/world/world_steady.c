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

/* Notes of each body the last contact that carries it where all that do are of one plane. */
static void note_floors(const world *w, const double *impulse, world_growth *grown) {
  const set_store *s = &w->store;
  enum { OTHERS = -2 };
  for (int i = 0; i < w->n_body; i++) {
    grown[i].floor = -1;
  }
  for (int k = 0; k < w->set.n_contact; k++) {
    const contact_item *c = &s->item[s->key[k].item];
    if (!(impulse[s->row_start[k]] > 0.0)) {
      continue;
    }
    int *at = &grown[c->a].floor;
    const bool same = *at == -1 || (*at >= 0 && c->b == s->item[s->key[*at].item].b);
    *at = (same && c->b >= w->n_body) ? k : OTHERS;
    if (c->b < w->n_body) {
      grown[c->b].floor = OTHERS;
    }
  }
}

/* Notes by how much body i turns at the start of the step, or at its end; 0: it is a ball, or it does not, or as it lies on a floor. And
 * what its friction turns it by there: nothing where it slides straight, as feet that balance it carry it under its centre; not known
 * where slips differ, or where axes are locked that the impulses do not balance. */
static void note_turn(const world *w, int i, int floor, unsigned effects, const double *v_next) {
  const body *b = &w->body[i];
  residual *r = world_residual(w, i);
  double speed[3], spin[3], was[3];
  r->turn = 0.0;
  if (world_is_ball(w, i)) {
    return;
  }
  world_side_motion(w, i, v_next, b->at.x, speed, spin);
  v3_copy(b->v + 3, was);
  const double counts = turning * (v3_norm(speed) + w->h * v3_norm(w->spec.gravity));
  const bool spins = b->bound * fmax(v3_norm(spin), v3_norm(was)) > counts;
  const bool locked = (world_locked_now(w, i, effects) & (unsigned)SPEC_ROT) != 0;
  r->yaw = (w->dim == 2 || (floor >= 0 && !spins)) ? 0.0 : (spins || locked) ? HUGE_VAL : r->yaw;
  if (w->dim == 3 && floor >= 0) {
    const double *n = w->store.frame + 9 * (ptrdiff_t)floor;
    v3_add_scaled(spin, -v3_dot(spin, n), n, spin);
    v3_add_scaled(was, -v3_dot(was, n), n, was);
  }
  const double most = fmax(v3_norm(spin), v3_norm(was));
  r->turn = (b->bound * most > counts) ? most : 0.0;
}

/* Is n the normal of a face of the piece, whose body is at `at`? */
static bool is_face_of(const piece *p, const pose *at, const double *n) {
  bool face = false;
  double R[9], d[3], edge[3];
  m3_mul(at->R, p->rot, R);
  for (int k = 0; k < 3 && p->kind == PIECE_BOX && !face; k++) {
    const double axis[3] = {R[k], R[3 + k], R[6 + k]};
    face = v3_along(axis, n, 1e-12);
  }
  for (int k = 0; k < p->n_vertex && p->kind == PIECE_POLYGON && !face; k++) {
    v3_sub(p->vertex + 3 * (ptrdiff_t)((k + 1) % p->n_vertex), p->vertex + 3 * (ptrdiff_t)k, edge);
    m3_mul_vec(at->R, edge, d);
    face = fabs(v3_dot(n, d)) < 1e-6 * v3_norm(d);
  }
  return face;
}

/* Is n the normal of a face of side i, and does that not turn? */
static bool is_still_face(const world *w, int i, const double *n) {
  if (i >= w->n_body) {
    return true; /* a plane */
  }
  const body *b = &w->body[i];
  bool face = false;
  for (int k = 0; k < b->n_piece && !face && world_residual(w, i)->turn == 0.0; k++) {
    face = is_face_of(&w->piece[b->first_piece + k], &b->at, n);
  }
  return face;
}

/* Of the side of a contact that pushes with f: what counts as going with places. */
static void add_press(const world *w, int side, bool turned, const double *f,
                      const world_growth *grown) {
  if (side < w->n_body) {
    residual *r = world_residual(w, side);
    r->press += (turned || grown[side].turned) ? v3_norm(f) : 0.0;
    r->bends += turned ? v3_norm(f) : 0.0;
  }
}

/* Impulses that go with the places of the bodies, onto each: of contacts whose normal turns, and on bodies that may, whose lever arms
 * change. */
static void add_presses(const world *w, const double *impulse, const world_growth *grown) {
  const set_store *s = &w->store;
  const contact_item *last = NULL;
  const double *normal = NULL; /* of the last */
  bool turned = false;
  for (int i = 0; i < w->n_body; i++) {
    world_residual(w, i)->press = world_residual(w, i)->bends = 0.0;
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const double *n = s->frame + 9 * (ptrdiff_t)i;
    if (!(impulse[s->row_start[i]] > 0.0)) {
      continue;
    }
    double f[3], m[3];
    world_contact_impulse(w, i, impulse, f, m);
    const bool same = last != NULL && c->a == last->a && c->b == last->b && n[0] == normal[0] &&
                      n[1] == normal[1] && n[2] == normal[2];
    if (!same) {
      turned = !is_still_face(w, c->b, n) && !is_still_face(w, c->a, n);
      last = c;
      normal = n;
    }
    add_press(w, c->a, turned, f, grown);
    add_press(w, c->b, turned, f, grown);
  }
}

static int first_of(const world_growth *grown, int i) {
  while (grown[i].group != i) {
    i = grown[i].group;
  }
  return i;
}

static bool deviates(const world *w, int side) {
  return side < w->n_body && !w->spec.body[side].kinematic;
}

/* Notes which bodies are pushed, and which push each other. tied: all may. */
static void add_groups(const world *w, bool tied, const double *impulse, world_growth *grown) {
  const set_store *s = &w->store;
  for (int i = 0; i < w->n_body && tied; i++) {
    grown[i].group = 0;
    grown[i].pushed = true;
  }
  for (int i = 0; i < w->set.n_contact && !tied; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    if (!(impulse[s->row_start[i]] > 0.0)) {
      continue;
    }
    if (deviates(w, c->a)) {
      grown[c->a].pushed = true;
    }
    if (deviates(w, c->b)) {
      grown[c->b].pushed = true;
    }
    if (deviates(w, c->a) && deviates(w, c->b)) {
      const int one = first_of(grown, c->a), other = first_of(grown, c->b);
      grown[one > other ? one : other].group = one > other ? other : one;
    }
  }
  for (int i = 0; i < w->n_body; i++) {
    grown[i].group = first_of(grown, i);
  }
}

/* By how much the moments of inertia differ [1]. What turns freely keeps its angular momentum L, and w = J L with J the inverse inertia in
 * space: an angle a more changes w by [a, J] L, at most by that times w a; which grows as a does, and as J turns, twice that times w^2 a. */
static double unlike(const world *w, int i) {
  const double *I = w->body[i].inertia;
  return fmax(I[0], fmax(I[1], I[2])) / world_least_inertia(w, i) - 1.0;
}

/* Adds what body i makes of deviations. falls: what a step makes of a place where what acts on it may go with that (`tied`). Of what turns with w
 * by some angle more, velocities on its contacts differ by w times that, in a step of h by h w^2 times the place. */
static void add_body(const world *w, int i, bool tied, double falls, world_growth *g) {
  const residual *r = world_residual(w, i);
  const double carried = w->h * r->turn * r->turn, size = w->body[i].mass * w->size;
  if (r->press > 0.0 || tied) {
    g->place = fmax(falls, r->bends / size) + carried;
    g->arm = fmax(falls, r->press / size) + carried;
  }
  g->speed = (w->dim == 3) ? w->h * r->turn * unlike(w, i) : 0.0;
  g->whirl = 2.0 * g->speed * r->turn;
}

void world_grown(const world *w, unsigned effects, const double *v_next, const double *impulse,
                 world_growth *grown) {
  const bool tied = w->n_joint > 0 || !loads_stay(w);
  const double falls = tied ? w->h * world_most_acceleration(w) / w->size : 0.0;
  bool some = false;
  note_floors(w, impulse, grown);
  for (int i = 0; i < w->n_body; i++) {
    note_turn(w, i, grown[i].floor, effects, v_next);
    grown[i].turned = tied || world_residual(w, i)->turn > 0.0;
  }
  world_note_firm(w, effects, tied, impulse, grown);
  for (int i = 0; i < w->n_body; i++) {
    some = some || grown[i].turned;
  }
  add_groups(w, tied, impulse, grown);
  for (int i = 0; i < w->n_body && !some; i++) {
    some = grown[i].group != i;
  }
  if (some) {
    add_presses(w, impulse, grown);
    for (int i = 0; i < w->n_body; i++) {
      add_body(w, i, tied, falls, &grown[i]);
    }
  }
}

world_inertia world_inertia_of(const world *w, unsigned effects, int i) {
  const body *b = &w->body[i];
  world_inertia of = {.mass = w->spec.body[i].kinematic ? 0.0 : b->mass, .bound = b->bound};
  const bool turns = (world_free_axes(w, i, effects) & (unsigned)SPEC_ROT) != 0;
  if (of.mass > 0.0 && b->bound > 0.0 && turns) {
    of.gyration = sqrt(world_least_inertia(w, i) / b->mass) / b->bound;
  }
  return of;
}

/* ---- impacts ---------------------------------------------------------------------------------- */

/* Of contact i, at the dofs' velocities v: what its sides part with along the normal [m/s]. */
static double parting(const world *w, int i, const double *v) {
  double u[3], spin[3];
  world_contact_motion(w, i, v, u, spin);
  return v3_dot(u, w->store.frame + 9 * (ptrdiff_t)i);
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

/* Does contact i, whose sides are off by `place` and part by `unsure` more or less? */
static bool acts_alike(const world *w, int i, double place, double unsure, const double *v_next,
                       const double *impulse) {
  const double tol = w->set.tol;
  const int row = w->store.row_start[i];
  const double before = w->store.u_before[row], after = parting(w, i, v_next);
  unsure += turning * (fabs(before) + w->h * v3_norm(w->spec.gravity));
  const bool carries = impulse[row] > 0.0;
  const bool pressed = !carries || before - parting(w, i, w->store.v_free) > unsure;
  const bool rests = pressed && fabs(before) <= unsure && fabs(after) <= unsure;
  const double gap = w->store.gap[i], gap_before = gap - w->h * before; /* of the last step */
  const bool passes = !carries && (after > unsure || gap > place + 100.0 * tol);
  const bool closed = gap_before <= tol - place, open = gap_before > tol + place;
  const bool hits =
      gap <= tol - place && (closed || open) && bounces_alike(w, i, before, unsure, impulse);
  return rests || passes || hits;
}

/* How far the sides of contact i may be off, and how fast. */
static void unsure_of(const world *w, int i, const world_deviation *off, const world_growth *grown,
                      double *place, double *speed) {
  const contact_item *c = &w->store.item[w->store.key[i].item];
  const int side[2] = {c->a, c->b};
  *place = *speed = 0.0;
  for (int k = 0; k < 2; k++) {
    if (deviates(w, side[k])) {
      const world_growth *g = &grown[side[k]];
      *place += off[side[k]].place;
      *speed += off[side[k]].speed + g->moved + g->spun;
    }
  }
}

bool world_may_meet(const world *w, const double *v_next, const double *impulse,
                    const world_deviation *off, const world_growth *grown) {
  bool meets = false;
  for (int i = 0; i < w->set.n_contact && !meets; i++) {
    double place;
    double speed;
    unsure_of(w, i, off, grown, &place, &speed);
    const bool open = w->store.gap[i] > w->set.tol && !(impulse[w->store.row_start[i]] > 0.0);
    const double after = parting(w, i, v_next);
    meets = open && after <= speed &&
            w->store.gap[i] + w->h * after <= w->set.tol + place + w->h * speed;
  }
  return meets;
}

bool world_contacts_alike(const world *w, const double *v_next, const double *impulse,
                          const world_deviation *off, const world_growth *grown) {
  static const unsigned laws = EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION;
  bool all = (w->effects & laws) == 0;
  for (int i = 0; i < w->set.n_contact && all; i++) {
    double place;
    double unsure;
    unsure_of(w, i, off, grown, &place, &unsure);
    all = acts_alike(w, i, place, unsure, v_next, impulse);
  }
  return all;
}
