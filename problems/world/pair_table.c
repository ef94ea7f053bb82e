#include "problems/world/pair_table.h"

#include <stdlib.h>

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

static base_status fill(pair_table *t, const name_index *names, const spec_pair *pair, int n_pair,
                        base_error *err) {
  for (int i = 0; i < n_pair; i++) {
    const int a = name_index_find(names, pair[i].a), b = name_index_find(names, pair[i].b);
    if (a < 0 || b < 0) {
      return BASE_FAIL(err, BASE_EINVAL, "pair %.32s-%.32s: '%.32s' is no body or half-space",
                       pair[i].a, pair[i].b, (a < 0) ? pair[i].a : pair[i].b);
    }
    t->entry[t->n++] = (pair_entry){.key = key_of(a, b), .value = pair[i].value, .order = i};
  }
  return BASE_OK;
}

base_status pair_table_open(pair_table *t, const name_index *names, double dflt,
                            const spec_pair *pair, int n_pair, base_error *err) {
  *t = (pair_table){.dflt = dflt};
  if (n_pair == 0) {
    return BASE_OK;
  }
  t->entry = malloc((size_t)n_pair * sizeof *t->entry);
  if (t->entry == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "pairs: no memory for %d", n_pair);
  }
  BASE_TRY(fill(t, names, pair, n_pair, err));
  qsort(t->entry, (size_t)t->n, sizeof *t->entry, by_key);
  keep_last(t);
  return BASE_OK;
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
