#include "problems/read/read_lcp.h"

#include "problems/families/generate.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

enum { CASE_N_MAX = 20000 };

void lcp_case_free(lcp_case *c) {
  known_lcp_free(&c->k);
  free(c->solution);
  free(c->example);
  free(c->w);
  free(c->invariants.C);
  free(c->invariants.c);
  for (int i = 0; i < c->n_set; i++) {
    free(c->set[i].C);
    free(c->set[i].c);
  }
  free(c->set);
  free(c->ray_d);
  memset(c, 0, sizeof *c);
}

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
    return BAD(n, "%s: %s: '%.20s' is no number", n->where, what, text);
  }
  return BASE_OK;
}

static base_status no_memory(const node *n) {
  return BASE_FAIL(n->err, BASE_ENOMEM, "%s: no memory", n->where);
}

/* `count` numbers of a list into a new array. */
static base_status take_numbers(const node *n, const json_t *v, const char *what, int count,
                                double **out) {
  if (!json_is_array(v) || json_array_size(v) != (size_t)count) {
    return BAD(n, "%s: %s: need %d numbers", n->where, what, count);
  }
  *out = calloc((size_t)count + 1, sizeof **out);
  if (*out == NULL) {
    return no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    BASE_TRY(any_number(n, json_array_get(v, (size_t)i), what, &(*out)[i]));
  }
  return BASE_OK;
}

static base_status optional_numbers(const node *n, const char *key, int count, double **out) {
  const json_t *v = json_object_get(n->v, key);
  return (v == NULL) ? BASE_OK : take_numbers(n, v, key, count, out);
}

/* ---- M and q -------------------------------------------------------------------------------- */

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
    return BAD(n, "%s: needs lists M and q, or a generator", n->where);
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
      return no_memory(g);
    }
    for (int i = 0; i < n; i++) {
      mass[i] = 1.0;
    }
  } else {
    const base_status status = take_numbers(g, v, "masses", n, &mass);
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
    return BAD(g, "%s: a has %d items, need n - 2 = %d", g->where, count, n - 2);
  }
  for (int i = 0; i < count; i++) {
    double x = 0.0;
    BASE_TRY(node_number(g, json_array_get(list, (size_t)i), "a", &x));
    if (x != floor(x) || !(x >= 1.0) || x > INT_MAX) {
      return BAD(g, "%s: a: need integers >= 1", g->where);
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
    return BAD(&g, "%s: n = %d, the case has %d", g.where, size, c->n);
  }
  return run_generator(&g, type, size, &c->k);
}

/* ---- answers -------------------------------------------------------------------------------- */

static base_status read_solutions(const node *n, lcp_case *c) {
  json_t *list;
  int count;
  BASE_TRY(node_bool(n, "solutions_complete", &c->solutions_complete));
  BASE_TRY(node_list(n, "solutions", 4096, &list, &count));
  if (count == 0) {
    return BASE_OK;
  }
  c->solution = calloc((size_t)count * (size_t)c->n + 1, sizeof *c->solution);
  if (c->solution == NULL) {
    return no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    node s;
    BASE_TRY(
        node_open(&s, json_array_get(list, (size_t)i), n->err, "%s: solution %d", n->where, i + 1));
    BASE_TRY(node_keys(&s, "z|z_exact|w"));
    BASE_TRY(node_need(&s, "z"));
    BASE_TRY(node_vector(&s, "z", c->n, c->solution + (size_t)i * (size_t)c->n));
  }
  c->n_solution = count;
  return BASE_OK;
}

static base_status read_example(const node *n, lcp_case *c) {
  json_t *v = json_object_get(n->v, "example_solution");
  node s;
  if (v == NULL) {
    return BASE_OK;
  }
  BASE_TRY(node_open(&s, v, n->err, "%s: example_solution", n->where));
  BASE_TRY(node_keys(&s, "z|z_exact"));
  return take_numbers(&s, json_object_get(v, "z"), "z", c->n, &c->example);
}

