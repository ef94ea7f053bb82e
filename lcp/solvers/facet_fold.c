#include "lcp/solvers/facet_fold.h"

#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

#include <string.h>

static const double pi = 3.14159265358979323846;
static const double same = 1e-12; /* of a facet's row, over the largest entry of its part */

void lcp_fold_layout(lcp_fold *s, const lcp_capacity *cap, base_arena *a) {
  const size_t n = (cap->n_body > 0) ? (size_t)cap->n_folded : 0; /* factors alone are folded */
  s->block = BASE_ARRAY(a, lcp_block, (n > 0) ? cap->n_block : 0);
  s->mixture = BASE_ARRAY(a, const lcp_mixture *, (n > 0) ? cap->n_block : 0);
  int **const whole[] = {&s->facets, &s->row_start, &s->jac_start, &s->colptr};
  for (int i = 0; i < BASE_COUNT(whole); i++) {
    *whole[i] = BASE_ARRAY(a, int, n + 1);
  }
  double **const real[] = {&s->q, &s->lo, &s->hi, &s->unit};
  for (int i = 0; i < BASE_COUNT(real); i++) {
    *real[i] = BASE_ARRAY(a, double, n);
  }
  s->jac = BASE_ARRAY(a, double, (n > 0) ? cap->n_jac_folded : 0);
  s->rowind = BASE_ARRAY(a, int, (n > 0) ? cap->nnz : 0);
  s->val = BASE_ARRAY(a, double, (n > 0) ? cap->nnz : 0);
}

/* ---- polygons -------------------------------------------------------------------------------- */

/* d_k of f, the four axes exactly. */
static void direction(int f, int k, double *d) {
  k %= f;
  if ((4 * k) % f == 0) {
    const int quarter = 4 * k / f;
    d[0] = (quarter == 0) - (quarter == 2);
    d[1] = (quarter == 1) - (quarter == 3);
    return;
  }
  d[0] = cos(2 * pi * k / f);
  d[1] = sin(2 * pi * k / f);
}

/* The corner before v, counter-clockwise. */
static int sector(int f, const double *v) {
  const double angle = atan2(v[1], v[0]);
  const int k = (int)floor(((angle < 0) ? angle + 2 * pi : angle) * f / (2 * pi));
  return (k < 0) ? 0 : ((k >= f) ? f - 1 : k);
}

bool lcp_polygon_project(int f, double radius, const double *v, double *to, double *by_v,
                         double *by_radius) {
  double a[2], b[2];
  const int k = sector(f, v);
  direction(f, k, a);
  direction(f, k + 1, b);
  /* the edge: its middle m (the apothem along the normal), half of its length along e */
  const double m[2] = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
  const double h[2] = {0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])};
  const double mm = m[0] * m[0] + m[1] * m[1], hh = h[0] * h[0] + h[1] * h[1];
  memset(by_v, 0, 4 * sizeof *by_v);
  memset(by_radius, 0, 2 * sizeof *by_radius);
  if (v[0] * m[0] + v[1] * m[1] <= radius * mm) {
    memcpy(to, v, 2 * sizeof *to);
    by_v[0] = by_v[3] = 1;
    return true;
  }
  const double along = (v[0] * h[0] + v[1] * h[1]) / hh;
  if (fabs(along) >= radius) {
    const double *corner = (along > 0) ? b : a;
    for (int i = 0; i < 2; i++) {
      by_radius[i] = corner[i];
      to[i] = radius * corner[i];
    }
    return false;
  }
  for (int i = 0; i < 2; i++) {
    to[i] = radius * m[i] + along * h[i];
    by_radius[i] = m[i];
    by_v[i] = h[i] * h[0] / hh;
    by_v[i + 2] = h[i] * h[1] / hh;
  }
  return false;
}

/* ---- folding --------------------------------------------------------------------------------- */

static bool is_faceted(const lcp_block *b) {
  return b->set == LCP_ORTHANT && b->n_part > 0;
}

