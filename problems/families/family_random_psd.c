#include "lcp/base/rng.h"
#include "problems/families/family.h"
#include "problems/families/triplets.h"

typedef struct random_psd {
  int n, repeat, seed;
  double active;
} random_psd;

static const base_field fields[] = {
    BASE_FIELD(random_psd, n, BASE_INT, "1", 100, 2, 5000, "unknowns"),
    BASE_FIELD(random_psd, repeat, BASE_INT, "1", 4, 2, 100,
               "rank is n over this: every row comes that often"),
    BASE_FIELD(random_psd, active, BASE_REAL, "1", 0.5, 0.0, 1.0, "share of positive z"),
    BASE_FIELD(random_psd, seed, BASE_INT, "1", 1, 0, 1e9, "seed"),
};

/* M = B'B with B of r = ceil(n/repeat) rows, entries normal; dense, rank r. */
static base_status build(const void *param, known_lcp *k, base_error *err) {
  const random_psd *p = param;
  const size_t n = (size_t)p->n, r = (n + (size_t)p->repeat - 1) / (size_t)p->repeat;
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  double *M, *q;
  BASE_TRY(known_dense(k, p->n, &M, &q, err));
  double *B = KNOWN_ARRAY(k, double, n *r); /* columns of length r */
  if (B == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", p->n);
  }
  for (size_t i = 0; i < n * r; i++) {
    B[i] = base_rng_normal(&rng);
  }
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i <= j; i++) {
      double sum = 0.0;
      for (size_t l = 0; l < r; l++) {
        sum += B[i * r + l] * B[j * r + l];
      }
      M[j * n + i] = M[i * n + j] = sum;
    }
  }
  k->p.traits = LCP_SYMMETRIC | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return plant_random(k, p->active, (uint64_t)p->seed, KNOWN_SOLVABLE, err);
}

const lcp_family family_random_psd = {
    .name = "random_psd",
    .title = "singular positive semidefinite matrix, planted solution",
    .cite = "",
    .about =
        "M = B'B with fewer rows than columns, the algebra of redundant contacts: solvable, with "
        "many solutions that share w = M z + q. Compare w, never z.",
    FAMILY_PARTS(random_psd),
};
