#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct murty {
  int n, upper, q;
} murty;

static const base_field fields[] = {
    BASE_FIELD(murty, n, BASE_INT, "1", 8, 1, 5000, "unknowns"),
    BASE_FIELD(murty, upper, BASE_INT, "1", 0, 0, 1, "1: transposed matrix"),
    BASE_FIELD_CHOICE(murty, q, "ones|hat", 0, "q = -1, or the nondegenerate hat (n <= 50)"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const murty *p = param;
  return generate_murty(k, p->n, p->upper == 1, p->q == 1, err);
}

const lcp_family family_murty = {
    .name = "murty",
    .title = "Murty's exponential example",
    .cite = "murty1978",
    .about = "Unit lower triangular matrix with 2 below the diagonal, a P-matrix whose unique "
             "solution is the first unit vector. Lexicographic Lemke with d = 1 takes exactly 2^n "
             "pivots, least-index pivoting 2^n - 1 on the transpose; nearly every other method "
             "finds the answer at once.",
    FAMILY_PARTS(murty),
};
