/* solver_nsgs.c - nonsmooth Gauss-Seidel for exact Coulomb friction on second-order cones.
 *
 * Jean 1999; Jourdan, Alart & Jean 1998; the exact local solve of cone_block.h in the place of a local
 * Newton method (Acary, Bremond & Huber 2018 compare both). De Saxce's term is inside the local
 * problem, no outer loop over it. Sliding, torsion and rolling parts. No convergence proof exists;
 * on redundant contacts convergence is sublinear. Rows of orthants, boxes and free blocks (joints)
 * are swept with the cones. */
#include "lcp/solvers/cone_sweep.h"
#include "lcp/solvers/loop.h"

typedef struct options {
  lcp_stop stop;
  double omega;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
    BASE_FIELD(options, omega, BASE_REAL, "1", 1.0, 0.01, 1.0, "relaxation factor"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_sweep sweep;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_cone_sweep_layout(&s->sweep, cap, a);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  return lcp_cone_sweep_prepare(&((state *)st)->sweep, p, err);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  bool fresh;
  lcp_loop_begin(&s->loop, p, true);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh) {
      lcp_sweep_refresh(&s->sweep.sweep, p, z, &res->work);
    }
    (void)lcp_cone_sweep_run(&s->sweep, p, o->omega, 0.0, NULL, z);
    res->work.iterations++;
    res->work.sweeps++;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_nsgs = {
    .name = "nsgs",
    .title = "Nonsmooth Gauss-Seidel",
    .cite = "jean1999; acary2018",
    .words = "Sweeps over the contacts, one friction cone at a time.",
    .when = "The round cone, to a moderate accuracy.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
