#include "lcp/solvers/cone_step.h"

#include "lcp/solvers/cone_body.h"

#include <stdlib.h>
#include <string.h>

void lcp_cone_step_layout_beside(lcp_cone_step *s, const lcp_capacity *cap, double *dz, double *t,
                                 base_arena *a) {
  lcp_sweep_layout(&s->sweep, cap, a);
  s->active = BASE_ARRAY(a, unsigned char, cap->n);
  s->piece_of = BASE_ARRAY(a, int, cap->n);
  s->dz = dz;
  s->t = t;
  s->v = BASE_ARRAY(a, double, 2 * (size_t)cap->n_dof);
}

void lcp_cone_step_layout(lcp_cone_step *s, const lcp_capacity *cap, base_arena *a) {
  double *dz = BASE_ARRAY(a, double, cap->n), *t = BASE_ARRAY(a, double, cap->n);
  lcp_cone_step_layout_beside(s, cap, dz, t, a);
}

void lcp_cone_step_release(lcp_cone_step *s) {
  if (s->mem != NULL) {
    lcp_direct_release(&s->direct);
    free(s->mem);
    s->mem = NULL;
  }
  lin_body_space_close(&s->body);
}

base_status lcp_cone_step_prepare(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                                  base_error *err) {
  s->mem = NULL;
  s->weighed = false;
  s->body = (lin_body_space){0};
  for (int k = 0; k < c->n_piece; k++) {
    for (int i = c->piece[k].start; i < c->piece[k].start + c->piece[k].size; i++) {
      s->piece_of[i] = k;
    }
  }
  if (p->M.storage == LCP_FACTORED) {
    BASE_TRY(lcp_sweep_weigh_bodies(&s->sweep, p->M.factored, err));
    return lcp_cone_body_check(s, p, c, err);
  }
  return BASE_OK;
}

/* ---- storage -------------------------------------------------------------------------------- */

/* Walks the pieces that column j of the system has rows in: those of column j of M, and its own. */
typedef struct walk {
  const lcp_csc *m;
  const int *piece_of;
  int k, end; /* entries of M not yet taken */
  int own;    /* -1 when taken */
  int piece;
} walk;

static walk walk_column(const lcp_cone_step *s, const lcp_csc *m, int j) {
  return (walk){m, s->piece_of, m->colptr[j], m->colptr[j + 1], s->piece_of[j], -1};
}

/* The next piece, with entries first .. w->k-1 of M in it. */
static bool walk_next(walk *w, int *first) {
  *first = w->k;
  w->piece = (w->k < w->end) ? w->piece_of[w->m->rowind[w->k]] : -1;
  if (w->own >= 0 && (w->piece < 0 || w->own <= w->piece)) {
    w->piece = w->own;
    w->own = -1;
  }
  if (w->piece < 0) {
    return false;
  }
  while (w->k < w->end && w->piece_of[w->m->rowind[w->k]] == w->piece) {
    w->k++;
  }
  return true;
}

static void pattern_csc(lcp_cone_step *s, const lcp_csc *m, const lcp_cone_scaled *c) {
  int at = 0, first;
  for (int j = 0; j < m->n_col; j++) {
    s->colptr[j] = at;
    for (walk w = walk_column(s, m, j); walk_next(&w, &first);) {
      for (int i = 0; i < c->piece[w.piece].size; i++) {
        s->rowind[at++] = c->piece[w.piece].start + i;
      }
    }
  }
  s->colptr[m->n_col] = at;
}

static size_t count_csc(const lcp_cone_step *s, const lcp_csc *m, const lcp_cone_scaled *c) {
  size_t count = 0;
  int first;
  for (int j = 0; j < m->n_col; j++) {
    for (walk w = walk_column(s, m, j); walk_next(&w, &first);) {
      count += (size_t)c->piece[w.piece].size;
    }
  }
  return count;
}

static void layout_system(lcp_cone_step *s, const lcp_problem *p, base_arena *a) {
  const lcp_capacity cap = {.n = p->M.n, .nnz = (int)s->entries};
  const bool sparse = p->M.storage == LCP_CSC;
  lcp_direct_layout(&s->direct, &cap, a);
  s->val = BASE_ARRAY(a, double, s->entries);
  s->colptr = BASE_ARRAY(a, int, sparse ? p->M.n + 1 : 0);
  s->rowind = BASE_ARRAY(a, int, sparse ? s->entries : 0);
}

/* Memory and pattern of the system of a matrix that is stored: once, when the first step is due. */
static base_status build(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c) {
  const int n = p->M.n;
  s->entries = (p->M.storage == LCP_CSC) ? count_csc(s, &p->M.csc, c) : (size_t)n * (size_t)n;
  base_arena measure = base_arena_measuring();
  layout_system(s, p, &measure);
  s->mem = (measure.overflow || s->entries > INT32_MAX) ? NULL : base_alloc(measure.used);
  if (s->mem == NULL) {
    return BASE_ENOMEM;
  }
  base_arena real = base_arena_over(s->mem, measure.used);
  layout_system(s, p, &real);
  lcp_direct_begin(&s->direct);
  s->A = (lcp_matrix){.storage = LCP_DENSE, .n = n, .val = s->val};
  if (p->M.storage == LCP_CSC) {
    s->A = (lcp_matrix){.storage = LCP_CSC, .n = n, .csc = {n, n, s->colptr, s->rowind, s->val}};
    pattern_csc(s, &p->M.csc, c);
  }
  return BASE_OK;
}

