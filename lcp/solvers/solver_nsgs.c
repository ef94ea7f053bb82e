/* solver_nsgs.c - nonsmooth Gauss-Seidel for exact Coulomb friction on second-order cones.
 *
 * Jean 1999; Jourdan, Alart & Jean 1998; the exact local solve of cone_block.h in the place of a local
 * Newton method (Acary, Bremond & Huber 2018 compare both). De Saxce's term is inside the local
 * problem, no outer loop over it. Sliding, torsion and rolling parts. No convergence proof exists;
 * on redundant contacts convergence is sublinear. Rows of orthants, boxes and free blocks (joints)
 * are swept with the cones. On the factored form cones of three rows between rigid bodies go in batches of four contacts,
 * (variant "batches", cone_batches.h).
 *
 * `accelerate=anderson` mixes the sweeps in the variables of cone_scaled.h (mixing.h), moved into K, at the price of a product each;
 * `polish=on` tries the modes of the iterates as the answer's (cone_polish.h). */
#include "lcp/solvers/batch_test.h"
#include "lcp/solvers/cone_batches.h"
#include "lcp/solvers/cone_polish.h"
#include "lcp/solvers/cone_sweep.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/mixing.h"

enum { PLAIN, ANDERSON }; /* accelerate */
enum { OFF, ON };         /* polish */

typedef struct options {
  lcp_stop stop;
  double omega;
  int budget, accelerate, polish;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
    LCP_LOOP_BUDGET_FIELD(options),
    BASE_FIELD(options, omega, BASE_REAL, "1", 1.0, 0.01, 1.0, "relaxation factor"),
    BASE_FIELD_CHOICE(options, accelerate, "none|anderson", PLAIN, "mixing of the sweeps"),
    BASE_FIELD_CHOICE(options, polish, "off|on", OFF, "modes solved to rounding"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_sweep sweep;
  lcp_cone_batches contacts;
  lcp_batch_test test;
  double omega;
  bool in_batches;        /* the matrix-free sweep of cone_batches.h */
  lcp_cone_polish polish; /* of either option: the scaled variables */
  lcp_mixing mixing;
  double *x, *step; /* n, scaled: before the sweep, and its step */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  const options *o = opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_cone_sweep_layout(&s->sweep, cap, a);
  lcp_cone_batches_layout(&s->contacts, cap, a);
  if (o->polish == ON || o->accelerate == ANDERSON) {
    lcp_cone_polish_layout(&s->polish, cap, a);
  }
  if (o->accelerate == ANDERSON) {
    lcp_mixing_layout(&s->mixing, cap, a);
    s->x = BASE_ARRAY(a, double, cap->n);
    s->step = BASE_ARRAY(a, double, cap->n);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  if (o->polish == ON && o->budget > 0) {
    return BASE_FAIL(
        err, BASE_EUNSUPPORTED,
        "polish=on with budget=%d: the polish goes by tests, of which a budget has none",
        o->budget);
  }
  if (o->polish == ON || o->accelerate == ANDERSON) {
    BASE_TRY(lcp_cone_polish_prepare(&s->polish, p, err));
  }
  s->in_batches = o->accelerate == PLAIN && lcp_cone_batches_prepare(&s->contacts, p);
  return s->in_batches ? BASE_OK : lcp_cone_sweep_prepare(&s->sweep, p, err);
}

/* One sweep from z, mixed with those before. */
static base_status mix(state *s, const options *o, const lcp_problem *p, double *z,
                       lcp_result *res) {
  const int n = p->M.n;
  const double *unit = s->polish.eq.s;
  for (int i = 0; i < n; i++) {
    s->x[i] = z[i] / unit[i];
  }
  (void)lcp_cone_sweep_run(&s->sweep, p, o->omega, 0.0, NULL, z);
  for (int i = 0; i < n; i++) {
    s->step[i] = z[i] / unit[i] - s->x[i];
  }
  const base_status status = lcp_mixing_next(&s->mixing, s->step, s->x, &res->work);
  for (int i = 0; i < n; i++) {
    s->step[i] = s->x[i] * unit[i];
  }
  lcp_cone_scaled_project(&s->polish.eq, s->step, z);
  lcp_sweep_refresh(&s->sweep.sweep, p, z, &res->work);
  return status;
}

static void sweep_batches(void *state_of, const lcp_problem *p, long sweeps, double *z) {
  state *s = state_of;
  lcp_cone_batches_run(&s->contacts, p, s->omega, sweeps, z);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  bool fresh;
  base_status status = BASE_OK;
  res->variant = s->in_batches ? "batches" : "";
  s->test = (lcp_batch_test){.loop = &s->loop,
                             .stop = &o->stop,
                             .sweeps = sweep_batches,
                             .state = s,
                             .body = s->contacts.body,
                             .every = trace != NULL || o->polish == ON};
  s->omega = o->omega;
  s->loop.budget = o->budget;
  if (o->budget == 0) {
    lcp_loop_begin(&s->loop, p, o->accelerate == PLAIN);
  }
  if (o->polish == ON) {
    lcp_cone_polish_begin(&s->polish);
  }
  if (o->accelerate == ANDERSON) {
    lcp_mixing_begin(&s->mixing, p->M.n);
  }
  while (status == BASE_OK && !lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh && o->polish == ON &&
        lcp_cone_polish_try(&s->polish, &s->loop, &o->stop, p, 1.0, NULL, z, res, &status)) {
      break;
    }
    if (s->in_batches) {
      if (lcp_batch_run(&s->test, p, z, res)) {
        break;
      }
      continue;
    }
    if (fresh) {
      lcp_sweep_refresh(&s->sweep.sweep, p, z, &res->work);
    }
    if (o->accelerate == ANDERSON) {
      status = (status == BASE_OK) ? mix(s, o, p, z, res) : status;
    } else {
      (void)lcp_cone_sweep_run(&s->sweep, p, o->omega, 0.0, NULL, z);
    }
    res->work.iterations++;
    res->work.sweeps++;
  }
  return status;
}

static void release(void *st) {
  lcp_cone_polish_release(&((state *)st)->polish);
}

const lcp_solver lcp_solver_nsgs = {
    .name = "nsgs",
    .title = "Nonsmooth Gauss-Seidel",
    .cite = "jean1999; acary2018",
    .words = "Sweeps over the contacts, one friction cone at a time.",
    .when = "The round cone, to a moderate accuracy.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .by_factors = true,
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
