#include "lcp/solvers/facet_batches.h"

#include <assert.h>
#include <float.h>
#include <string.h>

static const double rounding = 1e-13;        /* of rows, over the size of a facet */
static const double flat = 0.1;              /* least sine between the first two facets */
static const double noise = 8 * DBL_EPSILON; /* of a slack, over the sizes of its terms */

void lcp_facet_batches_layout(lcp_facet_batches *s, const lcp_capacity *cap, base_arena *a) {
  const bool any = cap->n_body > 0 && cap->nnz > 0; /* sigma stands in S */
  const size_t bodies = any ? (size_t)cap->n_body : 0;
  const size_t rows = any ? (size_t)cap->n : 0, contacts = rows / 5;
  s->lanes.batch = BASE_ARRAY(a, lcp_facet_batch, contacts);
  s->lanes.z = BASE_ARRAY(a, lcp_v4, rows);
  s->lanes.linear = BASE_ARRAY(a, lcp_v4, 4 * rows);
  s->lanes.body = BASE_ARRAY(a, double, 16 * lcp_batches_bodies(contacts, bodies));
  s->sigma = BASE_ARRAY(a, double, 2 * contacts);
  s->M = BASE_ARRAY(a, double, LEMKE_KEPT_MAX *LEMKE_KEPT_MAX);
  s->inverse = BASE_ARRAY(a, double, LEMKE_KEPT_MAX *LEMKE_KEPT_MAX);
  lcp_batches_layout(&s->in, contacts, bodies, a);
}

/* ---- does the problem have the form? --------------------------------------------------------- */

/* The frame (normal, first facet, the direction across it towards the second) over rows of the group. */
typedef struct axes {
  double unit, cosine, sine; /* length of a facet; the second one in the frame */
} axes;

/* Rows of one side in the frame, 3 x 6. */
static void turn_rows(const axes *x, const double *rows, double *out) {
  for (int i = 0; i < 6; i++) {
    out[i] = rows[i];
    out[6 + i] = rows[6 + i] / x->unit;
    out[12 + i] = (rows[12 + i] / x->unit - x->cosine * out[6 + i]) / x->sine;
  }
}

