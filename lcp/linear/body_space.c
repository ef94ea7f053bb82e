#include "lcp/linear/body_space.h"

#include "lcp/base/arena.h"
#include "lcp/linear/body_space_inside.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* ---- the rows of the system -------------------------------------------------------------------- */

void lin_body_space_close(lin_body_space *s) {
  lin_blocks_close(&s->blocks);
  free(s->mem);
  free(s->matrix_mem);
  *s = (lin_body_space){0};
}

void lin_body_space_rest(lin_body_space *s) {
  lin_blocks_rest(&s->blocks);
  free(s->mem);
  free(s->matrix_mem);
  s->mem = s->matrix_mem = NULL;
}

static void layout(lin_body_space *s, base_arena *a) {
  s->first = BASE_ARRAY(a, int, s->cap_group + 1);
  s->at = BASE_ARRAY(a, size_t, s->cap_group + 1);
  s->pair = BASE_ARRAY(a, int, 2 * (size_t)s->cap_group);
  s->joined = BASE_ARRAY(a, unsigned char, s->cap_group);
  s->row = BASE_ARRAY(a, int, s->cap_n);
  s->v = BASE_ARRAY(a, double, s->cap_dof);
  s->seen = BASE_ARRAY(a, int, s->cap_body + 1);
}

static void layout_matrices(lin_body_space *s, base_arena *a) {
  s->T = BASE_ARRAY(a, double, s->cap_matrices);
  s->Y = BASE_ARRAY(a, double, s->cap_matrices);
}

static base_status memory(void **mem, lin_body_space *s,
                          void (*lay)(lin_body_space *, base_arena *), base_error *err) {
  base_arena measure = base_arena_measuring();
  lay(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a system of %d groups", s->cap_group);
  }
  base_arena real = base_arena_over(*mem, measure.used);
  lay(s, &real);
  return BASE_OK;
}

/* S couples no rows of different groups. */
static base_status admit_shift(const lcp_factored *f, int g, base_error *err) {
  for (int j = f->row_start[g]; j < f->row_start[g + 1]; j++) {
    for (int k = f->shift->colptr[j]; k < f->shift->colptr[j + 1]; k++) {
      const int i = f->shift->rowind[k];
      if (f->shift->val[k] != 0.0 && (i < f->row_start[g] || i >= f->row_start[g + 1])) {
        return BASE_FAIL(err, BASE_EUNSUPPORTED,
                         "S couples rows %d and %d of different groups: need storage=csc", i, j);
      }
    }
  }
  return BASE_OK;
}

base_status lin_body_space_admits(const lcp_factored *f, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] > LIN_BLOCK_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %d has %d velocities: need at most %d", b,
                       f->dof_start[b + 1] - f->dof_start[b], (int)LIN_BLOCK_MAX);
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    if (f->row_start[g + 1] - f->row_start[g] > LIN_GROUP_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "group %d has %d rows: need at most %d", g,
                       f->row_start[g + 1] - f->row_start[g], (int)LIN_GROUP_MAX);
    }
    if (f->shift != NULL) {
      BASE_TRY(admit_shift(f, g, err));
    }
  }
  return BASE_OK;
}

/* The last of `dof` velocities that n rows see, and one more. */
static int last_seen(const double *A, int n, int dof) {
  int last = 0;
  for (int r = 0; r < n; r++) {
    for (int i = dof; i > last; i--) {
      last = (A[r * dof + i - 1] != 0.0) ? i : last;
    }
  }
  return last;
}

