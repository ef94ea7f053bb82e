/* M and q of a complementarity problem: lists of numbers, or a generator. */
#include "problems/families/generate.h"
#include "problems/read/read_lcp_part.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A number, or one of the texts NaN, Infinity, -Infinity (an invalid problem says so). */
static base_status any_number(const node *n, const json_t *v, const char *what, double *out) {
  if (!json_is_string(v)) {
    return node_number(n, v, what, out);
  }
  const char *text = json_string_value(v);
  if (strcmp(text, "NaN") == 0) {
    *out = (double)NAN;
  } else if (strcmp(text, "Infinity") == 0 || strcmp(text, "-Infinity") == 0) {
    *out = (text[0] == '-') ? -HUGE_VAL : HUGE_VAL;
  } else {
    return READ_BAD(n, "%s: %s: '%.20s' is no number", n->where, what, text);
  }
  return BASE_OK;
}

base_status read_no_memory(const node *n) {
  return BASE_FAIL(n->err, BASE_ENOMEM, "%s: no memory", n->where);
}

base_status read_numbers(const node *n, const json_t *v, const char *what, int count,
                         double **out) {
  if (!json_is_array(v) || json_array_size(v) != (size_t)count) {
    return READ_BAD(n, "%s: %s: need %d numbers", n->where, what, count);
  }
  *out = calloc((size_t)count + 1, sizeof **out);
  if (*out == NULL) {
    return read_no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    BASE_TRY(any_number(n, json_array_get(v, (size_t)i), what, &(*out)[i]));
  }
  return BASE_OK;
}

/* Why M and q do not make a problem of n unknowns; empty if they do. */
static void find_shape_error(const lcp_case *c, const json_t *M, const json_t *q, char *text,
                             size_t cap) {
  if (json_array_size(M) != (size_t)c->n) {
    (void)snprintf(text, cap, "M has %zu rows, need n = %d", json_array_size(M), c->n);
    return;
  }
  for (size_t i = 0; i < json_array_size(M); i++) {
    const json_t *row = json_array_get(M, i);
    if (!json_is_array(row) || json_array_size(row) != json_array_size(M)) {
      (void)snprintf(text, cap, "M: row %zu has %zu entries, need %zu", i + 1, json_array_size(row),
                     json_array_size(M));
      return;
    }
  }
  if (json_array_size(q) != (size_t)c->n) {
    (void)snprintf(text, cap, "q has %zu entries, need n = %d", json_array_size(q), c->n);
  }
}

/* NaN is equal to nothing, so a matrix with one is not symmetric. */
static bool is_symmetric(int n, const double *M) {
  for (size_t j = 0; j < (size_t)n; j++) {
    for (size_t i = 0; i <= j; i++) {
      if (!(M[j * (size_t)n + i] == M[i * (size_t)n + j])) {
        return false;
      }
    }
  }
  return true;
}

static base_status read_dense(const node *n, lcp_case *c) {
  const json_t *rows = json_object_get(n->v, "M"), *q_list = json_object_get(n->v, "q");
  if (!json_is_array(rows) || !json_is_array(q_list)) {
    return READ_BAD(n, "%s: needs lists M and q, or a generator", n->where);
  }
  find_shape_error(c, rows, q_list, c->shape_error, sizeof c->shape_error);
  if (c->shape_error[0] != '\0') {
    return BASE_OK;
  }
  double *M, *q;
  BASE_TRY(known_dense(&c->k, c->n, &M, &q, n->err));
  for (int i = 0; i < c->n; i++) {
    const json_t *row = json_array_get(rows, (size_t)i);
    for (int j = 0; j < c->n; j++) {
      BASE_TRY(any_number(n, json_array_get(row, (size_t)j), "M",
                          &M[(size_t)j * (size_t)c->n + (size_t)i]));
    }
    BASE_TRY(any_number(n, json_array_get(q_list, (size_t)i), "q", &q[i]));
  }
  c->k.p.traits = is_symmetric(c->n, M) ? LCP_SYMMETRIC : 0u;
  return BASE_OK;
}

static base_status run_stack(const node *g, int n, known_lcp *k) {
  double gh[2] = {0.0, 1.0}, *mass = NULL;
  json_t *v = json_object_get(g->v, "masses");
  BASE_TRY(node_need(g, "gh"));
  BASE_TRY(node_vector(g, "gh", 2, gh));
  if (json_is_string(v) && strcmp(json_string_value(v), "ones") == 0) {
    mass = calloc((size_t)n + 1, sizeof *mass);
    if (mass == NULL) {
      return read_no_memory(g);
    }
    for (int i = 0; i < n; i++) {
      mass[i] = 1.0;
    }
  } else {
    const base_status status = read_numbers(g, v, "masses", n, &mass);
    if (status != BASE_OK) {
      free(mass);
      return status;
    }
  }
  const base_status status = generate_stack(k, n, mass, gh[0] / gh[1], g->err);
  free(mass);
  return status;
}

