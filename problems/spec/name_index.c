#include "problems/spec/name_index.h"

#include <stdlib.h>
#include <string.h>

static int by_name(const void *a, const void *b) {
  const named_side *x = a, *y = b;
  const int c = strcmp(x->name, y->name);
  return (c != 0) ? c : (x->side > y->side) - (x->side < y->side);
}

base_status name_index_open(name_index *k, const scene_spec *s, base_error *err) {
  k->n = s->n_body + s->n_static;
  k->entry = malloc(((size_t)k->n + 1) * sizeof *k->entry);
  if (k->entry == NULL) {
    k->n = 0;
    return BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory for the names of %d sides", s->id,
                     s->n_body + s->n_static);
  }
  for (int i = 0; i < k->n; i++) {
    k->entry[i].name = (i < s->n_body) ? s->body[i].name : s->fixed[i - s->n_body].name;
    k->entry[i].side = i;
  }
  qsort(k->entry, (size_t)k->n, sizeof *k->entry, by_name);
  return BASE_OK;
}

void name_index_close(name_index *k) {
  free(k->entry);
  *k = (name_index){0};
}

int name_index_find(const name_index *k, const char *name) {
  int lo = 0, hi = k->n;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (strcmp(k->entry[mid].name, name) < 0) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < k->n && strcmp(k->entry[lo].name, name) == 0) ? k->entry[lo].side : -1;
}
