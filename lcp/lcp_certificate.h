/* lcp/lcp_certificate.h - what a solver proved, as a text file, and its check without any solver.
 *
 *   lcpbench certificate 1
 *   kind basis|farkas|ray
 *   n 3
 *   i basic z          (basis: one line a row, basic 0 or 1)    i y    (farkas, ray)
 *
 * Numbers are decimal with 17 digits, so they read back as the same binary64. A check sees the problem
 * and the file only:
 *   farkas  y >= 0, M'y <= 0, q'y < 0 in exact rational arithmetic (GMP), any n; in the rows of friction of a cone
 *           y_i = 0 and (M'y)_i = 0 (lcp_farkas.h);
 *   basis   n <= 64: M_BB z_B = -q_B is solved in rational arithmetic and z_B >= 0, w_N >= 0 are
 *           tested exactly. A degenerate problem with rounded data may fail that by round-off, and
 *           above n = 64 it is not tried: then rho of the file's z (lcp_judge.h, extended precision)
 *           decides, and `exact` is false;
 *   ray     v >= 0, v != 0, and M reverses its sign, v_i (Mv)_i <= 0 for all i (free rows: (Mv)_i = 0),
 *           as w = Mv + d z0 >= 0, v'w = 0 of a path with d >= 0 gives: M is then no P-matrix (Fiedler
 *           & Ptak 1962). v comes from a floating-point path, so the sums, in extended precision, may
 *           miss by LCP_CERT_RAY_TOL of their terms; that proves nothing of q and never counts as exact. */
#pragma once

#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"

enum { LCP_CERT_EXACT_N = 64 };
#define LCP_CERT_RAY_TOL 1e-10 /* as LCP_VERIFY_EXACT [1] */

typedef struct lcp_certificate_file {
  lcp_certificate_kind kind;
  int n;
  unsigned char *basis; /* n, owned; NULL unless LCP_CERT_BASIS */
  double *vector;       /* n, owned: z of a basis, y, or v */
} lcp_certificate_file;

typedef struct lcp_certificate_verdict {
  bool holds;
  bool exact; /* decided in rational arithmetic */
  double
      residual; /* basis: rho of the file's z; farkas: q'y / (|q|'|y|) (negative); ray: the largest
                    * v_i (Mv)_i / (v_i (|M||v|)_i) */
  const char *why; /* static: the rule that failed, or what was shown */
} lcp_certificate_verdict;

/* z[n]: solution of a basis certificate, else unused. BASE_EINVAL for LCP_CERT_NONE. */
base_status lcp_certificate_write(const char *path, int n, const lcp_certificate *c,
                                  const double *z, base_error *err);
base_status lcp_certificate_read(const char *path, lcp_certificate_file *out, base_error *err);
void lcp_certificate_free(lcp_certificate_file *f);

/* The one check of a certificate that a solver has just handed over (c->kind is not LCP_CERT_NONE; z[n]
 * is the solution of a basis, else unused) and of a file. BASE_EINVAL: the problem has sets other than
 * orthant and free rows and, for a Farkas vector, cones. */
base_status lcp_certificate_verify(const lcp_problem *p, const lcp_certificate *c, const double *z,
                                   lcp_certificate_verdict *out, base_error *err);

/* The same of a file. BASE_EINVAL also: the problem has not f->n rows. */
base_status lcp_certificate_file_verify(const lcp_problem *p, const lcp_certificate_file *f,
                                        lcp_certificate_verdict *out, base_error *err);
