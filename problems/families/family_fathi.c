#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct fathi {
  int n;
} fathi;

static const base_field fields[] = {
    BASE_FIELD(fathi, n, BASE_INT, "1", 8, 1, 5000, "unknowns"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const fathi *p = param;
  return generate_fathi(k, p->n, err);
}

const lcp_family family_fathi = {
    .name = "fathi",
    .title = "Fathi's exponential example",
    .cite = "fathi1979",
    .about =
        "M = L L' with L the lower Murty matrix: symmetric positive definite, and still "
        "lexicographic Lemke with d = 1 takes 2^n pivots. The solution is the first unit vector.",
    FAMILY_PARTS(fathi),
};
