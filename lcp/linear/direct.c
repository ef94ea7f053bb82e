#include "lcp/linear/direct.h"

#include "lcp/lcp_column.h"

#include <suitesparse/klu.h>

#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

static const double singular = 1e-15; /* reciprocal condition, about 5 roundings */

typedef struct klu_objects {
  klu_common common;
  klu_symbolic *symbolic;
  klu_numeric *numeric;
} klu_objects;

void lcp_direct_layout(lcp_direct *s, const lcp_capacity *cap, base_arena *arena) {
  s->a = BASE_ARRAY(arena, double, (size_t)cap->nnz + (size_t)cap->n);
  s->pivot = BASE_ARRAY(arena, int, (size_t)cap->nnz + (size_t)cap->n);
  s->colptr = BASE_ARRAY(arena, int, cap->n + 1);
  s->place = BASE_ARRAY(arena, int, cap->n);
  s->kept_ptr = BASE_ARRAY(arena, int, cap->n + 1);
  s->kept_row = BASE_ARRAY(arena, int, (size_t)cap->nnz + (size_t)cap->n);
  s->x = BASE_ARRAY(arena, double, cap->n);
}

void lcp_direct_begin(lcp_direct *s) {
  s->library = NULL;
  s->kept_n = 0;
  s->analyses = 0;
}

static void drop(klu_objects *k) {
  klu_free_numeric(&k->numeric, &k->common);
  klu_free_symbolic(&k->symbolic, &k->common);
}

void lcp_direct_release(lcp_direct *s) {
  if (s->library != NULL) {
    drop(s->library);
    free(s->library);
    s->library = NULL;
  }
}

static double or_one(const double *x, int i) {
  return (x != NULL) ? x[i] : 1.0;
}

static void fill_dense(lcp_direct *s, const lcp_matrix *M, const double *a, const double *r,
                       const double *c) {
  const int n = M->n;
  for (int j = 0; j < n; j++) {
    if (s->place[j] < 0) {
      continue;
    }
    double *to = s->a + (size_t)s->place[j] * (size_t)s->n;
    const double *from = lcp_column_of(M, j).val;
    const double cj = or_one(c, j);
    for (int i = 0; i < n; i++) {
      if (s->place[i] >= 0) {
        to[s->place[i]] = or_one(r, i) * from[i] * cj;
      }
    }
    to[s->place[j]] += (a != NULL) ? a[j] : 0.0;
  }
}

/* Keeps explicit zeros: the pattern depends on M and S alone. */
static void fill_csc(lcp_direct *s, const lcp_matrix *M, const double *a, const double *r,
                     const double *c) {
  int nz = 0;
  for (int j = 0; j < M->n; j++) {
    if (s->place[j] < 0) {
      continue;
    }
    s->colptr[s->place[j]] = nz;
    bool diagonal = false;
    const lcp_column from = lcp_column_of(M, j);
    for (int k = 0; k < from.count; k++) {
      const int i = from.row[k];
      if (s->place[i] >= 0) {
        diagonal = diagonal || i == j;
        s->pivot[nz] = s->place[i];
        s->a[nz++] =
            or_one(r, i) * from.val[k] * or_one(c, j) + ((i == j && a != NULL) ? a[j] : 0.0);
      }
    }
    if (!diagonal && a != NULL) { /* KLU takes unsorted columns */
      s->pivot[nz] = s->place[j];
      s->a[nz++] = a[j];
    }
  }
  s->colptr[s->n] = nz;
}

static bool factor_dense(lcp_direct *s) {
  if (LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, s->n, s->n, s->a, s->n, s->pivot) != 0) {
    return false;
  }
  double low = HUGE_VAL, high = 0.0;
  for (int i = 0; i < s->n; i++) {
    const double u = fabs(s->a[(size_t)i * (size_t)s->n + (size_t)i]);
    low = fmin(low, u);
    high = fmax(high, u);
  }
  return low > singular * high;
}

static bool same_pattern(const lcp_direct *s) {
  const size_t n = (size_t)s->n;
  return s->kept_n == s->n && memcmp(s->kept_ptr, s->colptr, (n + 1) * sizeof *s->colptr) == 0 &&
         memcmp(s->kept_row, s->pivot, (size_t)s->colptr[n] * sizeof *s->pivot) == 0;
}

/* Orders and analyses the pattern afresh, unless it is the last one's. */
static void analyse(lcp_direct *s, klu_objects *k) {
  klu_free_numeric(&k->numeric, &k->common);
  if (same_pattern(s)) {
    return;
  }
  klu_free_symbolic(&k->symbolic, &k->common);
  k->symbolic = klu_analyze(s->n, s->colptr, s->pivot, &k->common);
  s->analyses++;
  s->kept_n = (k->symbolic != NULL) ? s->n : 0;
  memcpy(s->kept_ptr, s->colptr, ((size_t)s->n + 1) * sizeof *s->colptr);
  memcpy(s->kept_row, s->pivot, (size_t)s->colptr[s->n] * sizeof *s->pivot);
}

static bool factor_csc(lcp_direct *s, base_status *status) {
  klu_objects *k = s->library;
  if (k == NULL) {
    k = calloc(1, sizeof *k);
    if (k == NULL) {
      *status = BASE_ENOMEM;
      return false;
    }
    s->library = k;
    klu_defaults(&k->common);
  }
  analyse(s, k);
  if (k->symbolic != NULL) {
    k->numeric = klu_factor(s->colptr, s->pivot, s->a, k->symbolic, &k->common);
  }
  if (k->common.status == KLU_OUT_OF_MEMORY) {
    *status = BASE_ENOMEM;
  }
  return k->numeric != NULL && k->common.status == KLU_OK &&
         klu_rcond(k->symbolic, k->numeric, &k->common) == 1 && k->common.rcond > singular;
}

bool lcp_direct_factor(lcp_direct *s, const lcp_matrix *M, const unsigned char *member,
                       const double *a, const double *r, const double *c, base_status *status) {
  s->n = 0;
  for (int i = 0; i < M->n; i++) {
    s->place[i] = (member == NULL || member[i]) ? s->n++ : -1;
  }
  s->dense = M->storage == LCP_DENSE;
  if (s->n == 0) {
    return true;
  }
  if (s->dense) {
    fill_dense(s, M, a, r, c);
    return factor_dense(s);
  }
  fill_csc(s, M, a, r, c);
  return factor_csc(s, status);
}

void lcp_direct_solve(lcp_direct *s, int n, double *b) {
  if (s->n == 0) {
    return;
  }
  for (int i = 0; i < n; i++) {
    if (s->place[i] >= 0) {
      s->x[s->place[i]] = b[i];
    }
  }
  if (s->dense) {
    (void)LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, 'N', s->n, 1, s->a, s->n, s->pivot, s->x, s->n);
  } else {
    klu_objects *k = s->library;
    (void)klu_solve(k->symbolic, k->numeric, s->n, 1, s->x, &k->common);
  }
  for (int i = 0; i < n; i++) {
    if (s->place[i] >= 0) {
      b[i] = s->x[s->place[i]];
    }
  }
}
