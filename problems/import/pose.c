/* A local friction problem as a complementarity problem: exact cones, or facets. */
#include "problems/families/triplets.h"
#include "problems/import/friction_problem.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static base_status need_local(const friction_problem *p, base_error *err) {
  return p->global ? BASE_FAIL(err, BASE_EINVAL, "a global problem must be condensed first")
                   : BASE_OK;
}

/* W as it is; dense where every entry is stored. */
static base_status copy_matrix(const lcp_csc *W, known_lcp *k, double **q, base_error *err) {
  const int n = W->n_col, nnz = W->colptr[n];
  double *dense, *val;
  int *colptr, *rowind;
  if ((double)nnz == (double)n * n) {
    BASE_TRY(known_dense(k, n, &dense, q, err));
    memcpy(dense, W->val, (size_t)nnz * sizeof *dense); /* sorted columns are dense columns */
  } else {
    BASE_TRY(known_sparse(k, n, nnz, &colptr, &rowind, &val, q, err));
    memcpy(colptr, W->colptr, ((size_t)n + 1) * sizeof *colptr);
    memcpy(rowind, W->rowind, (size_t)nnz * sizeof *rowind);
    memcpy(val, W->val, (size_t)nnz * sizeof *val);
  }
  k->p.traits = lcp_matrix_is_symmetric(&k->p.M) ? LCP_SYMMETRIC : 0u;
  return BASE_OK;
}

base_status friction_pose_cone(const friction_problem *p, known_lcp *out, base_error *err) {
  double *q;
  memset(out, 0, sizeof *out);
  BASE_TRY(need_local(p, err));
  base_status status = copy_matrix(&p->W, out, &q, err);
  lcp_block *block = (status == BASE_OK) ? KNOWN_ARRAY(out, lcp_block, p->n_contact) : NULL;
  if (status == BASE_OK && block == NULL) {
    status = BASE_FAIL(err, BASE_ENOMEM, "no memory for %d contacts", p->n_contact);
  }
  if (status != BASE_OK) {
    known_lcp_free(out);
    return status;
  }
  memcpy(q, p->q, (size_t)(p->rows * p->n_contact) * sizeof *q);
  for (int c = 0; c < p->n_contact; c++) {
    lcp_block *b = &block[c];
    *b = (lcp_block){.start = c * p->rows, .size = p->rows, .set = LCP_CONE, .n_part = 1};
    b->part_dim[0] = (p->rows == 2) ? 1 : 2;
    b->part_mu[0] = p->mu[c];
    if (p->rows == 5) {
      b->n_part = 2;
      b->part_dim[1] = 2;
      b->part_mu[1] = p->mu_r[c];
    }
  }
  out->p.block = block;
  out->p.n_block = p->n_contact;
  status = lcp_problem_check(&out->p, err);
  if (status != BASE_OK) {
    known_lcp_free(out);
  }
  return status;
}

/* ---- facets --------------------------------------------------------------------------------- */

/* Unknowns of a contact: n, beta_1 .. beta_nd, sigma, and with rolling gamma_1 .. gamma_nd and its
 * own sigma. */
static int unknowns(int nd, int rows) {
  return (rows == 5) ? 2 * nd + 3 : nd + 2;
}

/* Row `row` (0 normal, 1.. tangents, 3.. rolling) of a contact in terms of its LCP unknowns: the
 * normal impulse itself, or the sum of beta_k d_k[row-1]. Coefficient of unknown u. */
static double facet(int nd, int rows, int row, int u) {
  if (row == 0 || u == 0) {
    return (row == 0 && u == 0) ? 1.0 : 0.0;
  }
  if (rows == 2) {
    return (u == 1) ? 1.0 : (u == 2) ? -1.0 : 0.0;
  }
  const int k = (row >= 3) ? u - nd - 2 : u - 1; /* 0 .. nd - 1 on the facets of the row's part */
  if (k < 0 || k >= nd) {
    return 0.0;
  }
  const double angle = 2.0 * pi * k / nd;
  return (row % 2 == 1) ? cos(angle) : sin(angle);
}

