#include "lcp/solvers/cone_scaled.h"

#include "lcp/lcp_cone.h"
#include "lcp/solvers/sets.h"

void lcp_cone_scaled_layout(lcp_cone_scaled *c, const lcp_capacity *cap, base_arena *a) {
  c->piece = BASE_ARRAY(a, lcp_block, cap->n);
  c->s = BASE_ARRAY(a, double, cap->n);
  c->lo = BASE_ARRAY(a, double, cap->n);
  c->hi = BASE_ARRAY(a, double, cap->n);
  c->F = BASE_ARRAY(a, double, cap->n);
  c->X = BASE_ARRAY(a, double, 2 * (size_t)cap->n * (size_t)LCP_CONE_MAX);
}

/* One s for all rows of a part, that of the normal where none of them can move; mu scaled with them. */
static base_status scale_cone(lcp_cone_scaled *c, const lcp_problem *p, const lcp_block *b,
                              const double *d, int index, base_error *err) {
  lcp_block *piece = &c->piece[c->n_piece++];
  *piece = *b;
  if (b->size > LCP_CONE_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "cone block %d has %d rows: need at most %d", index,
                     b->size, (int)LCP_CONE_MAX);
  }
  c->wide = (b->size > c->wide) ? b->size : c->wide;
  for (int i = b->start; i < b->start + b->size; i++) {
    if (!(d[i] > 0.0) && !lcp_set_still(p, d[i], i)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "diagonal %d is %g: need > 0 in a cone", i, d[i]);
    }
  }
  c->s[b->start] = (d[b->start] > 0.0) ? 1.0 / sqrt(d[b->start]) : 1.0;
  for (int k = 0, at = b->start + 1; k < b->n_part; at += b->part_dim[k++]) {
    const double mean = (b->part_dim[k] == 2) ? 0.5 * (d[at] + d[at + 1]) : d[at];
    const double s = (mean > 0.0) ? 1.0 / sqrt(mean) : c->s[b->start];
    for (int i = at; i < at + b->part_dim[k]; i++) {
      c->s[i] = s;
    }
    piece->part_mu[k] *= c->s[b->start] / s;
  }
  return BASE_OK;
}

base_status lcp_cone_scaled_begin(lcp_cone_scaled *c, const lcp_problem *p, const double *d,
                                  const int *facets, base_error *err) {
  const lcp_block whole = {.start = 0, .size = p->M.n, .set = LCP_ORTHANT};
  const lcp_block *block = (p->block != NULL) ? p->block : &whole;
  const int count = (p->block != NULL) ? p->n_block : 1;
  lcp_set_scaling(&p->M, d, c->s);
  lcp_set_intervals(p, c->lo, c->hi);
  c->n_piece = 0;
  c->wide = 1;
  c->facets = facets;
  for (int k = 0; k < count; k++) {
    const lcp_block *b = &block[k];
    if (b->set == LCP_CONE) {
      BASE_TRY(scale_cone(c, p, b, d, k, err));
      continue;
    }
    for (int i = b->start; i < b->start + b->size; i++) {
      c->piece[c->n_piece++] = (lcp_block){.start = i, .size = 1, .set = b->set};
      c->lo[i] /= c->s[i];
      c->hi[i] /= c->s[i];
    }
  }
  c->Y = c->X + (size_t)p->M.n * (size_t)c->wide;
  return BASE_OK;
}

double lcp_cone_scaled_map(lcp_cone_scaled *c, lcp_map map, const double *x, const double *y,
                           bool slope) {
  double sum = 0.0;
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    const int i = b->start;
    const size_t at = lcp_cone_scaled_at(c, b);
    lcp_cone_map(map, b, (c->facets != NULL) ? c->facets + i : NULL, c->lo[i], c->hi[i], x + i,
                 y + i, c->F + i, slope ? c->X + at : NULL, slope ? c->Y + at : NULL);
    for (int r = i; r < i + b->size; r++) {
      sum += c->F[r] * c->F[r];
    }
  }
  return sum;
}

void lcp_cone_scaled_project(const lcp_cone_scaled *c, const double *z, double *to) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    const int i = b->start;
    if (b->set == LCP_CONE) { /* in x, where mu is scaled */
      double x[LCP_CONE_MAX];
      for (int r = 0; r < b->size; r++) {
        x[r] = z[i + r] / c->s[i + r];
      }
      lcp_cone_project(b, x, x);
      for (int r = 0; r < b->size; r++) {
        to[i + r] = x[r] * c->s[i + r];
      }
    } else {
      to[i] = lcp_set_clip(z[i], c->lo[i] * c->s[i], c->hi[i] * c->s[i]);
    }
  }
}
