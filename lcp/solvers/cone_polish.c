#include "lcp/solvers/cone_polish.h"

#include <limits.h>
#include <string.h>

enum { ROUNDS = 16, STEPS = 12, FIRST = 10, SHARE = 2, MANY = 64, SHARE_OF_ROWS = 16 };
static const double least_weight = 1e-11, share = 0.1;

void lcp_cone_polish_layout(lcp_cone_polish *s, const lcp_capacity *cap, base_arena *a) {
  lcp_cone_scaled_layout(&s->eq, cap, a);
  lcp_cone_step_layout(&s->step, cap, a);
  s->mode = BASE_ARRAY(a, unsigned char, cap->n);
  s->failed = BASE_ARRAY(a, unsigned char, cap->n);
  double **const arrays[] = {&s->x, &s->y, &s->dx, &s->z, &s->w, &s->d};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

base_status lcp_cone_polish_prepare(lcp_cone_polish *s, const lcp_problem *p, base_error *err) {
  lcp_matrix_diagonal(&p->M, s->d);
  memset(s->failed, UCHAR_MAX, (size_t)p->M.n); /* no mode: compared before any has failed */
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->d, NULL, err));
  return lcp_cone_step_prepare(&s->step, p, &s->eq, err);
}

void lcp_cone_polish_begin(lcp_cone_polish *s) {
  s->next = FIRST;
  s->failed[0] = UCHAR_MAX; /* no mode */
}

void lcp_cone_polish_release(lcp_cone_polish *s) {
  lcp_cone_step_release(&s->step);
}

/* x and y of z and w. */
static void place(lcp_cone_polish *s, int n, const double *z, const double *w) {
  for (int i = 0; i < n; i++) {
    s->x[i] = z[i] / s->eq.s[i];
    s->y[i] = w[i] * s->eq.s[i];
  }
}

/* The modes of x - y / balance, or of `point` where there is one. */
static void identify(lcp_cone_polish *s, int n, double balance, const double *point) {
  for (int i = 0; i < n; i++) {
    s->y[i] = (point != NULL) ? s->x[i] - point[i] : s->y[i] / balance;
  }
  for (int k = 0; k < s->eq.n_piece; k++) {
    const int i = s->eq.piece[k].start;
    lcp_cone_modes(&s->eq.piece[k], s->eq.lo[i], s->eq.hi[i], s->x + i, s->y + i, s->mode + i);
  }
}

/* |F|^2 of the modes at x, y. */
static double smooth(lcp_cone_polish *s) {
  double sum = 0.0;
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    const int i = b->start;
    const size_t at = lcp_cone_scaled_at(&s->eq, b);
    lcp_cone_smooth(b, s->eq.lo[i], s->eq.hi[i], s->mode + i, s->x + i, s->y + i, s->eq.F + i,
                    s->eq.X + at, s->eq.Y + at);
    for (int r = i; r < i + b->size; r++) {
      sum += s->eq.F[r] * s->eq.F[r];
    }
  }
  return sum;
}

/* Newton's method from s->z until |F| does not fall to half; x and y are those of the last s->z. False: no such step. */
static bool newton(lcp_cone_polish *s, lcp_loop *loop, const lcp_problem *p, lcp_work *work,
                   base_status *status) {
  const int n = p->M.n;
  double last = HUGE_VAL;
  for (int k = 0; k < STEPS; k++) {
    lcp_matrix_apply(&p->M, s->z, p->q, s->w, loop->stop.scratch);
    work->matvecs++;
    place(s, n, s->z, s->w);
    const double now = smooth(s);
    if (!(now < 0.25 * last)) {
      return now == now;
    }
    last = now;
    double size = 0.0;
    for (int i = 0; i < n; i++) {
      size += s->x[i] * s->x[i] + s->y[i] * s->y[i];
    }
    const double weight = fmax(share * fmin(1.0, sqrt(now / size)), least_weight);
    if (!lcp_cone_step_factor(&s->step, p, &s->eq, weight, work, status)) {
      return false;
    }
    lcp_cone_step_solve(&s->step, p, &s->eq, s->dx, work);
    for (int i = 0; i < n; i++) {
      s->z[i] += s->eq.s[i] * s->dx[i];
    }
  }
  return true;
}

static bool accepted(lcp_cone_polish *s, lcp_loop *loop, const lcp_stop *stop, const lcp_problem *p,
                     double *z, lcp_result *res) {
  const lcp_stop now = {stop->tol, stop->max_iter, 1, stop->max_seconds};
  lcp_result again = *res;
  lcp_cone_scaled_project(&s->eq, s->z, s->w);
  if (!lcp_loop_ended(loop, &now, p, s->w, NULL, &again, NULL) || again.outcome != LCP_SOLVED) {
    res->work = again.work;
    return false;
  }
  memcpy(z, s->w, (size_t)p->M.n * sizeof *z);
  *res = again;
  return true;
}

/* Rows whose modes are not those that failed last. */
static int differences(const lcp_cone_polish *s, int n) {
  int count = 0;
  for (int i = 0; i < n; i++) {
    count += s->mode[i] != s->failed[i];
  }
  return count;
}

// NOLINTNEXTLINE(readability-function-size): as lcp_cone_polish_try
static bool attempt(lcp_cone_polish *s, lcp_loop *loop, const lcp_stop *stop, const lcp_problem *p,
                    double balance, const double *point, double *z, lcp_result *res,
                    base_status *status) {
  const int n = p->M.n;
  memcpy(s->z, z, (size_t)n * sizeof *z);
  place(s, n, z, loop->stop.w);
  for (int round = 0; round < ROUNDS; round++) {
    identify(s, n, balance, (round == 0) ? point : NULL);
    const int now = differences(s, n);
    if (now == 0 || (round > 0 && now > MANY + n / SHARE_OF_ROWS)) {
      return false; /* the same again, or all over the place */
    }
    memcpy(s->failed, s->mode, (size_t)n);
    if (!newton(s, loop, p, &res->work, status)) {
      return false;
    }
    if (accepted(s, loop, stop, p, z, res)) {
      return true;
    }
    res->work.refinements++;
  }
  return false;
}

// NOLINTNEXTLINE(readability-function-size): the point, the test that it has to pass, and what it counts in
bool lcp_cone_polish_try(lcp_cone_polish *s, lcp_loop *loop, const lcp_stop *stop,
                         const lcp_problem *p, double balance, const double *point, double *z,
                         lcp_result *res, base_status *status) {
  const long before = res->work.factorizations;
  if (res->work.iterations < s->next) {
    return false;
  }
  const bool solved = attempt(s, loop, stop, p, balance, point, z, res, status);
  const long spent = res->work.factorizations - before;
  const long wait =
      (res->work.iterations > 4 * SHARE * spent) ? res->work.iterations / 4 : SHARE * spent;
  s->next = res->work.iterations + wait;
  return solved;
}
