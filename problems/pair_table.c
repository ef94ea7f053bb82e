#include "problems/pair_table.h"

#include <stdlib.h>
#include <string.h>

int pair_side(const scene_spec *s, const char *name) {
  const int body = spec_find_body(s, name);
  if (body >= 0) {
    return body;
  }
  for (int i = 0; i < s->n_static; i++) {
    if (strcmp(s->fixed[i].name, name) == 0) {
      return s->n_body + i;
    }
  }
  return -1;
}

static uint64_t key_of(int a, int b) {
  const uint32_t lo = (uint32_t)((a < b) ? a : b), hi = (uint32_t)((a < b) ? b : a);
  return ((uint64_t)lo << 32) | hi;
}

/* Insertion keeps the keys sorted; scenes name few pairs. */
static void insert(pair_table *t, uint64_t key, double value) {
  int i = t->n;
  while (i > 0 && t->key[i - 1] > key) {
    i--;
  }
  if (i > 0 && t->key[i - 1] == key) {
    t->value[i - 1] = value;
    return;
  }
  memmove(t->key + i + 1, t->key + i, (size_t)(t->n - i) * sizeof *t->key);
  memmove(t->value + i + 1, t->value + i, (size_t)(t->n - i) * sizeof *t->value);
  t->key[i] = key;
  t->value[i] = value;
  t->n++;
}

base_status pair_table_open(pair_table *t, const scene_spec *s, double dflt, const spec_pair *pair,
                            int n_pair, base_error *err) {
  *t = (pair_table){.dflt = dflt};
  if (n_pair == 0) {
    return BASE_OK;
  }
  t->key = malloc((size_t)n_pair * sizeof *t->key);
  t->value = malloc((size_t)n_pair * sizeof *t->value);
  if (t->key == NULL || t->value == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "pairs: no memory for %d", n_pair);
  }
  for (int i = 0; i < n_pair; i++) {
    const int a = pair_side(s, pair[i].a), b = pair_side(s, pair[i].b);
    if (a < 0 || b < 0) {
      return BASE_FAIL(err, BASE_EINVAL, "pair %.32s-%.32s: '%.32s' is no body or half-space",
                       pair[i].a, pair[i].b, (a < 0) ? pair[i].a : pair[i].b);
    }
    insert(t, key_of(a, b), pair[i].value);
  }
  return BASE_OK;
}

void pair_table_close(pair_table *t) {
  free(t->key);
  free(t->value);
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
    if (t->key[mid] < key) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < t->n && t->key[lo] == key) ? t->value[lo] : t->dflt;
}

bool pair_any_positive(const pair_table *t) {
  if (t->dflt > 0.0) {
    return true;
  }
  for (int i = 0; i < t->n; i++) {
    if (t->value[i] > 0.0) {
      return true;
    }
  }
  return false;
}
