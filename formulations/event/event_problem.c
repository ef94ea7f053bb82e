/* The complementarity problems of one instant: solved, with friction of the circle, and kept free of noise; and the forces of
 * the joints that follow. */
#include "formulations/event/event_run.h"

#include <math.h>
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

/* Rows of a contact move together where less than this share of a row's own mobility is left without the others. */
static const double together = 1e-9;

/* The row of the largest diagonal that is left, the normal before all others. */
static int next_row(const double *left, const bool *done, int n) {
  int k = -1;
  for (int r = 0; r < n && (done[0] || r == 0); r++) {
    k = (!done[r] && (k < 0 || left[r * (n + 1)] > left[k * (n + 1)])) ? r : k;
  }
  return k;
}

void event_make_consistent(const double *B, int n, double *term) {
  double left[9], asked[3];
  bool done[3] = {false};
  memcpy(left, B, (size_t)(n * n) * sizeof *left);
  memcpy(asked, term, (size_t)n * sizeof *asked);
  for (int k = 0; k >= 0 && left[k * (n + 1)] > together * B[k * (n + 1)];
       k = next_row(left, done, n)) {
    done[k] = true;
    for (int r = 0; r < n; r++) {
      const double share = done[r] ? 0.0 : left[k * n + r] / left[k * (n + 1)];
      asked[r] -= share * asked[k];
      for (int c = 0; c < n; c++) {
        left[c * n + r] -= share * (done[c] ? 0.0 : left[c * n + k]);
      }
    }
  }
  for (int r = 0; r < n; r++) {
    term[r] -= done[r] ? 0.0 : asked[r];
  }
}

base_status event_log_joints(event_run *s, double dt, bool jump, base_error *err) {
  return joint_log_add(&s->joints, &s->space.view, s->space.a.impulse, dt, jump, err);
}