static base_status read_invariants(const node *n, json_t *v, int size, case_invariants *out) {
  node s;
  json_t *rows;
  int count;
  BASE_TRY(node_open(&s, v, n->err, "%s: invariants", n->where));
  BASE_TRY(node_keys(&s, "name|C|c|c_exact"));
  BASE_TRY(node_text(&s, "name", out->name, sizeof out->name));
  BASE_TRY(node_list(&s, "C", 4096, &rows, &count));
  BASE_TRY(take_numbers(&s, json_object_get(v, "c"), "c", count, &out->c));
  out->C = calloc((size_t)count * (size_t)size + 1, sizeof *out->C);
  if (out->C == NULL) {
    return no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    const json_t *row = json_array_get(rows, (size_t)i);
    if (!json_is_array(row) || json_array_size(row) != (size_t)size) {
      return BAD(n, "%s: C: row %d needs %d numbers", s.where, i + 1, size);
    }
    for (int j = 0; j < size; j++) {
      BASE_TRY(node_number(&s, json_array_get(row, (size_t)j), "C",
                           &out->C[(size_t)i * (size_t)size + (size_t)j]));
    }
  }
  out->n_row = count;
  return BASE_OK;
}

static base_status read_sets(const node *n, lcp_case *c) {
  json_t *v = json_object_get(n->v, "invariants"), *list;
  int count;
  if (v != NULL) {
    BASE_TRY(read_invariants(n, v, c->n, &c->invariants));
  }
  BASE_TRY(node_list(n, "solution_sets", 64, &list, &count));
  if (count == 0) {
    return BASE_OK;
  }
  c->set = calloc((size_t)count, sizeof *c->set);
  if (c->set == NULL) {
    return no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    c->n_set = i + 1;
    BASE_TRY(read_invariants(n, json_array_get(list, (size_t)i), c->n, &c->set[i]));
  }
  return BASE_OK;
}

/* Farkas vectors are exact rationals written as text "p/q". */
static base_status read_farkas(const node *n, lcp_case *c) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, "farkas_y", CASE_N_MAX, &list, &count));
  if (list == NULL) {
    return BASE_OK;
  }
  if (count != c->n) {
    return BAD(n, "%s: farkas_y: need %d entries, has %d", n->where, c->n, count);
  }
  c->k.farkas = KNOWN_ARRAY(&c->k, double, count);
  if (c->k.farkas == NULL) {
    return no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    char text[64], *end;
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), "farkas_y", text, sizeof text));
    double x = strtod(text, &end);
    if (end != text && *end == '/') {
      const char *below = end + 1;
      x /= strtod(below, &end);
      end = (end == below) ? text : end;
    }
    if (end == text || *end != '\0' || !isfinite(x)) {
      return BAD(n, "%s: farkas_y: '%s' is no fraction", n->where, text);
    }
    c->k.farkas[i] = x;
  }
  return BASE_OK;
}

#define NAME_(id, text) text,
static const char *const status_names[] = {CASE_STATUS_LIST(NAME_)};

const char *case_status_name(int bit) {
  return (bit >= 0 && bit < CASE_STATUS_COUNT) ? status_names[bit] : "unknown";
}

static base_status read_statuses(const node *n, const char *key, unsigned *mask) {
  json_t *list;
  int count;
  BASE_TRY(node_list(n, key, CASE_STATUS_COUNT, &list, &count));
  for (int i = 0; i < count; i++) {
    char word[32];
    unsigned bit = 0;
    BASE_TRY(node_string(n, json_array_get(list, (size_t)i), key, word, sizeof word));
    for (int k = 0; k < CASE_STATUS_COUNT; k++) {
      bit |= (strcmp(word, status_names[k]) == 0) ? 1u << k : 0u;
    }
    if (bit == 0) {
      return BAD(n, "%s: %s: unknown status '%s'", n->where, key, word);
    }
    *mask |= bit;
  }
  return BASE_OK;
}

/* ---- work ----------------------------------------------------------------------------------- */