/* Entry (i, j) of S; *others: count of the rest of the column that is not zero. */
static double shift_entry(const lcp_csc *S, int i, int j) {
  const lcp_column c = lcp_csc_column(S, j);
  for (int k = 0; k < c.count; k++) {
    if (c.row[k] == i) {
      return c.val[k];
    }
  }
  return 0;
}

/* Nothing of column j of S is left outside rows first .. first+count-1 and row `also`. */
static bool shift_within(const lcp_csc *S, int j, int first, int count, int also) {
  const lcp_column c = lcp_csc_column(S, j);
  for (int k = 0; k < c.count; k++) {
    if (c.val[k] != 0 && c.row[k] != also && (c.row[k] < first || c.row[k] >= first + count)) {
      return false;
    }
  }
  return true;
}

/* A part with its facets first .. first+count-1 and the row sigma; a, b, c as above. */
static bool read_part(const lcp_problem *p, const lcp_block *blk, int first, int count, int sigma,
                      double *mu, double *unit) {
  const lcp_csc *S = p->M.factored->shift;
  const double a = shift_entry(S, sigma, blk->start), b = -shift_entry(S, sigma, first);
  const double c = shift_entry(S, first, sigma);
  bool right = count >= 2 && a >= 0 && b > 0 && c > 0 && p->q[sigma] == 0 &&
               shift_within(S, sigma, first, count, -1);
  for (int k = first; k < first + count && right; k++) {
    right = shift_entry(S, sigma, k) == -b && shift_entry(S, k, sigma) == c &&
            shift_within(S, k, sigma, 1, -1);
  }
  *mu = right ? a / b : 0;
  *unit = c;
  return right;
}

/* The rows 0 .. count-1 of `facet` (each `dof` long) from the one or two of `base`: they must be what d_k says. */
static bool fold_rows(int count, int dof, const double *facet, double *base) {
  const int dim = (count > 2) ? 2 : 1;
  double d[2], top = 0;
  direction(count, 1, d);
  for (int i = 0; i < dof; i++) {
    base[i] = facet[i];
    if (dim == 2) {
      base[dof + i] = (facet[dof + i] - d[0] * facet[i]) / d[1];
    }
    top = fmax(top, fabs(facet[i]) + fabs(base[(dim - 1) * dof + i]));
  }
  for (int k = 0; k < count; k++) {
    direction(count, k, d);
    for (int i = 0; i < dof; i++) {
      const double is = d[0] * base[i] + ((dim == 2) ? d[1] * base[dof + i] : 0);
      if (!(fabs(facet[k * dof + i] - is) <= same * top)) {
        return false;
      }
    }
  }
  return true;
}

/* The rows of one side of a block, to `out`; returns the end, NULL where they do not fold. */
static double *fold_side(const lcp_block *b, int dof, const double *jac, double *out) {
  const int normal = is_faceted(b) ? 1 : b->size;
  memcpy(out, jac, (size_t)(normal * dof) * sizeof *out);
  out += normal * dof;
  jac += normal * dof;
  for (int k = 0; is_faceted(b) && k < b->n_part; k++) {
    if (!fold_rows(b->part_dim[k], dof, jac, out)) {
      return NULL;
    }
    jac += b->part_dim[k] * dof;
    out += ((b->part_dim[k] > 2) ? 2 : 1) * dof;
  }
  for (int i = 0; is_faceted(b) && i < b->n_part * dof; i++) {
    if (jac[i] != 0) { /* sigma moves nothing */
      return NULL;
    }
  }
  return out;
}

