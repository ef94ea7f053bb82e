#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct tridiagonal {
  int n, period;
  double diag, off;
} tridiagonal;

static const base_field fields[] = {
    BASE_FIELD(tridiagonal, n, BASE_INT, "1", 100, 1, 1e7, "unknowns"),
    BASE_FIELD(tridiagonal, period, BASE_INT, "1", 3, 2, 1e6, "every so many z is zero"),
    BASE_FIELD(tridiagonal, diag, BASE_REAL, "1", 2.0, 1e-9, 1e9, "diagonal"),
    BASE_FIELD(tridiagonal, off, BASE_REAL, "1", -1.0, -1e9, 1e9, "off the diagonal"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const tridiagonal *p = param;
  return generate_tridiagonal(k, p->n, p->diag, p->off, p->period, err);
}

const lcp_family family_tridiagonal = {
    .name = "tridiagonal",
    .title = "tridiagonal matrix with a made-up solution",
    .cite = "cryer1971",
    .about =
        "The obstacle problem on a line: symmetric positive definite tridiagonal matrix, z_i = 1 + "
        "(i mod 5) except every period-th, which is zero. Sparse, exactly known, any size.",
    FAMILY_PARTS(tridiagonal),
};
