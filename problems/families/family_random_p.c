#include "lcp/base/rng.h"
#include "problems/families/family.h"
#include "problems/families/triplets.h"

typedef struct random_p {
  int n, seed, definite;
  double active, skew;
} random_p;

static const base_field fields[] = {
    BASE_FIELD(random_p, n, BASE_INT, "1", 100, 1, 5000, "unknowns"),
    BASE_FIELD(random_p, definite, BASE_INT, "1", 1, 0, 1,
               "1: positive definite with a skew part; 0: lower triangular, indefinite"),
    BASE_FIELD(random_p, skew, BASE_REAL, "1", 3.0, 0.0, 1e6,
               "size of the part that is not symmetric"),
    BASE_FIELD(random_p, active, BASE_REAL, "1", 0.5, 0.0, 1.0, "share of positive z"),
    BASE_FIELD(random_p, seed, BASE_INT, "1", 1, 0, 1e9, "seed"),
};

/* A diagonal in [0.5, 1.5] plus skew K/(1 + n/10) with K antisymmetric and normal, or lower triangular with
 * entries of that size. */
static base_status build(const void *param, known_lcp *k, base_error *err) {
  const random_p *p = param;
  const size_t n = (size_t)p->n;
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  const double size = p->skew / (1.0 + 0.1 * p->n);
  double *M, *q;
  BASE_TRY(known_dense(k, p->n, &M, &q, err));
  for (size_t j = 0; j < n; j++) {
    M[j * n + j] = base_rng_between(&rng, 0.5, 1.5);
    for (size_t i = j + 1; i < n; i++) {
      const double x = size * base_rng_normal(&rng);
      M[j * n + i] = x;
      M[i * n + j] = (p->definite == 1) ? -x : 0.0;
    }
  }
  k->p.traits = LCP_P_MATRIX;
  if (p->definite == 1) {
    k->p.traits |= LCP_PD | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  }
  return plant_random(k, p->active, (uint64_t)p->seed, KNOWN_UNIQUE, err);
}

const lcp_family family_random_p = {
    .name = "random_p",
    .title = "nonsymmetric P-matrix, planted solution",
    .cite = "",
    .about =
        "Positive diagonal plus a skew part (positive definite, yet sweeps may cycle), or unit "
        "triangular with large entries (a P-matrix that is not definite). P-matrices have exactly "
        "one solution for every q, so the planted one is it.",
    FAMILY_PARTS(random_p),
};