/* Block k of the problem as the cone `to`, with q; false where it is not of the kind above. */
static bool fold_block(lcp_fold *s, const lcp_block *b, lcp_block *to) {
  const lcp_problem *p = s->of;
  int first = b->start + 1, row = to->start + 1;
  s->q[to->start] = p->q[b->start];
  to->set = LCP_CONE;
  for (int k = 0; k < b->n_part; k++) {
    const int count = b->part_dim[k], dim = (count > 2) ? 2 : 1;
    const int sigma = b->start + b->size - b->n_part + k;
    if (!read_part(p, b, first, count, sigma, &to->part_mu[k], &s->unit[row]) ||
        !fold_rows(count, 1, p->q + first, s->q + row)) {
      return false;
    }
    to->part_dim[k] = dim;
    s->facets[row] = count;
    first += count;
    row += dim;
  }
  return true;
}

/* S of the rows that stay: of a folded block that of its normal row alone. */
static int fold_shift(lcp_fold *s, const lcp_block *b, const lcp_block *to, int at) {
  const lcp_csc *S = s->of->M.factored->shift;
  for (int j = 0; j < to->size; j++) {
    s->colptr[to->start + j] = at;
    const bool kept = !is_faceted(b) || j == 0;
    const lcp_column c = lcp_csc_column(S, b->start + j);
    for (int k = 0; kept && k < c.count; k++) {
      const int i = c.row[k] - b->start;
      if (!is_faceted(b) || i == 0) {
        s->rowind[at] = to->start + i;
        s->val[at++] = c.val[k];
      }
    }
  }
  return at;
}

/* Of a block that stays as it is S must stay inside; of one that folds, in its normal's column, the sigmas too. */
static bool shift_is_own(const lcp_problem *p, const lcp_block *b) {
  bool own = true;
  for (int j = b->start; j < b->start + b->size; j++) {
    own = own && shift_within(p->M.factored->shift, j, b->start, b->size, -1);
  }
  for (int i = b->start + 1; is_faceted(b) && own && i < b->start + b->size - b->n_part; i++) {
    own = shift_entry(p->M.factored->shift, i, b->start) == 0;
  }
  return own;
}

/* Blocks and vectors; returns the folded size, -1 where a block does not fold. */
static int fold_blocks(lcp_fold *s, const lcp_problem *p) {
  int n = 0, at = 0;
  for (int k = 0; k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    lcp_block *to = &s->block[k];
    *to = *b;
    to->start = n;
    to->size = lcp_block_folded(b);
    memset(s->facets + n, 0, (size_t)to->size * sizeof *s->facets);
    if (!shift_is_own(p, b) || (is_faceted(b) && !fold_block(s, b, to))) {
      return -1;
    }
    for (int i = 0; i < b->size && !is_faceted(b); i++) {
      s->q[n + i] = p->q[b->start + i];
      s->lo[n + i] = (b->set == LCP_BOX) ? p->lo[b->start + i] : 0;
      s->hi[n + i] = (b->set == LCP_BOX) ? p->hi[b->start + i] : 0;
    }
    at = fold_shift(s, b, to, at);
    n += to->size;
  }
  s->colptr[n] = at;
  return n;
}

/* Rows of J of group g, whose blocks are k .. *end-1; NULL where they do not fold. */
static double *fold_group(lcp_fold *s, const lcp_factored *f, int g, int k, int *end, double *out) {
  const lcp_block *block = s->of->block;
  double room[LCP_MIXED_MAX];
  const double *jac = lcp_factored_rows(f, g, room);
  for (int side = 0; side < 2; side++) {
    const int body = f->body[2 * (ptrdiff_t)g + side];
    const int dof = (body >= 0) ? f->dof_start[body + 1] - f->dof_start[body] : 0;
    *end = k;
    for (; *end < s->of->n_block && block[*end].start < f->row_start[g + 1]; (*end)++) {
      const lcp_block *b = &block[*end];
      out = (b->start + b->size <= f->row_start[g + 1]) ? fold_side(b, dof, jac, out) : NULL;
      if (out == NULL) {
        return NULL;
      }
      jac += (ptrdiff_t)b->size * dof;
    }
  }
  return out;
}

