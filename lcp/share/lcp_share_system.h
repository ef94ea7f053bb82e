/* lcp/share/lcp_share_system.h - the linear system of lcp_share: active rows of M + delta C, cones that slip linearised.
 * Private to lcp_share*.c. */
#pragma once

#include "lcp/lcp_problem.h"
#include "lcp/linear/sparse_lu.h"

/* What is asked of an unknown: its value stays; its row of M z + q is zero; it is friction of a cone that slips,
 *   own_0 z_t + own_1 z_t+1 + pull z_n + gain_0 u_t + gain_1 u_t+1 = 0,   t = first row of its part, n its normal,
 *
 * u = w + delta (z - anchor), which is zero where friction sticks. */
enum { SHARE_FIXED, SHARE_ACTIVE, SHARE_SLIP };

typedef struct share_rows {
  unsigned char *kind;     /* n */
  double *delta;           /* n: of active rows, on the diagonal; in u of those that slip */
  unsigned char *into;     /* n: rows of its part before it, of every cone's friction */
  unsigned char *part_dim; /* n: of the part, 1 or 2; else 0 */
  unsigned char *slips;    /* n: of a cone's normal: rows of friction behind it; else 0 */
  double *pull;            /* n */
  double *own, *gain;      /* 2 n */
} share_rows;

/* First row of the part of row i. */
static inline int share_first(const share_rows *r, int i) {
  return i - r->into[i];
}

/* One past the last friction row of the cone whose normal row i is; 0: it is none. */
static inline int share_slips(const share_rows *r, int i) {
  return (r->slips[i] > 0) ? i + 1 + r->slips[i] : 0;
}

typedef struct share_system {
  int count;            /* active and slipping unknowns */
  bool slips;           /* some of them slip */
  int *unknown, *local; /* cap_n */
  int *met, *stamp;     /* cap_n: rows met in a column; the column that met a row last */
  double *sum, *x;      /* cap_n */
  int *colptr, *rowind; /* cap_n + 1, cap_nnz */
  double *val;
  lin_lu lu;
  int cap_n;
  size_t cap_nnz, cap_fill;
  void *mem, *nnz_mem, *lu_mem; /* owned */
  long factorizations, backsolves;
} share_system;

void lcp_share_system_close(share_system *s);

/* The unknowns of the system alone: count, unknown, local. */
base_status lcp_share_system_list(share_system *s, int n, const share_rows *r, base_error *err);

/* Builds and factors the system for the kinds in r, n unknowns. *regular = false: singular. BASE_ENOMEM only. */
base_status lcp_share_system_factor(share_system *s, const lcp_matrix *M, const share_rows *r,
                                    bool *regular, base_error *err);

/* Pivots of the last factor that are at most `small`. */
int lcp_share_system_small_pivots(const share_system *s, double small);

/* x = the solution for right; n entries of both, of which those of the system are read and set. */
void lcp_share_system_solve(share_system *s, const double *right, double *x);
