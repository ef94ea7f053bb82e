/* lcp_judge.c - the independent residuals, accumulated in long double.
 *
 * Scales, products and terms are coded here once more although lcp_rho.h has them: a judge that shared the
 * arithmetic of the solvers would repeat their errors and confirm them. Of the solvers' headers this file
 * includes none (scripts/check_layers.sh); what both rest on is the problem itself and the geometry of its cone. */
#include "lcp/lcp_judge.h"

#include "lcp/base/crew.h"
#include "lcp/lcp_cone.h"
#include "lcp/lcp_wide_column.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

typedef struct judge {
  const lcp_problem *p;
  const double *z;
  lcp_wide_columns columns;    /* of M, in long double; a factored M is never formed */
  long double *w, *tau, *zref; /* n; tau and zref of tiny entries leave the range of double */
  long double *tau0;           /* n */
  double *d;                   /* n */
  double *r;                   /* n, r_i^2 M_ii = 1 */
} judge;

static bool judge_open(judge *j, const lcp_problem *p, const double *z) {
  const size_t n = (size_t)p->M.n + 1;
  *j = (judge){.p = p, .z = z};
  j->w = calloc(n, sizeof *j->w);
  j->tau = calloc(n, sizeof *j->tau);
  j->zref = calloc(n, sizeof *j->zref);
  j->tau0 = calloc(n, sizeof *j->tau0);
  j->d = calloc(n, sizeof *j->d);
  j->r = calloc(n, sizeof *j->r);
  return j->w != NULL && j->tau != NULL && j->zref != NULL && j->tau0 != NULL && j->d != NULL &&
         j->r != NULL;
}

static void judge_close(judge *j) {
  lcp_wide_columns_close(&j->columns);
  free(j->w);
  free(j->tau);
  free(j->zref);
  free(j->tau0);
  free(j->d);
  free(j->r);
}

/* w += M z, tau += |M| |z|, the diagonal. */
static void add_products(judge *j) {
  const int n = j->p->M.n;
  if (j->p->M.storage == LCP_FACTORED) {
    for (int i = 0; i < n; i++) {
      j->zref[i] = fabs(j->z[i]);
    }
    lcp_wide_factored_product(&j->columns, j->z, j->w);
    lcp_wide_factored_sizes(&j->columns, j->zref, j->tau);
    lcp_wide_factored_diagonal(&j->columns, j->d);
    return;
  }
  for (int c = 0; c < n; c++) {
    const lcp_wide_column col = lcp_wide_columns_at(&j->columns, c);
    for (int k = 0; k < col.count; k++) {
      const long double term = col.val[k] * j->z[c];
      j->w[col.row[k]] += term;
      j->tau[col.row[k]] += fabsl(term);
      if (col.row[k] == c) {
        j->d[c] = (double)col.val[k];
      }
    }
  }
}

/* zref of a variable: what moves its own row by |M| |z| + |q|, which is in tau, or where that has none of it the first
 * other one; 1 where none has. */
static long double reference(judge *j, int c) {
  if (j->d[c] != 0.0) {
    return j->tau[c] / fabsl((long double)j->d[c]);
  }
  const lcp_wide_column col = lcp_wide_columns_at(&j->columns, c);
  long double ref = 0.0L;
  bool empty = true;
  for (int k = 0; k < col.count; k++) {
    if (col.val[k] != 0.0L) {
      empty = false;
      ref = fmaxl(ref, j->tau[col.row[k]] / fabsl(col.val[k]));
    }
  }
  return empty ? 1.0L : ref;
}

static void begin_sizes(judge *j) {
  for (int i = 0; i < j->p->M.n; i++) {
    j->tau[i] = fabsl((long double)j->p->q[i]);
  }
}

static void raise_top(judge *j, int i, int k, long double entry) {
  if (!(j->d[i] > 0.0) && j->d[k] > 0.0) {
    j->r[i] = fmax(j->r[i], (double)fabsl(entry) / sqrt(j->d[k]));
  }
}

