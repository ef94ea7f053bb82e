#include "lcp/lcp_instance.h"

#include "lcp/base/clock.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct lcp_instance {
  const lcp_solver *solver;
  const void *opt; /* borrowed */
  lcp_capacity cap;
  void *state, *mem; /* owned */
  size_t bytes;
  bool prepared; /* third-party handles may be held */
  bool ready;    /* the last prepare succeeded */
  bool untimed;

  lcp_problem p; /* the problem as the solver reads it: a view, or with converted storage */
  double *dense; /* owned conversion buffers */
  size_t dense_cap;
  lcp_csc csc;
  lcp_times times;
};

static double now(const lcp_instance *k) {
  return k->untimed ? 0.0 : base_seconds();
}

void lcp_instance_untimed(lcp_instance *k) {
  k->untimed = true;
}

static void release(lcp_instance *k) {
  if (k->prepared && k->solver->release != NULL) {
    k->solver->release(k->state);
  }
  k->prepared = false;
}

/* Sizes the workspace for `cap`: the layout runs on a measuring arena, then on the real one. */
static base_status fit(lcp_instance *k, const lcp_capacity *cap, base_error *err) {
  release(k);
  memset(k->state, 0, k->solver->state_size);
  if (k->solver->context != NULL) {
    memcpy(k->state, &k->solver->context, sizeof k->solver->context);
  }
  k->cap = (lcp_capacity){.n = -1}; /* holds nothing until the new workspace stands */
  base_arena measure = base_arena_measuring();
  k->solver->layout(k->state, cap, k->opt, &measure);
  void *mem = measure.overflow ? NULL : base_alloc(measure.used);
  if (mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for its workspace at n=%d (%.3g MB)",
                     k->solver->name, cap->n, (double)measure.used / 1e6);
  }
  free(k->mem);
  k->mem = mem;
  k->bytes = measure.used;
  k->cap = *cap;
  base_arena real = base_arena_over(mem, measure.used);
  k->solver->layout(k->state, cap, k->opt, &real);
  return BASE_OK;
}

base_status lcp_instance_open(lcp_instance **out, const lcp_solver *s, const lcp_capacity *cap,
                              const void *opt, base_error *err) {
  *out = NULL;
  lcp_instance *k = calloc(1, sizeof *k);
  void *state = calloc(1, s->state_size > 0 ? s->state_size : 1);
  if (k == NULL || state == NULL) {
    free(k);
    free(state);
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for its state", s->name);
  }
  *k = (lcp_instance){.solver = s, .opt = opt, .state = state};
  const base_status status = fit(k, cap, err);
  if (status != BASE_OK) {
    lcp_instance_close(k);
    return status;
  }
  *out = k;
  return BASE_OK;
}

static base_status to_dense(lcp_instance *k, const lcp_problem *p, base_error *err) {
  const size_t n = (size_t)p->M.n;
  if (n * n > k->dense_cap) {
    double *more =
        (n <= SIZE_MAX / sizeof *more / (n + 1)) ? base_alloc(n * n * sizeof *more) : NULL;
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for a dense copy at n=%d", k->solver->name,
                       p->M.n);
    }
    free(k->dense);
    k->dense = more;
    k->dense_cap = n * n;
  }
  lcp_matrix_to_dense(&p->M, k->dense);
  k->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = p->M.n, .val = k->dense};
  return BASE_OK;
}

static base_status to_csc(lcp_instance *k, const lcp_problem *p, base_error *err) {
  lcp_csc_free(&k->csc);
  BASE_TRY(lcp_matrix_to_csc(&p->M, &k->csc, err));
  k->p.M = (lcp_matrix){.storage = LCP_CSC, .n = p->M.n, .csc = k->csc};
  return BASE_OK;
}

/* A view of p, or p in a storage that the solver reads: sparse before dense for a sparse or
 * factored problem. */
