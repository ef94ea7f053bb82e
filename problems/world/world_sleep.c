/* world_sleep.c - who falls asleep, and who is woken. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

/* Of the velocity that gravity and its loads give a body in a step: what moves by less lies still. */
static const double rest = 2e-11;
static const double rounding = 1e-4; /* of that */
/* Of the impulse of its load: what a contact remembers goes on as it is. */
static const double alike = 1e-9;
/* In a row, before a body sleeps: two in which --effects auto may leave out what is not needed at rest, and two that show it. */
enum { STILL_STEPS = 4, ASLEEP = STILL_STEPS + 1 };

/* ---- groups ---------------------------------------------------------------------------------- */

/* First of the group of node i: bodies, and behind them, in the spare unit of the array, the one of all that stays awake. */
static int first_of(int *link, int i) {
  while (link[i] != i) {
    link[i] = link[link[i]];
    i = link[i];
  }
  return i;
}

static void join(int *link, int i, int k) {
  link[first_of(link, i)] = first_of(link, k);
}

static bool is_awake(const world *w, int side) {
  return side >= 0 && side < w->n_body && w->body[side].n_dof > 0;
}

static void sides_of(uint64_t id, int side[2]) {
  const uint64_t mask = ((uint64_t)1 << ID_SIDE_BITS) - 1;
  side[0] = (int)(id >> ID_SIDE_A_SHIFT & mask);
  side[1] = (int)(id >> ID_SIDE_B_SHIFT & mask);
}

/* Does a side move by itself, whatever touches it? */
static bool carries_along(const world *w, int side) {
  if (side < 0) {
    return false;
  }
  return (side < w->n_body) ? body_is_moved(&w->body[side])
                            : world_has(w, EFFECT_MOTION) &&
                                  v3_norm(w->spec.fixed[side - w->n_body].surface_velocity) > 0.0;
}

/* What two sides that touch or are joined are to each other. */
static void join_sides(const world *w, int a, int b) {
  const int side[2] = {a, b};
  if (is_awake(w, a) && is_awake(w, b)) {
    join(w->link, a, b);
  }
  for (int k = 0; k < 2; k++) {
    if (is_awake(w, side[k]) && carries_along(w, side[1 - k])) {
      join(w->link, side[k], w->n_body);
    }
  }
}

static void join_loads(const world *w) {
  for (int i = 0; world_has(w, EFFECT_LOADS) && i < w->spec.n_load; i++) {
    const spec_load *l = &w->spec.load[i];
    const int side[2] = {l->body, l->other};
    for (int k = 0; k < 2 && l->kind != SPEC_FORCE; k++) {
      if (is_awake(w, side[k])) {
        join(w->link, side[k], w->n_body);
      }
    }
  }
}

/* Groups of the bodies that are awake; what stays so is of that of w->n_body. */
static void find_groups(const world *w) {
  for (int i = 0; i <= w->n_body; i++) {
    w->link[i] = i;
  }
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    const bool falls = b->rising >= STILL_STEPS - 1; /* faster in each step, however slow it is */
    if (b->n_dof > 0 && (b->still < STILL_STEPS || falls || body_is_moved(b))) {
      join(w->link, i, w->n_body);
    }
  }
  for (int i = 0; i < w->store.n_item; i++) {
    join_sides(w, w->store.item[i].a, w->store.item[i].b);
  }
  for (int i = 0; i < w->n_joint; i++) {
    join_sides(w, w->joint[i].a, w->joint[i].b);
  }
  join_loads(w);
}

/* ---- falling asleep, and waking -------------------------------------------------------------- */

/* Largest speed of a point of body b by its velocity and, in the step, by `shift` besides. */
static double speed_of(const body *b, const double *shift) {
  double part[2] = {v3_norm(b->v), v3_norm(b->v + 3)};
  for (int k = 0; shift != NULL && k < b->n_dof; k++) {
    part[b->axis[k] >= 3] += fabs(shift[b->dof + k]);
  }
  return part[0] + b->bound * part[1];
}

/* What gravity and its loads push body i with [N]. */
static double load_of(const world *w, int i) {
  return v3_norm(w->store.wrench + AXES * (ptrdiff_t)i);
}

/* The speed that gravity gives in the step [m/s]. */
static double fall_of(const world *w) {
  return w->h * (world_has(w, EFFECT_GRAVITY) ? v3_norm(w->spec.gravity) : 0.0);
}