/* r_i = 1 / sqrt(M_ii); where that gives no unit, from the largest |M_ij| / sqrt(M_jj) of row and column i, or 1. Of factors a zero on
 * the diagonal is a zero row of J W J': S alone counts there. */
static void set_units(judge *j) {
  const int n = j->p->M.n;
  bool all = true;
  for (int i = 0; i < n; i++) {
    j->r[i] = 0.0;
    all = all && j->d[i] > 0.0;
  }
  for (int c = 0; c < n && !all; c++) {
    if (j->p->M.storage == LCP_FACTORED && j->d[c] > 0.0) {
      continue;
    }
    const lcp_wide_column col = lcp_wide_columns_at(&j->columns, c);
    for (int k = 0; k < col.count; k++) {
      raise_top(j, col.row[k], c, col.val[k]);
      raise_top(j, c, col.row[k], col.val[k]);
    }
  }
  for (int i = 0; i < n; i++) {
    const double top = (j->d[i] > 0.0) ? sqrt(j->d[i]) : j->r[i];
    j->r[i] = (top > 0.0) ? 1.0 / top : 1.0;
  }
}

/* w = M z + q, the diagonal, zref, tau = |M| zref + |q|: two passes over M. */
static void measure(judge *j) {
  const int n = j->p->M.n;
  for (int i = 0; i < n; i++) {
    j->w[i] = j->p->q[i];
  }
  begin_sizes(j);
  add_products(j);
  for (int c = 0; c < n; c++) {
    j->tau0[c] = j->tau[c];
    j->zref[c] = reference(j, c);
  }
  set_units(j);
  begin_sizes(j);
  if (j->p->M.storage == LCP_FACTORED) {
    lcp_wide_factored_sizes(&j->columns, j->zref, j->tau);
    return;
  }
  for (int c = 0; c < n; c++) {
    const lcp_wide_column col = lcp_wide_columns_at(&j->columns, c);
    for (int k = 0; k < col.count; k++) {
      j->tau[col.row[k]] += fabsl(col.val[k]) * j->zref[c];
    }
  }
}

/* x / scale where a zero scale means that nothing but zero can stand above it. */
static double ratio(double x, long double scale) {
  if (scale > 0.0L) {
    return (double)(x / scale);
  }
  return (x == 0.0) ? 0.0 : copysign(HUGE_VAL, x);
}

static double clip(double x, double lo, double hi) {
  return fmin(fmax(x, lo), hi);
}

/* |natural map| of one orthant, box or free row with variable x and residual y in like units. */
static double row_map(lcp_set set, double x, double y, double lo, double hi) {
  switch (set) {
  case LCP_FREE:
    return fabs(y);
  case LCP_BOX:
    return fabs(x - clip(x - y, lo, hi));
  default:
    return fabs(fmin(x, y));
  }
}

static void note_natural(lcp_verdict *v, double map, int row) {
  if (map > v->natural) {
    v->natural = map;
    v->natural_row = row;
  }
}

/* Of a row or a cone whose map is `seen`, in velocities. */
static void note_defect(lcp_verdict *v, double r, double seen, long double tau0) {
  const double noise = (double)(32 * (long double)DBL_EPSILON * r * tau0);
  v->noise = fmax(v->noise, noise);
  v->defect = fmax(v->defect, r * seen);
}

