#include "harness/case_lcp.h"

#include <stdlib.h>
#include <string.h>

#define NAME_(id, text) text,
static const char *const words[] = {CASE_WORD_LIST(NAME_)};

const char *case_word_name(case_word w) {
  return words[w];
}

/* A JSON number, or one of the strings that stand for what JSON cannot hold. */
static bool number(const json_t *j, double *x) {
  if (json_is_number(j)) {
    *x = json_number_value(j);
    return true;
  }
  const char *text = json_string_value(j);
  if (text == NULL) {
    return false;
  }
  if (strcmp(text, "NaN") == 0) {
    *x = (double)NAN;
  } else if (strcmp(text, "Infinity") == 0 || strcmp(text, "-Infinity") == 0) {
    *x = (text[0] == '-') ? -HUGE_VAL : HUGE_VAL;
  } else {
    return false;
  }
  return true;
}

static base_status invalid(case_lcp *c, const char *rule) {
  c->valid = false;
  (void)BASE_FAIL(&c->why, BASE_EINVAL, "case %s: %s", c->id, rule);
  return BASE_OK;
}

static base_status no_memory(const case_lcp *c, base_error *err) {
  return BASE_FAIL(err, BASE_ENOMEM, "case %s: no memory", c->id);
}

/* M and q as rows of numbers. A wrong shape is a finding (invalid), not an error. */
static base_status read_dense(case_lcp *c, const json_t *rows, const json_t *q, base_error *err) {
  const size_t n = json_array_size(q);
  c->m = calloc(n * n + 1, sizeof *c->m);
  c->q = calloc(n + 1, sizeof *c->q);
  if (c->m == NULL || c->q == NULL) {
    return no_memory(c, err);
  }
  if (json_array_size(rows) != n) {
    return invalid(c, "M and q differ in their number of rows");
  }
  for (size_t i = 0; i < n; i++) {
    const json_t *row = json_array_get(rows, i);
    if (json_array_size(row) != n) {
      return invalid(c, "M is not square");
    }
    for (size_t j = 0; j < n; j++) {
      if (!number(json_array_get(row, j), &c->m[j * n + i])) {
        return invalid(c, "M has an entry that is no number");
      }
    }
    if (!number(json_array_get(q, i), &c->q[i])) {
      return invalid(c, "q has an entry that is no number");
    }
  }
  c->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = (int)n, .val = c->m}, .q = c->q};
  return BASE_OK;
}

/* Tridiagonal CSC with constant off-diagonal, diagonal d[n]. */
static base_status make_tridiagonal(case_lcp *c, int n, double diagonal, double off,
                                    base_error *err) {
  c->m = calloc(3 * (size_t)n, sizeof *c->m);
  c->q = calloc((size_t)n, sizeof *c->q);
  c->colptr = calloc((size_t)n + 1, sizeof *c->colptr);
  c->rowind = calloc(3 * (size_t)n, sizeof *c->rowind);
  if (c->m == NULL || c->q == NULL || c->colptr == NULL || c->rowind == NULL) {
    return no_memory(c, err);
  }
  int k = 0;
  for (int j = 0; j < n; j++) {
    for (int i = (j > 0 ? j - 1 : 0); i <= j + 1 && i < n; i++) {
      c->rowind[k] = i;
      c->m[k++] = (i == j) ? diagonal : off;
    }
    c->colptr[j + 1] = k;
  }
  c->p = (lcp_problem){.M = {.storage = LCP_CSC, .n = n}, .q = c->q};
  c->p.M.csc = (lcp_csc){n, n, c->colptr, c->rowind, c->m};
  return BASE_OK;
}

static double member(const json_t *o, const char *key) {
  return json_number_value(json_object_get(o, key));
}

/* z_i = 1 + (i mod 5) unless period divides i, w_i = 1 + (i mod 4) there; q = w - M z. */
static base_status make_manufactured(case_lcp *c, const json_t *gen, int n, base_error *err) {
  const double diagonal = member(gen, "diag");
  const double off = member(gen, "off");
  const int period = (int)member(gen, "period");
  BASE_TRY(make_tridiagonal(c, n, diagonal, off, err));
  double before = 0.0;
  for (int i = 1; i <= n; i++) { /* 1-based as in the case's formula */
    const double z = (i % period != 0) ? 1.0 + i % 5 : 0.0;
    const double next = (i < n && (i + 1) % period != 0) ? 1.0 + (i + 1) % 5 : 0.0;
    const double w = (z == 0.0) ? 1.0 + i % 4 : 0.0;
    c->q[i - 1] = w - diagonal * z - off * (before + next);
    before = z;
  }
  return BASE_OK;
}

/* Column of n unit masses: M = tridiag(-1, 2, -1) with M_11 = 1, q = (-g h, 0, ...). */
static base_status make_stack(case_lcp *c, const json_t *gen, int n, base_error *err) {
  const json_t *gh = json_object_get(gen, "gh");
  if (!json_is_string(json_object_get(gen, "masses"))) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "case %s: stack generator without unit masses", c->id);
  }
  BASE_TRY(make_tridiagonal(c, n, 2.0, -1.0, err));
  c->m[0] = 1.0;
  c->q[0] = -json_number_value(json_array_get(gh, 0)) / json_number_value(json_array_get(gh, 1));
  return BASE_OK;
}

