/* world_memory.c - the memory of a world: arrays that only ever grow, described once in world_data.h. */
#include "problems/world/world_data.h"

#include <stdlib.h>
#include <string.h>

typedef struct array_line {
  size_t at;   /* of the pointer in the world [bytes] */
  size_t size; /* of what one unit takes [bytes] */
  world_unit unit;
} array_line;

#define LINE_(path, type, unit, each)        {offsetof(world, path), (each) * sizeof(type), unit},
#define WORLD_LINE_(type, name, unit, each)  LINE_(name, type, unit, each)
#define SET_LINE_(type, name, unit, each)    LINE_(store.name, type, unit, each)
#define AHEAD_LINE_(type, name, unit, each)  LINE_(ahead.name, type, unit, each)
#define BEHIND_LINE_(type, name, unit, each) LINE_(behind.name, type, unit, each)

static const array_line lines[] = {WORLD_ARRAYS(WORLD_LINE_) SET_ARRAYS(SET_LINE_)
                                       CURVE_ARRAYS(AHEAD_LINE_) CURVE_ARRAYS(BEHIND_LINE_)};

/* All object pointers have one representation here; memcpy moves it without naming their types. */
static void *get(const world *w, const array_line *l) {
  void *p;
  memcpy(&p, (const char *)w + l->at, sizeof p);
  return p;
}

static void set(world *w, const array_line *l, void *p) {
  memcpy((char *)w + l->at, &p, sizeof p);
}

/* Exact at first, for most worlds never grow; then by half, so that a slowly growing one allocates rarely. */
static size_t capacity(size_t need, size_t have) {
  return (have == 0) ? need : need + need / 2 + 16;
}

base_status world_reserve(world *w, world_unit unit, size_t n, base_error *err) {
  if (n < w->cap[unit]) {
    return BASE_OK;
  }
  const size_t units = capacity(n + 1, w->cap[unit]);
  for (int i = 0; i < BASE_COUNT(lines); i++) {
    if (lines[i].unit != unit) {
      continue;
    }
    void *p = realloc(get(w, &lines[i]), units * lines[i].size);
    if (p == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "world: no memory for %zu items of %zu bytes", units,
                       lines[i].size);
    }
    set(w, &lines[i], p);
  }
  w->cap[unit] = units;
  return BASE_OK;
}

void world_release(world *w) {
  for (int i = 0; i < BASE_COUNT(lines); i++) {
    free(get(w, &lines[i]));
    set(w, &lines[i], NULL);
  }
  memset(w->cap, 0, sizeof w->cap);
}