/* How many velocities the rows of group g in the system see of one side. */
static int seen_by_group(const lin_body_space *s, int g, const lin_side *a) {
  const lcp_mixture *mix = lin_body_space_mixture(s, g);
  const int *row;
  const int n = lin_body_space_rows(s, g, &row);
  const int only = (mix != NULL) ? lin_body_space_only(s, g, mix, n) : -1;
  if (mix != NULL) {
    return last_seen(a->jac + (ptrdiff_t)((only > 0) ? only : 0) * a->dof,
                     (only >= 0) ? 1 : mix->stored, a->dof);
  }
  int last = 0;
  for (int k = 0; k < n && last < a->dof; k++) {
    const int own =
        last_seen(a->jac + (ptrdiff_t)(row[k] - s->f->row_start[g]) * a->dof, 1, a->dof);
    last = (own > last) ? own : last;
  }
  return last;
}

/* How many velocities a body of `dof` has in the system: all, unless half of them are seen by no row, for blocks of five rows take
 * longer than blocks of six. Of a body that nothing meets one stays: a block has a row. */
static int kept(int last, int dof) {
  return (2 * last > dof) ? dof : (last > 0 || dof == 0) ? last : 1;
}

static void find_seen(lin_body_space *s) {
  const lcp_factored *f = s->f;
  int *count = s->seen + 1;
  for (int b = 0; b < f->n_body; b++) {
    count[b] = 0;
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int k = 0; k < 2 && s->joined[g]; k++) {
      const int b = f->body[2 * (ptrdiff_t)g + k];
      if (b >= 0 && 2 * count[b] <= f->dof_start[b + 1] - f->dof_start[b]) {
        const lin_side a = lin_body_space_side(s, g, k);
        const int last = seen_by_group(s, g, &a);
        count[b] = (last > count[b]) ? last : count[b];
      }
    }
  }
  s->seen[0] = 0;
  for (int b = 0; b < f->n_body; b++) {
    s->seen[b + 1] = s->seen[b] + kept(count[b], f->dof_start[b + 1] - f->dof_start[b]);
  }
}

base_status lin_body_space_begin(lin_body_space *s, const lcp_factored *f, const double *G,
                                 bool stored, const double *scale, const unsigned char *member,
                                 base_error *err) {
  const int n = f->row_start[f->n_group], dof = f->dof_start[f->n_body];
  assert(lin_body_space_admits(f, NULL) == BASE_OK);
  if (s->mem == NULL || f->n_group > s->cap_group || n > s->cap_n || dof > s->cap_dof ||
      f->n_body > s->cap_body) {
    s->cap_group = (f->n_group > s->cap_group) ? base_room(f->n_group) : s->cap_group;
    s->cap_n = (n > s->cap_n) ? base_room(n) : s->cap_n;
    s->cap_dof = (dof > s->cap_dof) ? base_room(dof) : s->cap_dof;
    s->cap_body = (f->n_body > s->cap_body) ? base_room(f->n_body) : s->cap_body;
    BASE_TRY(memory(&s->mem, s, layout, err));
  }
  s->f = f;
  s->G = G;
  assert(!stored || scale == NULL);
  s->stored = stored && (f->mixture != NULL || f->stored_start != NULL);
  s->scale = scale;
  int count = 0;
  size_t at = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int before = count;
    s->first[g] = count;
    s->at[g] = at;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      s->row[count] = i;
      count += member[i] != 0;
    }
    s->joined[g] = count > before;
    at += (size_t)(count - before) * (size_t)(count - before);
  }
  s->first[f->n_group] = count;
  s->at[f->n_group] = at;
  find_seen(s);
  if (s->matrix_mem == NULL || at > s->cap_matrices) {
    s->cap_matrices = base_room_of(at);
    BASE_TRY(memory(&s->matrix_mem, s, layout_matrices, err));
  }
  memset(s->T, 0, at * sizeof *s->T);
  memset(s->Y, 0, at * sizeof *s->Y);
  return BASE_OK;
}

/* ---- I + G'KG ---------------------------------------------------------------------------------- */

/* The row from k on with the largest entry of column k. */
static int pivot_row(int n, const double *A, int k) {
  int p = k;
  for (int i = k + 1; i < n; i++) {
    p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
  }
  return p;
}