static double dot3(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool axes_of(const double *const side[2], axes *out) {
  const double *rows = (side[0] != NULL) ? side[0] : side[1];
  if (rows == NULL) {
    return false;
  }
  out->unit = sqrt(dot3(rows + 6, rows + 6));
  out->cosine = dot3(rows + 6, rows + 12) / (out->unit * out->unit);
  out->sine = sqrt(1.0 - out->cosine * out->cosine);
  return out->unit > 0.0 && out->sine > flat;
}

static bool frame_of(const lcp_factored *f, int g, axes *at, lcp_contact_frame *frame) {
  double turned[2][18], room[LCP_MIXED_MAX];
  const double *side[2], *rows[2] = {NULL, NULL};
  lcp_contact_rows(f, g, f->row_start[g + 1] - f->row_start[g], room, side);
  if (!axes_of(side, at)) {
    return false;
  }
  for (int s = 0; s < 2; s++) {
    if (side[s] != NULL) {
      turn_rows(at, side[s], turned[s]);
      rows[s] = turned[s];
    }
  }
  return lcp_contact_frame_of(rows, frame);
}

/* Facet k of group g in its frame. */
static void facet_of(const lcp_factored *f, int g, const lcp_contact_frame *frame, int k,
                     double *facet) {
  double room[LCP_MIXED_MAX];
  const double *side[2];
  lcp_contact_rows(f, g, f->row_start[g + 1] - f->row_start[g], room, side);
  for (int i = 0; i < 2; i++) {
    facet[i] = (side[0] != NULL) ? dot3(side[0] + 6 * (1 + k), frame->d[1 + i])
                                 : -dot3(side[1] + 6 * (1 + k), frame->d[1 + i]);
  }
}

/* Is row 1 + k of the group the facet (c, s) of the frame, on both sides, and q with it? */
static bool is_facet(const lcp_problem *p, int g, const axes *at, int k, const double *facet) {
  const lcp_factored *f = p->M.factored;
  double room[LCP_MIXED_MAX];
  const double *side[2], *q = p->q + f->row_start[g];
  const double q1 = q[1] / at->unit, q2 = (q[2] / at->unit - at->cosine * q1) / at->sine;
  bool good = fabs(q[1 + k] - (facet[0] * q1 + facet[1] * q2)) <=
              rounding * at->unit * (fabs(q1) + fabs(q2));
  lcp_contact_rows(f, g, f->row_start[g + 1] - f->row_start[g], room, side);
  for (int s = 0; s < 2 && good; s++) {
    double turned[18], size = 0.0;
    if (side[s] == NULL) {
      continue;
    }
    turn_rows(at, side[s], turned);
    for (int i = 6; i < 18; i++) {
      size = fmax(size, fabs(turned[i]));
    }
    for (int i = 0; i < 6 && good; i++) {
      const double want = facet[0] * turned[6 + i] + facet[1] * turned[12 + i];
      good = fabs(side[s][6 * (1 + k) + i] - want) <= rounding * at->unit * size;
    }
  }
  return good;
}

/* The row of sigma moves no body, and q has nothing there. */
static bool is_slip_row(const lcp_problem *p, int g) {
  const lcp_factored *f = p->M.factored;
  const int rows = f->row_start[g + 1] - f->row_start[g];
  double room[LCP_MIXED_MAX];
  const double *side[2];
  bool good = p->q[f->row_start[g + 1] - 1] == 0.0;
  lcp_contact_rows(f, g, rows, room, side);
  for (int i = 6 * (rows - 1); i < 6 * rows; i++) {
    good = good && (side[0] == NULL || side[0][i] == 0.0) && (side[1] == NULL || side[1][i] == 0.0);
  }
  return good;
}

/* alpha and alpha mu of a group's columns of S; false where S is not that of sigma. */
static bool sigma_of(const lcp_csc *S, int first, int m, double *sigma) {
  const int last = first + m - 1;
  lcp_column c = lcp_csc_column(S, last);
  bool good = c.count == m - 2;
  sigma[0] = good ? c.val[0] : 0.0;
  for (int k = 0; good && k < m - 2; k++) {
    good = c.row[k] == first + 1 + k && c.val[k] == sigma[0];
  }
  for (int k = 0; good && k < m - 1; k++) {
    c = lcp_csc_column(S, first + k);
    good = c.count == 1 && c.row[0] == last && (k == 0 || c.val[0] == -sigma[0]);
    sigma[1] = (good && k == 0) ? c.val[0] : sigma[1];
  }
  return good && sigma[0] > 0.0 && sigma[1] > 0.0;
}

static bool admits_group(lcp_facet_batches *s, const lcp_problem *p, int g) {
  const lcp_factored *f = p->M.factored;
  const lcp_block *b = &p->block[g];
  const int m = s->lanes.facets + 2;
  axes at;
  lcp_contact_frame frame;
  bool good = b->set == LCP_ORTHANT && b->start == f->row_start[g] && b->size == m &&
              f->row_start[g + 1] - f->row_start[g] == m && f->body[2 * g] != f->body[2 * g + 1] &&
              is_slip_row(p, g) && sigma_of(f->shift, b->start, m, s->sigma + 2 * (ptrdiff_t)g) &&
              frame_of(f, g, &at, &frame);
  for (int k = 0; good && k < m - 2; k++) {
    if (g == 0) {
      facet_of(f, g, &frame, k, s->lanes.facet[k]);
    }
    good = is_facet(p, g, &at, k, s->lanes.facet[k]);
  }
  return good;
}

static bool admits(lcp_facet_batches *s, const lcp_gs *gs, const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  bool good = p->M.storage == LCP_FACTORED && f->shift != NULL && f->n_group > 0 && gs->by_block &&
              p->n_block == f->n_group && lcp_contact_rigid(f);
  s->lanes.facets = good ? f->row_start[1] - 2 : 0;
  good = good && s->lanes.facets >= 3 && s->lanes.facets <= LCP_FACETS_MAX;
  for (int g = 0; good && g < f->n_group; g++) {
    good = admits_group(s, p, g);
  }
  return good;
}

/* ---- one contact ------------------------------------------------------------------------------- */

/* Column i of the 3 x m map from unknowns to impulses; its transpose takes velocities to rows. */
static void direction(const lcp_facet_lanes *s, int i, double *d) {
  const bool facet = i > 0 && i <= s->facets;
  d[0] = (i == 0) ? 1.0 : 0.0;
  d[1] = facet ? s->facet[i - 1][0] : 0.0;
  d[2] = facet ? s->facet[i - 1][1] : 0.0;
}

/* M_bb of the contact in a lane. */
static void block_matrix(lcp_facet_batches *s, int batch, int l) {
  static const int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  const lcp_facet_batch *c = &s->lanes.batch[batch];
  const double *sigma = s->sigma + 2 * (ptrdiff_t)s->in.order[LCP_LANES * batch + l];
  const int m = s->lanes.facets + 2;
  for (int j = 0; j < m; j++) {
    double d[3], moved[3] = {0}, e[3];
    direction(&s->lanes, j, d);
    for (int i = 0; i < 3; i++) {
      for (int k = 0; k < 3; k++) {
        moved[i] += c->A[at[i][k]][l] * d[k];
      }
    }
    for (int i = 0; i < m; i++) {
      direction(&s->lanes, i, e);
      s->M[i + j * m] = dot3(e, moved);
    }
    s->M[m - 1 + j * m] = (j == 0) ? sigma[1] : (j < m - 1) ? -sigma[0] : 0.0;
  }
  for (int i = 1; i < m - 1; i++) {
    s->M[i + (m - 1) * m] = sigma[0];
  }
}

/* The rows over b of the basis: x_B = -M_BB^-1 d_B b, the slacks (d + M x) b. NaN, which no test passes, where the basis is
 * singular. s->M is the block. */
static void keep(lcp_facet_batches *s, int batch, int l, unsigned basis) {
  const int m = s->lanes.facets + 2;
  lcp_v4 *linear = s->lanes.linear + (ptrdiff_t)(4 * m) * batch;
  int row[LEMKE_KEPT_MAX] = {0}, k = 0;
  double x[LEMKE_KEPT_MAX][3] = {{0}}, d[3];
  for (int i = 0; i < m; i++) {
    row[k] = i;
    k += (int)((basis >> i) & 1);
  }
  const bool regular = lemke_block_invert(k, row, m, s->M, s->inverse);
  for (int j = 0; j < k && regular; j++) {
    direction(&s->lanes, row[j], d);
    for (int i = 0; i < k; i++) {
      for (int a = 0; a < 3; a++) {
        x[row[i]][a] -= s->inverse[i + j * k] * d[a];
      }
    }
  }
  for (int i = 0; i < m; i++) {
    const bool basic = ((basis >> i) & 1) != 0;
    double largest = 0.0;
    direction(&s->lanes, i, d);
    for (int a = 0; a < 3; a++) {
      double slack = d[a], size = fabs(d[a]);
      for (int j = 0; j < k; j++) {
        const double term = s->M[i + row[j] * m] * x[row[j]][a];
        slack += term;
        size += fabs(term);
      }
      largest = fmax(largest, size);
      linear[4 * i + a][l] = !regular ? (double)NAN : basic ? x[i][a] : slack;
    }
    linear[4 * i + 3][l] = basic ? 0.0 : noise * largest;
  }
  s->lanes.batch[batch].basis[l] = basis;
}

/* b_n >= 0: no impulse; sigma covers the fastest approach to a facet, which is basic with it. */
static unsigned leave_open(const lcp_facet_batches *s, int batch, int l, const double *b,
                           lcp_v4 *x) {
  const int m = s->lanes.facets + 2;
  const double alpha = s->sigma[2 * (ptrdiff_t)s->in.order[LCP_LANES * batch + l]];
  double low = 0.0, d[3];
  int worst = 0;
  for (int i = 0; i < m; i++) {
    direction(&s->lanes, i, d);
    const double w = d[1] * b[1] + d[2] * b[2];
    worst = (w < low) ? i : worst;
    low = (w < low) ? w : low;
    x[i][l] = 0.0;
  }
  x[m - 1][l] = -low / alpha;
  return (worst > 0) ? 1u << worst | 1u << (m - 1) : 0u;
}

static void resolve(void *context, int batch, int l, const lcp_v4 *lanes, lcp_v4 *x) {
  lcp_facet_batches *s = context;
  const int m = s->lanes.facets + 2;
  const double b[3] = {lanes[0][l], lanes[1][l], lanes[2][l]};
  double q[LEMKE_KEPT_MAX], found[LEMKE_KEPT_MAX] = {0}, d[3];
  unsigned basis = 0;
  block_matrix(s, batch, l);
  if (b[0] >= 0.0) {
    keep(s, batch, l, leave_open(s, batch, l, b, x));
    return;
  }
  for (int i = 0; i < m; i++) {
    direction(&s->lanes, i, d);
    q[i] = dot3(d, b);
  }
  const bool solved = lemke_block_solve(s->lemke, m, s->M, q, found);
  s->rays += !solved;
  for (int i = 0; i < m; i++) {
    x[i][l] = solved ? found[i] : s->lanes.z[(ptrdiff_t)m * batch + i][l];
    basis |= (unsigned)(solved && s->lemke->path.in_z[i] != 0) << i;
  }
  if (solved) {
    keep(s, batch, l, basis);
  }
}

/* ---- records ----------------------------------------------------------------------------------- */

/* A of the frame from M of the rows (normal, first facet, second facet). */
static void turn_block(const axes *at, const double *B, double A[6]) {
  const double T[3][3] = {{1.0, 0.0, 0.0},
                          {0.0, 1.0 / at->unit, 0.0},
                          {0.0, -at->cosine / (at->sine * at->unit), 1.0 / (at->sine * at->unit)}};
  for (int i = 0, k = 0; i < 3; i++) {
    for (int j = i; j < 3; j++, k++) {
      A[k] = 0.0;
      for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++) {
          A[k] += T[i][a] * B[a + 3 * b] * T[j][b];
        }
      }
    }
  }
}

