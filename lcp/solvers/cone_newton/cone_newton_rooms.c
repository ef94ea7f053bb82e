/* cone_newton_rooms.c - where the arrays lie, and facets folded or as they are. */
#include "lcp/solvers/cone_newton/cone_newton.h"

#include <stdlib.h>

/* What is of the size of the problem that is solved. */
static void layout_inner(cone_newton *s, const lcp_capacity *cap, base_arena *a) {
  s->n_inner = cap->n;
  lcp_cone_scaled_layout(&s->eq, cap, a);
  double **const arrays[] = {&s->x, &s->y, &s->center, &s->dx, &s->trial, &s->wt, &s->inner, &s->w};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  lcp_cone_step_layout_beside(&s->step, cap, s->trial, s->wt, a);
}

static void layout_proof(cone_newton *s, const lcp_capacity *cap, base_arena *a) {
  s->force = BASE_ARRAY(a, lcp_farkas_sum, cap->n_dof);
  s->proof = BASE_ARRAY(a, double, cap->n);
  s->kind = BASE_ARRAY(a, unsigned char, cap->n);
}

/* A proof is tried where an outer step ends: X and Y are made anew behind it, or not needed any more. */
static void place_proof(cone_newton *s, const lcp_capacity *cap, base_arena *a) {
  const size_t room = 2 * (size_t)s->n_inner * (size_t)LCP_CONE_MAX * sizeof *s->eq.X;
  base_arena measure = base_arena_measuring(), over = base_arena_over(s->eq.X, room);
  layout_proof(s, cap, &measure);
  layout_proof(s, cap, (measure.used <= room) ? &over : a);
}

/* What is shown is tested, and taken or not, before the step behind it makes X and Y anew; so are the scales of the test. */
static void place_shown(cone_newton *s, const lcp_capacity *cap, base_arena *a) {
  const size_t n = (size_t)cap->n;
  const bool fits = 3 * n <= 2 * (size_t)s->n_inner * (size_t)LCP_CONE_MAX;
  double *room = fits ? s->eq.X : BASE_ARRAY(a, double, 3 * n);
  s->shown = room;
  if (room != NULL) {
    s->loop.stop.tau = room + n;
    s->loop.stop.zref = room + 2 * n;
  }
}

void lcp_cone_newton_layout(cone_newton *s, const lcp_capacity *cap, base_arena *a) {
  lcp_capacity inner = *cap;
  inner.n = (cap->n_folded > 0) ? cap->n_folded : cap->n;
  inner.n_jac = (cap->n_folded > 0) ? cap->n_jac_folded : cap->n_jac;
  lcp_loop_layout(&s->loop, cap, a);
  s->best = BASE_ARRAY(a, double, cap->n);
  layout_inner(s, &inner, a);
  /* from here on problems without facets touch nothing, so that the pages they touch lie together */
  lcp_fold_layout(&s->fold, cap, a);
  place_proof(s, cap, a);
  place_shown(s, cap, a);
}

static base_status prepare_inner(cone_newton *s, const lcp_problem *p, const int *facets,
                                 base_error *err) {
  lcp_matrix_diagonal(&p->M, s->dx);
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->dx, facets, err));
  return lcp_cone_step_prepare(&s->step, p, &s->eq, err);
}

/* Room for all unknowns where facets stay what they are, until the release. */
static base_status widen(cone_newton *s, const lcp_problem *p, base_error *err) {
  const lcp_capacity cap = lcp_problem_capacity(p);
  cone_newton laid = *s;
  base_arena measure = base_arena_measuring();
  layout_inner(&laid, &cap, &measure);
  cone_newton *narrow = malloc(sizeof *narrow);
  void *wide = measure.overflow ? NULL : base_alloc(measure.used);
  if (narrow == NULL || wide == NULL) {
    free(narrow);
    free(wide);
    return BASE_FAIL(err, BASE_ENOMEM, "cone_newton: no memory for %d unknowns as they are", cap.n);
  }
  *narrow = *s;
  base_arena real = base_arena_over(wide, measure.used);
  layout_inner(s, &cap, &real);
  s->narrow = narrow;
  s->wide = wide;
  return BASE_OK;
}

base_status lcp_cone_newton_prepare(cone_newton *s, const lcp_problem *p, base_error *err) {
  lcp_fold_begin(&s->fold, p);
  if (s->fold.done && prepare_inner(s, &s->fold.p, s->fold.facets, err) == BASE_OK) {
    return BASE_OK;
  }
  s->fold.done =
      false; /* a friction without mobility is no cone, but its facets are rows like others */
  if (p->M.n > s->n_inner) {
    lcp_cone_step_release(&s->step);
    BASE_TRY(widen(s, p, err));
  }
  return prepare_inner(s, p, NULL, err);
}

void lcp_cone_newton_release(cone_newton *s) {
  lcp_cone_step_release(&s->step);
  if (s->narrow != NULL) {
    cone_newton *narrow = s->narrow;
    free(s->wide);
    *s = *narrow;
    free(narrow);
  }
}
