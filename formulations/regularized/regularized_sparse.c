/* regularized_sparse.c - M_hat = P' L L' P by CHOLMOD (Chen, Davis, Hager & Rajamanickam 2008), for scenes
 * whose envelope would be wide. The pattern is that of the bodies that share a contact with friction; while
 * it stands, ordering and symbolic analysis are kept and only numbers are factored. CHOLMOD allocates. */
#include "formulations/regularized/regularized_factor.h"
#include "lcp/linear/cholmod_library.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct reg_sparse {
  cholmod_session cholmod;
  cholmod_sparse *A; /* lower triangle, dofs in the order of reg_mass.place */
  cholmod_factor *F;
  int *colptr, *rowind; /* of this step, n+1 and nnz */
  int *near_start, *near,
      *off;  /* by body in that order: later bodies it meets, and how far down their
                                   rows begin below its own */
  int *rank; /* n_dof: which body of that order a dof belongs to */
  int cap_dof, cap_body, cap_link, cap_nnz;
};

void reg_sparse_close(reg_mass *m) {
  reg_sparse *s = m->sparse;
  if (s != NULL) {
    s->cholmod.of.cholmod_free_sparse(&s->A, &s->cholmod.common);
    s->cholmod.of.cholmod_free_factor(&s->F, &s->cholmod.common);
    s->cholmod.of.cholmod_finish(&s->cholmod.common);
    free(s->colptr);
    free(s->rowind);
    free(s->near_start);
    free(s->near);
    free(s->off);
    free(s->rank);
    free(s);
  }
}

static base_status grow(int **array, int *cap, int need, base_error *err) {
  if (*array == NULL || need > *cap) {
    free(*array);
    *array = malloc(((size_t)need + (size_t)need / 2 + 1) * sizeof **array);
    *cap = (*array != NULL) ? base_room(need) : 0;
    if (*array == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "regularized: no memory for the pattern of %d entries",
                       need);
    }
  }
  return BASE_OK;
}

static base_status reserve(const contact_set *c, reg_mass *m, base_error *err) {
  if (m->sparse == NULL) {
    m->sparse = calloc(1, sizeof *m->sparse);
    if (m->sparse == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "regularized: no memory for CHOLMOD");
    }
    const base_status begun = cholmod_begin(&m->sparse->cholmod, err);
    if (begun != BASE_OK) {
      free(m->sparse);
      m->sparse = NULL;
      return begun;
    }
    m->sparse->cholmod.common.final_ll = 1;
  }
  reg_sparse *s = m->sparse;
  int same = s->cap_dof;
  BASE_TRY(grow(&s->colptr, &same, c->n_dof + 1, err));
  BASE_TRY(grow(&s->rank, &s->cap_dof, c->n_dof + 1, err));
  BASE_TRY(grow(&s->near_start, &s->cap_body, c->n_body + 1, err));
  same = s->cap_link;
  BASE_TRY(grow(&s->near, &same, m->link_start[c->n_body], err));
  return grow(&s->off, &s->cap_link, m->link_start[c->n_body], err);
}

/* Places of the later bodies that body b meets: ascending, each once; returns how many. */
static int later(const reg_mass *m, int b, int *near) {
  int n = 0;
  for (int k = m->link_start[b]; k < m->link_start[b + 1]; k++) {
    const int place = m->place[m->link[k]];
    int at = n;
    while (at > 0 && near[at - 1] >= place) {
      at--;
    }
    if (place > m->place[b] && (at == n || near[at] != place)) {
      memmove(near + at + 1, near + at, (size_t)(n - at) * sizeof *near);
      near[at] = place;
      n++;
    }
  }
  return n;
}

