#include "harness/cli/solve_all.h"

#include "harness/cell/death.h"
#include "harness/util/json_out.h"
#include "harness/util/stop.h"
#include "harness/util/table.h"

#include <stdlib.h>
#include <string.h>

/* ---- one solver ------------------------------------------------------------------------------ */

static void put_verdict(json_t *o, const solve_record *r) {
  const lcp_verdict *v = &r->verdict;
  const bool judged = r->has_claim;
  json_out_text(o, "status", run_status_name(r->status));
  json_out_text(o, "claimed", judged ? lcp_outcome_name(r->claim.outcome) : NULL);
  json_out_bool(o, "verified", r->verified);
  json_out_real(o, "rho", judged ? v->rho : HUGE_VAL);
  json_out_real(o, "res_natural", judged ? v->natural : HUGE_VAL);
  json_out_real(o, "res_natural_rel", judged ? v->natural_rel : HUGE_VAL);
  json_out_real(o, "res_comp", judged ? v->comp : HUGE_VAL);
}

/* null: the solver handed over none, or it is of a problem whose certificates are not checked. */
static void put_certificate(json_t *o, const solve_record *r) {
  const lcp_certificate_verdict *v = &r->certificate;
  json_out_text(o, "certificate", certificate_name(r->claim.certificate.kind));
  if (r->certificate_checked) {
    json_out_bool(o, "certificate_holds", v->holds);
    json_out_bool(o, "certificate_exact", v->exact);
  } else {
    json_out_text(o, "certificate_holds", NULL);
    json_out_text(o, "certificate_exact", NULL);
  }
  json_out_text(o, "certificate_why", r->certificate_checked ? v->why : NULL);
}

base_status solve_cone(const problem_source *src, const solve_record *r, const double *z,
                       lcp_verdict *room, const lcp_verdict **cone, base_error *err) {
  *room = (lcp_verdict){.natural = HUGE_VAL, .natural_rel = HUGE_VAL, .infeasible_z = HUGE_VAL};
  *cone = problem_source_has_cone(src) ? room : NULL;
  return (*cone != NULL && r->has_claim) ? problem_source_judge_cone(src, z, room, err) : BASE_OK;
}

json_t *solve_report(const problem_source *src, const solver_choice *s, const solve_record *r,
                     const lcp_verdict *cone) {
  json_t *o = json_object();
  const lcp_work *w = &r->claim.work;
  json_out_text(o, "problem", src->name);
  json_out_int(o, "n", src->p->M.n);
  json_out_int(o, "nnz", lcp_matrix_entries(&src->p->M));
  json_out_text(o, "storage", storage_name(src->p->M.storage));
  json_out_text(o, "solver", s->solver->name);
  json_out_text(o, "options", s->config);
  json_out_text(o, "variant", r->claim.variant);
  put_verdict(o, r);
  json_out_int(o, "n_iter", w->iterations);
  json_out_int(o, "n_pivot", w->pivots);
  json_out_int(o, "n_factor", w->factorizations);
  json_out_int(o, "n_matvec", w->matvecs);
  json_out_int(o, "n_fallback", w->fallbacks);
  json_out_real(o, "t_setup_s", r->time.setup);
  json_out_real(o, "t_factor_s", r->time.factor);
  json_out_real(o, "t_solve_s", r->time.solve);
  put_certificate(o, r);
  char hash[24];
  (void)snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->hash);
  json_out_text(o, "solution_hash", r->has_claim ? hash : NULL);
  json_out_text(o, "note", r->note);
  if (cone != NULL) { /* how far the answer is from the true cone, whatever it was posed on */
    json_out_real(o, "res_ncp", cone->natural);
    json_out_real(o, "res_ncp_rel", cone->natural_rel);
    json_out_real(o, "cone_violation_Ns", cone->infeasible_z);
  }
  return o;
}

/* ---- several --------------------------------------------------------------------------------- */

