/* base/arena.h - bump allocator for solver, formulation and scene workspaces.
 *
 * A component describes its memory once, in a layout function that only stores
 * pointers. Running it on a measuring arena yields the size; running it again
 * on a real one yields the arrays. No size is ever written down twice.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define BASE_ALIGN 64 /* one cache line; also enough for AVX-512 loads */

typedef struct base_arena {
  unsigned char *mem; /* NULL on a measuring arena; not owned */
  size_t cap;         /* [bytes] */
  size_t used;        /* [bytes] high-water of the current layout */
  bool overflow;      /* a request did not fit; sticky until reset */
} base_arena;

base_arena base_arena_measuring(void);
base_arena base_arena_over(void *mem, size_t cap); /* mem aligned to BASE_ALIGN */

/* Returns count * size bytes aligned to BASE_ALIGN, or NULL when measuring or full; typed: BASE_ARRAY(a, double, n).
 * Never touches the heap. Builds without NDEBUG fill the block with 0xFF, which
 * reads back as NaN, so use of an uninitialised entry shows in the result. A count whose size would not fit in
 * size_t overflows the arena instead of wrapping round. */
void *base_arena_take_array(base_arena *a, size_t count, size_t size);
#define BASE_ARRAY(a, type, count)                                                                 \
  ((type *)base_arena_take_array((a), (size_t)(count), sizeof(type)))

/* Temporary frame: mark, take, release. Frames nest. */
static inline size_t base_arena_mark(const base_arena *a) {
  return a->used;
}
static inline void base_arena_release(base_arena *a, size_t mark) {
  a->used = mark;
}

/* How much to take where `need` no longer fits: half as much again, so that what grows slowly allocates rarely; an eighth where
 * there is much of it, since memory that is never filled is still paid for in huge pages. */
static inline size_t base_room_of(size_t need) {
  return need + ((need < (1u << 12)) ? need / 2 : need / 8);
}
static inline int base_room(int need) {
  return (int)base_room_of((size_t)need);
}

/* Heap block aligned to BASE_ALIGN, or NULL. Freed with free(). */
void *base_alloc(size_t bytes);
