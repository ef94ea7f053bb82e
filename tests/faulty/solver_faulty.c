#define _DEFAULT_SOURCE /* usleep */
#include "tests/faulty/solver_faulty.h"

#include "lcp/base/clock.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct faulty_options {
  lcp_stop stop;
  double seconds; /* work or sleep of the well-behaved ones [s] */
} faulty_options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(faulty_options, 1e-10, 1000),
    BASE_FIELD(faulty_options, seconds, BASE_REAL, "s", 0.002, 0, 10, "time one solve takes"),
};

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)state;
  (void)cap;
  (void)opt;
  (void)a;
}

static base_status claim(lcp_outcome outcome, lcp_result *res) {
  *res = (lcp_result){.outcome = outcome, .work.iterations = 1, .variant = ""};
  return BASE_OK;
}

/* ---- six ways to die, and two ways to lie -----------------------------------------------------*/

#define UNUSED_ (void)state, (void)p, (void)opt, (void)trace, (void)z

static base_status solve_liar(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                              double *z, lcp_result *res) {
  UNUSED_;
  memset(z, 0, (size_t)p->M.n * sizeof *z);
  return claim(LCP_SOLVED, res);
}

static base_status solve_nan(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                             double *z, lcp_result *res) {
  UNUSED_;
  for (int i = 0; i < p->M.n; i++) {
    z[i] = (double)NAN;
  }
  return claim(LCP_SOLVED, res);
}

static base_status solve_crash(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                               double *z, lcp_result *res) {
  UNUSED_;
  (void)raise(SIGSEGV);
  return claim(LCP_SOLVED, res);
}

static base_status solve_hang(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                              double *z, lcp_result *res) {
  UNUSED_;
  (void)signal(SIGTERM, SIG_IGN); /* only SIGKILL helps */
  for (;;) {
    (void)usleep(1000);
  }
  return claim(LCP_SOLVED, res);
}

static base_status solve_hog(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                             double *z, lcp_result *res) {
  UNUSED_;
  char *much = malloc((size_t)100 << 30);
  if (much == NULL) {
    return BASE_ENOMEM;
  }
  memset(much, 1, (size_t)100 << 30);
  free(much);
  return claim(LCP_SOLVED, res);
}

static base_status solve_quit(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                              double *z, lcp_result *res) {
  UNUSED_;
  _exit((int)(claim(LCP_SOLVED, res) - BASE_OK));
  return BASE_OK;
}

static base_status solve_flood(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                               double *z, lcp_result *res) {
  UNUSED_;
  for (;;) {
    (void)puts("I am still here, and I have nothing to say, which I shall now repeat.");
  }
  return claim(LCP_SOLVED, res);
}

/* ---- well-behaved ones with a known cost ------------------------------------------------------*/

/* Scalar problems only: z_i = max(0, -q_i / M_ii), exact on a diagonal matrix. */
static base_status solve_diagonal(const lcp_problem *p, double *z, lcp_result *res) {
  lcp_matrix_diagonal(&p->M, z);
  for (int i = 0; i < p->M.n; i++) {
    z[i] = (p->q[i] < 0.0 && z[i] > 0.0) ? -p->q[i] / z[i] : 0.0;
  }
  return claim(LCP_SOLVED, res);
}

/* The same arithmetic for everybody: a number of rounds, not a time. */
static void work(double rounds) {
  volatile double x = 1.0;
  for (long i = 0; i < (long)rounds; i++) {
    x = x * 0.999999 + 1e-6;
  }
}

enum { ROUNDS_PER_SECOND = 250000000 };

static base_status solve_steady(void *state, const lcp_problem *p, const void *opt,
                                lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const faulty_options *o = opt;
  work(o->seconds * ROUNDS_PER_SECOND);
  return solve_diagonal(p, z, res);
}

static base_status solve_slower(void *state, const lcp_problem *p, const void *opt,
                                lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const faulty_options *o = opt;
  work(1.05 * o->seconds * ROUNDS_PER_SECOND);
  return solve_diagonal(p, z, res);
}

/* A planted sleep: in the factorisation, nowhere else. */
static base_status factor_sleep(void *state, const lcp_problem *p, const void *opt,
                                base_error *err) {
  (void)state;
  (void)p;
  (void)err;
  const faulty_options *o = opt;
  const double until = base_seconds() + o->seconds;
  while (base_seconds() < until) {
    (void)usleep(50);
  }
  return BASE_OK;
}

static base_status solve_plain(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                               double *z, lcp_result *res) {
  UNUSED_;
  return solve_diagonal(p, z, res);
}

/* ---- ones that a flag should find -------------------------------------------------------------*/

/* Damped steps towards the answer of a diagonal matrix: right, but not to the last bit. */
static base_status solve_damped(void *state, const lcp_problem *p, const void *opt,
                                lcp_trace *trace, double *z, lcp_result *res) {
  enum { STEPS = 12 };
  UNUSED_;
  const base_status done = solve_diagonal(p, z, res);
  double left = 1.0;
  for (int k = 0; k < STEPS; k++) {
    left *= 0.1;
  }
  for (int i = 0; i < p->M.n; i++) {
    z[i] -= left * z[i];
  }
  res->work.iterations = STEPS;
  return done;
}