static void record(lcp_facet_batches *s, const lcp_gs *gs, const lcp_problem *p, int k) {
  const lcp_factored *f = p->M.factored;
  lcp_facet_batch *c = &s->lanes.batch[k / LCP_LANES];
  const int l = k % LCP_LANES, g = s->in.order[k], m = s->lanes.facets + 2;
  lcp_v4 *linear = s->lanes.linear + (ptrdiff_t)(4 * m) * (k / LCP_LANES);
  double A[6] = {0}, B[9], q[3] = {0};
  lcp_contact_frame frame;
  axes at;
  if (g >= 0) {
    const double *from = p->q + f->row_start[g];
    (void)frame_of(f, g, &at, &frame); /* admitted */
    lcp_sweep_block(&gs->sweep, p, f->row_start[g], 3, B);
    turn_block(&at, B, A);
    q[0] = from[0];
    q[1] = from[1] / at.unit;
    q[2] = (from[2] / at.unit - at.cosine * q[1]) / at.sine;
  }
  lcp_contact_place(&c->at, k, f, g, (g >= 0) ? &frame : NULL, NULL);
  for (int i = 0; i < 6; i++) {
    c->A[i][l] = A[i];
  }
  for (int i = 0; i < 3; i++) {
    c->q[i][l] = q[i];
  }
  c->basis[l] = 0; /* of an idle lane the solution: all slacks are zero */
  for (int i = 0; i < 4 * m; i++) {
    linear[i][l] = (g >= 0) ? (double)NAN : 0.0;
  }
}

