/* Forces at rest away from the edges of their cones. Joints and redundant contacts leave the forces of contacts at rest
 * undetermined, and the vertex that a pivoting method ends at stands on edges that nothing presses it to: taken by its word such a
 * contact slides, and a force on its edge leaves it with the next rounding. With K = B' C B, B the columns of what may change (all
 * rows of a contact at rest, the normal with its friction where one slides), every x + null(K) makes the same motion. Looked for is
 * one of them in cones narrower than those of friction, by projections on the cones and on null(K) in turn. */
#include "formulations/event/event_run.h"
#include "lcp/lcp_cone.h"
#include "lcp/linear/lapack_status.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest eigenvalue of K: less is none. What is chosen is the beginning of an arc, which makes up for the rest. */
static const double null_tol = 1e-10;
/* Of the cone: beyond it stands what lies on a facet, which is inside the circle. */
static const double near = 0.875;
/* The cones looked into have the share 1 - 2^-k of the friction, k = 0, 1, ...; what lies in the next wider one is found. */
enum { NARROWER = 6, PROJECTIONS = 100 };

typedef struct inside {
  double *K, *value, *x, *to; /* m*m, then its eigenvectors; m each */
  double *scale; /* m: of the unknowns of a contact, so that its own block is of size one */
  int *of, *row; /* m: contact of the assembly, row of it */
  int m, first;  /* unknowns, the first eigenvector that moves something */
} inside;

static double force_scale(const form_assembly *a, int i) {
  const double *own = form_own_block(a, i);
  double trace = 0.0;
  for (int r = 0; r < form_rows_of(a, i); r++) {
    trace += own[r * (form_rows_of(a, i) + 1)];
  }
  return (trace > 0.0) ? sqrt(trace) : 1.0;
}

/* Entry r of column j of B. */
static double entry(const event_run *s, const inside *w, const double *lambda, int j, int r) {
  const int i = w->of[j], n = form_rows_of(&s->space.a, i);
  const double *f = lambda + s->space.a.row[i];
  const bool alone = j + 1 == w->m || w->of[j + 1] != i; /* of its contact */
  const bool slides = w->row[j] == 0 && alone && n > 1;
  return ((r == w->row[j]) ? 1.0 : (slides ? f[r] / f[0] : 0.0)) / w->scale[j];
}

static void fill(const event_run *s, const double *lambda, inside *w) {
  const form_assembly *a = &s->space.a;
  const size_t n = (size_t)a->n_row;
  for (int j = 0; j < w->m; j++) {
    w->x[j] = lambda[a->row[w->of[j]] + w->row[j]] * w->scale[j];
    for (int i = 0; i < w->m; i++) {
      const int gi = w->of[i], gj = w->of[j];
      double sum = 0.0;
      for (int p = 0; p < form_rows_of(a, gi); p++) {
        for (int q = 0; q < form_rows_of(a, gj); q++) {
          const size_t at = (size_t)(a->row[gj] + q) * n + (size_t)(a->row[gi] + p);
          sum += entry(s, w, lambda, i, p) * s->p.C[at] * entry(s, w, lambda, j, q);
        }
      }
      w->K[(size_t)j * (size_t)w->m + (size_t)i] = sum;
    }
  }
}

/* Rows of the contact of unknown j. */
static int rows_from(const inside *w, int j) {
  int n = 1;
  while (j + n < w->m && w->of[j + n] == w->of[j]) {
    n++;
  }
  return n;
}

/* Do all forces lie in cones of the share `part` of friction? */
static bool lies_inside(const event_run *s, const inside *w, double part) {
  for (int j = 0; j < w->m; j += rows_from(w, j)) {
    double friction = 0.0;
    for (int r = 1; r < rows_from(w, j); r++) {
      friction = hypot(friction, w->x[j + r]);
    }
    if (w->x[j] < 0.0 || friction > part * s->p.mu[w->of[j]] * w->x[j]) {
      return false;
    }
  }
  return true;
}

/* to - x, to the point of cones of the share `part` that is nearest to x. */
static void project(const event_run *s, const inside *w, double part) {
  for (int j = 0; j < w->m; j += rows_from(w, j)) {
    const int n = rows_from(w, j);
    lcp_block cone = {.set = LCP_CONE, .size = n, .n_part = (n > 1) ? 1 : 0};
    cone.part_dim[0] = n - 1;
    cone.part_mu[0] = part * s->p.mu[w->of[j]];
    lcp_cone_project(&cone, w->x + j, w->to + j);
    for (int r = j; r < j + n; r++) {
      w->to[r] -= w->x[r];
    }
  }
}

