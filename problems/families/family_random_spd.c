#include "lcp/base/rng.h"
#include "problems/families/family.h"
#include "problems/families/triplets.h"

#include <math.h>

typedef struct random_spd {
  int n, degree, seed;
  double active, shift;
} random_spd;

static const base_field fields[] = {
    BASE_FIELD(random_spd, n, BASE_INT, "1", 100, 1, 1e6, "unknowns"),
    BASE_FIELD(random_spd, degree, BASE_INT, "1", 6, 0, 200, "couplings a row has on average"),
    BASE_FIELD(random_spd, active, BASE_REAL, "1", 0.5, 0.0, 1.0, "share of positive z"),
    BASE_FIELD(random_spd, shift, BASE_REAL, "1", 0.01, 1e-12, 1e6,
               "least eigenvalue; small means ill-conditioned"),
    BASE_FIELD(random_spd, seed, BASE_INT, "1", 1, 0, 1e9, "seed"),
};

/* Sum of random rank-one couplings c (e_i + s e_j)(e_i + s e_j)', s = -1 or 1, plus shift I. */
static base_status fill(const random_spd *p, triplets *t, known_lcp *k, base_error *err) {
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  const int couplings = (int)((double)p->n * p->degree / 2.0);
  for (int i = 0; i < p->n; i++) {
    triplets_add(t, i, i, p->shift);
  }
  for (int e = 0; e < couplings && p->n > 1; e++) {
    const int i = (int)base_rng_between(&rng, 0.0, p->n);
    const int j = (i + 1 + (int)base_rng_between(&rng, 0.0, p->n - 1)) % p->n;
    const double c = base_rng_between(&rng, 0.5, 1.5);
    const double s = (base_rng_uniform(&rng) < 0.5) ? -c : c;
    triplets_add(t, i, i, c);
    triplets_add(t, j, j, c);
    triplets_add(t, i, j, s);
    triplets_add(t, j, i, s);
  }
  BASE_TRY(triplets_compress(t, k, err));
  k->p.traits =
      LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return plant_random(k, p->active, (uint64_t)p->seed, KNOWN_UNIQUE, err);
}

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const random_spd *p = param;
  const double entries = (double)p->n * (1.0 + 2.0 * p->degree);
  triplets t;
  if (entries > 2e8) {
    return BASE_FAIL(err, BASE_EINVAL, "n = %d with degree = %d: more than 2e8 entries", p->n,
                     p->degree);
  }
  BASE_TRY(triplets_open(&t, p->n, p->n, (int)entries + 8, err));
  const base_status status = fill(p, &t, k, err);
  triplets_free(&t);
  return status;
}

const lcp_family family_random_spd = {
    .name = "random_spd",
    .title = "sparse symmetric positive definite matrix, planted solution",
    .cite = "",
    .about = "A random graph of couplings c (e_i +- e_j)(e_i +- e_j)' plus shift I, so the least "
             "eigenvalue is at least shift; z and w are drawn complementary and q = w - M z. The "
             "solution is unique and known; shift sets the condition number.",
    FAMILY_PARTS(random_spd),
};
