/* heap_count.c - counts heap calls of code under test, and makes the k-th one fail on request.
 * Linked with --wrap; sees only statically linked code. */
#include "tests/support/heap_count.h"

#include <malloc.h>

long check_heap_calls;
long check_heap_fail_at;

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t n, size_t bytes);
void *__real_realloc(void *p, size_t bytes);
void *__real_aligned_alloc(size_t align, size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t n, size_t bytes);
void *__wrap_realloc(void *p, size_t bytes);
void *__wrap_aligned_alloc(size_t align, size_t bytes);

static int refuse(void) {
  check_heap_calls++;
  return check_heap_fail_at > 0 && --check_heap_fail_at == 0;
}

void *__wrap_malloc(size_t bytes) {
  return refuse() ? NULL : __real_malloc(bytes);
}
void *__wrap_calloc(size_t n, size_t bytes) {
  return refuse() ? NULL : __real_calloc(n, bytes);
}
/* Less room than there is can be had without memory, and KLU goes on where it is refused. */
void *__wrap_realloc(void *p, size_t bytes) {
  const int fits = p != NULL && bytes <= malloc_usable_size(p);
  return (!fits && refuse()) ? NULL : __real_realloc(p, bytes);
}
void *__wrap_aligned_alloc(size_t align, size_t bytes) {
  return refuse() ? NULL : __real_aligned_alloc(align, bytes);
}