/* Bodies in their order of elimination, with the blocks below each; returns the entries. */
static int find_blocks(const contact_set *c, reg_mass *m) {
  reg_sparse *s = m->sparse;
  int nnz = 0;
  for (int k = 0; k < c->n_body; k++) {
    const int b = m->order[c->n_body - 1 - k];
    for (int i = 0; i < contact_dofs(c, b); i++) {
      s->rank[m->place[b] + i] = k;
    }
  }
  s->near_start[0] = 0;
  for (int k = 0; k < c->n_body; k++) {
    const int b = m->order[c->n_body - 1 - k];
    const int n = contact_dofs(c, b);
    const int first = s->near_start[k];
    s->near_start[k + 1] = first + ((n > 0) ? later(m, b, s->near + first) : 0);
    int below = 0;
    for (int j = first; j < s->near_start[k + 1]; j++) {
      s->off[j] = below;
      below += contact_dofs(c, m->order[c->n_body - 1 - s->rank[s->near[j]]]);
    }
    nnz += n * (n + 1) / 2 + n * below;
  }
  return nnz;
}

static void fill_pattern(const contact_set *c, reg_mass *m) {
  reg_sparse *s = m->sparse;
  int at = 0;
  for (int k = 0; k < c->n_body; k++) {
    const int b = m->order[c->n_body - 1 - k];
    const int n = contact_dofs(c, b);
    for (int j = 0; j < n; j++) {
      s->colptr[m->place[b] + j] = at;
      for (int i = j; i < n; i++) {
        s->rowind[at++] = m->place[b] + i;
      }
      for (int x = s->near_start[k]; x < s->near_start[k + 1]; x++) {
        const int rows = contact_dofs(c, m->order[c->n_body - 1 - s->rank[s->near[x]]]);
        for (int i = 0; i < rows; i++) {
          s->rowind[at++] = s->near[x] + i;
        }
      }
    }
  }
  s->colptr[c->n_dof] = at;
}

static bool same_pattern(const reg_sparse *s, int n, int nnz) {
  return s->F != NULL && s->A->nrow == (size_t)n && ((const int *)s->A->p)[n] == nnz &&
         memcmp(s->A->p, s->colptr, ((size_t)n + 1) * sizeof *s->colptr) == 0 &&
         memcmp(s->A->i, s->rowind, (size_t)nnz * sizeof *s->rowind) == 0;
}

base_status reg_sparse_plan(const contact_set *c, reg_mass *m, base_error *err) {
  BASE_TRY(reserve(c, m, err));
  reg_sparse *s = m->sparse;
  const int n = c->n_dof;
  const int nnz = find_blocks(c, m);
  BASE_TRY(grow(&s->rowind, &s->cap_nnz, nnz, err));
  fill_pattern(c, m);
  if (same_pattern(s, n, nnz)) {
    return BASE_OK;
  }
  s->cholmod.of.cholmod_free_sparse(&s->A, &s->cholmod.common);
  s->cholmod.of.cholmod_free_factor(&s->F, &s->cholmod.common);
  s->A = s->cholmod.of.cholmod_allocate_sparse((size_t)n, (size_t)n, (size_t)nnz, 1, 1, -1,
                                               CHOLMOD_REAL, &s->cholmod.common);
  if (s->A != NULL) {
    memcpy(s->A->p, s->colptr, ((size_t)n + 1) * sizeof *s->colptr);
    memcpy(s->A->i, s->rowind, (size_t)nnz * sizeof *s->rowind);
    s->F = s->cholmod.of.cholmod_analyze(s->A, &s->cholmod.common);
  }
  m->analyses++;
  return (s->F != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EEXTERNAL, "regularized: CHOLMOD status %d on %d dofs",
                         s->cholmod.common.status, n);
}

void reg_sparse_mass(const contact_set *c, reg_mass *m) {
  const reg_sparse *s = m->sparse;
  assert(same_pattern(s, c->n_dof, s->colptr[c->n_dof])); /* that of the symbolic factor */
  double *value = s->A->x;
  memset(value, 0, (size_t)s->colptr[c->n_dof] * sizeof *value);
  for (int b = 0; b < c->n_body; b++) {
    const int n = contact_dofs(c, b);
    const double *mass = c->mass + c->mass_start[b];
    for (int j = 0; j < n; j++) {
      memcpy(value + s->colptr[m->place[b] + j], mass + (ptrdiff_t)j * n + j,
             (size_t)(n - j) * sizeof *value);
    }
  }
}

