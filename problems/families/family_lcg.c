#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct lcg {
  int n, seed, kind;
} lcg;

static const base_field fields[] = {
    BASE_FIELD(lcg, n, BASE_INT, "1", 8, 1, 2000, "unknowns"),
    BASE_FIELD(lcg, seed, BASE_INT, "1", 1, 0, 2147483647, "seed"),
    BASE_FIELD_CHOICE(lcg, kind, "spd|p_nonsym", 0, "symmetric, or with a skew part"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const lcg *p = param;
  return (p->kind == 0) ? generate_lcg_spd(k, p->n, (uint32_t)p->seed, err)
                        : generate_lcg_p(k, p->n, (uint32_t)p->seed, err);
}

const lcp_family family_lcg = {
    .name = "lcg",
    .title = "dense positive definite matrices with integer entries",
    .cite = "",
    .about =
        "M = A'A + I, or A'A + I + K with K skew, and q, all small integers from a congruential "
        "generator anyone can repeat (MATHEMATICS F6). Positive definite, hence uniquely "
        "solvable; the solution is not planted.",
    FAMILY_PARTS(lcg),
};
