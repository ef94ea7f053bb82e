#include "problems/families/triplets.h"

#include "lcp/base/rng.h"

#include <stdlib.h>
#include <string.h>

base_status triplets_open(triplets *t, int n_row, int n_col, int cap, base_error *err) {
  *t = (triplets){.n_row = n_row, .n_col = n_col, .cap = cap};
  t->row = malloc(((size_t)cap + 1) * sizeof *t->row);
  t->col = malloc(((size_t)cap + 1) * sizeof *t->col);
  t->val = malloc(((size_t)cap + 1) * sizeof *t->val);
  if (t->row == NULL || t->col == NULL || t->val == NULL) {
    triplets_free(t);
    return BASE_FAIL(err, BASE_ENOMEM, "matrix %d x %d: no memory for %d entries", n_row, n_col,
                     cap);
  }
  return BASE_OK;
}

void triplets_free(triplets *t) {
  free(t->row);
  free(t->col);
  free(t->val);
  memset(t, 0, sizeof *t);
}

void triplets_add(triplets *t, int row, int col, double val) {
  t->row[t->count] = row;
  t->col[t->count] = col;
  t->val[t->count++] = val;
}

/* Stable bucket sort by key[0..n-1] of the entries listed in `from`. */
static void sort_by(const int *key, int n, int count, const int *from, int *to, int *start) {
  memset(start, 0, ((size_t)n + 1) * sizeof *start);
  for (int i = 0; i < count; i++) {
    start[key[i] + 1]++;
  }
  for (int i = 0; i < n; i++) {
    start[i + 1] += start[i];
  }
  for (int i = 0; i < count; i++) {
    const int entry = (from != NULL) ? from[i] : i;
    to[start[key[entry]]++] = entry;
  }
}

/* Entries by column, rows ascending inside, duplicates summed. */
static void fill(const triplets *t, const int *order, int *colptr, int *rowind, double *val) {
  int at = 0, last_col = -1;
  for (int i = 0; i < t->count; i++) {
    const int e = order[i];
    if (t->col[e] == last_col && rowind[at - 1] == t->row[e]) {
      val[at - 1] += t->val[e];
      continue;
    }
    last_col = t->col[e];
    rowind[at] = t->row[e];
    val[at++] = t->val[e];
    colptr[last_col + 1] = at;
  }
  for (int j = 0; j < t->n_col; j++) { /* empty columns */
    colptr[j + 1] = (colptr[j + 1] > colptr[j]) ? colptr[j + 1] : colptr[j];
  }
}

/* colptr zeroed, of n_col + 1 entries; rowind and val of t->count. */
static base_status compress(const triplets *t, int *colptr, int *rowind, double *val,
                            base_error *err) {
  const size_t n = (size_t)((t->n_row > t->n_col) ? t->n_row : t->n_col);
  int *by_row = malloc(((size_t)t->count + 1) * sizeof *by_row);
  int *order = malloc(((size_t)t->count + 1) * sizeof *order);
  int *start = malloc((n + 1) * sizeof *start);
  const bool ok = by_row != NULL && order != NULL && start != NULL;
  if (ok) {
    sort_by(t->row, t->n_row, t->count, NULL, by_row, start);
    sort_by(t->col, t->n_col, t->count, by_row, order, start);
    fill(t, order, colptr, rowind, val);
  }
  free(by_row);
  free(order);
  free(start);
  return ok ? BASE_OK
            : BASE_FAIL(err, BASE_ENOMEM, "matrix %d x %d: no memory", t->n_row, t->n_col);
}

base_status triplets_compress(const triplets *t, known_lcp *k, base_error *err) {
  int *colptr, *rowind;
  double *val, *q;
  BASE_TRY(known_sparse(k, t->n_col, t->count, &colptr, &rowind, &val, &q, err));
  return compress(t, colptr, rowind, val, err);
}

base_status triplets_to_csc(const triplets *t, lcp_csc *out, base_error *err) {
  int *colptr = calloc((size_t)t->n_col + 1, sizeof *colptr);
  int *rowind = malloc(((size_t)t->count + 1) * sizeof *rowind);
  double *val = malloc(((size_t)t->count + 1) * sizeof *val);
  base_status status = BASE_ENOMEM;
  if (colptr != NULL && rowind != NULL && val != NULL) {
    status = compress(t, colptr, rowind, val, err);
  } else {
    (void)BASE_FAIL(err, BASE_ENOMEM, "matrix %d x %d: no memory", t->n_row, t->n_col);
  }
  if (status != BASE_OK) {
    free(colptr);
    free(rowind);
    free(val);
    return status;
  }
  *out = (lcp_csc){t->n_row, t->n_col, colptr, rowind, val};
  return BASE_OK;
}

base_status plant_random(known_lcp *k, double active, uint64_t seed, known_answer answer,
                         base_error *err) {
  const size_t n = (size_t)k->p.M.n;
  base_rng rng = base_rng_seeded(seed ^ 0x5EEDu);
  double *z = calloc(n + 1, sizeof *z), *w = calloc(n + 1, sizeof *w);
  base_status status = BASE_FAIL(err, BASE_ENOMEM, "no memory for the solution");
  if (z != NULL && w != NULL) {
    for (size_t i = 0; i < n; i++) {
      const double size = base_rng_between(&rng, 0.5, 1.5);
      *((base_rng_uniform(&rng) < active) ? &z[i] : &w[i]) = size;
    }
    status = known_plant(k, z, w, err);
  }
  free(z);
  free(w);
  k->answer = answer;
  return status;
}