void reg_sparse_add(reg_mass *m, const reg_springs *p, int x, int y) {
  const reg_sparse *s = m->sparse;
  const int row = p->place[x];
  const int column = p->place[y];
  double *value = s->A->x;
  int block = s->near_start[s->rank[column]];
  while (row != column && s->near[block] != row) {
    block++;
  }
  for (int j = 0; j < p->n[y]; j++) {
    const int first = (row == column) ? j : 0;
    double *to = value + s->colptr[column + j];
    to += (row == column) ? -j : p->n[y] - j + s->off[block];
    for (int r = 0; r < p->rank; r++) {
      const double scaled = p->stiffness[r] * p->e[y][r * p->n[y] + j];
      for (int i = first; i < p->n[x]; i++) {
        to[i] += scaled * p->e[x][r * p->n[x] + i];
      }
    }
  }
}

bool reg_sparse_factor(reg_mass *m) {
  reg_sparse *s = m->sparse;
  assert(same_pattern(s, (int)s->A->nrow, s->colptr[s->A->nrow]));
  return s->cholmod.of.cholmod_factorize(s->A, s->F, &s->cholmod.common) && s->F->minor == s->F->n;
}

/* The dense right sides B through two of CHOLMOD's partial solves; NULL without memory. Frees B. */
static cholmod_dense *solve_twice(reg_sparse *s, int first, int second, cholmod_dense *B) {
  cholmod_dense *X =
      (B != NULL) ? s->cholmod.of.cholmod_solve(first, s->F, B, &s->cholmod.common) : NULL;
  cholmod_dense *Z =
      (X != NULL) ? s->cholmod.of.cholmod_solve(second, s->F, X, &s->cholmod.common) : NULL;
  s->cholmod.of.cholmod_free_dense(&B, &s->cholmod.common);
  s->cholmod.of.cholmod_free_dense(&X, &s->cholmod.common);
  return Z;
}

bool reg_sparse_forward(reg_mass *m, int n, int width) {
  reg_sparse *s = m->sparse;
  const size_t rows = (size_t)n;
  cholmod_dense *B = s->cholmod.of.cholmod_allocate_dense(rows, (size_t)width, rows, CHOLMOD_REAL,
                                                          &s->cholmod.common);
  for (size_t k = 0; B != NULL && k < (size_t)width; k++) {
    for (size_t i = 0; i < rows; i++) {
      ((double *)B->x)[k * rows + i] = m->Y[i * (size_t)width + k];
    }
  }
  cholmod_dense *Z = solve_twice(s, CHOLMOD_P, CHOLMOD_L, B);
  for (size_t k = 0; Z != NULL && k < (size_t)width; k++) {
    for (size_t i = 0; i < rows; i++) {
      m->Y[i * (size_t)width + k] = ((const double *)Z->x)[k * rows + i];
    }
  }
  const bool good = Z != NULL;
  s->cholmod.of.cholmod_free_dense(&Z, &s->cholmod.common);
  return good;
}

void reg_sparse_backward(reg_mass *m, int n, double *x) {
  reg_sparse *s = m->sparse;
  cholmod_dense *B = s->cholmod.of.cholmod_allocate_dense((size_t)n, 1, (size_t)n, CHOLMOD_REAL,
                                                          &s->cholmod.common);
  if (B != NULL) {
    memcpy(B->x, x, (size_t)n * sizeof *x);
  }
  cholmod_dense *Z = solve_twice(s, CHOLMOD_Lt, CHOLMOD_Pt, B);
  for (int i = 0; i < n; i++) {
    x[i] = (Z != NULL) ? ((const double *)Z->x)[i] : (double)NAN;
  }
  s->cholmod.of.cholmod_free_dense(&Z, &s->cholmod.common);
}
