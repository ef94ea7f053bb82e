#include "problems/read/read_lcp.h"

#include "problems/read/read_lcp_part.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static base_status optional_numbers(const node *n, const char *key, int count, double **out) {
  const json_t *v = json_object_get(n->v, key);
  return (v == NULL) ? BASE_OK : read_numbers(n, v, key, count, out);
}

/* ---- answers -------------------------------------------------------------------------------- */

/* A text "p" or "p/q". */
static base_status read_fraction(const node *n, const json_t *v, const char *what, double *out) {
  char text[512], *end;
  BASE_TRY(node_string(n, v, what, text, sizeof text));
  *out = strtod(text, &end);
  if (end != text && *end == '/') {
    const char *below = end + 1;
    *out /= strtod(below, &end);
    end = (end == below) ? text : end;
  }
  if (end == text || *end != '\0' || !isfinite(*out)) {
    return READ_BAD(n, "%s: %s: '%.60s' is no fraction", n->where, what, text);
  }
  return BASE_OK;
}

/* Of two ways to state a number, up to rounding. */
static bool same_number(double a, double b) {
  return fabs(a - b) <= 1e-12 * fmax(fabs(a), fabs(b));
}

/* z_exact says the same as z. */
static base_status check_exact(const node *n, int count, const double *z) {
  json_t *list;
  int size;
  BASE_TRY(node_list(n, "z_exact", CASE_N_MAX, &list, &size));
  if (list != NULL && size != count) {
    return READ_BAD(n, "%s: z_exact: need %d fractions, has %d", n->where, count, size);
  }
  for (int i = 0; i < size; i++) {
    double x = 0.0;
    BASE_TRY(read_fraction(n, json_array_get(list, (size_t)i), "z_exact", &x));
    if (!same_number(x, z[i])) {
      return READ_BAD(n, "%s: z_%d is %.17g, z_exact says %.17g", n->where, i + 1, z[i], x);
    }
  }
  return BASE_OK;
}

/* The w of the answer z is M z + q, up to the rounding of z: relative to the largest term of a row. */
static base_status check_w(const node *n, const lcp_case *c, const double *z, const double *w) {
  const lcp_problem *p = &c->k.p;
  const size_t size = (size_t)c->n;
  if (w == NULL || c->shape_error[0] != '\0') {
    return BASE_OK;
  }
  double *M = malloc((size * size + 1) * sizeof *M);
  if (M == NULL) {
    return read_no_memory(n);
  }
  lcp_matrix_to_dense(&p->M, M);
  base_status status = BASE_OK;
  for (size_t i = 0; status == BASE_OK && i < size; i++) {
    double sum = p->q[i], most = fmax(fabs(sum), fabs(w[i]));
    for (size_t j = 0; j < size; j++) {
      sum += M[j * size + i] * z[j];
      most = fmax(most, fabs(M[j * size + i] * z[j]));
    }
    if (!(fabs(sum - w[i]) <= 1e-9 * most)) {
      status = READ_BAD(n, "%s: w_%zu is %.17g, M z + q of the answer is %.17g", n->where, i + 1,
                        w[i], sum);
    }
  }
  free(M);
  return status;
}

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
    return read_no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    node s;
    BASE_TRY(
        node_open(&s, json_array_get(list, (size_t)i), n->err, "%s: solution %d", n->where, i + 1));
    BASE_TRY(node_keys(&s, "z|z_exact|w"));
    BASE_TRY(node_need(&s, "z"));
    double *z = c->solution + (size_t)i * (size_t)c->n, *w = NULL;
    BASE_TRY(node_vector(&s, "z", c->n, z));
    BASE_TRY(check_exact(&s, c->n, z));
    base_status status = optional_numbers(&s, "w", c->n, &w);
    if (status == BASE_OK) {
      status = check_w(&s, c, z, w);
    }
    free(w);
    BASE_TRY(status);
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
  BASE_TRY(read_numbers(&s, json_object_get(v, "z"), "z", c->n, &c->example));
  return check_exact(&s, c->n, c->example);
}

/* That of each answer that is stated. */
static base_status read_w(const node *n, lcp_case *c) {
  BASE_TRY(optional_numbers(n, "w", c->n, &c->w));
  for (int i = 0; i < c->n_solution; i++) {
    BASE_TRY(check_w(n, c, c->solution + (size_t)i * (size_t)c->n, c->w));
  }
  return (c->example != NULL) ? check_w(n, c, c->example, c->w) : BASE_OK;
}

static base_status read_invariants(const node *n, json_t *v, int size, case_invariants *out) {
  node s;
  json_t *rows;
  int count;
  BASE_TRY(node_open(&s, v, n->err, "%s: invariants", n->where));
  BASE_TRY(node_keys(&s, "name|C|c|c_exact"));
  BASE_TRY(node_text(&s, "name", out->name, sizeof out->name));
  BASE_TRY(node_list(&s, "C", 4096, &rows, &count));
  BASE_TRY(read_numbers(&s, json_object_get(v, "c"), "c", count, &out->c));
  out->C = calloc((size_t)count * (size_t)size + 1, sizeof *out->C);
  if (out->C == NULL) {
    return read_no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    const json_t *row = json_array_get(rows, (size_t)i);
    if (!json_is_array(row) || json_array_size(row) != (size_t)size) {
      return READ_BAD(n, "%s: C: row %d needs %d numbers", s.where, i + 1, size);
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
    return read_no_memory(n);
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
    return READ_BAD(n, "%s: farkas_y: need %d entries, has %d", n->where, c->n, count);
  }
  if ((c->correct & CASE_SOLVED) != 0) {
    return READ_BAD(n, "%s: farkas_y proves that there is no solution, status_correct has solved",
                    n->where);
  }
  c->k.farkas = KNOWN_ARRAY(&c->k, double, count);
  if (c->k.farkas == NULL) {
    return read_no_memory(n);
  }
  for (int i = 0; i < count; i++) {
    BASE_TRY(read_fraction(n, json_array_get(list, (size_t)i), "farkas_y", &c->k.farkas[i]));
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
      return READ_BAD(n, "%s: %s: unknown status '%s'", n->where, key, word);
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
  if (node_has(n, "forward_tol") && !(c->forward_tol > 0.0)) {
    return READ_BAD(n, "%s: forward_tol = %g, need > 0", n->where, c->forward_tol);
  }
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
    return READ_BAD(n, "%s: a closed form needs a generator that knows it", n->where);
  }
  c->solution = malloc((size_t)c->n * sizeof *c->solution);
  if (c->solution == NULL) {
    return read_no_memory(n);
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
    return READ_BAD(&n, "%s: n = %d, need 0 to %d", n.where, c->n, CASE_N_MAX);
  }
  BASE_TRY(read_texts(&n, c));
  BASE_TRY(read_statuses(&n, "status_correct", &c->correct));
  BASE_TRY(read_statuses(&n, "status_honest_failure", &c->honest_failure));
  BASE_TRY(read_statuses(&n, "status_false_claim", &c->false_claim));
  BASE_TRY(read_lcp_problem(&n, c));
  BASE_TRY(read_solutions(&n, c));
  BASE_TRY(read_example(&n, c));
  BASE_TRY(read_w(&n, c));
  BASE_TRY(read_sets(&n, c));
  BASE_TRY(read_farkas(&n, c));
  BASE_TRY(read_work(&n, c));
  return adopt_closed_form(&n, c);
}