/* x moves by the part of `to` that moves no contact. */
static void move(inside *w) {
  for (int k = 0; k < w->first; k++) {
    const double *v = w->K + (size_t)k * (size_t)w->m;
    double along = 0.0;
    for (int j = 0; j < w->m; j++) {
      along += v[j] * w->to[j];
    }
    for (int j = 0; j < w->m; j++) {
      w->x[j] += along * v[j];
    }
  }
}

static bool found(const event_run *s, inside *w) {
  for (int k = 0; k < NARROWER; k++) {
    for (int n = 0; n < PROJECTIONS; n++) {
      project(s, w, 1.0 - ldexp(1.0, -k));
      move(w);
      if (lies_inside(s, w, 1.0 - ldexp(1.0, -k - 1))) {
        return true;
      }
    }
  }
  return false;
}

static bool near_edge(const event_run *s, int i, const double *f) {
  double friction = 0.0;
  for (int r = 1; r < form_rows_of(&s->space.a, i); r++) {
    friction = hypot(friction, f[r]);
  }
  return friction > near * s->p.mu[i] * f[0];
}

/* The unknowns: of contacts that carry force. Returns whether one at rest stands near its edge. */
static bool number(const event_run *s, const double *u0, const double *lambda, double least,
                   inside *w) {
  const form_assembly *a = &s->space.a;
  bool edge = false;
  w->m = 0;
  for (int i = 0; i < a->n_contact; i++) {
    const double *f = lambda + a->row[i];
    if (!(f[0] > least)) {
      continue;
    }
    const bool holds = event_holds(s, i, u0, lambda);
    edge = edge || (holds && near_edge(s, i, f));
    for (int r = 0; r < (holds ? form_rows_of(a, i) : 1); r++) {
      w->of[w->m] = i;
      w->row[w->m] = r;
      w->scale[w->m++] = force_scale(a, i);
    }
  }
  return edge;
}

static void layout(void *state, base_arena *m) {
  inside *w = state;
  const size_t n = (size_t)w->m;
  w->K = BASE_ARRAY(m, double, n *n);
  w->value = BASE_ARRAY(m, double, n);
  w->x = BASE_ARRAY(m, double, n);
  w->to = BASE_ARRAY(m, double, n);
  w->scale = BASE_ARRAY(m, double, n);
  w->of = BASE_ARRAY(m, int, n);
  w->row = BASE_ARRAY(m, int, n);
}

/* Eigenvectors of K; w->first counts those that move nothing. */
static base_status decompose(inside *w, base_error *err) {
  const lapack_int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', w->m, w->K, w->m, w->value);
  if (info != 0) {
    return BASE_FAIL(err, lin_lapack_status(info), "event: no eigenvalues of the contacts at rest");
  }
  for (w->first = 0; w->first < w->m && w->value[w->first] <= null_tol * w->value[w->m - 1];) {
    w->first++;
  }
  return BASE_OK;
}

/* w->x becomes lambda (n_row), of the contacts that have unknowns. */
static void take(const event_run *s, const inside *w, double *lambda) {
  for (int j = 0; j < w->m; j += rows_from(w, j)) {
    const int i = w->of[j], n = form_rows_of(&s->space.a, i);
    double *f = lambda + s->space.a.row[i];
    const double share = w->x[j] / w->scale[j] / f[0];
    for (int r = 0; r < n; r++) {
      f[r] = (rows_from(w, j) == n) ? w->x[j + r] / w->scale[j] : share * f[r];
    }
  }
}

base_status event_inside(const event_run *s, const double *u0, double least, double *lambda,
                         base_error *err) {
  inside w = {.m = s->space.a.n_row};
  void *mem = NULL;
  if (w.m == 0) {
    return BASE_OK;
  }
  BASE_TRY(form_memory(&mem, layout, &w, err));
  base_status status = BASE_OK;
  if (number(s, u0, lambda, least, &w)) {
    fill(s, lambda, &w);
    status = decompose(&w, err);
    if (status == BASE_OK && w.first > 0 && found(s, &w)) {
      take(s, &w, lambda);
    }
  }
  free(mem);
  return status;
}
