/* solver_tableau.c - the textbook's Lemke on a dense tableau (tests/support/tableau_lemke.h) as a solver
 * of the command line, so that a whole simulation can be timed with it. Not part of the library: it
 * neither scales nor refactorises, and says "solved" only where the residual test agrees. */
#include "tests/bench/solver_tableau.h"

#include "tests/support/tableau_lemke.h"

typedef struct options {
  lcp_stop stop;
} options;

typedef struct tableau {
  lcp_stop_state stop;
  double *work, *dense;
} tableau;

static const base_field fields[] = {LCP_STOP_FIELDS(options, 1e-9, 1000000)};

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  tableau *s = state;
  lcp_stop_layout(&s->stop, cap, a);
  s->work = BASE_ARRAY(a, double, tableau_lemke_work(cap->n));
  s->dense = BASE_ARRAY(a, double, (size_t)cap->n *(size_t)cap->n);
}

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* a pivot sequence has no residual */
  tableau *s = state;
  const lcp_stop *stop = &((const options *)opt)->stop;
  lcp_stop_begin(&s->stop, p);
  lcp_matrix_to_dense(&p->M, s->dense);
  const lcp_outcome ended = tableau_lemke(p->M.n, s->dense, p->q, z, s->work, &res->work.pivots);
  res->work.iterations = res->work.pivots;
  const bool met = lcp_stop_met(&s->stop, stop->tol, p, z, res);
  res->outcome = (ended == LCP_SOLVED && !met) ? LCP_NUMERICAL : ended;
  return BASE_OK;
}

static const lcp_solver tableau_solver = {
    .name = "tableau",
    .title = "Lemke, dense tableau",
    .cite = "cottle1992, algorithm 4.4.5",
    .sets = 1u << LCP_ORTHANT,
    .storages = 1u << LCP_DENSE,
    .exact = true,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(tableau),
    .layout = layout,
    .solve = solve,
};

const lcp_solver *const tableau_solvers[] = {&tableau_solver, NULL};
