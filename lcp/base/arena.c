#include "lcp/base/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { HUGE_PAGE = 1 << 21, LARGE = 16 * HUGE_PAGE }; /* [bytes] */

base_arena base_arena_measuring(void) {
  return (base_arena){.cap = SIZE_MAX};
}

base_arena base_arena_over(void *mem, size_t cap) {
  return (base_arena){.mem = mem, .cap = cap};
}

static void *take(base_arena *a, size_t bytes) {
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
  return take(a, count * size);
}

/* Blocks that fill many pages lie on whole huge pages where the system has them on request: a sweep
 * over 200 MB then misses the page table a hundred times less often. It is advice: refused, the block
 * is as good as any other. */
static void *large_block(size_t bytes) {
  const size_t padded = (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
  void *mem = aligned_alloc(HUGE_PAGE, padded);
#ifdef MADV_HUGEPAGE
  if (mem != NULL) {
    (void)madvise(mem, padded, MADV_HUGEPAGE);
  }
#endif
  return mem;
}

void *base_alloc(size_t bytes) {
  if (bytes > PTRDIFF_MAX) { /* no object is as large */
    return NULL;
  }
  if (bytes >= LARGE) {
    return large_block(bytes);
  }
  const size_t lines = (bytes + BASE_ALIGN - 1) / BASE_ALIGN;
  return aligned_alloc(BASE_ALIGN, BASE_ALIGN * (lines > 0 ? lines : 1));
}
