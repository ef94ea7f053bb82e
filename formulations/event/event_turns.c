#include "formulations/event/event_turns.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest friction: what it takes to stop a motion worth following. */
static const double idle_tol = 1e-6;
static const double rank_tol = 1e-8; /* directions of the mixing that the differences do not tell */

static void layout(void *state, base_arena *m) {
  facet_turns *t = state;
  const size_t n = (size_t)t->cap;
  t->at = BASE_ARRAY(m, double, n);
  t->step = BASE_ARRAY(m, double, n);
  t->d_at = BASE_ARRAY(m, double, n *TURNS_DEPTH);
  t->d_step = BASE_ARRAY(m, double, n *TURNS_DEPTH);
  t->mix = BASE_ARRAY(m, double, n *TURNS_DEPTH);
  t->rest = BASE_ARRAY(m, double, n);
}

void turns_close(facet_turns *t) {
  free(t->mem);
  *t = (facet_turns){0};
}

base_status turns_begin(facet_turns *t, int n_contact, base_error *err) {
  if (t->mem == NULL || n_contact > t->cap) {
    t->cap = n_contact + n_contact / 2 + 4;
    BASE_TRY(form_memory(&t->mem, layout, t, err));
  }
  t->n = n_contact;
  t->turns = t->kept = 0;
  memset(t->at, 0, (size_t)n_contact * sizeof *t->at);
  memset(t->step, 0, (size_t)n_contact * sizeof *t->step);
  return BASE_OK;
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

/* Takes the angles and steps of this turn in, and their differences from those of the last one. The
 * first turn is from anywhere to the first aim: it tells nothing. */
static void take(facet_turns *t, const slip_problem *p, const form_assembly *a, const double *u0,
                 const double *lambda) {
  const int column = t->kept % TURNS_DEPTH * t->n;
  const double largest = largest_friction(p, a, lambda);
  for (int i = 0; i < t->n; i++) {
    const double step = step_of(p, a, i, u0, lambda, largest);
    t->d_at[column + i] = p->turn[i] - t->at[i];
    t->d_step[column + i] = step - t->step[i];
    t->at[i] = p->turn[i];
    t->step[i] = step;
  }
  t->kept += (t->turns > 1);
  t->turns++;
}

base_status turns_next(facet_turns *t, slip_problem *p, const form_assembly *a, const double *u0,
                       const double *lambda, base_error *err) {
  take(t, p, a, u0, lambda);
  const int n = t->n, deep = (t->kept < TURNS_DEPTH) ? t->kept : TURNS_DEPTH;
  const int m = (deep < n) ? deep : n;
  for (int j = 0; j < m; j++) {
    memcpy(t->mix + (ptrdiff_t)j * n, t->d_step + (ptrdiff_t)((t->kept - 1 - j) % TURNS_DEPTH) * n,
           (size_t)n * sizeof *t->mix);
  }
  memcpy(t->rest, t->step, (size_t)n * sizeof *t->rest);
  lapack_int pivot[TURNS_DEPTH] = {0}, rank = 0;
  if (m > 0 && LAPACKE_dgelsy(LAPACK_COL_MAJOR, n, m, 1, t->mix, n, t->rest, n, pivot, rank_tol,
                              &rank) != 0) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "event: directions of friction could not be mixed");
  }
  for (int i = 0; i < n; i++) {
    p->turn[i] += t->step[i];
    for (int j = 0; j < m; j++) {
      const int k = (t->kept - 1 - j) % TURNS_DEPTH * n + i;
      p->turn[i] -= t->rest[j] * (t->d_at[k] + t->d_step[k]);
    }
  }
  return BASE_OK;
}