static base_status generate(case_lcp *c, const json_t *gen, base_error *err) {
  const char *name = json_string_value(json_object_get(gen, "name"));
  const int n = (int)member(gen, "n");
  if (name != NULL && n > 0 && strcmp(name, "tridiag_manufactured") == 0) {
    return make_manufactured(c, gen, n, err);
  }
  if (name != NULL && n > 0 && strcmp(name, "stack") == 0) {
    return make_stack(c, gen, n, err);
  }
  return BASE_FAIL(err, BASE_EUNSUPPORTED, "case %s: unknown generator '%s'", c->id,
                   name != NULL ? name : "");
}

base_status case_lcp_read(const json_t *json, case_lcp *out, base_error *err) {
  *out = (case_lcp){.json = json, .valid = true};
  out->id = json_string_value(json_object_get(json, "id"));
  if (out->id == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "an LCP case has no id");
  }
  const json_t *m = json_object_get(json, "M");
  const json_t *q = json_object_get(json, "q");
  const base_status done = (m != NULL && q != NULL)
                               ? read_dense(out, m, q, err)
                               : generate(out, json_object_get(json, "gen"), err);
  if (done != BASE_OK) {
    case_lcp_free(out);
    return done;
  }
  if (out->valid && lcp_problem_check(&out->p, &out->why) != BASE_OK) {
    out->valid = false;
  }
  return BASE_OK;
}

void case_lcp_free(case_lcp *c) {
  free(c->m);
  free(c->q);
  free(c->colptr);
  free(c->rowind);
  c->m = c->q = NULL;
  c->colptr = c->rowind = NULL;
}

/* ---- judging --------------------------------------------------------------------------------- */

case_word case_lcp_word(const case_lcp *c, const solve_record *r) {
  if (!c->valid) {
    return CASE_INVALID;
  }
  if (r->status == RUN_UNSUPPORTED || !r->has_claim) {
    return CASE_NOT_APPLICABLE;
  }
  switch (r->claim.outcome) {
  case LCP_SOLVED:
    return CASE_SOLVED;
  case LCP_INFEASIBLE:
    return CASE_INFEASIBLE;
  case LCP_RAY:
    return CASE_RAY;
  case LCP_MAX_ITER:
  case LCP_TIME_LIMIT:
  case LCP_STALLED:
    return CASE_NOT_CONVERGED;
  case LCP_NUMERICAL:
  case LCP_OUTCOME_COUNT:
    break;
  }
  return CASE_NUMERICAL;
}

bool case_lcp_lists(const case_lcp *c, const char *key, case_word w) {
  size_t i;
  const json_t *item;
  json_array_foreach(json_object_get(c->json, key), i, item) {
    const char *text = json_string_value(item);
    if (text != NULL && strcmp(text, words[w]) == 0) {
      return true;
    }
  }
  return false;
}

/* max |z - z*| / max |z*| */
static double distance(const json_t *z_star, const double *z, int n) {
  double error = 0.0;
  double size = 0.0;
  for (int i = 0; i < n; i++) {
    const double want = json_number_value(json_array_get(z_star, (size_t)i));
    error = fmax(error, fabs(z[i] - want));
    size = fmax(size, fabs(want));
  }
  return (size > 0.0) ? error / size : error;
}

/* max over rows of |C z - c| / (|c| + sum |C||z|) */
static double invariant_error(const json_t *set, const double *z, int n) {
  double worst = 0.0;
  size_t r;
  const json_t *row;
  json_array_foreach(json_object_get(set, "C"), r, row) {
    const double c = json_number_value(json_array_get(json_object_get(set, "c"), r));
    double sum = -c;
    double scale = fabs(c);
    for (int i = 0; i < n; i++) {
      const double term = json_number_value(json_array_get(row, (size_t)i)) * z[i];
      sum += term;
      scale += fabs(term);
    }
    worst = fmax(worst, scale > 0.0 ? fabs(sum) / scale : 0.0);
  }
  return worst;
}

static double nearest_solution(const json_t *solutions, const double *z, int n) {
  double best = HUGE_VAL;
  size_t i;
  const json_t *one;
  json_array_foreach(solutions, i, one) {
    best = fmin(best, distance(json_object_get(one, "z"), z, n));
  }
  return best;
}

bool case_lcp_forward(const case_lcp *c, const lcp_solver *s, const double *z, double *error,
                      double *tolerance, const char **rule) {
  const int n = c->p.M.n;
  const json_t *forward = json_object_get(c->json, "forward_tol");
  const json_t *invariants = json_object_get(c->json, "invariants");
  const json_t *sets = json_object_get(c->json, "solution_sets");
  /* The residual holds to verdict_tolerance; what it implies for sums may be larger by the
   * condition of the case, at most 1e3 in this group. */
  *tolerance = 1e3 * verdict_tolerance(s);
  if (json_is_number(forward)) {
    *rule = "forward_tol";
    *tolerance = json_number_value(forward);
    *error = nearest_solution(json_object_get(c->json, "solutions"), z, n);
    return true;
  }
  if (invariants != NULL) {
    *rule = "invariants";
    *error = invariant_error(invariants, z, n);
    return true;
  }
  if (sets == NULL) {
    return false;
  }
  *rule = "solution_sets";
  *error = HUGE_VAL;
  size_t i;
  const json_t *one;
  json_array_foreach(sets, i, one) {
    *error = fmin(*error, invariant_error(one, z, n));
  }
  return true;
}
