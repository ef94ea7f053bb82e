#include "problems/families/family.h"
#include "problems/families/triplets.h"

typedef struct box_stack {
  int n, storage;
  double mass_ratio, half, gh;
} box_stack;

static const base_field fields[] = {
    BASE_FIELD(box_stack, n, BASE_INT, "1", 10, 1, 1e6, "boxes"),
    BASE_FIELD(box_stack, mass_ratio, BASE_REAL, "1", 1.0, 1e-12, 1e12,
               "mass of the topmost over that of the others, which are 1 kg"),
    BASE_FIELD(box_stack, half, BASE_REAL, "m", 0.5, 1e-3, 1e3, "half edge"),
    BASE_FIELD(box_stack, gh, BASE_REAL, "m/s", 0.0981, 1e-12, 1e6, "gravity times step"),
    BASE_FIELD_CHOICE(box_stack, storage, "factored|sparse", 0,
                      "J W J' kept as factors, or formed"),
};

/* Contact c of interface i (box i on box i-1, the floor below box 0) at corner (sx, sy): rows over
 * (v_z, omega_x, omega_y) of the upper box (1, y, -x), of the lower one minus that. */
static void corner_row(const box_stack *p, int corner, double sign, double *row) {
  const double x = (corner & 1) ? p->half : -p->half, y = (corner & 2) ? p->half : -p->half;
  row[0] = sign;
  row[1] = sign * y;
  row[2] = -sign * x;
}

static double mass_of(const box_stack *p, int box) {
  return (box == p->n - 1) ? p->mass_ratio : 1.0;
}

/* 1/m and 1/I, I = m (2 half)^2/6 of a cube. */
static void weight_of(const box_stack *p, int box, double w[3]) {
  w[0] = 1.0 / mass_of(p, box);
  w[1] = w[2] = 1.5 / (mass_of(p, box) * p->half * p->half);
}

static double dot3(const double *w, const double *a, const double *b) {
  return w[0] * a[0] * b[0] + w[1] * a[1] * b[1] + w[2] * a[2] * b[2];
}

static void add_interface(const box_stack *p, triplets *t, int i) {
  double w[3], up[3], other[3];
  for (int c = 0; c < 16; c++) { /* pairs of corners */
    weight_of(p, i, w);
    corner_row(p, c & 3, 1.0, up);
    corner_row(p, c >> 2, 1.0, other);
    double own = dot3(w, up, other);
    const int row = 4 * i + (c & 3), col = 4 * i + (c >> 2);
    if (i + 1 < p->n) { /* box i carries interface i from above and i+1 from below */
      triplets_add(t, row, col + 4, -own);
      triplets_add(t, row + 4, col, -own);
    }
    if (i > 0) {
      weight_of(p, i - 1, w);
      own += dot3(w, up, other);
    }
    triplets_add(t, row, col, own);
  }
}

static base_status build_sparse(const box_stack *p, known_lcp *k, base_error *err) {
  triplets t;
  if (p->n > 4000000) {
    return BASE_FAIL(err, BASE_EINVAL, "n = %d: need at most 4e6 with sparse storage", p->n);
  }
  BASE_TRY(triplets_open(&t, 4 * p->n, 4 * p->n, 48 * p->n, err));
  for (int i = 0; i < p->n; i++) {
    add_interface(p, &t, i);
  }
  const base_status status = triplets_compress(&t, k, err);
  triplets_free(&t);
  return status;
}

static base_status build_factored(const box_stack *p, known_lcp *k, base_error *err) {
  const int n = p->n, m = 4 * n;
  int *dof = KNOWN_ARRAY(k, int, n + 1), *at = KNOWN_ARRAY(k, int, n + 1);
  double *weight = KNOWN_ARRAY(k, double, 9 * (size_t)n),
         *jac = KNOWN_ARRAY(k, double, 6 * (size_t)m);
  int *row = KNOWN_ARRAY(k, int, m + 1), *body = KNOWN_ARRAY(k, int, 2 * (size_t)m);
  int *start = KNOWN_ARRAY(k, int, m + 1);
  double *q = KNOWN_ARRAY(k, double, m);
  lcp_factored *f = KNOWN_ARRAY(k, lcp_factored, 1);
  if (dof == NULL || at == NULL || weight == NULL || jac == NULL || row == NULL || body == NULL ||
      start == NULL || q == NULL || f == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", n);
  }
  int used = 0;
  for (int i = 0; i < n; i++) {
    double w[3];
    weight_of(p, i, w);
    dof[i + 1] = 3 * (i + 1);
    at[i + 1] = 9 * (i + 1);
    for (int d = 0; d < 3; d++) {
      weight[9 * i + 4 * d] = w[d];
    }
    for (int c = 0; c < 4; c++) {
      const int g = 4 * i + c;
      row[g + 1] = g + 1;
      body[2 * g] = i;
      body[2 * g + 1] = i - 1;
      corner_row(p, c, 1.0, jac + used);
      used += 3;
      if (i > 0) {
        corner_row(p, c, -1.0, jac + used);
        used += 3;
      }
      start[g + 1] = used;
    }
  }
  *f = (lcp_factored){.n_body = n,
                      .dof_start = dof,
                      .weight_start = at,
                      .weight = weight,
                      .n_group = m,
                      .row_start = row,
                      .body = body,
                      .jac_start = start,
                      .jac = jac};
  k->p.M = (lcp_matrix){.storage = LCP_FACTORED, .n = m, .factored = f};
  k->p.q = q;
  return BASE_OK;
}

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const box_stack *p = param;
  BASE_TRY(p->storage == 0 ? build_factored(p, k, err) : build_sparse(p, k, err));
  const int n = 4 * p->n;
  double *q = KNOWN_ARRAY(k, double, n);
  k->z = KNOWN_ARRAY(k, double, n);
  k->w = KNOWN_ARRAY(k, double, n);
  if (q == NULL || k->z == NULL || k->w == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", n);
  }
  double above = 0.0;
  for (int i = p->n - 1; i >= 0; i--) {
    above += mass_of(p, i);
    for (int c = 0; c < 4; c++) {
      k->z[4 * i + c] = p->gh * above / 4.0;
      q[4 * i + c] = (i == 0) ? -p->gh : 0.0;
    }
  }
  k->p.q = q;
  k->answer = KNOWN_SOLVABLE;
  k->p.traits = LCP_SYMMETRIC | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}

const lcp_family family_box_stack = {
    .name = "box_stack",
    .title = "frictionless tower of boxes, four contacts each",
    .cite = "acary2008",
    .about =
        "Cubes on each other with contacts at the four corners: 4n unknowns of rank 3n, so the "
        "split among corners is free and the sum at interface i is the weight above it. "
        "Block-tridiagonal, of any size; kept as J W J' or formed. Packaged solvers fail on it "
        "from some hundred boxes on.",
    FAMILY_PARTS(box_stack),
};