/* Row a of what entry W_ij becomes between the facets of its two contacts. */
static void spread(int nd, int rows, int i, int j, int a, double value, triplets *t) {
  const int size = unknowns(nd, rows);
  const double left = facet(nd, rows, i % rows, a);
  for (int b = 0; b < size && left != 0.0; b++) {
    const double right = facet(nd, rows, j % rows, b);
    if (right != 0.0) {
      triplets_add(t, i / rows * size + a, j / rows * size + b, left * value * right);
    }
  }
}

/* The rows and columns of a cone |r_part| <= mu r_n whose facets start at `first`; n: r_n. */
static void bound(int n, int first, int nd, double mu, triplets *t) {
  const int sigma = first + nd;
  triplets_add(t, sigma, n, mu);
  for (int b = 0; b < nd; b++) {
    triplets_add(t, first + b, sigma, 1.0);
    triplets_add(t, sigma, first + b, -1.0);
  }
}

/* M = [F' W F, sigma rows and columns], contact by contact. */
static void collect(const friction_problem *p, int nd, triplets *t) {
  const int rows = p->rows, size = unknowns(nd, rows);
  for (int j = 0; j < p->W.n_col; j++) {
    for (int at = p->W.colptr[j]; at < p->W.colptr[j + 1]; at++) {
      const int i = p->W.rowind[at];
      for (int a = 0; a < size; a++) {
        spread(nd, rows, i, j, a, p->W.val[at], t);
      }
    }
  }
  for (int c = 0; c < p->n_contact; c++) {
    const int n = c * size;
    bound(n, n + 1, nd, p->mu[c], t);
    if (rows == 5) {
      bound(n, n + nd + 2, nd, p->mu_r[c], t);
    }
  }
}

static base_status fill_vectors(const friction_problem *p, int nd, known_lcp *out,
                                base_error *err) {
  const int size = unknowns(nd, p->rows), n = size * p->n_contact;
  double *q = KNOWN_ARRAY(out, double, n);
  lcp_block *block = KNOWN_ARRAY(out, lcp_block, p->n_contact);
  if (q == NULL || block == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d contacts", p->n_contact);
  }
  for (int c = 0; c < p->n_contact; c++) {
    block[c] = (lcp_block){.start = c * size, .size = size, .set = LCP_ORTHANT};
    for (int u = 0; u < size; u++) {
      for (int row = 0; row < p->rows; row++) {
        q[c * size + u] += facet(nd, p->rows, row, u) * p->q[c * p->rows + row];
      }
    }
  }
  out->p.q = q;
  out->p.block = block;
  out->p.n_block = p->n_contact;
  out->p.traits = LCP_ZERO_DIAGONAL;
  return lcp_problem_check(&out->p, err);
}

base_status friction_pose_facets(const friction_problem *p, int nd, known_lcp *out,
                                 base_error *err) {
  memset(out, 0, sizeof *out);
  BASE_TRY(need_local(p, err));
  if (p->rows == 2 ? nd != 2 : (nd < 3 || nd > 64)) {
    return BASE_FAIL(err, BASE_EINVAL, "%d facets: need %s", nd,
                     p->rows == 2 ? "2 in the plane" : "3 to 64");
  }
  /* an entry of W makes at most nd^2 entries (tangent with tangent) */
  const double cap =
      (double)p->W.colptr[p->W.n_col] * nd * nd + 2.0 * (2.0 * nd + 1.0) * p->n_contact;
  triplets t;
  if (cap > 5e8) {
    return BASE_FAIL(err, BASE_EINVAL, "%d facets: more than 5e8 entries", nd);
  }
  const int n = unknowns(nd, p->rows) * p->n_contact;
  BASE_TRY(triplets_open(&t, n, n, (int)cap, err));
  collect(p, nd, &t);
  base_status status = triplets_compress(&t, out, err);
  triplets_free(&t);
  if (status == BASE_OK) {
    status = fill_vectors(p, nd, out, err);
  }
  if (status != BASE_OK) {
    known_lcp_free(out);
  }
  return status;
}

void friction_facet_impulse(int rows, int n_contact, int nd, const double *z, double *r) {
  const int size = unknowns(nd, rows);
  for (int c = 0; c < n_contact; c++) {
    for (int row = 0; row < rows; row++) {
      double sum = 0.0;
      for (int u = 0; u < size; u++) {
        sum += facet(nd, rows, row, u) * z[c * size + u];
      }
      r[c * rows + row] = sum;
    }
  }
}
