/* base/clones.h - BASE_CLONES before a function: compiled for AVX-512, AVX2 and the baseline, chosen at load time. Without
 * contraction into fused multiply-adds, and without sums in another order, all of them give the same bits. One version under a
 * sanitizer: that of threads cannot run yet when the choice is made, and that of addresses sees the same reads and writes in each. */
#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) &&                        \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BASE_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define BASE_CLONES
#endif

/* Before a static function that is to be part of those that call it, and so of their clones. */
#define BASE_INLINE static inline __attribute__((always_inline))