/* Rows of a mixture that are those of a normal, of `count` facets of two tangents or of one, and of a sigma that moves nothing. */
static bool is_regular(const lcp_mixture *m, int count) {
  const int dim = (count > 2) ? 2 : 1;
  bool right = m->stored == 1 + dim && m->rows == count + 2;
  for (int i = 0; i < m->rows && right; i++) {
    double d[2] = {0};
    if (i > 0 && i <= count) {
      direction(count, i - 1, d);
    }
    const double want[3] = {(i == 0) ? 1.0 : 0.0, d[0], d[1]};
    for (int k = 0; k < m->stored; k++) {
      right = right && fabs(m->c[i * m->stored + k] - want[k]) <= same;
    }
  }
  return right;
}

/* Where J has the rows of the cones already, it is used as it is: every group a block, whose facets are mixed from them. */
static bool share_jacobian(lcp_fold *s, const lcp_factored *f) {
  const lcp_mixture *known = NULL; /* that is regular */
  int at = 0, n = 0;
  s->mixed = false;
  if (f->mixture == NULL || f->n_group != s->of->n_block) {
    return false;
  }
  for (int g = 0; g < f->n_group; g++) {
    const lcp_block *b = &s->of->block[g];
    const lcp_mixture *m = f->mixture[g];
    const bool facets = is_faceted(b);
    if (b->start != f->row_start[g] || (facets && (m == NULL || b->n_part != 1)) ||
        (facets && m != known && !is_regular(m, b->part_dim[0]))) {
      return false;
    }
    known = facets ? m : known;
    s->mixture[g] = facets ? NULL : m;
    s->mixed = s->mixed || s->mixture[g] != NULL;
    s->row_start[g] = n;
    s->jac_start[g] = at;
    n += s->block[g].size;
    at += (f->jac_start[g + 1] - f->jac_start[g]) / b->size * s->block[g].size;
  }
  s->row_start[f->n_group] = n;
  s->jac_start[f->n_group] = at;
  return true;
}

static bool fold_jacobian(lcp_fold *s, const lcp_factored *f) {
  double *out = s->jac;
  for (int g = 0, k = 0, end = 0, n = 0; g < f->n_group; g++) {
    s->row_start[g] = n;
    s->jac_start[g] = (int)(out - s->jac);
    out = fold_group(s, f, g, k, &end, out);
    if (out == NULL) {
      return false;
    }
    for (; k < end; k++) {
      n += s->block[k].size;
    }
    s->row_start[g + 1] = n;
    s->jac_start[g + 1] = (int)(out - s->jac);
  }
  return true;
}

void lcp_fold_begin(lcp_fold *s, const lcp_problem *p) {
  bool any = false;
  s->done = false;
  s->of = p;
  if (p->M.storage != LCP_FACTORED || p->block == NULL || p->M.factored->shift == NULL) {
    return;
  }
  for (int k = 0; k < p->n_block; k++) {
    any = any || is_faceted(&p->block[k]);
  }
  const int n = any ? fold_blocks(s, p) : -1;
  const bool shared = n >= 0 && share_jacobian(s, p->M.factored);
  if (n < 0 || (!shared && !fold_jacobian(s, p->M.factored))) {
    return;
  }
  s->shift = (lcp_csc){n, n, s->colptr, s->rowind, s->val};
  s->factored = *p->M.factored;
  s->factored.row_start = s->row_start;
  s->factored.jac_start = s->jac_start;
  s->factored.mixture = (shared && s->mixed) ? s->mixture : NULL;
  if (!shared) {
    s->factored.jac = s->jac;
    s->factored.stored_start = NULL;
  }
  s->factored.shift = (s->colptr[n] > 0) ? &s->shift : NULL;
  s->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = n, .factored = &s->factored},
                       .q = s->q,
                       .lo = s->lo,
                       .hi = s->hi,
                       .block = s->block,
                       .n_block = p->n_block};
  s->done = true;
}

/* ---- answers --------------------------------------------------------------------------------- */

