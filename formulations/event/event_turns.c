#include "formulations/event/event_turns.h"

#include <math.h>
#include <stdlib.h>

/* Of the largest friction: what it takes to stop a motion worth following. */
static const double idle_tol = 1e-6;

static void layout(void *state, base_arena *m) {
  facet_turns *t = state;
  t->step = BASE_ARRAY(m, double, t->cap);
}

void turns_close(facet_turns *t) {
  anderson_close(&t->mixing);
  free(t->mem);
  *t = (facet_turns){0};
}

base_status turns_begin(facet_turns *t, int n_contact, base_error *err) {
  if (t->mem == NULL || n_contact > t->cap) {
    t->cap = base_room(n_contact) + 4;
    BASE_TRY(form_memory(&t->mem, layout, t, err));
  }
  return anderson_begin(&t->mixing, n_contact, err);
}

/* Contact i has a cone of two tangents, and friction. */
static bool has_facets(const slip_problem *p, const form_assembly *a, int i) {
  return slip_at_rest(p, a, i) && form_rows_of(a, i) == 3 && p->mu[i] > 0.0;
}

/* |f_t - P(aim)| [N] of contact i, and aim. */
static double off_circle(const slip_problem *p, const form_assembly *a, int i, const double *u0,
                         const double *lambda, double aim[2]) {
  const double *f = lambda + a->row[i];
  const size_t n = (size_t)a->n_row, r = (size_t)a->row[i] + 1;
  const double own = fmax(p->C[r * n + r], p->C[(r + 1) * n + r + 1]);
  const double limit = p->mu[i] * f[0];
  slip_departure(p, a, i, u0, lambda, aim);
  for (int t = 0; t < 2; t++) {
    aim[t] = f[1 + t] - ((own > 0.0) ? aim[t] / own : 0.0); /* 0: no force moves the contact */
  }
  const double size = hypot(aim[0], aim[1]), share = (size > limit) ? limit / size : 1.0;
  return hypot(f[1] - share * aim[0], f[2] - share * aim[1]);
}

static double largest_friction(const slip_problem *p, const form_assembly *a,
                               const double *lambda) {
  double largest = 0.0;
  for (int i = 0; i < a->n_contact; i++) {
    largest = fmax(largest, p->mu[i] * lambda[a->row[i]]);
  }
  return largest;
}

double turns_residual(const slip_problem *p, const form_assembly *a, const double *u0,
                      const double *lambda) {
  double worst = 0.0;
  for (int i = 0; i < a->n_contact; i++) {
    double aim[2];
    if (has_facets(p, a, i) && lambda[a->row[i]] > 0.0) {
      worst = fmax(worst, off_circle(p, a, i, u0, lambda, aim));
    }
  }
  return (worst > 0.0) ? worst / largest_friction(p, a, lambda) : 0.0;
}

/* arg(aim) - theta of contact i, 0 where its friction is right. A contact without force that moves turns
 * towards where its friction would point: redundant neighbours pass load to and fro. */
static double step_of(const slip_problem *p, const form_assembly *a, int i, const double *u0,
                      const double *lambda, double largest) {
  double aim[2];
  if (!has_facets(p, a, i)) {
    return 0.0;
  }
  const double miss = off_circle(p, a, i, u0, lambda, aim);
  const bool loaded = lambda[a->row[i]] > 0.0;
  const bool turns = loaded ? miss > 0.0 : hypot(aim[0], aim[1]) > idle_tol * largest;
  return turns ? remainder(atan2(aim[1], aim[0]) - p->turn[i], 6.283185307179586476925) : 0.0;
}

base_status turns_next(facet_turns *t, slip_problem *p, const form_assembly *a, const double *u0,
                       const double *lambda, base_error *err) {
  const double largest = largest_friction(p, a, lambda);
  for (int i = 0; i < t->mixing.mixing.n; i++) {
    t->step[i] = step_of(p, a, i, u0, lambda, largest);
  }
  /* the first turn is from anywhere to the first aim: it tells nothing */
  return anderson_next(&t->mixing, t->step, 2, p->turn, err);
}