/* Column k was swapped with from[k], k going up; goes back. */
static void swap_back(int n, const int *from, double *A) {
  for (int k = n - 1; k >= 0; k--) {
    for (int i = 0; i < n && from[k] != k; i++) {
      const double x = A[i + k * n];
      A[i + k * n] = A[i + from[k] * n];
      A[i + from[k] * n] = x;
    }
  }
}

static inline bool invert_of(int n, double *A, double *B) {
  double copy[LIN_GROUP_MAX];
  int from[LIN_GROUP_MAX];
  for (int k = 0; k < n; k++) {
    const int p = from[k] = pivot_row(n, A, k);
    const double pivot = A[p + k * n];
    if (!(fabs(pivot) > 0)) {
      return false;
    }
    for (int j = 0; j < n; j++) {
      const double a = A[p + j * n], b = B[p + j * n];
      A[p + j * n] = A[k + j * n];
      B[p + j * n] = B[k + j * n];
      A[k + j * n] = ((j == k) ? 1.0 : a) / pivot;
      B[k + j * n] = b / pivot;
    }
    for (int i = 0; i < n; i++) {
      copy[i] = (i == k) ? 0 : A[i + k * n];
      A[i + k * n] = (i == k) ? A[i + k * n] : 0;
    }
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        A[i + j * n] -= copy[i] * A[k + j * n];
        B[i + j * n] -= copy[i] * B[k + j * n];
      }
    }
  }
  swap_back(n, from, A);
  return true;
}

static inline bool is_diagonal(int n, const double *A) {
  bool diagonal = true;
  for (int j = 0; j < n && diagonal; j++) {
    for (int i = 0; i < n; i++) {
      diagonal = diagonal && (i == j || A[i + j * n] == 0);
    }
  }
  return diagonal;
}

/* The same of a diagonal A. */
static bool invert_diagonal(int n, double *A, double *B) {
  for (int k = 0; k < n; k++) {
    double *pivot = &A[k + k * n];
    if (!(fabs(*pivot) > 0)) {
      return false;
    }
    for (int j = 0; j < n; j++) {
      B[k + j * n] /= *pivot;
    }
    *pivot = 1 / *pivot;
  }
  return true;
}

/* A (n x n, by columns) -> its inverse by Gauss-Jordan with row pivoting; B <- A^-1 B. False: singular. */
static bool invert(int n, double *A, double *B) {
  if (is_diagonal(n, A)) {
    return invert_diagonal(n, A, B);
  }
  return (n == 3) ? invert_of(3, A, B) : invert_of(n, A, B);
}

static void mirror(int n, double *K) {
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < j; i++) {
      K[i + j * n] = K[j + i * n] = 0.5 * (K[i + j * n] + K[j + i * n]);
    }
  }
}

/* Q = K A, rows x n, A's rows that many. */
BASE_INLINE void multiply(int rows, int n, const double *K, const double *A, double *Q) {
  for (int r = 0; r < rows; r++) {
    for (int j = 0; j < n; j++) {
      Q[r * n + j] = K[r] * A[j];
    }
    for (int i = 1; i < rows; i++) {
      for (int j = 0; j < n; j++) {
        Q[r * n + j] += K[r + i * rows] * A[i * n + j];
      }
    }
  }
}

/* B += A' Q, m x n, over `rows` rows. */
BASE_INLINE void cross(int rows, const double *A, const double *Q, double *restrict B, int m,
                       int n) {
  for (int i = 0; i < m; i++) {
    for (int r = 0; r < rows; r++) {
      for (int j = 0; j < n; j++) {
        B[i * n + j] += A[r * m + i] * Q[r * n + j];
      }
    }
  }
}

/* The same with what contacts in space mostly have, three rows or one and bodies of six velocities, as constants. */
BASE_INLINE void multiply_sized(int rows, int n, const double *K, const double *A, double *Q) {
  if (n == 6 && rows == 3) {
    multiply(3, 6, K, A, Q);
  } else if (n == 6 && rows == 1) {
    multiply(1, 6, K, A, Q);
  } else {
    multiply(rows, n, K, A, Q);
  }
}

