/* solve.c - solving and judging, and the list of solvers. */
#include "harness/choice/plugin_solver.h"
#include "harness/choice/solver_choice.h"
#include "harness/measure/verdict.h"
#include "lcp/lcp_instance.h"
#include "library/library.h"

#include <stdlib.h>
#include <string.h>

struct lcp_workspace {
  solver_choice choice;
  lcp_instance *instance; /* NULL before the first solve */
};

static lcp_report blank(const char *solver) {
  return (lcp_report){.solver = solver,
                      .status = run_status_name(RUN_ERROR),
                      .claim = "",
                      .rho = HUGE_VAL,
                      .natural = HUGE_VAL,
                      .natural_relative = HUGE_VAL,
                      .min_map = HUGE_VAL,
                      .infeasible_z = HUGE_VAL,
                      .infeasible_w = HUGE_VAL,
                      .complementarity = HUGE_VAL};
}

static void take_verdict(lcp_report *r, const lcp_verdict *v) {
  r->rho = v->rho;
  r->natural = v->natural;
  r->natural_relative = v->natural_rel;
  r->min_map = v->min_map;
  r->infeasible_z = v->infeasible_z;
  r->infeasible_w = v->infeasible_w;
  r->complementarity = v->comp;
}

static void take_claim(lcp_report *r, const lcp_result *claim, lcp_times t) {
  r->claim = lcp_outcome_name(claim->outcome);
  r->iterations = claim->work.iterations;
  r->matvecs = claim->work.matvecs;
  r->factorizations = claim->work.factorizations;
  r->setup_seconds = t.setup + t.factor;
  r->solve_seconds = t.solve;
}

lcp_workspace *lcp_workspace_new(const char *solver) {
  base_error err = {0};
  lcp_workspace *work = calloc(1, sizeof *work);
  base_status done = BASE_OK;
  if (work == NULL) {
    done = BASE_FAIL(&err, BASE_ENOMEM, "no memory for a workspace");
  } else if (solver == NULL) {
    done = BASE_FAIL(&err, BASE_EINVAL, "solver: missing");
  } else {
    done = solver_choose(solver, &work->choice, &err);
  }
  if (done != BASE_OK) {
    (void)library_failed(&err);
    free(work);
    return NULL;
  }
  return work;
}

void lcp_workspace_free(lcp_workspace *work) {
  if (work != NULL) {
    lcp_instance_close(work->instance);
    solver_choice_free(&work->choice);
    free(work);
  }
}

static base_status open_and_prepare(lcp_workspace *work, const lcp_problem *p, base_error *err) {
  const lcp_solver *s = work->choice.solver;
  BASE_TRY(lcp_solver_admits(s, p, err));
  if (work->instance == NULL) {
    const lcp_capacity cap = lcp_problem_capacity(p);
    BASE_TRY(lcp_instance_open(&work->instance, s, &cap, work->choice.opt, err));
  }
  return lcp_instance_prepare(work->instance, p, err);
}

static base_status solve_and_judge(lcp_workspace *work, const lcp_problem *p, double *z,
                                   lcp_report *r, base_error *err) {
  const base_status ready = open_and_prepare(work, p, err);
  if (ready != BASE_OK) {
    r->status = run_status_name(ready == BASE_EUNSUPPORTED ? RUN_UNSUPPORTED : RUN_ERROR);
    return ready;
  }
  lcp_result claim;
  lcp_verdict v;
  bool verified;
  BASE_TRY(lcp_instance_solve(work->instance, NULL, z, &claim, err));
  take_claim(r, &claim, lcp_instance_times(work->instance));
  BASE_TRY(lcp_judge(p, z, &v, err));
  take_verdict(r, &v);
  r->status =
      run_status_name(verdict_of(work->choice.solver, work->choice.opt, p, &claim, &v, &verified));
  r->verified = verified;
  return BASE_OK;
}

int lcp_workspace_solve(lcp_workspace *work, const lcp_problem *p, double *z, lcp_report *report) {
  base_error err = {0};
  lcp_report r = blank(work->choice.solver->name);
  r.tolerance = verdict_tolerance(work->choice.solver);
  const base_status done = solve_and_judge(work, p, z, &r, &err);
  if (report != NULL) {
    *report = r;
  }
  if (done != BASE_OK) {
    return library_failed(&err);
  }
  if (strcmp(r.status, run_status_name(RUN_OK)) != 0) {
    return library_unsolved("%s: %s, rho %.3g", r.solver, r.status, r.rho);
  }
  return LCP_OK;
}

const char *lcp_default_solver(const lcp_problem *p) {
  static const char *const order[] = {"lemke", "cone_newton", "pgs"};
  for (int i = 0; i < BASE_COUNT(order); i++) {
    if (lcp_solver_admits(lcp_solver_find(order[i]), p, NULL) == BASE_OK) {
      return order[i];
    }
  }
  return NULL;
}

