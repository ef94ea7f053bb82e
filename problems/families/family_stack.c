#include "problems/families/family.h"
#include "problems/families/generate.h"

#include <stdlib.h>

typedef struct stack {
  int n;
  double mass_ratio, gh;
} stack;

static const base_field fields[] = {
    BASE_FIELD(stack, n, BASE_INT, "1", 20, 1, 1e7, "masses"),
    BASE_FIELD(stack, mass_ratio, BASE_REAL, "1", 1.0, 1e-12, 1e12,
               "mass of the topmost over that of the others, which are 1 kg"),
    BASE_FIELD(stack, gh, BASE_REAL, "m/s", 0.015625, 1e-12, 1e6, "gravity times step"),
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const stack *p = param;
  double *mass = malloc((size_t)p->n * sizeof *mass);
  if (mass == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", p->n);
  }
  for (int i = 0; i < p->n; i++) {
    mass[i] = (i == p->n - 1) ? p->mass_ratio : 1.0;
  }
  const base_status status = generate_stack(k, p->n, mass, p->gh, err);
  free(mass);
  return status;
}

const lcp_family family_stack = {
    .name = "stack",
    .title = "column of point masses under gravity",
    .cite = "acary2008",
    .about =
        "Masses on top of each other, one contact each: a symmetric positive definite tridiagonal "
        "matrix; contact i carries everything above it. Gauss-Seidel sweeps contract like "
        "cos^2(pi/2n) for equal masses and R/(1+R) for two of ratio R (MATHEMATICS F8).",
    FAMILY_PARTS(stack),
};
