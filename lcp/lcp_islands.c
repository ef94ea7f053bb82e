#include "lcp/lcp_islands.h"

#include "lcp/base/clock.h"
#include "lcp/base/crew.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_islands_cut.h"

#include <stdlib.h>
#include <string.h>

/* What the solver made of an island. */
typedef struct solved {
  lcp_instance *instance; /* owned */
  lcp_result res;
  base_status status;
  base_error err;
} solved;

struct lcp_islands {
  const lcp_solver *solver;
  const void *opt;
  islands_cut cut;
  solved *of; /* cap_of */
  int cap_of;
  lcp_times times;
  double *proof; /* cap_n: of the whole */
  unsigned char *basis;
  int cap_n;
};

base_status lcp_islands_open(lcp_islands **out, const lcp_solver *s, const void *opt,
                             base_error *err) {
  *out = calloc(1, sizeof **out);
  if (*out == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for islands");
  }
  **out = (lcp_islands){.solver = s, .opt = opt};
  return BASE_OK;
}

void lcp_islands_close(lcp_islands *s) {
  if (s == NULL) {
    return;
  }
  for (int k = 0; k < s->cap_of; k++) {
    lcp_instance_close(s->of[k].instance);
  }
  lcp_islands_cut_close(&s->cut);
  free(s->of);
  free(s->proof);
  free(s->basis);
  free(s);
}

static base_status grow(lcp_islands *s, int n, base_error *err) {
  const int count = s->cut.count;
  if (count > s->cap_of) {
    solved *more = realloc(s->of, (size_t)(2 * count) * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d islands", count);
    }
    memset(more + s->cap_of, 0, (size_t)(2 * count - s->cap_of) * sizeof *more);
    s->of = more;
    s->cap_of = 2 * count;
  }
  if (n > s->cap_n) {
    free(s->proof);
    free(s->basis);
    s->proof = malloc((size_t)n * sizeof *s->proof);
    s->basis = malloc((size_t)n);
    s->cap_n = (s->proof != NULL && s->basis != NULL) ? n : 0;
    if (s->cap_n == 0) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for a proof of %d rows", n);
    }
  }
  return BASE_OK;
}

/* ---- one island after the other -------------------------------------------------------------- */

static void solve_island(void *islands, int part, int hand) {
  lcp_islands *s = islands;
  const int k = s->cut.by_size[part];
  (void)hand;
  solved *own = &s->of[k];
  const lcp_problem *p = &s->cut.island[k].p;
  own->err = (base_error){0};
  own->status = BASE_OK;
  if (own->instance == NULL) {
    const lcp_capacity cap = lcp_problem_capacity(p);
    own->status = lcp_instance_open(&own->instance, s->solver, &cap, s->opt, &own->err);
  }
  if (own->status == BASE_OK) {
    own->status = lcp_instance_prepare(own->instance, p, &own->err);
  }
  if (own->status == BASE_OK) {
    own->status = lcp_instance_solve(own->instance, NULL, s->cut.island[k].z, &own->res, &own->err);
  }
}

/* ---- the answer of the whole ----------------------------------------------------------------- */

static bool is_worse(lcp_outcome a, lcp_outcome b) {
  return b != LCP_INFEASIBLE && (a == LCP_INFEASIBLE || a > b);
}

/* The vector of island k, zero elsewhere: a Farkas vector of a part is one of the whole, and so is a ray. */
static void whole_vector(lcp_islands *s, int n, int k, lcp_certificate *c) {
  memset(s->proof, 0, (size_t)n * sizeof *s->proof);
  lcp_islands_cut_out(&s->cut, k, c->vector, s->proof);
  c->vector = s->proof;
}

/* A basis of the whole needs one of every island. */
static void whole_basis(lcp_islands *s, lcp_certificate *c) {
  *c = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->basis};
  for (int k = 0; k < s->cut.count; k++) {
    const lcp_certificate *own = &s->of[k].res.certificate;
    if (own->kind != LCP_CERT_BASIS) {
      *c = (lcp_certificate){.kind = LCP_CERT_NONE};
      return;
    }
    const islands_part *part = &s->cut.island[k];
    for (int i = 0; i < part->p.M.n; i++) {
      s->basis[part->row[i]] = own->basis[i];
    }
  }
}