BASE_INLINE void cross_sized(int rows, const double *A, const double *Q, double *B, int m, int n) {
  if (m == 6 && n == 6 && rows == 3) {
    cross(3, A, Q, B, 6, 6);
  } else if (m == 6 && n == 6 && rows == 1) {
    cross(1, A, Q, B, 6, 6);
  } else {
    cross(rows, A, Q, B, m, n);
  }
}

/* G'KG of groups that follow one another between the same bodies: block [l][k] has rows of body l and columns of body k. */
typedef struct meeting {
  const int *body; /* 2; NULL: no group yet */
  int dof[2];
  double B[2][2][LIN_BLOCK_MAX * LIN_BLOCK_MAX];
} meeting;

static void end_meeting(lin_body_space *s, meeting *m) {
  for (int k = 0; k < 2 && m->body != NULL; k++) {
    for (int l = 0; l < 2; l++) {
      if (m->dof[k] > 0 && m->dof[l] > 0) {
        lin_blocks_add(&s->blocks, m->body[l], m->body[k], m->B[l][k]);
      }
    }
  }
  m->body = NULL;
}

static void meet(lin_body_space *s, int g, meeting *m) {
  const int *body = &s->f->body[2 * (ptrdiff_t)g];
  if (m->body != NULL && m->body[0] == body[0] && m->body[1] == body[1]) {
    return;
  }
  end_meeting(s, m);
  m->body = body;
  for (int k = 0; k < 2; k++) {
    m->dof[k] = lin_body_space_seen(s, body[k]);
  }
  for (int k = 0; k < 2; k++) {
    for (int l = 0; l < 2; l++) {
      memset(m->B[l][k], 0, (size_t)(m->dof[l] * m->dof[k]) * sizeof(double));
    }
  }
}

const double *lin_body_space_copy(const lin_side *a, int first, int n, int seen, double *room) {
  for (int m = 0; m < n; m++) {
    memcpy(room + (ptrdiff_t)m * seen, a->jac + (ptrdiff_t)(first + m) * a->dof,
           (size_t)seen * sizeof *room);
  }
  return room;
}

const double *lin_body_space_gather(const lin_body_space *s, int g, const lin_side *a,
                                    double *room) {
  const int *row;
  const int n = lin_body_space_rows(s, g, &row), seen = lin_body_space_seen(s, a->body);
  for (int m = 0; m < n; m++) {
    const double *G = a->jac + (ptrdiff_t)(row[m] - s->f->row_start[g]) * a->dof;
    for (int i = 0; i < seen; i++) {
      room[m * seen + i] = ((s->scale != NULL) ? s->scale[row[m]] : 1) * G[i];
    }
  }
  return room;
}

/* K of the rows of a group in the system, as one of those that they are mixed of. */
BASE_INLINE void mix_both(const lin_body_space *s, int g, const lcp_mixture *mix, int n,
                          const double *K, double *out) {
  const int *row = s->row + s->first[g], stored = mix->stored;
  double half[LCP_STORED_MAX * LIN_GROUP_MAX]; /* c' K, stored x n by columns */
  for (int j = 0; j < n; j++) {
    for (int k = 0; k < stored; k++) {
      half[k + j * stored] = 0;
      for (int i = 0; i < n; i++) {
        half[k + j * stored] += mix->c[(row[i] - s->f->row_start[g]) * stored + k] * K[i + j * n];
      }
    }
  }
  for (int l = 0; l < stored; l++) {
    for (int k = 0; k < stored; k++) {
      out[k + l * stored] = 0;
      for (int j = 0; j < n; j++) {
        out[k + l * stored] +=
            half[k + j * stored] * mix->c[(row[j] - s->f->row_start[g]) * stored + l];
      }
    }
  }
}