int lcp_solve(const lcp_problem *p, const char *solver, double *z, lcp_report *report) {
  if (report != NULL) {
    *report = blank("");
  }
  const char *chosen = (solver != NULL) ? solver : lcp_default_solver(p);
  if (chosen == NULL) {
    base_error err;
    (void)BASE_FAIL(&err, BASE_EUNSUPPORTED, "no solver takes this problem");
    return library_failed(&err);
  }
  lcp_workspace *work = lcp_workspace_new(chosen);
  if (work == NULL) {
    return LCP_INVALID;
  }
  const int code = lcp_workspace_solve(work, p, z, report);
  if (report != NULL) {
    report->solver = work->choice.solver->name;
  }
  lcp_workspace_free(work);
  return code;
}

int lcp_verify(const lcp_problem *p, const double *z, double tolerance, lcp_report *report) {
  base_error err = {0};
  lcp_report r = blank("");
  lcp_verdict v;
  base_status done = BASE_OK;
  r.tolerance = tolerance;
  if (!(tolerance > 0.0)) {
    done = BASE_FAIL(&err, BASE_EINVAL, "tolerance %g: need > 0", tolerance);
  } else {
    done = lcp_judge(p, z, &v, &err);
  }
  if (done == BASE_OK) {
    take_verdict(&r, &v);
    r.verified = v.finite && v.rho <= tolerance && lcp_judged_small(&v, tolerance);
    r.status = run_status_name(r.verified ? RUN_OK : RUN_UNVERIFIED);
  }
  if (report != NULL) {
    *report = r;
  }
  if (done != BASE_OK) {
    return library_failed(&err);
  }
  if (!r.verified && v.finite && v.rho <= tolerance) {
    return library_unsolved("z is so large that rho means nothing: M z + q is not small against q");
  }
  return r.verified ? LCP_OK : library_unsolved("rho is %.3g: need %g", v.rho, tolerance);
}

int lcp_plugin_load(const char *file) {
  base_error err = {0};
  const lcp_solver *s;
  base_status done = BASE_OK;
  if (file == NULL) {
    done = BASE_FAIL(&err, BASE_EINVAL, "file: missing");
  } else {
    done = plugin_load(file, &s, &err);
  }
  return (done == BASE_OK) ? LCP_OK : library_failed(&err);
}

/* ---- lists -------------------------------------------------------------------------------- */

int lcp_solver_count(void) {
  int n = 0;
  while (registry_solver(n) != NULL) {
    n++;
  }
  return n;
}

static const lcp_solver *solver_at(int i) {
  const lcp_solver *s = (i >= 0) ? registry_solver(i) : NULL;
  if (s == NULL) {
    base_error err;
    (void)BASE_FAIL(&err, BASE_EINVAL, "solver %d: need 0 to %d", i, lcp_solver_count() - 1);
    (void)library_failed(&err);
  }
  return s;
}

int lcp_solver_describe(int i, lcp_solver_info *info) {
  const lcp_solver *s = solver_at(i);
  if (s == NULL) {
    return LCP_INVALID;
  }
  *info = (lcp_solver_info){.name = s->name,
                            .title = s->title,
                            .words = s->words,
                            .when = s->when,
                            .bounds = (s->sets >> LCP_BOX) & 1u,
                            .free_rows = (s->sets >> LCP_FREE) & 1u,
                            .cones = (s->sets >> LCP_CONE) & 1u,
                            .exact = s->exact,
                            .warm = s->warm,
                            .n_option = s->n_fields};
  return LCP_OK;
}

int lcp_option_describe(int i, int k, lcp_option_info *info) {
  static const char *const kinds[] = {
      [BASE_INT] = "int", [BASE_REAL] = "real", [BASE_CHOICE] = "choice"};
  const lcp_solver *s = solver_at(i);
  if (s == NULL) {
    return LCP_INVALID;
  }
  if (k < 0 || k >= s->n_fields) {
    base_error err;
    (void)BASE_FAIL(&err, BASE_EINVAL, "%s has no option %d: need 0 to %d", s->name, k,
                    s->n_fields - 1);
    return library_failed(&err);
  }
  const base_field *f = &s->fields[k];
  *info = (lcp_option_info){.name = f->name,
                            .unit = f->unit,
                            .kind = kinds[f->kind],
                            .standard = f->dflt,
                            .least = f->min,
                            .most = f->max,
                            .words = (f->words != NULL) ? f->words : "",
                            .help = f->help};
  return LCP_OK;
}

int lcp_options(const char *solver, char *text, size_t capacity) {
  base_error err = {0};
  solver_choice c;
  if (solver_choose(solver, &c, &err) != BASE_OK) {
    return library_failed(&err);
  }
  const size_t need =
      base_fields_print(c.solver->fields, c.solver->n_fields, c.opt, text, capacity) + 1;
  int code = LCP_OK;
  if (need > capacity) {
    (void)BASE_FAIL(&err, BASE_EINVAL, "options of %s: need %zu bytes, not %zu", c.solver->name,
                    need, capacity);
    code = library_failed(&err);
  }
  solver_choice_free(&c);
  return code;
}
