/* world_standing.c - do bodies that cannot turn stand: can their contacts share the forces so that no moment is left, and with enough to
 * spare? */
#include "problems/vec.h"
#include "problems/world/world_feet.h"

/* Of a patch's load, evenly on its feet, before the rest is shared out; of a body's largest, for a patch to count. */
static const double spared = 0.1, light = 0.01;

/* Does side k of f stand on it: on a plane, or on a body that pushes it against its load? */
static bool stands(const world *w, const foot *f, int k) {
  static const double against = 1e-3;
  if (f->side[k] < 0 || f->side[1 - k] < 0) {
    return f->side[k] >= 0;
  }
  const double *load = world_residual(w, f->side[k])->load;
  return v3_dot(f->column[k], load) < -against * v3_norm(load);
}

/* Does body i stand on f? */
static bool carries(const foot *f, int i) {
  return (f->stands[0] && f->side[0] == i) || (f->stands[1] && f->side[1] == i);
}

static double most_pressed(const feet *s, int i) {
  double most = 0.0;
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    most = carries(f, i) ? fmax(most, s->patch[f->patch].press) : most;
  }
  return most;
}

/* Does f count for a body that stands on it? */
static bool counts(const feet *s, const foot *f) {
  bool some = false;
  for (int k = 0; k < 2 && !some; k++) {
    some = f->stands[k] && s->patch[f->patch].press >= light * most_pressed(s, f->side[k]);
  }
  return some;
}

static double dot(const double *x, const double *y) {
  double sum = 0.0;
  for (int a = 0; a < AXES; a++) {
    sum += x[a] * y[a];
  }
  return sum;
}

/* What each foot carries in any case, counted with all else that acts. */
static void press_all(const world *w, feet *s) {
  int count[FEET_MOST] = {0};
  for (int j = 0; j < s->n; j++) {
    foot *f = &s->foot[j];
    count[f->patch]++;
    f->stands[0] = stands(w, f, 0);
    f->stands[1] = stands(w, f, 1);
  }
  for (int j = 0; j < s->n; j++) {
    foot *f = &s->foot[j];
    f->least = counts(s, f) ? spared * s->patch[f->patch].press / count[f->patch] : 0.0;
    world_feet_add(w, f, f->least, true);
  }
}

/* Of as many feet of body i as space has dimensions: the least part of one's column that those before it do not have, the largest
 * there is each time; 0: they lie on a line. */
static double lever(const world *w, const feet *s, int i) {
  double left[FEET_MOST][AXES], least = HUGE_VAL;
  int n = 0;
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    if (carries(f, i) && f->least > 0.0) {
      memcpy(left[n++], f->column[(f->side[0] == i) ? 0 : 1], sizeof left[0]);
    }
  }
  for (int r = 0; r < w->dim; r++) {
    double most = 0.0, base[AXES] = {0};
    for (int j = 0; j < n; j++) {
      const double size = dot(left[j], left[j]);
      if (size > most) {
        most = size;
        memcpy(base, left[j], sizeof base);
      }
    }
    least = fmin(least, most);
    for (int j = 0; j < n && most > 0.0; j++) {
      const double part = dot(left[j], base) / most;
      for (int a = 0; a < AXES; a++) {
        left[j][a] -= part * base[a];
      }
    }
  }
  return (least > 1e-12) ? sqrt(least) : 0.0;
}

/* What is left of the balance of body i [N s]. */
static double left_of(const world *w, int i) {
  double sum = 0.0;
  for (int a = 0; a < AXES; a++) {
    sum += fabs(world_residual(w, i)->rest[a]);
  }
  return sum;
}

/* Body i, whose balance leaves `off`, touches nothing, or is a ball, or that and what rubs it are little beside what its feet have to
 * spare. */
static bool holds(const world *w, const feet *s, int i, double off, double scale) {
  double spare = HUGE_VAL;
  bool flies = true;
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    spare = (f->least > 0.0 && carries(f, i)) ? fmin(spare, f->least) : spare;
    flies = flies && f->side[0] != i && f->side[1] != i;
  }
  if (flies || world_is_ball(w, i)) {
    return off <= WORLD_FEET_LITTLE * scale;
  }
  return spare < HUGE_VAL && 10.0 * (off + world_residual(w, i)->rub) < spare * lever(w, s, i);
}

/* Would they all, with impulses that balance them? */
static bool hold(const world *w, const feet *s, double scale) {
  bool all = true;
  for (int i = 0; i < w->n_body && all; i++) {
    all = holds(w, s, i, 0.0, scale);
  }
  return all;
}

/* Notes which bodies, of those not noted yet, do not stand firmly with the impulses that there are: these do not keep their balance
 * nearly, or not with enough on every foot. Are there any? */
static bool some_turn(const world *w, const feet *s, const double *impulse, double scale,
                      world_growth *grown) {
  bool some = false;
  world_feet_set_rest(w, s);
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    const double more = fmax(impulse[w->store.row_start[f->contact]], 0.0) - f->least;
    for (int k = 0; k < 2 && more < 0.0; k++) {
      if (f->side[k] >= 0) {
        some = some || !grown[f->side[k]].turned;
        grown[f->side[k]].turned = true;
      }
    }
    world_feet_add(w, f, more, false);
  }
  for (int i = 0; i < w->n_body; i++) {
    const bool firm = grown[i].turned || holds(w, s, i, left_of(w, i), scale);
    some = some || !firm;
    grown[i].turned = grown[i].turned || !firm;
  }
  return some;
}

/* ---- the two ---------------------------------------------------------------------------------- */

bool world_stands(const world *w, unsigned effects, const double *impulse) {
  feet s;
  double scale;
  return world_feet_set_up(w, effects, impulse, world_locked_now, &s, &scale) &&
         world_feet_balanced(w, &s, scale);
}

/* A ball that turns is where it was; about an axis that is locked it is not what it would be. */
static unsigned turned_by(const world *w, int i, unsigned effects) {
  const unsigned axes = world_free_axes(w, i, effects);
  const unsigned turns = world_free_axes(w, i, w->effects) & (unsigned)SPEC_ROT;
  return world_is_ball(w, i) ? axes & ~turns : axes;
}

void world_note_firm(const world *w, unsigned effects, bool tied, const double *impulse,
                     world_growth *grown) {
  feet s;
  double scale;
  bool known = false; /* some are known to turn */
  for (int i = 0; i < w->n_body; i++) {
    known = known || grown[i].turned;
  }
  if (tied || !world_feet_set_up(w, effects, impulse, turned_by, &s, &scale)) {
    for (int i = 0; i < w->n_body; i++) {
      grown[i].turned = true;
    }
    return;
  }
  press_all(w, &s);
  if (some_turn(w, &s, impulse, scale, grown) && !known && hold(w, &s, scale) &&
      world_feet_balanced(w, &s, scale)) {
    for (int i = 0; i < w->n_body; i++) {
      grown[i].turned = false;
    }
  }
}
