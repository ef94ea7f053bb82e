/* problems/families/known_lcp.h - a complementarity problem that owns its data, with what is known of its
 * answer. Families, case files and imports produce these. */
#pragma once

#include "lcp/lcp_problem.h"

typedef enum known_answer {
  KNOWN_UNSTATED,   /* judge by the residual alone */
  KNOWN_UNIQUE,     /* z is the only solution */
  KNOWN_SOLVABLE,   /* z, if given, is one of several */
  KNOWN_INFEASIBLE, /* farkas: y >= 0, M'y <= 0, q.y < 0 */
  KNOWN_UNSOLVABLE, /* no solution, by exhaustion */
} known_answer;

enum { KNOWN_OWNED = 48 };

typedef struct known_lcp {
  lcp_problem p; /* views of owned arrays */
  known_answer answer;
  double *z, *w;           /* a solution (n each), NULL where unknown; owned */
  double *farkas;          /* n, NULL unless infeasible; owned */
  long lemke_pivots;       /* exact count of lexicographic Lemke with d = 1; 0: unknown */
  long least_index_pivots; /* of Murty's least-index method; 0: unknown */
  double sweep_rate;       /* asymptotic rate of Gauss-Seidel sweeps; 0: unknown */
  void *owned[KNOWN_OWNED];
  int n_owned;
} known_lcp;

void known_lcp_free(known_lcp *k);

/* Zeroed array owned by k; NULL without memory (then also *status = BASE_ENOMEM when not NULL). */
void *known_take(known_lcp *k, size_t count, size_t size);
#define KNOWN_ARRAY(k, type, count) ((type *)known_take((k), (size_t)(count), sizeof(type)))

/* Starts a dense problem of n unknowns, everything zero: M column-major, q. */
base_status known_dense(known_lcp *k, int n, double **M, double **q, base_error *err);
/* Starts a problem stored by columns with room for nnz entries. */
base_status known_sparse(known_lcp *k, int n, int nnz, int **colptr, int **rowind, double **val,
                         double **q, base_error *err);
/* Takes z as the solution: w = M z + q is not computed, q = w - M z is. Both arrays are copied. */
base_status known_plant(known_lcp *k, const double *z, const double *w, base_error *err);