static base_status solve_idle(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                              double *z, lcp_result *res) {
  UNUSED_;
  const base_status done = solve_diagonal(p, z, res);
  res->work.iterations = 0;
  return done;
}

static base_status solve_fallback(void *state, const lcp_problem *p, const void *opt,
                                  lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const base_status done = solve_diagonal(p, z, res);
  res->work.fallbacks = 1;
  return done;
}

/* Uses up the time it is given, then says so. */
static base_status solve_patient(void *state, const lcp_problem *p, const void *opt,
                                 lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const faulty_options *o = opt;
  const double until = base_seconds() + o->stop.max_seconds;
  while (base_seconds() < until) {
    (void)usleep(1000);
  }
  return claim(LCP_TIME_LIMIT, res);
}

static long solves; /* a solver must not: these three do */

static base_status solve_fickle(void *state, const lcp_problem *p, const void *opt,
                                lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const base_status done = solve_diagonal(p, z, res);
  z[0] *= 1.0 + 1e-14 * (double)(++solves % 997); /* the same again by chance: hardly */
  return done;
}

/* Gives up at once, elsewhere each time, and blames the clock. */
static base_status solve_tired(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                               double *z, lcp_result *res) {
  UNUSED_;
  z[0] = (double)(++solves);
  return claim(LCP_TIME_LIMIT, res);
}

static base_status solve_hiccup(void *state, const lcp_problem *p, const void *opt,
                                lcp_trace *trace, double *z, lcp_result *res) {
  UNUSED_;
  const faulty_options *o = opt;
  const bool late = ++solves % 6 == 0;
  (void)usleep((useconds_t)(1e6 * o->seconds * (late ? 40.0 : 1.0)));
  return solve_diagonal(p, z, res);
}

/* What happens once in a process: its first solve sleeps. */
static base_status solve_first(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                               double *z, lcp_result *res) {
  UNUSED_;
  static bool begun;
  const faulty_options *o = opt;
  if (!begun) {
    (void)usleep((useconds_t)(1e6 * o->seconds));
  }
  begun = true;
  return solve_diagonal(p, z, res);
}

#define FAULTY(id, text, solve_, factor_) FAULTY_KIND(id, text, solve_, factor_, true)
#define FAULTY_KIND(id, text, solve_, factor_, exact_)                                             \
  static const lcp_solver faulty_##id = {                                                          \
      .name = "faulty_" #id,                                                                       \
      .title = (text),                                                                             \
      .cite = "test",                                                                              \
      .sets = 1u << LCP_ORTHANT | 1u << LCP_BOX | 1u << LCP_FREE | 1u << LCP_CONE,                 \
      .storages = 1u << LCP_DENSE | 1u << LCP_CSC | 1u << LCP_FACTORED,                            \
      .exact = (exact_),                                                                           \
      .fields = fields,                                                                            \
      .n_fields = BASE_COUNT(fields),                                                              \
      .options_size = sizeof(faulty_options),                                                      \
      .layout = layout,                                                                            \
      .factor = (factor_),                                                                         \
      .solve = (solve_),                                                                           \
  }

FAULTY(liar, "claims success with z = 0", solve_liar, NULL);
FAULTY(nan, "returns NaN and claims success", solve_nan, NULL);
FAULTY(crash, "dies by SIGSEGV", solve_crash, NULL);
FAULTY(hang, "never returns and ignores SIGTERM", solve_hang, NULL);
FAULTY(hog, "allocates 100 GB", solve_hog, NULL);
FAULTY(quit, "calls exit(0)", solve_quit, NULL);
FAULTY(flood, "floods stdout", solve_flood, NULL);
FAULTY(steady, "fixed work", solve_steady, NULL);
FAULTY(twin, "the same fixed work", solve_steady, NULL);
FAULTY(slower, "five per cent more work", solve_slower, NULL);
FAULTY(sleeper, "sleeps while factoring", solve_plain, factor_sleep);

FAULTY_KIND(damped, "iterates", solve_damped, NULL, false);
FAULTY_KIND(copy, "the same iteration under another name", solve_damped, NULL, false);
FAULTY(idle, "solves without an iteration", solve_idle, NULL);
FAULTY(fallback, "asks another method", solve_fallback, NULL);
FAULTY(patient, "works until its time limit", solve_patient, NULL);
FAULTY(fickle, "never the same answer", solve_fickle, NULL);
FAULTY(tired, "says that its time is up", solve_tired, NULL);
FAULTY(hiccup, "every sixth solve takes forty times as long", solve_hiccup, NULL);
FAULTY(first, "the first solve of a process sleeps", solve_first, NULL);

const lcp_solver *const faulty_solvers[] = {&faulty_liar,    &faulty_nan,     &faulty_crash,
                                            &faulty_hang,    &faulty_hog,     &faulty_quit,
                                            &faulty_flood,   &faulty_steady,  &faulty_twin,
                                            &faulty_slower,  &faulty_sleeper, &faulty_damped,
                                            &faulty_copy,    &faulty_idle,    &faulty_fallback,
                                            &faulty_patient, &faulty_fickle,  &faulty_hiccup,
                                            &faulty_tired,   &faulty_first,   NULL};