static void judge_row(const judge *j, lcp_set set, int i, lcp_verdict *v) {
  const double z = j->z[i], w = (double)j->w[i];
  const long double zref = j->zref[i], tau = j->tau[i];
  const double d = (j->d[i] > 0.0) ? j->d[i] : 1.0;
  const double lo = (set == LCP_BOX) ? j->p->lo[i] : 0.0;
  const double hi = (set == LCP_BOX) ? j->p->hi[i] : HUGE_VAL;
  v->rho =
      fmax(v->rho, row_map(set, ratio(z, zref), ratio(w, tau), ratio(lo, zref), ratio(hi, zref)));
  note_natural(v, row_map(set, d * z, w, d * lo, d * hi), i);
  const double r = j->r[i], own = 1.0 / r / r;
  note_defect(v, r, row_map(set, own * z, w, own * lo, own * hi), j->tau0[i]);
  v->min_map = fmax(v->min_map, row_map(set, z, w, lo, hi));
  if (set == LCP_FREE) {
    v->infeasible_w = fmax(v->infeasible_w, fabs(w));
    return;
  }
  v->infeasible_z = fmax(v->infeasible_z, fmax(lo - z, z - hi));
  v->infeasible_w = fmax(v->infeasible_w, (set == LCP_ORTHANT) ? -w : 0.0);
  v->comp += (set == LCP_ORTHANT) ? fabs(z * w) : 0.0;
}

enum { CONE_ROWS_MAX = 1 + 2 * LCP_PARTS_MAX };

static void judge_cone(const judge *j, const lcp_block *b, lcp_verdict *v) {
  double w[CONE_ROWS_MAX] = {0}, moved[CONE_ROWS_MAX], plain[CONE_ROWS_MAX];
  double d = 0.0, work = 0.0, worst = 0.0;
  long double tau = 0.0L, tau0 = 0.0L;
  const double *z = j->z + b->start;
  for (int i = 0; i < b->size; i++) {
    w[i] = (double)j->w[b->start + i];
    d += j->d[b->start + i] / b->size;
    tau = fmaxl(tau, j->tau[b->start + i]);
    tau0 = fmaxl(tau0, j->tau0[b->start + i]);
  }
  v->infeasible_w = fmax(v->infeasible_w, -w[0]);
  w[0] += lcp_cone_shift(b, w);
  d = (d > 0.0) ? d : 1.0;
  for (int i = 0; i < b->size; i++) {
    moved[i] = d * z[i] - w[i];
    plain[i] = z[i] - w[i];
    work += z[i] * w[i];
  }
  lcp_cone_project(b, moved, moved);
  lcp_cone_project(b, plain, plain);
  for (int i = 0; i < b->size; i++) {
    worst = fmax(worst, fabs(d * z[i] - moved[i]));
    note_natural(v, fabs(d * z[i] - moved[i]), b->start + i);
    v->rho = fmax(v->rho, ratio(fabs(d * z[i] - moved[i]), tau));
    v->min_map = fmax(v->min_map, fabs(z[i] - plain[i]));
  }
  note_defect(v, 1.0 / sqrt(d), worst, tau0);
  v->infeasible_z = fmax(v->infeasible_z, lcp_cone_violation(b, z));
  v->comp += fabs(work);
}

enum { SHARE = 256 }; /* blocks, or rows, of one part of the work */

typedef struct verdicts {
  const judge *j;
  lcp_verdict *part;
} verdicts;

/* Some blocks of the problem; some rows where it has none. */
static void share_verdict(void *of, int part, int hand) {
  const verdicts *s = of;
  const lcp_problem *p = s->j->p;
  lcp_verdict *v = &s->part[part];
  const bool blocks = p->block != NULL;
  (void)hand;
  for (int k = part * SHARE; k < base_part_end(part, blocks ? p->n_block : p->M.n, SHARE); k++) {
    if (!blocks) {
      judge_row(s->j, LCP_ORTHANT, k, v);
      continue;
    }
    const lcp_block *b = &p->block[k];
    if (b->set == LCP_CONE) {
      judge_cone(s->j, b, v);
      continue;
    }
    for (int i = b->start; i < b->start + b->size; i++) {
      judge_row(s->j, b->set, i, v);
    }
  }
}

