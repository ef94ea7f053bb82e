#include "lcp/base/rng.h"
#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct subset_sum {
  int n, largest, solvable, seed;
} subset_sum;

static const base_field fields[] = {
    BASE_FIELD(subset_sum, n, BASE_INT, "1", 8, 1, 60, "numbers"),
    BASE_FIELD(subset_sum, largest, BASE_INT, "1", 50, 2, 100000, "largest number"),
    BASE_FIELD(subset_sum, solvable, BASE_INT, "1", 1, 0, 1,
               "1: the target is the sum of a subset; 0: all numbers even, the target odd"),
    BASE_FIELD(subset_sum, seed, BASE_INT, "1", 1, 0, 1e9, "seed"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const subset_sum *p = param;
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  int a[60], b = 0;
  for (int i = 0; i < p->n; i++) {
    a[i] = 1 + (int)base_rng_between(&rng, 0.0, p->largest);
    a[i] += (p->solvable == 0) ? a[i] % 2 : 0;
    b += (base_rng_uniform(&rng) < 0.5 || i == 0) ? a[i] : 0;
  }
  return generate_subset_sum(k, p->n, a, (p->solvable == 0) ? b - 1 : b, err);
}

const lcp_family family_subset_sum = {
    .name = "subset_sum",
    .title = "subset sum as a complementarity problem",
    .cite = "chung1989",
    .about =
        "w_i = 1 - z_i, and two rows that force a.z = b: solvable if and only if a subset of the "
        "numbers sums to b, so the general problem is NP-complete. With solvable=0 the linear "
        "program is feasible and yet there is no complementary solution: 'infeasible' would be a "
        "false claim, an honest solver says it does not know (MATHEMATICS F14).",
    FAMILY_PARTS(subset_sum),
};