bool lcp_facet_batches_prepare(lcp_facet_batches *s, lcp_gs *gs, const lcp_problem *p) {
  s->in.n_contact = 0;
  if (!admits(s, gs, p)) {
    return false;
  }
  s->lemke = &gs->lemke;
  lcp_contact_bodies(p->M.factored, s->lanes.body);
  lcp_batches_order(&s->in, p->M.factored);
  s->lanes.n_batch = s->in.n_batch;
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    record(s, gs, p, k);
  }
  return true;
}

/* The basis of a contact is that of the z_i > 0; of an open one, where only sigma is, the one that is kept where it is open
 * too: sigma is unique. */
static bool is_kept(const lcp_facet_batches *s, unsigned kept, unsigned basis) {
  const unsigned slip = 1u << (s->lanes.facets + 1);
  return kept == basis || (basis == slip && (kept & slip) != 0 && (kept & 1u) == 0);
}

static void import(lcp_facet_batches *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  const int m = s->lanes.facets + 2;
  assert(lcp_batches_are_partitioned(&s->in, f));
  lcp_contact_stop_bodies(f, s->lanes.body);
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    const int l = k % LCP_LANES, batch = k / LCP_LANES, g = s->in.order[k];
    lcp_v4 *to = s->lanes.z + (ptrdiff_t)m * batch;
    unsigned basis = 0;
    for (int i = 0; i < m; i++) {
      to[i][l] = (g >= 0) ? z[f->row_start[g] + i] : 0.0;
      basis |= (unsigned)(to[i][l] > 0.0) << i;
    }
    if (g >= 0 && !is_kept(s, (unsigned)s->lanes.batch[batch].basis[l], basis)) {
      block_matrix(s, batch, l);
      keep(s, batch, l, basis);
    }
  }
  lcp_facet_kernel_push(&s->lanes);
}

void lcp_facet_batches_run(lcp_facet_batches *s, const lcp_problem *p, long sweeps, double *z) {
  const lcp_factored *f = p->M.factored;
  const int m = s->lanes.facets + 2;
  s->rays = 0;
  import(s, p, z);
  for (long k = 0; k < sweeps; k++) {
    lcp_facet_kernel_sweep(&s->lanes, resolve, s);
  }
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    const int g = s->in.order[k];
    for (int i = 0; g >= 0 && i < m; i++) {
      z[f->row_start[g] + i] = s->lanes.z[(ptrdiff_t)m * (k / LCP_LANES) + i][k % LCP_LANES];
    }
  }
}