void lcp_fold_in(const lcp_fold *s, const double *z, double *x) {
  for (int k = 0; k < s->p.n_block; k++) {
    const lcp_block *b = &s->of->block[k], *to = &s->block[k];
    const int whole = is_faceted(b) ? 1 : b->size;
    memcpy(x + to->start, z + b->start, (size_t)whole * sizeof *x);
    int row = to->start + 1, first = b->start + 1;
    for (int part = 0; is_faceted(b) && part < b->n_part; part++) {
      double t[2] = {0}, d[2];
      for (int m = 0; m < b->part_dim[part]; m++) {
        direction(b->part_dim[part], m, d);
        t[0] += z[first + m] * d[0];
        t[1] += z[first + m] * d[1];
      }
      memcpy(x + row, t, (size_t)to->part_dim[part] * sizeof *x);
      row += to->part_dim[part];
      first += b->part_dim[part];
    }
  }
}

/* t as a sum of the two corners beside it. */
static void split(int f, const double *t, double *beta) {
  double a[2], b[2];
  memset(beta, 0, (size_t)f * sizeof *beta);
  if (f == 2) {
    beta[(t[0] < 0) ? 1 : 0] = fabs(t[0]);
    return;
  }
  const int k = sector(f, t);
  direction(f, k, a);
  direction(f, k + 1, b);
  const double det = a[0] * b[1] - a[1] * b[0];
  beta[k] = fmax((t[0] * b[1] - t[1] * b[0]) / det, 0.0);
  beta[(k + 1) % f] = fmax((a[0] * t[1] - a[1] * t[0]) / det, 0.0);
}

/* max_k(-d_k'u, 0). */
static double speed(int f, int dim, const double *u) {
  double most = 0, d[2];
  for (int k = 0; k < f; k++) {
    direction(f, k, d);
    most = fmax(most, -(d[0] * u[0] + ((dim == 2) ? d[1] * u[1] : 0)));
  }
  return most;
}

void lcp_fold_out_rows(const lcp_fold *s, const double *x, double *z) {
  for (int k = 0; k < s->p.n_block; k++) {
    const lcp_block *b = &s->of->block[k];
    const int whole = is_faceted(b) ? 1 : b->size;
    memset(z + b->start, 0, (size_t)b->size * sizeof *z);
    memcpy(z + b->start, x + s->block[k].start, (size_t)whole * sizeof *z);
  }
}

/* Friction t stays inside its polygon of this radius where the speed u pushes on: u counts as none. */
static bool sticks(int f, int dim, double radius, const double *t, const double *u,
                   const double *unit) {
  double p[2] = {0}, to[2], by_v[4], by_radius[2];
  for (int i = 0; i < dim; i++) {
    p[i] = t[i] - unit[i] * unit[i] * u[i];
  }
  return (dim == 1) ? fabs(p[0]) <= radius : lcp_polygon_project(f, radius, p, to, by_v, by_radius);
}

void lcp_fold_out(const lcp_fold *s, const double *x, const double *w, const double *unit,
                  double *z) {
  for (int k = 0; k < s->p.n_block; k++) {
    const lcp_block *b = &s->of->block[k], *to = &s->block[k];
    if (!is_faceted(b)) {
      memcpy(z + b->start, x + to->start, (size_t)b->size * sizeof *z);
      continue;
    }
    int row = to->start + 1, first = b->start + 1;
    z[b->start] = fmax(x[to->start], 0.0);
    for (int part = 0; part < b->n_part; part++) {
      const int f = b->part_dim[part], dim = to->part_dim[part];
      const double t[2] = {x[row], (dim == 2) ? x[row + 1] : 0};
      split(f, t, z + first);
      const bool stuck = sticks(f, dim, to->part_mu[part] * z[b->start], t, w + row, unit + row);
      z[b->start + b->size - b->n_part + part] =
          stuck ? 0.0 : speed(f, dim, w + row) / s->unit[row];
      row += dim;
      first += f;
    }
  }
}
