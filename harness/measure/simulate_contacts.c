/* simulate_contacts.c - what the contacts of a step tell of it: which carry and slip, how deep they are, when one closes, stops or gives way. */
#include "harness/measure/sim_watch.h"
#include "harness/measure/simulate_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A slip that turns on its way comes to rest where it becomes less than a tenth, squared [1]. What seems to stop no later than so many times a
 * step was stopped in it, when it does not say [1]. A slip is rounding that is this much less than what the normal impulse would give along the
 * contact [1]. */
static const double at_rest = 0.01, resting = 1.0 + 1e-6, no_slip = 1e-9;

static unsigned slips(const formulation_answer *a, int i) {
  return a->mode != NULL && a->mode[i] == 2;
}

/* Two steps whose contacts with a normal impulse are the same have the same hash. Beside the largest in the step, rounding is none. */
sim_carrying sim_carrying_of(const sim *s, const contact_set *set, const formulation_answer *a) {
  static const double rounding = 1e-13;
  sim_carrying c = {.ids = SIM_HASH_START, .slips = SIM_HASH_START};
  double most = 0.0;
  for (int i = 0; a->impulse != NULL && i < set->n_contact; i++) {
    most = fmax(most, a->impulse[set->row_start[i]]);
  }
  for (int i = 0; a->impulse != NULL && i < set->n_contact; i++) {
    const bool asleep = s->slept && world_contact_sleeps(s->w, set->id[i]);
    if (a->impulse[set->row_start[i]] > rounding * most && !asleep) {
      c.ids = (c.ids ^ set->id[i]) * 0x100000001b3u;
      c.slips = (c.slips ^ slips(a, i)) * 0x100000001b3u;
      c.n++;
    }
  }
  return c;
}

/* Notes when an open gap closes, within a step of h, that changes by u at its start and by u_end at its end, and how deep it is then. */
static void note_closing(sim_closing *c, double gap, double u, double u_end, double h) {
  const double root = u * u - 2.0 * gap * (u_end - u) / h;
  const double speed = sqrt(fmax(root, 0.0));
  const double at = (root >= 0.0 && speed > u) ? 2.0 * gap / (speed - u) : HUGE_VAL;
  if (at <= h) {
    c->deep = fmax(c->deep, -gap - 0.5 * h * (u + u_end));
  }
  if (at <= h && at < c->at) {
    c->at = at;
    c->speed = speed;
  }
}

/* Notes when the slip u of a contact's n tangential rows comes to rest that a step of h leaves at u_end, and how fast it is where the
 * friction of that step pushes it on. */
static void note_slip(sim_slip *slip, const double *u, const double *u_end, const double *friction,
                      int n, double h, bool slides) {
  double along = 0.0;
  double slowed = 0.0;
  double before = 0.0;
  double after = 0.0;
  double work = 0.0;
  for (int k = 0; k < n; k++) {
    along += u[k] * (u[k] - u_end[k]);
    slowed += (u[k] - u_end[k]) * (u[k] - u_end[k]);
    before += u[k] * u[k];
    after += u_end[k] * u_end[k];
    work += friction[k] * u_end[k];
  }
  const bool passes = before - along * along / slowed <= at_rest * before; /* through rest */
  const double at = (along > 0.0 && passes) ? h * along / slowed : HUGE_VAL;
  const bool turns = slides && before < along && after > at_rest * before; /* the other way */
  if (at > resting * h && at < slip->stops) {
    slip->stops = at;
  }
  if (work > 0.0) {
    slip->pushed = fmax(slip->pushed, sqrt(after));
  }
  if (turns) {
    slip->pushed = fmax(slip->pushed, 2.0 * sqrt(before));
  }
}

/* Room for what n contacts have. */
static base_status loads_fit(sim_loads *l, int n, base_error *err) {
  if (n > l->cap) {
    free(l->pair);
    l->cap = 2 * n;
    l->pair = malloc((size_t)l->cap * (sizeof *l->pair + sizeof *l->press));
    if (l->pair == NULL) {
      l->cap = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for the loads of %d contacts", n);
    }
    l->press = (sim_press *)(void *)(l->pair + l->cap);
  }
  return BASE_OK;
}

base_status sim_loads_copy(sim_loads *to, const sim_loads *from, base_error *err) {
  to->n = to->n_press = 0;
  BASE_TRY(loads_fit(to, (from->n > from->n_press) ? from->n : from->n_press, err));
  to->n = from->n;
  to->n_press = from->n_press;
  if (from->n > 0) {
    memcpy(to->pair, from->pair, (size_t)from->n * sizeof *to->pair);
  }
  if (from->n_press > 0) {
    memcpy(to->press, from->press, (size_t)from->n_press * sizeof *to->press);
  }
  return BASE_OK;
}

/* The speed that `much` friction costs contact i, which falls as it slips: from the next step on, and is too much in that in which it begins
 * to [m/s]. */
