/* ppm_basis.c - the basis of ppm: F gains and loses rows, and a row outside it drives. */
#include "lcp/lcp_column.h"
#include "lcp/solvers/ppm/ppm.h"

const lcp_ppm_share lcp_ppm_relative = {.rank = 2e-13, .faint = 1e-12};

/* x = M_Fr by place in F. */
static void gather(const ppm *s, const lcp_matrix *M, int r, double *x) {
  if (M->storage == LCP_FACTORED) {
    lcp_ppm_gather_factored(s, M->factored, r, x);
    return;
  }
  const lcp_column c = lcp_column_of(M, r);
  if (c.row == NULL) {
    for (int k = 0; k < s->m; k++) {
      x[k] = c.val[s->order[k]];
    }
    return;
  }
  for (int k = 0; k < s->m; k++) {
    x[k] = 0;
  }
  for (int k = 0; k < c.count; k++) {
    const int at = s->pos[c.row[k]];
    if (at >= 0) {
      x[at] = c.val[k];
    }
  }
}

double lcp_ppm_violation(const ppm *s, int i) {
  if (s->is_free[i] || s->where[i] == INSIDE) {
    return fabs(s->w[i]);
  }
  return (s->where[i] == AT_HI) ? s->w[i] : -s->w[i];
}

void lcp_ppm_leave(ppm *s, double *z, int k, place where) {
  const int out = s->order[k];
  z[out] = (where == AT_LO) ? s->lo[out] : s->hi[out];
  s->e[out] = 0;
  s->where[out] = (unsigned char)where;
  lin_chol_remove(s->L, s->m, k, s->cs);
  s->m--;
  for (int j = k; j < s->m; j++) {
    s->order[j] = s->order[j + 1];
    s->pos[s->order[j]] = j;
  }
  s->pos[out] = -1;
}

int lcp_ppm_first_block(const ppm *s, const double *z, double top, double sign, double *step) {
  for (int k = 0; k < s->m; k++) {
    top = fmax(top, fabs(s->y[k]) * s->unit[s->order[k]]);
  }
  int best = -1;
  double size = 0;
  for (int k = 0; k < s->m; k++) {
    const int i = s->order[k];
    const double rate = sign * s->y[k];
    const double scaled = fabs(rate) * s->unit[i];
    const double room = (rate < 0) ? (z[i] - s->lo[i]) + s->e[i] : (s->hi[i] - z[i]) - s->e[i];
    if (s->is_free[i] || !(scaled > lcp_ppm_relative.faint * top) || room == HUGE_VAL) {
      continue;
    }
    const double t = fmax(room, 0.0) / fabs(rate);
    if (best < 0 || t < *step || (t == *step && scaled > size)) {
      best = k;
      *step = t;
      size = scaled;
    }
  }
  return best;
}

static void advance(const ppm *s, double *x, int r, double move) {
  for (int k = 0; k < s->m; k++) {
    x[s->order[k]] += move * s->y[k];
  }
  x[r] += move;
}

double lcp_ppm_direction(ppm *s, const lcp_matrix *M, int r, lcp_work *work) {
  gather(s, M, r, s->x);
  lin_chol_forward(s->L, s->m, s->x);
  double schur = s->d[r];
  for (int k = 0; k < s->m; k++) {
    schur -= s->x[k] * s->x[k];
    s->y[k] = -s->x[k];
  }
  lin_chol_backward(s->L, s->m, s->y);
  work->backsolves += 2;
  work->pivots++;
  return schur;
}

void lcp_ppm_enter(ppm *s, int r, double root) {
  lin_chol_append(s->L, s->m, s->x, root);
  s->order[s->m] = r;
  s->pos[r] = s->m++;
  s->where[r] = BASIC;
}

lcp_ppm_end lcp_ppm_drive(ppm *s, const lcp_problem *p, double *z, double *x, int r, long limit,
                          lcp_work *work) {
  const double sign = (s->w[r] < 0) ? 1 : -1;
  for (;;) {
    if (work->pivots >= limit) {
      return LCP_PPM_SPENT;
    }
    const double schur = lcp_ppm_direction(s, &p->M, r, work);
    const bool positive = schur > lcp_ppm_relative.rank * fabs(s->d[r]) && s->m < s->m_max;
    const double own = (sign > 0) ? s->hi[r] - z[r] : z[r] - s->lo[r];
    double t = HUGE_VAL;
    const int k = lcp_ppm_first_block(s, z, s->unit[r], sign, &t);
    const double join = positive ? fabs(s->w[r]) / schur : HUGE_VAL;
    if (join <= t && join <= own && join < HUGE_VAL) {
      advance(s, x, r, sign * join);
      lcp_ppm_enter(s, r, sqrt(schur));
      return LCP_PPM_JOINED;
    }
    if (own <= t && own < HUGE_VAL) {
      advance(s, x, r, sign * own);
      z[r] = (sign > 0) ? s->hi[r] : s->lo[r];
      s->e[r] = 0;
      s->where[r] = (sign > 0) ? AT_HI : AT_LO;
      return LCP_PPM_BOUNDED;
    }
    if (k < 0) {
      return LCP_PPM_UNBLOCKED;
    }
    advance(s, x, r, sign * t);
    s->w[r] += sign * t * schur;
    lcp_ppm_leave(s, z, k, sign * s->y[k] < 0 ? AT_LO : AT_HI);
  }
}
