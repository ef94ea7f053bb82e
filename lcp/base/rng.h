/* base/rng.h - seeded random numbers with explicit state (splitmix64; Steele,
 * Lea & Flood 2014). Same seed, same numbers, on every machine. */
#pragma once

#include <stdint.h>

typedef struct base_rng {
  uint64_t state;
} base_rng;

static inline base_rng base_rng_seeded(uint64_t seed) {
  return (base_rng){seed};
}

static inline uint64_t base_rng_bits(base_rng *r) {
  uint64_t z = (r->state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

/* Uniform in [0, 1) with 53 bits. */
static inline double base_rng_uniform(base_rng *r) {
  return (double)(base_rng_bits(r) >> 11) * 0x1p-53;
}

/* Uniform in [lo, hi). */
static inline double base_rng_between(base_rng *r, double lo, double hi) {
  return lo + (hi - lo) * base_rng_uniform(r);
}

/* Standard normal (Box & Muller 1958); uses two draws a call, keeps no spare. */
double base_rng_normal(base_rng *r);