static base_status read_work(const node *n, lcp_case *c) {
  int lemke = 0, least = 0, sweeps = -1;
  BASE_TRY(node_int(n, "lemke_pivots", &lemke));
  BASE_TRY(node_int(n, "least_index_pivots", &least));
  c->lemke_pivots = lemke;
  c->least_index_pivots = least;
  BASE_TRY(node_real(n, "forward_tol", &c->forward_tol));
  BASE_TRY(node_real(n, "residual_floor", &c->residual_floor));
  BASE_TRY(node_int(n, "binary_first", &c->binary_first));
  BASE_TRY(optional_numbers(n, "ray_d", c->n, &c->ray_d));
  BASE_TRY(node_choice(n, "pgs", "cycle|noconv|not_applicable", &sweeps));
  c->sweeps = (case_sweeps)(sweeps + 1);
  c->sweep_rate = node_has(n, "pgs_rho") ? c->k.sweep_rate : 0.0; /* formula of the generator */
  json_t *cycles = json_object_get(n->v, "cycles");
  const char *rule;
  json_t *period;
  json_object_foreach(cycles, rule, period) {
    const size_t used = strlen(c->cycles);
    (void)snprintf(c->cycles + used, sizeof c->cycles - used, "%s%s", used > 0 ? " " : "", rule);
  }
  return BASE_OK;
}

/* A closed form is the generator's; its text is kept to be shown. */
static base_status adopt_closed_form(const node *n, lcp_case *c) {
  if (strcmp(c->kind, "closed_form") != 0 || c->n_solution > 0) {
    return BASE_OK;
  }
  if (c->k.z == NULL) {
    return BAD(n, "%s: a closed form needs a generator that knows it", n->where);
  }
  c->solution = malloc((size_t)c->n * sizeof *c->solution);
  if (c->solution == NULL) {
    return no_memory(n);
  }
  memcpy(c->solution, c->k.z, (size_t)c->n * sizeof *c->solution);
  c->n_solution = 1;
  c->solutions_complete = c->k.answer == KNOWN_UNIQUE;
  return BASE_OK;
}

static const char case_keys[] =
    "id|group|title|kind|status_correct|status_honest_failure|status_false_claim|n|M|q|gen|"
    "solutions|solutions_complete|farkas_y|farkas_meaning|note|example_solution|invariants|w|"
    "source|residual_floor|cycles|pgs|lemke_pivots|least_index_pivots|ray_d|certificate|"
    "forward_tol|binary_first|solution_sets|solution_formula|truth|pgs_rho";

static base_status read_texts(const node *n, lcp_case *c) {
  BASE_TRY(node_text(n, "group", c->group, sizeof c->group));
  BASE_TRY(node_text(n, "title", c->title, sizeof c->title));
  BASE_TRY(node_text(n, "kind", c->kind, sizeof c->kind));
  BASE_TRY(node_text(n, "note", c->note, sizeof c->note));
  BASE_TRY(node_text(n, "source", c->source, sizeof c->source));
  BASE_TRY(node_text(n, "certificate", c->certificate, sizeof c->certificate));
  return node_text(n, "solution_formula", c->formula, sizeof c->formula);
}

base_status read_lcp_case(json_t *v, lcp_case *c, base_error *err) {
  node n;
  BASE_TRY(node_open(&n, v, err, "lcp case"));
  BASE_TRY(node_need(&n, "id"));
  BASE_TRY(node_text(&n, "id", c->id, sizeof c->id));
  BASE_TRY(node_open(&n, v, err, "lcp '%s'", c->id));
  BASE_TRY(node_keys(&n, case_keys));
  BASE_TRY(node_need(&n, "n"));
  BASE_TRY(node_int(&n, "n", &c->n));
  if (c->n < 0 || c->n > CASE_N_MAX) {
    return BAD(&n, "%s: n = %d, need 0 to %d", n.where, c->n, CASE_N_MAX);
  }
  BASE_TRY(read_texts(&n, c));
  BASE_TRY(read_statuses(&n, "status_correct", &c->correct));
  BASE_TRY(read_statuses(&n, "status_honest_failure", &c->honest_failure));
  BASE_TRY(read_statuses(&n, "status_false_claim", &c->false_claim));
  BASE_TRY(node_has(&n, "gen") ? read_generated(&n, c) : read_dense(&n, c));
  BASE_TRY(read_solutions(&n, c));
  BASE_TRY(read_example(&n, c));
  BASE_TRY(optional_numbers(&n, "w", c->n, &c->w));
  BASE_TRY(read_sets(&n, c));
  BASE_TRY(read_farkas(&n, c));
  BASE_TRY(read_work(&n, c));
  return adopt_closed_form(&n, c);
}
