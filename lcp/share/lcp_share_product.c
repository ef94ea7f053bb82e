/* lcp_share_product.c - w = M z + q, and what its rows are measured against. */
#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"
#include "lcp/share/lcp_share_state.h"

#include <string.h>

enum {
  TOGETHER = 4
}; /* dense columns that are added in one pass, one after the other in each row */

/* w += M z over these columns, size += |M||z| unless NULL. */
BASE_INLINE void add_dense(const lcp_matrix *M, const int *column, const double *z,
                           double *restrict w, double *restrict size) {
  const size_t n = (size_t)M->n;
  const double *const a = M->val + n * (size_t)column[0], *const b = M->val + n * (size_t)column[1];
  const double *const c = M->val + n * (size_t)column[2], *const d = M->val + n * (size_t)column[3];
  const double x[TOGETHER] = {z[column[0]], z[column[1]], z[column[2]], z[column[3]]};
  for (size_t i = 0; i < n; i++) {
    w[i] = (((w[i] + a[i] * x[0]) + b[i] * x[1]) + c[i] * x[2]) + d[i] * x[3];
  }
  for (size_t i = 0; i < n && size != NULL; i++) {
    size[i] = (((size[i] + fabs(a[i] * x[0])) + fabs(b[i] * x[1])) + fabs(c[i] * x[2])) +
              fabs(d[i] * x[3]);
  }
}

BASE_INLINE void add_column(lcp_column c, double x, double *w, double *size) {
  if (size != NULL) {
    lcp_column_add_sized(c, x, w, size);
  } else {
    lcp_column_add(c, x, w);
  }
}

BASE_CLONES static void stored_product(lcp_share *s, double *size) {
  const int n = s->p->M.n, most = (s->M.storage == LCP_DENSE) ? TOGETHER : 1;
  memcpy(s->w, s->p->q, (size_t)n * sizeof *s->w);
  for (int i = 0; i < n && size != NULL; i++) {
    size[i] = fabs(s->p->q[i]);
  }
  for (int j = 0; j < n;) {
    int column[TOGETHER] = {0}, count = 0;
    for (; j < n && count < most; j++) {
      column[count] = j;
      count += s->z[j] != 0;
    }
    if (count == TOGETHER) {
      add_dense(&s->M, column, s->z, s->w, size);
      continue;
    }
    for (int k = 0; k < count; k++) {
      add_column(lcp_column_of(&s->M, column[k]), s->z[column[k]], s->w, size);
    }
  }
}

enum { ABREAST = 4 }; /* sums that do not wait for each other */

/* Of the bits of n numbers. */
static uint64_t sum_of(const double *x, size_t n) {
  uint64_t sum[ABREAST] = {1, 2, 3, 4};
  for (size_t i = 0; i < n; i++) {
    uint64_t bits;
    memcpy(&bits, &x[i], sizeof bits);
    uint64_t *one = &sum[i % ABREAST];
    *one = (*one ^ bits) * 0x9e3779b97f4a7c15u;
    *one ^= *one >> 32;
  }
  for (int k = 1; k < ABREAST; k++) {
    sum[0] = (sum[0] ^ sum[k]) * 0x9e3779b97f4a7c15u;
    sum[0] ^= sum[0] >> 32;
  }
  return sum[0];
}

void lcp_share_note_product(lcp_share *s) {
  s->seen = sum_of(s->z, (size_t)s->p->M.n);
  s->stale = false;
}

void lcp_share_product(lcp_share *s, double *size) {
  if (s->by_bodies) {
    lcp_share_bodies_product(&s->bodies, s->z, s->w, size);
  } else {
    stored_product(s, size);
  }
  lcp_share_note_product(s);
}

void lcp_share_refresh_product(lcp_share *s) {
  if (s->stale || s->seen != sum_of(s->z, (size_t)s->p->M.n)) {
    lcp_share_product(s, NULL);
  }
}

/* Row i is held against row `other` as well, in its own unit. */
static void level_row(lcp_share *s, int i, int other) {
  const double a = s->diagonal[i], b = s->diagonal[other];
  const double unit = (a > 0 && b > 0) ? sqrt(a / b) : 1;
  const double size = unit * s->size[other];
  s->size[i] = (size > s->size[i]) ? size : s->size[i];
}

/* Rows of one contact share their roundings: those of friction at rest are made of nothing, and are held against
 * the normal row. So do rows of one joint, which are held against all of them. */
void lcp_share_level_sizes(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    for (int i = b->start + 1; i < lcp_share_end(s, b); i++) {
      level_row(s, i, b->start);
    }
  }
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    for (int i = b->start; i < b->start + b->size && b->set == LCP_FREE; i++) {
      for (int other = b->start; other < b->start + b->size; other++) {
        level_row(s, i, other);
      }
    }
  }
}