static void merge(lcp_islands *s, int n, double *z, lcp_result *res) {
  int worst = 0;
  lcp_work sum = {0};
  double residual = 0;
  for (int k = 0; k < s->cut.count; k++) {
    const lcp_result *own = &s->of[k].res;
    lcp_islands_cut_out(&s->cut, k, s->cut.island[k].z, z);
    lcp_work_add(&sum, &own->work);
    residual =
        (own->residual > residual || own->residual != own->residual) ? own->residual : residual;
    worst = is_worse(own->outcome, s->of[worst].res.outcome) ? k : worst;
  }
  *res = s->of[worst].res;
  res->work = sum;
  res->residual = residual;
  res->solutions = -1;
  if (res->certificate.kind == LCP_CERT_FARKAS || res->certificate.kind == LCP_CERT_RAY) {
    whole_vector(s, n, worst, &res->certificate);
  } else if (res->certificate.kind == LCP_CERT_BASIS) {
    whole_basis(s, &res->certificate);
  }
}

/* Wall time from `cut` to `done`, shared out as the instances' own times are. */
static void tell_times(lcp_islands *s, double begun, double cut, double done) {
  lcp_times sum = {0};
  for (int k = 0; k < s->cut.count; k++) {
    const lcp_times own = lcp_instance_times(s->of[k].instance);
    sum.setup += own.setup;
    sum.factor += own.factor;
    sum.solve += own.solve;
  }
  const double all = sum.setup + sum.factor + sum.solve;
  const double unit = (all > 0) ? (done - cut) / all : 0;
  s->times = (lcp_times){.setup = (cut - begun) + unit * sum.setup,
                         .factor = unit * sum.factor,
                         .solve = unit * sum.solve};
}

base_status lcp_islands_cut_out_of(lcp_islands *s, const lcp_problem *p, double *z,
                                   base_error *err) {
  return lcp_islands_cut_problem(&s->cut, p, s->solver->by_factors, z, err);
}

base_status lcp_islands_solve(lcp_islands *s, const lcp_problem *p, double *z, lcp_result *res,
                              base_error *err) {
  const double begun = base_seconds();
  s->times = (lcp_times){0};
  BASE_TRY(lcp_solver_admits(s->solver, p, err));
  BASE_TRY(lcp_islands_cut_out_of(s, p, z, err));
  BASE_TRY(grow(s, p->M.n, err));
  const double cut = base_seconds();
  base_share(s->cut.count, solve_island, s);
  for (int k = 0; k < s->cut.count; k++) {
    if (s->of[k].status != BASE_OK) {
      *err = s->of[k].err;
      return s->of[k].status;
    }
  }
  if (s->cut.count == 1) { /* of the whole already */
    *res = s->of[0].res;
  } else {
    merge(s, p->M.n, z, res);
  }
  tell_times(s, begun, cut, base_seconds());
  return BASE_OK;
}

lcp_islands_view lcp_islands_at(const lcp_islands *s, int k) {
  const int number = s->cut.by_size[k];
  const islands_part *part = &s->cut.island[number];
  return (lcp_islands_view){.number = number, .p = &part->p, .row = part->row};
}

int lcp_islands_count(const lcp_islands *s) {
  return s->cut.count;
}

int lcp_islands_largest(const lcp_islands *s) {
  int most = 0;
  for (int k = 0; k < s->cut.count; k++) {
    most = (s->cut.island[k].p.M.n > most) ? s->cut.island[k].p.M.n : most;
  }
  return most;
}

lcp_times lcp_islands_times(const lcp_islands *s) {
  return s->times;
}

size_t lcp_islands_bytes(const lcp_islands *s) {
  size_t sum = 0;
  for (int k = 0; k < s->cap_of; k++) {
    sum += (s->of[k].instance != NULL) ? lcp_instance_bytes(s->of[k].instance) : 0;
  }
  return sum;
}
