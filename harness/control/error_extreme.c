#include "harness/control/error_extreme.h"

#include "problems/world/world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the step that ends at a row met: nothing, something in the one row of its step, or in one of the two halves of it that end here. */
enum { MET_NOTHING, MET_WHOLE, MET_HALVES };

base_status extreme_met(const series *s, const step_list *kept, unsigned char **met,
                        base_error *err) {
  *met = calloc((size_t)s->n_row, sizeof **met);
  if (*met == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for what %d steps met", s->n_row);
  }
  for (long k = 0; k < kept->n && k + 1 < s->n_row; k++) {
    const unsigned way = kept->way[k]; /* behind the start there is a row a step */
    const bool whole = (way & STEP_EXTRAPOLATED) != 0;
    (*met)[k + 1] = ((way & STEP_MET) == 0) ? MET_NOTHING : whole ? MET_WHOLE : MET_HALVES;
  }
  return BASE_OK;
}

/* ---- between three rows ---------------------------------------------------------------------- */

/* A column over the time of a check. */
typedef struct view {
  const double *t, *x;
  const unsigned char *met;
  int n;
  double t0, t1;
  bool jumps; /* an impact changes it at once */
} view;

/* Does an impact bend the way at row k? A step ends just behind it, so that nothing is beyond that. What an impact changes at once is bent at the
 * end of that change, too. */
static bool is_kink(const view *v, int k) {
  const bool next = k + 1 < v->n && v->met[k + 1] != MET_NOTHING;
  const bool halves = k + 2 < v->n && v->met[k + 2] == MET_HALVES;
  return next || halves || (v->jumps && v->met[k] != MET_NOTHING);
}

/* The parabola through rows k - 1, k and k + 1. */
typedef struct parabola {
  double bend;        /* twice its second coefficient [unit/s^2] */
  double slope;       /* at row k [unit/s] */
  double first, last; /* slopes at the outer rows [unit/s] */
  double bow;         /* how far row k is from the chord of the others [unit] */
  double uneven;      /* the longer of the two times over the shorter [1] */
} parabola;

/* False: row k is at an end of the run, or a kink. */
static bool parabola_at(const view *v, int k, parabola *p) {
  if (k < 1 || k + 1 >= v->n || is_kink(v, k)) {
    return false;
  }
  const double before = v->t[k] - v->t[k - 1], behind = v->t[k + 1] - v->t[k];
  if (!(before > 0.0 && behind > 0.0)) {
    return false;
  }
  const double part = before / (before + behind);
  const double early = (v->x[k] - v->x[k - 1]) / before, late = (v->x[k + 1] - v->x[k]) / behind;
  *p = (parabola){.bend = 2.0 * (late - early) / (before + behind),
                  .slope = early + part * (late - early),
                  .first = early - part * (late - early),
                  .last = late + (1.0 - part) * (late - early),
                  .bow = fabs(v->x[k] - v->x[k - 1] - part * (v->x[k + 1] - v->x[k - 1])),
                  .uneven = fmax(before, behind) / fmin(before, behind)};
  return true;
}

/* By what share the acceleration around row k differs from that of its neighbours; 1: they do not tell. */
static double varies(const view *v, int k, double bend) {
  double most = 0.0;
  bool told = false;
  for (int side = -1; side <= 1; side += 2) {
    parabola p;
    if (parabola_at(v, k + side, &p)) {
      most = fmax(most, fabs(p.bend - bend));
      told = true;
    }
  }
  return (told && most < fabs(bend)) ? most / fabs(bend) : 1.0;
}

/* How far `sign` times the column may be beyond its largest at a row, and when: where it turns round between three rows, as far as the parabola
 * through them is, and farther by the share of its bow by which the acceleration is not even. The bow of an even acceleration over the
 * longer of two steps is a quarter of that of both times the longer over the shorter. */