/* What a child hands back; its texts are static, and stand at the same place in the parent. */
typedef struct attempt {
  const problem_source *src;
  const solver_choice *s;
  bool done, cone;
  solve_record r;
  lcp_verdict on_cone;
} attempt;

static void attempt_body(void *ctx, isolate_channel *out) {
  attempt a = *(const attempt *)ctx;
  const lcp_verdict *cone;
  base_error err = {0};
  double *z = calloc((size_t)a.src->p->M.n + 1, sizeof *z);
  base_status done = (z != NULL) ? solve_once(a.src->p, a.s, z, &a.r, &err)
                                 : BASE_FAIL(&err, BASE_ENOMEM, "no memory for the answer");
  if (done == BASE_OK) {
    done = solve_cone(a.src, &a.r, z, &a.on_cone, &cone, &err);
    a.cone = cone != NULL;
  }
  if (done != BASE_OK) {
    a.r.status = (done == BASE_ENOMEM) ? RUN_OOM : RUN_ERROR;
    (void)snprintf(a.r.note, sizeof a.r.note, "%.230s", err.text);
  }
  a.done = true;
  (void)isolate_emit(out, &a);
  free(z);
}

static void attempt_item(void *ctx, const void *item) {
  memcpy(ctx, item, sizeof(attempt));
}

static double seconds(const attempt *a) {
  return a->r.time.setup + a->r.time.factor + a->r.time.solve;
}

/* Verified answers first, the fastest of them first; then by how bad the word is. */
static int by_worth(const void *x, const void *y) {
  const attempt *a = x;
  const attempt *b = y;
  if (a->r.verified != b->r.verified) {
    return a->r.verified ? -1 : 1;
  }
  if (a->r.status != b->r.status) {
    return (a->r.status > b->r.status) - (a->r.status < b->r.status);
  }
  return (seconds(a) > seconds(b)) - (seconds(a) < seconds(b));
}

static json_t *row_of(const attempt *a) {
  json_t *o = solve_report(a->src, a->s, &a->r, a->cone ? &a->on_cone : NULL);
  json_out_real(o, "time_s", a->r.has_claim ? seconds(a) : HUGE_VAL);
  if (!a->r.has_claim) { /* nothing was counted */
    json_out_text(o, "n_iter", NULL);
  }
  return o;
}

base_status solve_all(const problem_source *src, const solver_choice *s, int n, double wall,
                      const char *format, FILE *to, solve_all_end *end, base_error *err) {
  static const char *const column[] = {"solver", "status", "verified",    "rho",
                                       "time_s", "n_iter", "certificate", "certificate_holds",
                                       "note",   NULL};
  const isolate_limits limits = {.wall = wall, .grace = 1.0, .output = 1048576.0, .cpu = -1};
  attempt *all = calloc((size_t)n + 1, sizeof *all);
  base_status done = (all != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "no memory for a table");
  int ran = 0;
  stop_catch_signals();
  while (done == BASE_OK && ran < n && stop_requested() == 0) {
    attempt *a = &all[ran];
    isolate_end how;
    *a = (attempt){.src = src, .s = &s[ran], .r = {.status = RUN_NO_OUTPUT}};
    const isolate_work work = {sizeof *a, attempt_body, attempt_item, a};
    done = isolate_run(&work, &limits, &how, err);
    if (!a->done) {
      a->r.status = death_word(&how, wall, a->r.note, sizeof a->r.note);
    }
    ran += (how.how == ISOLATE_INTERRUPTED) ? 0 : 1;
  }
  *end = (solve_all_end){.stopped = stop_requested() != 0};
  if (done == BASE_OK) {
    qsort(all, (size_t)ran, sizeof *all, by_worth);
    json_t *rows = json_array();
    for (int i = 0; i < ran; i++) {
      end->verified = end->verified || (all[i].r.status == RUN_OK && all[i].r.verified);
      (void)json_array_append_new(rows, row_of(&all[i]));
    }
    if (!table_print(rows, column, format, to)) {
      done = BASE_FAIL(err, BASE_EEXTERNAL, "the table could not be written");
    }
  }
  free(all);
  return done;
}