static base_status run_subset_sum(const node *g, int n, known_lcp *k) {
  int a[64], b = 0, count;
  json_t *list;
  BASE_TRY(node_list(g, "a", BASE_COUNT(a), &list, &count));
  BASE_TRY(node_int(g, "b", &b));
  if (count + 2 != n) {
    return READ_BAD(g, "%s: a has %d items, need n - 2 = %d", g->where, count, n - 2);
  }
  for (int i = 0; i < count; i++) {
    double x = 0.0;
    BASE_TRY(node_number(g, json_array_get(list, (size_t)i), "a", &x));
    if (x != floor(x) || !(x >= 1.0) || x > INT_MAX) {
      return READ_BAD(g, "%s: a: need integers >= 1", g->where);
    }
    a[i] = (int)x;
  }
  return generate_subset_sum(k, count, a, b, g->err);
}

enum { G_MURTY, G_FATHI, G_CSIZMADIA, G_CIRCULANT, G_TRIDIAGONAL, G_STACK, G_SPD, G_P, G_SUBSET };
static const char generators[] = "murty|fathi|csizmadia|circulant|tridiag_manufactured|stack|"
                                 "lcg_spd|lcg_p_nonsym|subset_sum";
static const char *const generator_keys[] = {
    "name|n|upper|q",   "name|n",      "name|n",      "name|n|a|b", "name|n|diag|off|period",
    "name|n|masses|gh", "name|n|seed", "name|n|seed", "name|a|b"};

static base_status run_generator(const node *g, int type, int n, known_lcp *k) {
  bool upper = false;
  int hat = 0, seed = 0, period = 0;
  double a = 0.0, b = 0.0, diag = 0.0, off = 0.0;
  switch (type) {
  case G_MURTY:
    BASE_TRY(node_bool(g, "upper", &upper));
    BASE_TRY(node_choice(g, "q", "ones|hat", &hat));
    return generate_murty(k, n, upper, hat == 1, g->err);
  case G_FATHI:
    return generate_fathi(k, n, g->err);
  case G_CSIZMADIA:
    return generate_csizmadia(k, n, g->err);
  case G_CIRCULANT:
    BASE_TRY(node_real(g, "a", &a));
    BASE_TRY(node_real(g, "b", &b));
    return generate_circulant(k, n, a, b, g->err);
  case G_TRIDIAGONAL:
    BASE_TRY(node_real(g, "diag", &diag));
    BASE_TRY(node_real(g, "off", &off));
    BASE_TRY(node_int(g, "period", &period));
    return generate_tridiagonal(k, n, diag, off, period, g->err);
  case G_STACK:
    return run_stack(g, n, k);
  case G_SUBSET:
    return run_subset_sum(g, n, k);
  default:
    BASE_TRY(node_int(g, "seed", &seed));
    return (type == G_SPD) ? generate_lcg_spd(k, n, (uint32_t)seed, g->err)
                           : generate_lcg_p(k, n, (uint32_t)seed, g->err);
  }
}

static base_status read_generated(const node *n, lcp_case *c) {
  node g;
  int type = 0, size = c->n;
  BASE_TRY(node_open(&g, json_object_get(n->v, "gen"), n->err, "%s: gen", n->where));
  BASE_TRY(node_need(&g, "name"));
  BASE_TRY(node_choice(&g, "name", generators, &type));
  BASE_TRY(node_keys(&g, generator_keys[type]));
  BASE_TRY(node_int(&g, "n", &size));
  if (size != c->n) {
    return READ_BAD(&g, "%s: n = %d, the case has %d", g.where, size, c->n);
  }
  return run_generator(&g, type, size, &c->k);
}

static bool is_number(const json_t *v, double x) {
  return json_is_number(v) &&
         fabs(json_number_value(v) - x) <= 1e-12 * fmax(fabs(json_number_value(v)), fabs(x));
}

static bool are_numbers(const json_t *list, int n, const double *x, int stride) {
  bool same = json_is_array(list) && json_array_size(list) == (size_t)n;
  for (int i = 0; same && i < n; i++) {
    same = is_number(json_array_get(list, (size_t)i), x[(size_t)i * (size_t)stride]);
  }
  return same;
}

/* M or q beside a generator say what it gives, up to rounding. */
static base_status check_listed(const node *n, const lcp_case *c) {
  const size_t size = (size_t)c->n;
  const json_t *rows = json_object_get(n->v, "M"), *q = json_object_get(n->v, "q");
  if (q != NULL && !are_numbers(q, c->n, c->k.p.q, 1)) {
    return READ_BAD(n, "%s: q is not that of gen", n->where);
  }
  if (rows == NULL) {
    return BASE_OK;
  }
  bool same = json_array_size(rows) == size;
  double *M = same ? malloc((size * size + 1) * sizeof *M) : NULL;
  if (same && M == NULL) {
    return read_no_memory(n);
  }
  if (same) {
    lcp_matrix_to_dense(&c->k.p.M, M);
  }
  for (size_t i = 0; same && i < size; i++) {
    same = are_numbers(json_array_get(rows, i), c->n, M + i, c->n);
  }
  free(M);
  return same ? BASE_OK : READ_BAD(n, "%s: M is not that of gen", n->where);
}

base_status read_lcp_problem(const node *n, lcp_case *c) {
  if (!node_has(n, "gen")) {
    return read_dense(n, c);
  }
  BASE_TRY(read_generated(n, c));
  return (node_has(n, "M") || node_has(n, "q")) ? check_listed(n, c) : BASE_OK;
}