/* ---- dense and CSC -------------------------------------------------------------------------- */

static void find_active(lcp_cone_step *s, const lcp_cone_scaled *c) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    const double *Y = c->Y + lcp_cone_scaled_at(c, b);
    bool any = false;
    for (int i = 0; i < b->size * b->size; i++) {
      any = any || Y[i] != 0.0;
    }
    memset(s->active + b->start, any, (size_t)b->size);
  }
}

/* to[i] += sum_r Y[i, r] t[r] over a piece. */
static void add_product(const lcp_block *b, const double *Y, const double *t, double *to) {
  for (int r = 0; r < b->size; r++) {
    for (int i = 0; i < b->size && t[r] != 0.0; i++) {
      to[i] += Y[i + r * b->size] * t[r];
    }
  }
}

/* Own piece of column j: X and the weight. */
static void add_own(const lcp_cone_scaled *c, const lcp_block *b, int j, double weight,
                    double *to) {
  const double *X = c->X + lcp_cone_scaled_at(c, b);
  const double *Y = c->Y + lcp_cone_scaled_at(c, b);
  const int col = (j - b->start) * b->size;
  for (int i = 0; i < b->size; i++) {
    to[i] += X[i + col] + weight * Y[i + col];
  }
}

static void fill_dense(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                       double weight) {
  const size_t n = (size_t)p->M.n;
  for (int j = 0; j < p->M.n; j++) {
    if (!s->active[j]) {
      continue;
    }
    double *to = s->val + (size_t)j * n;
    const double *m = p->M.val + (size_t)j * n;
    for (int i = 0; i < p->M.n; i++) {
      s->t[i] = c->s[i] * m[i] * c->s[j];
    }
    memset(to, 0, n * sizeof *to);
    for (int k = 0; k < c->n_piece; k++) {
      const lcp_block *b = &c->piece[k];
      if (s->active[b->start]) {
        add_product(b, c->Y + lcp_cone_scaled_at(c, b), s->t + b->start, to + b->start);
      }
    }
    const lcp_block *own = &c->piece[s->piece_of[j]];
    add_own(c, own, j, weight, to + own->start);
  }
}

static void fill_csc(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                     double weight) {
  const lcp_csc *m = &p->M.csc;
  int first;
  memset(s->val, 0, s->entries * sizeof *s->val);
  for (int j = 0; j < p->M.n; j++) {
    double *to = s->val + s->colptr[j];
    for (walk w = walk_column(s, m, j); s->active[j] && walk_next(&w, &first);) {
      const lcp_block *b = &c->piece[w.piece];
      double t[LCP_CONE_MAX] = {0};
      for (int k = first; k < w.k; k++) {
        t[m->rowind[k] - b->start] = c->s[m->rowind[k]] * m->val[k] * c->s[j];
      }
      if (s->active[b->start]) {
        add_product(b, c->Y + lcp_cone_scaled_at(c, b), t, to);
      }
      if (w.piece == s->piece_of[j]) {
        add_own(c, b, j, weight, to);
      }
      to += b->size;
    }
  }
}

bool lcp_cone_step_factor(lcp_cone_step *s, const lcp_problem *p, lcp_cone_scaled *c, double weight,
                          lcp_work *work, base_status *status) {
  work->factorizations++;
  find_active(s, c);
  if (p->M.storage == LCP_FACTORED) {
    return lcp_cone_body_factor(s, p->M.factored, c, weight, status);
  }
  if (s->mem == NULL) {
    *status = build(s, p, c);
    if (*status != BASE_OK) {
      return false;
    }
  }
  (p->M.storage == LCP_DENSE ? fill_dense : fill_csc)(s, p, c, weight);
  return lcp_direct_factor(&s->direct, &s->A, s->active, NULL, NULL, NULL, status);
}

void lcp_cone_step_solve(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                         double *dx, lcp_work *work) {
  const int n = p->M.n;
  work->backsolves++;
  bool moved = false;
  for (int i = 0; i < n; i++) { /* X = I outside the active pieces */
    dx[i] = s->active[i] ? 0.0 : -c->F[i];
    s->dz[i] = c->s[i] * dx[i];
    moved = moved || dx[i] != 0.0;
  }
  memset(s->t, 0, (size_t)n * sizeof *s->t);
  if (moved) {
    lcp_matrix_apply(&p->M, s->dz, NULL, s->t, s->v);
    work->matvecs++;
  }
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    if (!s->active[b->start]) {
      continue;
    }
    double t[LCP_CONE_MAX], product[LCP_CONE_MAX] = {0};
    for (int i = 0; i < b->size; i++) {
      t[i] = c->s[b->start + i] * s->t[b->start + i];
    }
    add_product(b, c->Y + lcp_cone_scaled_at(c, b), t, product);
    for (int i = 0; i < b->size; i++) {
      dx[b->start + i] = -c->F[b->start + i] - product[i];
    }
  }
  if (p->M.storage != LCP_FACTORED) {
    lcp_direct_solve(&s->direct, n, dx);
    return;
  }
  lin_body_space_solve(&s->body, dx, s->t);
  for (int i = 0; i < n; i++) {
    dx[i] = s->active[i] ? s->t[i] : dx[i];
  }
}