/* The speed at which body i lies still [m/s]. */
static double least_speed(const world *w, int i, double fall) {
  const bool loads = world_has(w, EFFECT_LOADS);
  return rest * (loads ? fmax(fall, w->h * load_of(w, i) / w->body[i].mass) : fall);
}

static void note_still(body *b, double speed, double least) {
  const bool rises = speed > b->last && speed > rounding * least;
  b->rising = rises ? b->rising + (b->rising < STILL_STEPS) : 0;
  b->still = (speed <= least) ? b->still + (b->still < STILL_STEPS) : 0;
  b->last = speed;
}

bool world_count_still(world *w, const double *shift) {
  const double fall = fall_of(w);
  bool some = false;
  for (int i = 0; w->model == NULL && i < w->n_body; i++) {
    body *b = &w->body[i];
    if (b->n_dof > 0) {
      note_still(b, speed_of(b, shift), least_speed(w, i, fall));
      some = some || b->still == STILL_STEPS;
    } else if (b->sleeps != 0) {
      b->still = ASLEEP;
    }
  }
  return some;
}

void world_stir(world *w, uint64_t id, double by) {
  int side[2];
  double load = 0.0;
  sides_of(id, side);
  for (int k = 0; k < 2; k++) {
    load = is_awake(w, side[k]) ? fmax(load, load_of(w, side[k])) : load;
  }
  for (int k = 0; k < 2; k++) {
    if (is_awake(w, side[k]) && !(by <= alike * w->h * load)) {
      body *b = &w->body[side[k]];
      b->still -= b->still == STILL_STEPS;
    }
  }
}

base_status world_fall_asleep(world *w, bool *some, base_error *err) {
  *some = false;
  find_groups(w);
  const int awake = first_of(w->link, w->n_body);
  for (int i = 0; i < w->n_body; i++) {
    const int first = first_of(w->link, i);
    if (w->body[i].n_dof > 0 && first != awake) {
      w->body[i].sleeps = first + 1;
      *some = true;
    }
  }
  return *some ? world_renumber(w, err) : BASE_OK;
}

bool world_is_reached(const world *w) {
  return w->reached;
}

/* Marks the group of a side that sleeps. */
static void mark(const world *w, int side) {
  const int group = (side < w->n_body) ? w->body[side].sleeps : 0;
  if (group != 0) {
    w->link[group - 1] = 1;
  }
}

base_status world_wake(world *w, bool all, base_error *err) {
  for (int i = 0; i < w->n_body; i++) {
    w->link[i] = all;
  }
  for (int i = 0; i < w->store.n_item && !all; i++) {
    mark(w, w->store.item[i].a);
    mark(w, w->store.item[i].b);
  }
  for (int i = 0; i < w->n_body; i++) {
    body *b = &w->body[i];
    if (b->sleeps != 0 && w->link[b->sleeps - 1] != 0) {
      b->sleeps = b->still = 0;
    }
  }
  return world_renumber(w, err);
}

int world_n_asleep(const world *w) {
  return w->n_asleep;
}

static bool sleeps(const world *w, int side) {
  return side < w->n_body && w->body[side].sleeps != 0;
}

bool world_just_fell_asleep(const world *w, int i) {
  return sleeps(w, i) && w->body[i].still == STILL_STEPS;
}

bool world_contact_sleeps(const world *w, uint64_t id) {
  int side[2];
  sides_of(id, side);
  const bool awake = is_awake(w, side[0]) || is_awake(w, side[1]);
  return !awake && (sleeps(w, side[0]) || sleeps(w, side[1]));
}

/* ---- to come back to ------------------------------------------------------------------------- */

enum { SLEEP_NUMBERS = 4 }; /* of a body */

size_t world_sleep_size(const world *w) {
  return SLEEP_NUMBERS * (size_t)w->n_body;
}

void world_sleep_save(const world *w, double *asleep) {
  for (int i = 0; i < w->n_body; i++, asleep += SLEEP_NUMBERS) {
    const body *b = &w->body[i];
    asleep[0] = b->sleeps;
    asleep[1] = b->still;
    asleep[2] = b->rising;
    asleep[3] = b->last;
  }
}

base_status world_sleep_load(world *w, const double *asleep, base_error *err) {
  bool others = false;
  for (int i = 0; i < w->n_body; i++, asleep += SLEEP_NUMBERS) {
    body *b = &w->body[i];
    others = others || b->sleeps != (int)asleep[0];
    b->sleeps = (int)asleep[0];
    b->still = (int)asleep[1];
    b->rising = (int)asleep[2];
    b->last = asleep[3];
  }
  return others ? world_renumber(w, err) : BASE_OK;
}