static extreme beyond_rows(const view *v, double sign) {
  double most = -HUGE_VAL;
  double reach = -HUGE_VAL;
  double at = 0.0;
  for (int k = 0; k < v->n; k++) {
    parabola p;
    if (v->t[k] < v->t0 || v->t[k] > v->t1) {
      continue;
    }
    most = fmax(most, sign * v->x[k]);
    if (!parabola_at(v, k, &p) || p.first * p.last > 0.0) {
      continue;
    }
    const double before = (v->t[k - 1] >= v->t0) ? sign * v->x[k - 1] : -HUGE_VAL;
    const double behind = (v->t[k + 1] <= v->t1) ? sign * v->x[k + 1] : -HUGE_VAL;
    const double turn = (p.bend != 0.0) ? -p.slope / p.bend : 0.0;
    const double vertex = sign * (v->x[k] + 0.5 * turn * p.slope);
    const double top = fmax(sign * v->x[k], fmax(before, behind));
    const double spare = varies(v, k, p.bend) * p.bow * fmax(1.0, 0.25 * p.uneven);
    const double over = ((sign * p.bend < 0.0) ? fmax(vertex, top) : top) + spare;
    if (over > reach) {
      reach = over;
      at = (sign * p.bend < 0.0) ? v->t[k] + turn : 0.0;
    }
  }
  return (extreme){.beyond = (reach > most) ? reach - most : 0.0,
                   .at = (reach > most && at > v->t0 && at < v->t1) ? at : 0.0,
                   .nearest = HUGE_VAL};
}

/* ---- lengths --------------------------------------------------------------------------------- */

double extreme_nearer(double far, double x) {
  const double half = 0.5 * far;
  return (half < x) ? half * half / (x + sqrt(x * x - half * half)) : x;
}

/* Is it the length of a vector of bodies? Between two states it may be less than at both, by more than accelerated motion is off its chord. */
static bool of_length(const spec_check *c) {
  const char *dot = strchr(c->var, '.');
  const char *q = (dot != NULL) ? dot + 1 : "";
  return !c->has_dir && (strcmp(q, "pos") == 0 || strcmp(q, "vel") == 0 || strcmp(q, "speed") == 0);
}

/* A length is less between two states than at both, where the way from one to the next is straight. Of a place the speed tells how far that may
 * be; of a velocity the least at a state is noted. */
static void note_length(const view *v, const double *speed, bool place, extreme *e) {
  double least = HUGE_VAL;
  double reach = HUGE_VAL;
  for (int k = 0; k < v->n; k++) {
    if (v->t[k] < v->t0 || v->t[k] > v->t1) {
      continue;
    }
    least = fmin(least, v->x[k]);
    if (place && k > 0) {
      const double far = fmax(speed[k], speed[k - 1]) * (v->t[k] - v->t[k - 1]);
      const double near = fmin(v->x[k], v->x[k - 1]);
      reach = fmin(reach, near - extreme_nearer(far, near));
    }
  }
  e->beyond = (place && reach < least) ? fmax(e->beyond, least - reach) : e->beyond;
  e->nearest = place ? HUGE_VAL : least;
}

extreme extreme_between(const series *s, const unsigned char *met, int column,
                        const spec_check *c) {
  const char *unit = world_observe_unit(c->var);
  const double *t = s->column[SERIES_TIME];
  const bool place = strcmp(unit, "m") == 0;
  const view v = {.t = t,
                  .x = s->column[column],
                  .met = met,
                  .n = s->n_row,
                  .t0 = c->t0,
                  .t1 = (c->t1 > 0.0 && c->t1 < HUGE_VAL) ? c->t1 : t[s->n_row - 1],
                  .jumps = !place && strcmp(unit, "rad") != 0};
  const extreme up = beyond_rows(&v, 1.0), down = beyond_rows(&v, -1.0);
  extreme e = (c->kind == CHECK_WINDOW_MAX)   ? up
              : (c->kind == CHECK_WINDOW_MIN) ? down
              : (up.beyond > down.beyond)     ? up
                                              : down;
  if (c->kind != CHECK_WINDOW_MAX && of_length(c)) {
    note_length(&v, s->column[SERIES_SPEED], place, &e);
  }
  return e;
}
