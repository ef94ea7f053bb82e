#include "problems/pair_table.h"

#include <stdlib.h>
#include <string.h>

/* ---- names ------------------------------------------------------------------------------------ */

typedef struct named_side {
  const char *name;
  int side;
} named_side;

/* By name, then by side: the first of equal names is the one meant. */
static int by_name(const void *a, const void *b) {
  const named_side *x = a, *y = b;
  const int c = strcmp(x->name, y->name);
  return (c != 0) ? c : (x->side > y->side) - (x->side < y->side);
}

/* All sides of a scene by name; NULL without memory. */
static named_side *sort_names(const scene_spec *s) {
  const int n = s->n_body + s->n_static;
  named_side *all = malloc((size_t)(n + 1) * sizeof *all);
  if (all == NULL) {
    return NULL;
  }
  for (int i = 0; i < n; i++) {
    all[i].name = (i < s->n_body) ? s->body[i].name : s->fixed[i - s->n_body].name;
    all[i].side = i;
  }
  qsort(all, (size_t)n, sizeof *all, by_name);
  return all;
}

static int find_name(const named_side *all, int n, const char *name) {
  int lo = 0, hi = n;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (strcmp(all[mid].name, name) < 0) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < n && strcmp(all[lo].name, name) == 0) ? all[lo].side : -1;
}

/* ---- pairs ------------------------------------------------------------------------------------ */

static uint64_t key_of(int a, int b) {
  const uint32_t lo = (uint32_t)((a < b) ? a : b), hi = (uint32_t)((a < b) ? b : a);
  return ((uint64_t)lo << 32) | hi;
}

static int by_key(const void *a, const void *b) {
  const pair_entry *x = a, *y = b;
  return (x->key != y->key) ? ((x->key > y->key) ? 1 : -1)
                            : (x->order > y->order) - (x->order < y->order);
}

/* Later pairs override earlier ones of the same sides. */
static void keep_last(pair_table *t) {
  int kept = 0;
  for (int i = 0; i < t->n; i++) {
    if (i + 1 == t->n || t->entry[i + 1].key != t->entry[i].key) {
      t->entry[kept++] = t->entry[i];
    }
  }
  t->n = kept;
}

static base_status fill(pair_table *t, const scene_spec *s, const named_side *names,
                        const spec_pair *pair, int n_pair, base_error *err) {
  for (int i = 0; i < n_pair; i++) {
    const int n = s->n_body + s->n_static;
    const int a = find_name(names, n, pair[i].a), b = find_name(names, n, pair[i].b);
    if (a < 0 || b < 0) {
      return BASE_FAIL(err, BASE_EINVAL, "pair %.32s-%.32s: '%.32s' is no body or half-space",
                       pair[i].a, pair[i].b, (a < 0) ? pair[i].a : pair[i].b);
    }
    t->entry[t->n++] = (pair_entry){.key = key_of(a, b), .value = pair[i].value, .order = i};
  }
  return BASE_OK;
}

base_status pair_table_open(pair_table *t, const scene_spec *s, double dflt, const spec_pair *pair,
                            int n_pair, base_error *err) {
  *t = (pair_table){.dflt = dflt};
  if (n_pair == 0) {
    return BASE_OK;
  }
  named_side *names = sort_names(s);
  t->entry = malloc((size_t)n_pair * sizeof *t->entry);
  if (names == NULL || t->entry == NULL) {
    free(names);
    return BASE_FAIL(err, BASE_ENOMEM, "pairs: no memory for %d", n_pair);
  }
  const base_status status = fill(t, s, names, pair, n_pair, err);
  free(names);
  qsort(t->entry, (size_t)t->n, sizeof *t->entry, by_key);
  keep_last(t);
  return status;
}

void pair_table_close(pair_table *t) {
  free(t->entry);
  *t = (pair_table){0};
}

double pair_value(const pair_table *t, int side_a, int side_b) {
  if (t->n == 0) {
    return t->dflt;
  }
  const uint64_t key = key_of(side_a, side_b);
  int lo = 0, hi = t->n;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (t->entry[mid].key < key) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < t->n && t->entry[lo].key == key) ? t->entry[lo].value : t->dflt;
}
