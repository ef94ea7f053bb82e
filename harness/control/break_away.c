#include "harness/control/break_away.h"

#include <math.h>
#include <stddef.h>

/* When a pair of bodies breaks away that takes so much friction in the first half of a step of h and so much in the second, of what it could at
 * rest; HUGE_VAL: it does not. Both are the loads of the start of a half. Where the second is all that it could, to rounding, it has
 * slipped since some time in the first half. */
static break_away breaks_by(double takes, double could, double takes_then, double could_then,
                            double h) {
  static const double all = 1.0 - 1e-6;
  const double left = could - takes;
  const double yet = could_then - takes_then;
  const double at = 0.5 * h * fmax(left / (left - yet), 1.0);
  const bool nears = takes < all * could && yet < left;
  return (break_away){nears ? (1.0 + 1e-6) * at : HUGE_VAL, takes_then < all * could_then};
}

static break_away earlier(break_away a, break_away b) {
  return (b.at < a.at) ? b : a;
}

/* The load of the same bodies in the second half, at k if nothing has changed; NULL: they have no contacts there. */
static const sim_load *load_then(const sim_loads *l, const sim_load *first, int k) {
  for (int i = 0; i < l->n; i++) {
    const sim_load *p = &l->pair[(k + i) % l->n];
    if (p->body[0] == first->body[0] && p->body[1] == first->body[1]) {
      return p;
    }
  }
  return NULL;
}

break_away break_away_in(const sim_loads half[2], double h) {
  break_away found = {HUGE_VAL, false};
  for (int k = 0; k < half[0].n; k++) {
    const sim_load *a = &half[0].pair[k];
    const sim_load *b = load_then(&half[1], a, k);
    if (b != NULL) {
      found = earlier(found, breaks_by(a->takes, a->could, b->takes, b->could, h));
      found = earlier(found, breaks_by(a->together, a->could, b->together, b->could, h));
    }
  }
  return found;
}

/* What contact `id` presses with in the second half, at k if nothing has changed; 0: with nothing. */
static double press_then(const sim_loads *l, uint64_t id, int k) {
  for (int i = 0; i < l->n_press; i++) {
    const sim_press *p = &l->press[(k + i) % l->n_press];
    if (p->id == id) {
      return p->impulse;
    }
  }
  return 0.0;
}

break_away opening_in(const sim_loads half[2], double h) {
  static const double slight = 1e-6; /* of the largest: rounding goes to nothing, and comes back */
  break_away found = {HUGE_VAL, false};
  double most = 0.0;
  for (int k = 0; k < half[0].n_press; k++) {
    most = fmax(most, half[0].press[k].impulse);
  }
  for (int k = 0; k < half[0].n_press; k++) {
    const double now = half[0].press[k].impulse;
    const double then = press_then(&half[1], half[0].press[k].id, k);
    if (now > slight * most) {
      found = earlier(found, breaks_by(0.0, now, 0.0, then, h));
    }
  }
  return found;
}

void openings_begin(openings *o, bool vary) {
  *o = (openings){.vary = vary, .asked = vary, .again = patience_untried()};
}

void openings_note(openings *o, bool aimed, bool opened) {
  static const int few = 6;
  o->vain = (o->aimed && !opened) ? o->vain + 1 : 0;
  if (o->aimed && opened) {
    o->again = patience_untried();
  } else if (o->vain > few) {
    patience_lose(&o->again);
  }
  o->aimed = aimed;
  o->asked = o->vary && patience_again(&o->again);
}