/* Adds G'KG of a group with rows in the system. */
BASE_INLINE void add_group(lin_body_space *s, int g, meeting *m) {
  double room[2][LIN_GROUP_MAX * LIN_BLOCK_MAX], Q[LIN_GROUP_MAX * LIN_BLOCK_MAX];
  double mixed[LCP_STORED_MAX * LCP_STORED_MAX];
  const lcp_mixture *mix = lin_body_space_mixture(s, g);
  const double *A[2], *K = s->Y + s->at[g];
  int n = s->first[g + 1] - s->first[g];
  meet(s, g, m);
  const int only = (mix != NULL) ? lin_body_space_only(s, g, mix, n) : -1;
  if (mix != NULL && only < 0) {
    mix_both(s, g, mix, n, K, mixed);
    K = mixed;
    n = mix->stored;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side side = lin_body_space_side(s, g, k);
    const int from = (only > 0) ? only : 0;
    A[k] = (m->dof[k] == 0) ? NULL
           : (mix != NULL)  ? lin_body_space_narrowed(&side, from, n, m->dof[k], room[k])
                            : lin_body_space_part(s, g, n, &side, room[k]);
  }
  for (int k = 0; k < 2; k++) {
    if (m->dof[k] > 0) {
      multiply_sized(n, m->dof[k], K, A[k], Q);
    }
    for (int l = 0; l < 2; l++) {
      const bool read =
          m->dof[k] > 0 && m->dof[l] > 0 &&
          !(s->blocks.symmetric && s->blocks.place[m->body[l]] < s->blocks.place[m->body[k]]);
      if (read) {
        cross_sized(n, A[l], Q, m->B[l][k], m->dof[l], m->dof[k]);
      }
    }
  }
}

BASE_CLONES static void add_groups(lin_body_space *s) {
  meeting m = {.body = NULL};
  for (int g = 0; g < s->f->n_group; g++) {
    if (s->joined[g]) {
      add_group(s, g, &m);
    }
  }
  end_meeting(s, &m);
}

/* The pairs of bodies that meet in groups of the system: contacts of two bodies follow one another, one pair for them. */
static size_t find_pairs(lin_body_space *s) {
  const lcp_factored *f = s->f;
  size_t n = 0;
  for (int g = 0; g < f->n_group; g++) {
    const int a = f->body[2 * (ptrdiff_t)g], b = f->body[2 * (ptrdiff_t)g + 1];
    if (s->joined[g] && a >= 0 && b >= 0 && a != b) {
      const bool again = n > 0 && s->pair[2 * n - 2] == a && s->pair[2 * n - 1] == b;
      s->pair[2 * n] = a;
      s->pair[2 * n + 1] = b;
      n += !again;
    }
  }
  return n;
}

static void add_one(lin_body_space *s) {
  for (int b = 0; b < s->f->n_body; b++) {
    double one[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    const int n = lin_body_space_seen(s, b);
    for (int k = 0; k < n; k++) {
      one[k + k * n] = 1;
    }
    lin_blocks_add(&s->blocks, b, b, one);
  }
}

base_status lin_body_space_factor(lin_body_space *s, bool symmetric, bool *regular,
                                  base_error *err) {
  const lcp_factored *f = s->f;
  *regular = false;
  for (int g = 0; g < f->n_group; g++) {
    const int n = s->first[g + 1] - s->first[g];
    if (!invert(n, s->T + s->at[g], s->Y + s->at[g])) {
      return BASE_OK;
    }
    if (symmetric) {
      mirror(n, s->Y + s->at[g]);
    }
  }
  BASE_TRY(lin_blocks_plan(&s->blocks, f->n_body, s->seen, s->pair, find_pairs(s), err));
  lin_blocks_clear(&s->blocks, symmetric);
  add_one(s);
  add_groups(s);
  *regular = lin_blocks_factor(&s->blocks);
  return BASE_OK;
}