static void add_verdict(lcp_verdict *v, const lcp_verdict *part) {
  v->rho = fmax(v->rho, part->rho);
  note_natural(v, part->natural, part->natural_row);
  v->defect = fmax(v->defect, part->defect);
  v->noise = fmax(v->noise, part->noise);
  v->min_map = fmax(v->min_map, part->min_map);
  v->infeasible_z = fmax(v->infeasible_z, part->infeasible_z);
  v->infeasible_w = fmax(v->infeasible_w, part->infeasible_w);
  v->comp += part->comp;
}

/* What the data ask for: the largest velocity that is to be stopped, or bound that is to be met, in the units of r. */
static double size_of(const judge *j) {
  const lcp_problem *p = j->p;
  double size = 0.0;
  for (int i = 0; i < p->M.n; i++) {
    size = fmax(size, j->r[i] * fabs(p->q[i]));
  }
  for (int b = 0; p->block != NULL && b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    for (int i = k->start; k->set == LCP_BOX && i < k->start + k->size; i++) {
      size = fmax(size, fabs(clip(0.0, p->lo[i], p->hi[i])) / j->r[i]);
    }
  }
  return size;
}

bool lcp_judged_small(const lcp_verdict *v, double tol) {
  return v->defect <= 10.0 * tol + fmin(v->noise, 1e-3);
}

static bool judge_all(const judge *j, lcp_verdict *v) {
  const lcp_problem *p = j->p;
  const int parts = base_parts((p->block != NULL) ? p->n_block : p->M.n, SHARE);
  double q_max = 0.0;
  verdicts s = {j, calloc((size_t)parts + 1, sizeof *s.part)};
  if (s.part == NULL) {
    return false;
  }
  base_share(parts, share_verdict, &s);
  for (int k = 0; k < parts; k++) {
    add_verdict(v, &s.part[k]);
  }
  free(s.part);
  for (int i = 0; i < p->M.n; i++) {
    q_max = fmax(q_max, fabs(p->q[i]));
  }
  v->natural_rel = v->natural / (1.0 + q_max);
  const double size = size_of(j);
  v->defect = (size > 0.0) ? v->defect / size : 0.0;
  v->noise = (size > 0.0) ? v->noise / size : 0.0;
  return true;
}

/* Every residual is without bound: of a point that is not finite, or whose w leaves the range of double, or a scale that of
 * long double, where fmin and fmax would drop a NaN and call it zero. */
static const lcp_verdict hopeless = {.rho = HUGE_VAL,
                                     .natural = HUGE_VAL,
                                     .defect = HUGE_VAL,
                                     .noise = HUGE_VAL,
                                     .natural_rel = HUGE_VAL,
                                     .min_map = HUGE_VAL,
                                     .infeasible_z = HUGE_VAL,
                                     .infeasible_w = HUGE_VAL,
                                     .comp = HUGE_VAL};

static bool in_range(const judge *j) {
  for (int i = 0; i < j->p->M.n; i++) {
    if (!isfinite((double)j->w[i]) || !isfinite(j->tau[i]) || !isfinite(j->zref[i])) {
      return false;
    }
  }
  return true;
}

base_status lcp_judge(const lcp_problem *p, const double *z, lcp_verdict *out, base_error *err) {
  *out = (lcp_verdict){.finite = true};
  for (int i = 0; i < p->M.n; i++) {
    if (!isfinite(z[i])) {
      *out = hopeless;
      return BASE_OK;
    }
  }
  judge j;
  base_status s = BASE_OK;
  if (!judge_open(&j, p, z)) {
    s = BASE_FAIL(err, BASE_ENOMEM, "judge: no memory for %d rows", p->M.n);
  } else {
    s = lcp_wide_columns_open(&j.columns, &p->M, err);
  }
  if (s == BASE_OK) {
    measure(&j);
    if (!in_range(&j)) {
      *out = hopeless;
      out->finite = true;
    } else if (!judge_all(&j, out)) {
      s = BASE_FAIL(err, BASE_ENOMEM, "judge: no memory for %d rows", p->M.n);
    }
  }
  judge_close(&j);
  return s;
}
