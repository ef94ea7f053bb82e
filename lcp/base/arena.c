#include "lcp/base/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

base_arena base_arena_measuring(void) {
  return (base_arena){.cap = SIZE_MAX};
}

base_arena base_arena_over(void *mem, size_t cap) {
  return (base_arena){.mem = mem, .cap = cap};
}

void *base_arena_take(base_arena *a, size_t bytes) {
  const size_t padded = (bytes + BASE_ALIGN - 1) / BASE_ALIGN * BASE_ALIGN;
  if (padded < bytes || padded > a->cap - a->used) {
    a->overflow = true;
    return NULL;
  }
  unsigned char *p = (a->mem != NULL) ? a->mem + a->used : NULL;
  a->used += padded;
#ifndef NDEBUG
  if (p != NULL && bytes > 0) {
    memset(p, 0xFF, bytes);
  }
#endif
  return p;
}

void *base_arena_take_array(base_arena *a, size_t count, size_t size) {
  if (size != 0 && count > SIZE_MAX / size) {
    a->overflow = true;
    return NULL;
  }
  return base_arena_take(a, count * size);
}

void *base_alloc(size_t bytes) {
  const size_t padded = (bytes + BASE_ALIGN - 1) / BASE_ALIGN * BASE_ALIGN;
  if (padded < bytes) {
    return NULL;
  }
  return aligned_alloc(BASE_ALIGN, padded > 0 ? padded : BASE_ALIGN);
}
