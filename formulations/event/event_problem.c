/* The complementarity problems of one instant: solved, with friction of the circle, and kept free of noise; and the forces of
 * the joints that follow. */
#include "formulations/event/event_run.h"
#include "lcp/linear/lapack_status.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distance from the circle's law over the largest friction. */
static const double circle_tol = 1e-9;
/* A box that pivots about a corner settles in ten or so (test form_event); what has not by now does not. */
static const int max_turns = 100;

void event_drop_noise(int n, double *u) {
  double largest = 0.0;
  for (int r = 0; r < n; r++) {
    largest = fmax(largest, fabs(u[r]));
  }
  for (int r = 0; r < n; r++) {
    u[r] = (fabs(u[r]) > 1e-12 * largest) ? u[r] : 0.0;
  }
}

/* Poses, solves, and leaves lambda (n_row of the assembly) in a.lambda; s->solved says how. */
static base_status solve(event_run *s, const double *u0, double *lambda, base_error *err) {
  lcp_problem p;
  lcp_outcome claimed = LCP_NUMERICAL;
  slip_pose(&s->p, &s->space.a, u0, &p);
  memset(s->z, 0, (size_t)p.M.n * sizeof *s->z);
  BASE_TRY(s->solver->solve(s->solver->ctx, &p, s->z, &claimed, err));
  s->answer.work.solves++;
  s->answer.lcp_dim = (p.M.n > s->answer.lcp_dim) ? p.M.n : s->answer.lcp_dim;
  s->solved = claimed == LCP_SOLVED;
  s->without_solution = claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  s->answer.work.rays += s->without_solution;
  s->answer.residual = s->solved ? 0.0 : 1.0; /* without a solution nothing of the model is met */
  slip_impulses(&s->p, &s->space.a, s->z, lambda);
  return BASE_OK;
}

base_status event_solve(event_run *s, const double *u0, double *lambda, base_error *err) {
  BASE_TRY(turns_begin(&s->turns, s->space.a.n_contact, err));
  BASE_TRY(solve(s, u0, lambda, err));
  double off = s->solved ? turns_residual(&s->p, &s->space.a, u0, lambda) : 0.0;
  while (s->solved && off > circle_tol && s->turns.mixing.mixing.taken < max_turns) {
    BASE_TRY(turns_next(&s->turns, &s->p, &s->space.a, u0, lambda, err));
    BASE_TRY(solve(s, u0, lambda, err));
    off = s->solved ? turns_residual(&s->p, &s->space.a, u0, lambda) : 0.0;
  }
  if (off > circle_tol) {
    s->solved = false;
    s->answer.residual = off;
  }
  return BASE_OK;
}

double event_scale(const event_run *s, const double *u0) {
  double scale = 0.0;
  for (int r = 0; r < s->space.a.n_row; r++) {
    scale = fmax(scale, fabs(u0[r]));
  }
  return scale;
}

double event_departs(const event_run *s, int i, const double *u0, const double *lambda,
                     double along[2]) {
  slip_departure(&s->p, &s->space.a, i, u0, lambda, along);
  const double size = hypot(along[0], along[1]);
  return (size > 1e-9 * event_scale(s, u0)) ? size : 0.0;
}

bool event_holds(const event_run *s, int i, const double *u0, const double *lambda) {
  double along[2];
  return slip_at_rest(&s->p, &s->space.a, i) && event_departs(s, i, u0, lambda, along) == 0.0;
}

/* Rows move together where less than this share of their own mobility is left without the others. */
static const double together = 1e-9;

/* Rows that take part, each scaled to a mobility of one. */
typedef struct moving {
  double *C, *A, *b, *scale; /* m*m, m*m, m, m */
  lapack_int *pivot;
  int *row, m;
} moving;

static void moving_layout(void *state, base_arena *m) {
  moving *w = state;
  const size_t n = (size_t)w->m;
  w->C = BASE_ARRAY(m, double, n *n);
  w->A = BASE_ARRAY(m, double, n *n);
  w->b = BASE_ARRAY(m, double, n);
  w->scale = BASE_ARRAY(m, double, n);
  w->pivot = BASE_ARRAY(m, lapack_int, n);
  w->row = BASE_ARRAY(m, int, n);
}

static void list_moving(const event_run *s, moving *w) {
  const form_assembly *a = &s->space.a;
  w->m = 0;
  for (int i = 0; i < a->n_contact; i++) {
    const double *own = form_own_block(a, i);
    const int n = form_rows_of(a, i), rows = slip_at_rest(&s->p, a, i) ? n : 1;
    for (int r = 0; r < rows && own[0] > 0.0; r++) {
      w->row[w->m] = a->row[i] + r;
      w->scale[w->m] = (own[r * (n + 1)] > 0.0) ? 1.0 / sqrt(own[r * (n + 1)]) : 1.0;
      w->m++;
    }
  }
}

base_status event_make_consistent(const event_run *s, double *term, base_error *err) {
  moving w = {.m = s->space.a.n_row};
  void *mem = NULL;
  if (w.m == 0) {
    return BASE_OK;
  }
  BASE_TRY(form_memory(&mem, moving_layout, &w, err));
  list_moving(s, &w);
  const size_t m = (size_t)w.m, n = (size_t)s->space.a.n_row;
  for (size_t j = 0; j < m; j++) {
    w.b[j] = w.scale[j] * term[w.row[j]];
    for (size_t i = 0; i < m; i++) {
      w.C[j * m + i] = w.scale[i] * s->p.C[(size_t)w.row[j] * n + (size_t)w.row[i]] * w.scale[j];
    }
  }
  memcpy(w.A, w.C, m * m * sizeof *w.A);
  memset(w.pivot, 0, m * sizeof *w.pivot);
  lapack_int rank = 0;
  const lapack_int info = (m > 0) ? LAPACKE_dgelsy(LAPACK_COL_MAJOR, w.m, w.m, 1, w.A, w.m, w.b,
                                                   w.m, w.pivot, together, &rank)
                                  : 0;
  if (info != 0) {
    free(mem);
    return BASE_FAIL(err, lin_lapack_status(info), "event: no consistent terms of %d rows", w.m);
  }
  for (size_t i = 0; i < m && rank < w.m; i++) {
    double sum = 0.0;
    for (size_t j = 0; j < m; j++) {
      sum += w.C[j * m + i] * w.b[j];
    }
    term[w.row[i]] = sum / w.scale[i];
  }
  free(mem);
  return BASE_OK;
}

base_status event_log_joints(event_run *s, double dt, bool jump, base_error *err) {
  return joint_log_add(&s->joints, &s->space.view, s->space.a.impulse, dt, jump, err);
}
