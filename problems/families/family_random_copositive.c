#include "lcp/base/rng.h"
#include "problems/families/family.h"
#include "problems/families/triplets.h"

typedef struct random_copositive {
  int n, seed;
  double active, density;
} random_copositive;

static const base_field fields[] = {
    BASE_FIELD(random_copositive, n, BASE_INT, "1", 50, 1, 5000, "unknowns"),
    BASE_FIELD(random_copositive, density, BASE_REAL, "1", 0.3, 0.0, 1.0,
               "share of entries off the diagonal"),
    BASE_FIELD(random_copositive, active, BASE_REAL, "1", 0.3, 0.0, 1.0, "share of positive z"),
    BASE_FIELD(random_copositive, seed, BASE_INT, "1", 1, 0, 1e9, "seed"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const random_copositive *p = param;
  const size_t n = (size_t)p->n;
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  double *M, *q;
  BASE_TRY(known_dense(k, p->n, &M, &q, err));
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i < n; i++) {
      const bool there = base_rng_uniform(&rng) < p->density;
      const double x = base_rng_between(&rng, 0.0, 4.0);
      M[j * n + i] = (i == j) ? 0.5 + x / 4.0 : there ? x : 0.0;
    }
  }
  k->p.traits = LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS; /* strictly: z'Mz > 0 for z >= 0, z != 0 */
  return plant_random(k, p->active, (uint64_t)p->seed, KNOWN_SOLVABLE, err);
}

const lcp_family family_random_copositive = {
    .name = "random_copositive",
    .title = "strictly copositive matrix, planted solution",
    .cite = "cottle1992",
    .about =
        "Nonnegative entries with a positive diagonal, indefinite as a rule: strictly copositive, "
        "so solvable for every q and processed by Lemke's method (Cottle, Pang & Stone 1992, "
        "theorem 4.4.12), but with many solutions and out of reach of descent methods.",
    FAMILY_PARTS(random_copositive),
};
