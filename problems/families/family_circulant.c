#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct circulant {
  int n;
  double a, b;
} circulant;

static const base_field fields[] = {
    BASE_FIELD(circulant, n, BASE_INT, "1", 5, 3, 5000, "unknowns"),
    BASE_FIELD(circulant, a, BASE_REAL, "1", 2.0, -1e6, 1e6, "first subdiagonal, cyclic"),
    BASE_FIELD(circulant, b, BASE_REAL, "1", 0.0, -1e6, 1e6, "second subdiagonal, cyclic"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const circulant *p = param;
  return generate_circulant(k, p->n, p->a, p->b, err);
}

const lcp_family family_circulant = {
    .name = "circulant",
    .title = "circulant matrices on which simple methods cycle",
    .cite = "bengharbia2012",
    .about = "Unit diagonal with cyclic subdiagonals a and b; q = -1 and z = 1/(1+a+b) in every "
             "entry. For a > 1 and odd n a P-matrix on which Newton-min cycles and Gauss-Seidel "
             "sweeps diverge.",
    FAMILY_PARTS(circulant),
};