static double falls_by(const contact_set *set, int i, double much) {
  double easiest = 0.0;
  for (int k = 1; k <= set->rows[i].tangent; k++) {
    easiest = fmax(easiest, contact_mobility(set, i, k));
  }
  return fmax(much * easiest, 0.0);
}

/* The load of contacts [first, end) of two bodies, and the speed that it falls by where they slip. */
static sim_load load_of(sim_slip *slip, const contact_set *set, const formulation_answer *a,
                        int first, int end) {
  const int *body = set->body + 2 * (size_t)first;
  const contact_friction f = contact_friction_of(set, first, end, a->impulse);
  sim_load l = {.together = f.together, .could = f.could, .body = {body[0], body[1]}};
  double falls = 0.0;
  for (int i = first; i < end; i++) {
    const double *impulse = a->impulse + set->row_start[i];
    double takes = 0.0;
    for (int k = 1; k <= set->rows[i].tangent; k++) {
      takes = hypot(takes, impulse[k]);
    }
    l.takes += takes;
    if (set->mu_kinetic[i] < set->mu_static[i] && slips(a, i) != 0) {
      falls += falls_by(set, i, takes - set->mu_kinetic[i] * impulse[0]);
    }
  }
  slip->broke = fmax(slip->broke, falls);
  return l;
}

/* Notes what contacts press with, and how much of their friction at rest those between two bodies take: how they share it among themselves is
 * free. */
static base_status note_loads(sim *s, const contact_set *set, const formulation_answer *a,
                              base_error *err) {
  BASE_TRY(loads_fit(&s->loads, set->n_contact, err));
  for (int i = 0, end; i < set->n_contact; i = end) {
    end = contact_pair_end(set, i);
    s->loads.pair[s->loads.n++] = load_of(&s->slip, set, a, i, end);
  }
  for (int i = 0; i < set->n_contact && s->presses; i++) {
    const double impulse = a->impulse[set->row_start[i]];
    if (impulse > 0.0) {
      s->loads.press[s->loads.n_press++] = (sim_press){set->id[i], impulse};
    }
  }
  return BASE_OK;
}

/* Contact i of a step at whose end its gap changes by u. */
static void note_gap(sim_depth *d, const contact_set *set, int i, double u) {
  const double gap = set->gap[i];
  const double deep = -gap - set->h * u;
  d->start = fmax(d->start, -gap);
  if (gap > set->tol) {
    d->open = fmax(d->open, deep);
    d->even = fmax(d->even, -gap - 0.5 * set->h * (set->u_before[set->row_start[i]] + u));
  } else {
    d->held = fmax(d->held, deep);
  }
}

/* What decides whether two impacts on a body are one after the other: gaps that are no farther from closed than `near` may as well be closed,
 * and impacts that come `alike` near each other are at once in all runs, as far as the solves can tell [m]. */
typedef struct doubts {
  double near, alike;
} doubts;

/* Do contacts i and j have a body in common? */
static bool meet(const contact_set *set, int i, int j) {
  const int *a = set->body + 2 * (ptrdiff_t)i;
  const int *b = set->body + 2 * (ptrdiff_t)j;
  const bool first = a[0] >= 0 && (a[0] == b[0] || a[0] == b[1]);
  return first || (a[1] >= 0 && (a[1] == b[0] || a[1] == b[1]));
}

/* Does contact j rest, or hold what goes through it, beside an impact at `speed`? */
static bool rests(const contact_set *set, int j, double speed, const double *u_free) {
  static const double still = 1e-6, drifts = 1e-3; /* of the speed of the impact */
  const int k = set->row_start[j];
  const double u = set->u_before[k];
  const bool pressed = u_free[k] <= 0.0 && u >= -drifts * speed;
  return set->gap[j] <= set->tol && (fabs(u) <= still * speed || pressed);
}

/* The share of the slip of contact j that a unit impulse on contact i, `much` times, takes or gives: its friction goes with that [1]. */
static double slip_turned(const contact_set *set, int i, int j, double much) {
  const double *u = set->u_before + set->row_start[j];
  double given = 0.0;
  double slip = 0.0;
  for (int k = 1; k <= set->rows[j].tangent; k++) {
    given = hypot(given, much * contact_coupling(set, j, k, i, 0));
    slip = hypot(slip, u[k]);
  }
  return (given < slip) ? given / slip : (double)(given > 0.0);
}

/* What goes with whether contact j of the same body, nearly closed, is hit before contact i, after it or with it, which is at `speed` [m/s]: the
 * share of it that one takes from the other, or its friction. Nothing does where j is not reached. */
