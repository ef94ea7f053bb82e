/* solver_pgs.c - projected Gauss-Seidel, point by point or contact by contact.
 *
 *   point   z_i <- P_i( z_i - omega w_i / M_ii )                             M_ii > 0
 *   block   z_b <- z_b + omega (x - z_b),  x solves the LCP (M_bb, w_b - M_bb z_b)
 *
 * with w = M z + q current at every change. Point: Cryer 1971; Cottle, Pang & Stone 1992, alg.
 * 5.2.1. Block: where a block of the problem has a zero on its diagonal (sigma of the polyhedral
 * contact LCP) the block is one LCP of its own, solved exactly (lemke/block.h). Converges for
 * symmetric positive semidefinite M and 0 < omega < 2 (w does; z where it is unique); on others it
 * may cycle, which ends as `stalled`.
 *
 * On the factored form the sweep runs on body velocities and never forms M (sweep.h); boxed friction with three rows a
 * contact (contact_sweep.h) and, with omega = 1, blocks of faceted friction (facet_batches.h) between rigid bodies go in
 * batches of four contacts (variant "batches"). */
#include "lcp/solvers/batch_test.h"
#include "lcp/solvers/contact_sweep.h"
#include "lcp/solvers/facet_batches.h"
#include "lcp/solvers/gauss_seidel.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

typedef struct options {
  lcp_stop stop;
  double omega;
  int budget;
  long rays; /* of one solve */
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
    LCP_LOOP_BUDGET_FIELD(options),
    BASE_FIELD(options, omega, BASE_REAL, "1", 1.0, 0.01, 1.99, "relaxation factor"),
};

typedef struct state {
  lcp_loop loop;
  lcp_gs gs;
  lcp_contact_sweep contacts;
  lcp_batch_test test;
  double omega;
  long rays; /* of one solve */
  lcp_facet_batches facets;
  bool in_facets;  /* of facet_batches.h */
  bool in_batches; /* the matrix-free sweep of contact_sweep.h, or */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_gs_layout(&s->gs, cap, a);
  lcp_contact_sweep_layout(&s->contacts, cap, a);
  lcp_facet_batches_layout(&s->facets, cap, a);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  BASE_TRY(lcp_gs_prepare(&s->gs, p, err));
  s->in_batches = lcp_contact_sweep_prepare(&s->contacts, &s->gs, p);
  s->in_facets = o->omega == 1.0 && lcp_facet_batches_prepare(&s->facets, &s->gs, p);
  return BASE_OK;
}

static void sweep_batches(void *state_of, const lcp_problem *p, long sweeps, double *z) {
  state *s = state_of;
  lcp_contact_sweep_import(&s->contacts, p, z);
  lcp_contact_sweep_run(&s->contacts, s->omega, (int)sweeps);
  lcp_contact_sweep_export(&s->contacts, p, z);
  for (int i = 0; i < p->M.n; i++) { /* bounds went through the scaling */
    z[i] = lcp_set_clip(z[i], s->gs.lo[i], s->gs.hi[i]);
  }
}

static void sweep_facets(void *state_of, const lcp_problem *p, long sweeps, double *z) {
  state *s = state_of;
  lcp_facet_batches_run(&s->facets, p, sweeps, z);
  s->rays += s->facets.rays;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  res->variant = (s->in_batches || s->in_facets) ? "batches" : (s->gs.by_block ? "block" : "point");
  s->test = (lcp_batch_test){.loop = &s->loop,
                             .stop = &o->stop,
                             .sweeps = s->in_facets ? sweep_facets : sweep_batches,
                             .state = s,
                             .body = s->in_facets ? s->facets.lanes.body : s->contacts.body,
                             .every = trace != NULL};
  s->omega = o->omega;
  s->rays = 0;
  lcp_gs_start(&s->gs, p, z, &res->work);
  s->loop.budget = o->budget;
  if (o->budget == 0) {
    lcp_loop_begin(&s->loop, p, true);
  }
  bool fresh;
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (s->in_batches || s->in_facets) {
      if (lcp_batch_run(&s->test, p, z, res)) {
        break;
      }
      continue;
    }
    if (fresh) { /* so that the next iterate depends on z alone */
      lcp_sweep_refresh(&s->gs.sweep, p, z, &res->work);
    }
    lcp_gs_sweep(&s->gs, p, o->omega, z, res);
    res->work.iterations++;
    res->work.sweeps++;
  }
  res->work.fallbacks += s->rays;
  return BASE_OK;
}

const lcp_solver lcp_solver_pgs = {
    .name = "pgs",
    .title = "Projected Gauss-Seidel",
    .cite = "cryer1971; cottle1992, algorithm 5.2.1",
    .words = "Sweeps over the contacts, one unknown at a time.",
    .when = "A rough answer of a large problem, cheaply.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .by_factors = true,
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
