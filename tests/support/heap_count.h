/* heap_count.h - heap calls made by code under test (tests/meson.build links with --wrap). */
#pragma once

#include <stddef.h>

extern long check_heap_calls;   /* malloc, calloc, realloc, aligned_alloc so far */
extern long check_heap_fail_at; /* k > 0: the k-th call from now returns NULL; 0: none */