static double doubt_of(const contact_set *set, int i, int j, double speed, const doubts *d) {
  const double gap = set->gap[j];
  const double u = set->u_before[set->row_start[j]];
  if (fabs(gap) > d->near || fabs(gap * speed + set->gap[i] * u) <= d->alike * speed) {
    return 0.0;
  }
  const double both = contact_coupling(set, i, 0, j, 0);
  const double own = contact_mobility(set, i, 0);
  const double met = -fmin(u, u + both * speed / own);
  if (!(met > 0.0)) {
    return 0.0;
  }
  const double friction = set->mu_kinetic[j] * met * slip_turned(set, i, j, speed / own);
  return fmax(friction, fabs(both) / sqrt(own * contact_mobility(set, j, 0)) * speed);
}

/* Notes what goes with the order of impacts. What bounces no higher than the doubt is soon lost. */
static void note_doubt(sim *s, const contact_set *set, const double *impulse,
                       const double *u_free) {
  static const double lost = 32.0, margin = 10.0;
  const doubts d = {s->near, set->tol + margin * s->out->natural_max * world_time(s->w)};
  for (int i = 0; i < set->n_contact; i++) {
    const int k = set->row_start[i];
    const double speed = -set->u_before[k];
    const double pressed = fabs(u_free[k] - set->u_before[k]) / set->h;
    if (!(impulse[k] > 0.0 && speed > 0.0 && speed * speed > lost * pressed * d.near)) {
      continue;
    }
    for (int j = 0; j < set->n_contact; j++) {
      if (j != i && meet(set, i, j) && !rests(set, j, speed, u_free)) {
        s->doubt = fmax(s->doubt, doubt_of(set, i, j, speed, &d));
      }
    }
  }
}

/* Room for the row velocities at the end of the step and without contacts, behind each other in s->u, and behind these for s->law. */
static base_status make_room(sim *s, const contact_set *set, base_error *err) {
  const int need = 2 * set->n_row + set->n_dof;
  if (need > s->u_cap) {
    free(s->u);
    s->u_cap = 2 * need;
    s->u = malloc((size_t)s->u_cap * sizeof *s->u);
    if (s->u == NULL) {
      s->u_cap = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for the velocities of %d rows", set->n_row);
    }
  }
  s->law = s->u + 2 * (size_t)set->n_row;
  return BASE_OK;
}

/* Does contact i slip at the start of a step in which its normal impulse is this? */
static bool moves_along(const contact_set *set, int i, double impulse) {
  double slip = 0.0;
  double most = 0.0;
  for (int k = 1; k <= set->rows[i].tangent; k++) {
    slip = hypot(slip, set->u_before[set->row_start[i] + k]);
    most = fmax(most, impulse * contact_mobility(set, i, k));
  }
  return slip > no_slip * most;
}

/* What gaps and slips do by the row velocities at the end of the step. */
static void note_motion(sim *s, const contact_set *set, const formulation_answer *a,
                        const double *u) {
  for (int i = 0; i < set->n_contact; i++) {
    const int k = set->row_start[i];
    note_gap(&s->depth, set, i, u[k]);
    if (a->impulse != NULL && a->impulse[k] > 0.0 && moves_along(set, i, a->impulse[k])) {
      note_slip(&s->slip, set->u_before + k + 1, u + k + 1, a->impulse + k + 1,
                set->rows[i].tangent, set->h, slips(a, i) != 0);
    }
  }
}

base_status sim_note_contacts(sim *s, const contact_set *set, const formulation_answer *a,
                              base_error *err) {
  s->carrying = s->goes_on = sim_carrying_of(s, set, a);
  s->depth = (sim_depth){0};
  s->closing = s->struck = (sim_closing){.at = HUGE_VAL};
  s->doubt = 0.0;
  s->friction = (contact_law){0};
  s->slip = (sim_slip){.stops = HUGE_VAL};
  s->loads.n = s->loads.n_press = 0;
  if (!s->controlled || set->n_contact == 0) {
    return BASE_OK;
  }
  BASE_TRY(make_room(s, set, err));
  double *u = s->u;
  double *u_free = s->u + set->n_row;
  contact_relative_velocity(set, a->v_next, set->u_drift, u);
  contact_relative_velocity(set, set->v_free, set->u_drift, u_free);
  note_motion(s, set, a, u);
  for (int i = 0; i < set->n_contact; i++) {
    const int k = set->row_start[i];
    if (set->gap[i] > set->tol) {
      const double given = u[k] - u_free[k];
      note_closing(&s->closing, set->gap[i], set->u_before[k], u[k], set->h);
      note_closing(&s->struck, set->gap[i], set->u_before[k] + given, u[k], set->h);
    }
  }
  if (a->impulse == NULL) {
    return BASE_OK;
  }
  BASE_TRY(note_loads(s, set, a, err));
  if (s->near > 0.0) {
    note_doubt(s, set, a->impulse, u_free);
  }
  if (a->mode != NULL) {
    memset(s->law, 0, (size_t)set->n_dof * sizeof *s->law);
    s->friction = contact_law_at(set, a->impulse, a->mode, u, u_free, s->law);
    s->friction.left = a->gave_way ? HUGE_VAL : s->friction.left; /* whatever comes of it */
  }
  return BASE_OK;
}
