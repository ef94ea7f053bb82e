#include "lcp/base/gather.h"

#include <assert.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_ROOM = 16 }; /* items */

static base_status more_lists(base_gather *g, int parts, base_error *err) {
  const int cap = base_room(parts);
  base_list *list = base_alloc((size_t)cap * sizeof *list);
  if (list == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d lists", cap);
  }
  for (int k = 0; k < cap; k++) {
    list[k] = (k < g->cap) ? g->list[k] : (base_list){0};
  }
  free(g->list);
  g->list = list;
  g->cap = cap;
  return BASE_OK;
}

base_status base_gather_begin(base_gather *g, int parts, size_t size, base_error *err) {
  assert(g->size == 0 || g->size == size);
  if (parts > g->cap) {
    BASE_TRY(more_lists(g, parts, err));
  }
  g->size = size;
  g->parts = parts;
  for (int k = 0; k < parts; k++) {
    g->list[k].n = 0;
    g->list[k].failed = false;
  }
  return BASE_OK;
}

static bool grow(base_list *l, size_t size) {
  const int cap = (l->cap > 0) ? base_room(l->cap + 1) : LEAST_ROOM;
  unsigned char *at = (l->cap < INT_MAX / 2) ? realloc(l->at, (size_t)cap * size) : NULL;
  if (at == NULL) {
    l->failed = true; /* whatever has room later */
    return false;
  }
  l->at = at;
  l->cap = cap;
  return true;
}

void *base_gather_add(base_gather *g, int part) {
  base_list *l = &g->list[part];
  return (l->n < l->cap || grow(l, g->size)) ? l->at + (size_t)l->n++ * g->size : NULL;
}

base_status base_gather_count(const base_gather *g, const char *what, int *n, base_error *err) {
  long sum = 0;
  for (int k = 0; k < g->parts; k++) {
    if (g->list[k].failed) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d %s", g->list[k].n, what);
    }
    sum += g->list[k].n;
  }
  if (sum > INT_MAX / 2) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "more than %d %s", INT_MAX / 2, what);
  }
  *n = (int)sum;
  return BASE_OK;
}

void base_gather_join(const base_gather *g, void *to) {
  unsigned char *at = to;
  for (int k = 0; k < g->parts; k++) {
    const size_t bytes = (size_t)g->list[k].n * g->size;
    if (bytes > 0) {
      memcpy(at, g->list[k].at, bytes);
      at += bytes;
    }
  }
}

void base_gather_close(base_gather *g) {
  for (int k = 0; k < g->cap; k++) {
    free(g->list[k].at);
  }
  free(g->list);
  *g = (base_gather){0};
}
