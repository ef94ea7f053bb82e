#include "lcp/solvers/cone_inner.h"

#include <string.h>

void lcp_cone_inner_layout(lcp_cone_inner *s, const lcp_capacity *cap, base_arena *a) {
  lcp_cone_scaled_layout(&s->eq, cap, a);
  double **const arrays[] = {&s->x, &s->y, &s->center, &s->dx, &s->trial, &s->w};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  lcp_cone_step_layout_beside(&s->step, cap, s->trial, s->w, a);
  s->scratch = BASE_ARRAY(a, double, 2 * (size_t)cap->n_dof);
}

base_status lcp_cone_inner_prepare(lcp_cone_inner *s, const lcp_problem *p, base_error *err) {
  lcp_matrix_diagonal(&p->M, s->dx);
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->dx, NULL, err));
  return lcp_cone_step_prepare(&s->step, p, &s->eq, err);
}

void lcp_cone_inner_release(lcp_cone_inner *s) {
  lcp_cone_step_release(&s->step);
}

/* |F|^2 at z. */
static double merit(lcp_cone_inner *s, const lcp_problem *p, double weight, const double *z,
                    bool slope, lcp_work *work) {
  lcp_matrix_apply(&p->M, z, p->q, s->w, s->scratch);
  work->matvecs++;
  for (int i = 0; i < p->M.n; i++) {
    s->x[i] = z[i] / s->eq.s[i];
    s->y[i] = s->w[i] * s->eq.s[i] + weight * (s->x[i] - s->center[i]);
  }
  return lcp_cone_scaled_map(&s->eq, LCP_MAP_MIN, s->x, s->y, slope);
}

/* z <- z + t s dx. */
static void search(lcp_cone_inner *s, const lcp_problem *p, double weight, double now, double *z,
                   lcp_work *work) {
  static const double lengths[] = {1.0, 0.5, 0.25};
  double t = 1.0;
  for (int k = 0; k < BASE_COUNT(lengths); k++) {
    for (int i = 0; i < p->M.n; i++) {
      s->trial[i] = z[i] + lengths[k] * s->eq.s[i] * s->dx[i];
    }
    const double shorter = 1.0 - 1e-4 * lengths[k];
    if (merit(s, p, weight, s->trial, false, work) < shorter * shorter * now) {
      t = lengths[k];
      break;
    }
    work->linesearches++;
  }
  for (int i = 0; i < p->M.n; i++) {
    z[i] += t * s->eq.s[i] * s->dx[i];
  }
}

int lcp_cone_inner_run(lcp_cone_inner *s, const lcp_problem *p, double weight, int steps, double *z,
                       lcp_work *work, base_status *status) {
  for (int i = 0; i < p->M.n; i++) {
    s->center[i] = z[i] / s->eq.s[i];
  }
  for (int k = 0; k <= steps; k++) {
    const double bare = merit(s, p, 0.0, z, false, work);
    const double now = merit(s, p, weight, z, true, work);
    if (k > 0 && now <= 0.01 * bare) {
      return k;
    }
    if (k == steps || !lcp_cone_step_factor(&s->step, p, &s->eq, weight, work, status)) {
      break;
    }
    lcp_cone_step_solve(&s->step, p, &s->eq, s->dx, work);
    search(s, p, weight, now, z, work);
  }
  return steps + 1;
}
