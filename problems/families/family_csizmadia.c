#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct csizmadia {
  int n;
} csizmadia;

static const base_field fields[] = {
    BASE_FIELD(csizmadia, n, BASE_INT, "1", 8, 1, 5000, "unknowns"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const csizmadia *p = param;
  return generate_csizmadia(k, p->n, err);
}

const lcp_family family_csizmadia = {
    .name = "csizmadia",
    .title = "Csizmadia's matrix of exponential handicap",
    .cite = "deklerk2011",
    .about = "Unit lower triangular with -1 below the diagonal. A P-matrix whose handicap grows "
             "exponentially with n, which bounds the complexity estimates of interior-point "
             "methods; z alternates 1, 0, 1, ...",
    FAMILY_PARTS(csizmadia),
};