static base_status read_storage(lcp_instance *k, const lcp_problem *p, base_error *err) {
  k->p = *p;
  const unsigned reads = k->solver->storages;
  if (k->solver->by_factors && p->M.storage == LCP_CSC && p->M.factored != NULL) {
    k->p.M = lcp_matrix_in_factors(&p->M);
    return BASE_OK;
  }
  if ((reads & (1u << p->M.storage)) != 0) {
    return BASE_OK;
  }
  if (p->M.storage != LCP_CSC && (reads & (1u << LCP_CSC)) != 0) {
    return to_csc(k, p, err);
  }
  if (p->M.storage != LCP_DENSE && (reads & (1u << LCP_DENSE)) != 0) {
    return to_dense(k, p, err);
  }
  return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: reads factored matrices only", k->solver->name);
}

base_status lcp_instance_prepare(lcp_instance *k, const lcp_problem *p, base_error *err) {
  k->times = (lcp_times){0};
  k->ready = false;
  BASE_TRY(lcp_solver_admits(k->solver, p, err));
  const double started = now(k);
  BASE_TRY(read_storage(k, p, err));
  assert(lcp_problem_is_shaped(&k->p));
  const lcp_capacity need = lcp_problem_capacity(&k->p);
  if (!lcp_capacity_holds(&k->cap, &need)) {
    BASE_TRY(fit(k, &need, err));
  }
  release(k);
  k->prepared = true;
  if (k->solver->prepare != NULL) {
    BASE_TRY(k->solver->prepare(k->state, &k->p, k->opt, err));
  }
  const double set_up = now(k);
  k->times.setup = set_up - started;
  if (k->solver->factor != NULL) {
    BASE_TRY(k->solver->factor(k->state, &k->p, k->opt, err));
    k->times.factor = now(k) - set_up;
  }
  k->ready = true;
  return BASE_OK;
}

/* q = 0, and every box holds zero: so zero is an answer. */
static bool is_homogeneous(const lcp_problem *p) {
  bool is = true;
  for (int i = 0; i < p->M.n && is; i++) {
    is = p->q[i] == 0.0;
  }
  for (int b = 0; p->block != NULL && b < p->n_block && is; b++) {
    const lcp_block *k = &p->block[b];
    for (int i = k->start; k->set == LCP_BOX && i < k->start + k->size && is; i++) {
      is = p->lo[i] <= 0.0 && p->hi[i] >= 0.0;
    }
  }
  return is;
}

base_status lcp_instance_solve(lcp_instance *k, lcp_trace *trace, double *z, lcp_result *res,
                               base_error *err) {
  *res =
      (lcp_result){.outcome = LCP_NUMERICAL, .residual = HUGE_VAL, .variant = "", .solutions = -1};
  if (!k->ready) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: solve without a successful prepare", k->solver->name);
  }
  if (is_homogeneous(&k->p)) {
    memset(z, 0, (size_t)k->p.M.n * sizeof *z);
  }
  const double started = now(k);
  const base_status s = k->solver->solve(k->state, &k->p, k->opt, trace, z, res);
  k->times.solve = k->untimed ? 0.0 : now(k) - started - res->aside;
  return (s == BASE_OK)
             ? BASE_OK
             : BASE_FAIL(err, s, "%s: solve failed: %s", k->solver->name, base_status_text(s));
}

void lcp_instance_rest(lcp_instance *k) {
  release(k);
  free(k->mem);
  k->mem = NULL;
  k->ready = false;
  k->cap = (lcp_capacity){.n = -1};
}

lcp_times lcp_instance_times(const lcp_instance *k) {
  return k->times;
}

lcp_storage lcp_instance_storage(const lcp_instance *k) {
  return k->p.M.storage;
}

size_t lcp_instance_bytes(const lcp_instance *k) {
  return k->bytes;
}

void lcp_instance_close(lcp_instance *k) {
  if (k != NULL) {
    release(k);
    lcp_csc_free(&k->csc);
    free(k->dense);
    free(k->mem);
    free(k->state);
    free(k);
  }
}
