#include "formulations/row_form.h"

#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

enum {
  PLAIN = 3,     /* solves whose bounds follow the last answer: most steps need no more */
  MIXED = 30,    /* solves of a round before its safeguarded part */
  ROUND = 60,    /* of a round */
  SAFE = 8,      /* safeguarded moves before a trial */
  TRIAL = 2,     /* Newton steps of a trial */
  LARGEST = 1000 /* rows of a step whose matrix is factored for its bounds */
};

static const double SHARE_UP = 1.3;
/* Compliance over C_ii that chooses among redundant impulses as equal springs do. */
static const double spring = 1e-11;

static void layout(void *state, base_arena *m) {
  boxed_bounds *b = state;
  b->base = BASE_ARRAY(m, double, b->cap_contact);
  b->share = BASE_ARRAY(m, double, b->cap_contact);
  b->moved = BASE_ARRAY(m, double, b->cap_contact);
}

static void layout_dense(void *state, base_arena *m) {
  boxed_bounds *b = state;
  const size_t n = (size_t)b->cap_row;
  b->M = BASE_ARRAY(m, double, n *n);
  b->A = BASE_ARRAY(m, double, n *n);
  b->x = BASE_ARRAY(m, double, n);
  b->side = BASE_ARRAY(m, double, n);
  b->between = BASE_ARRAY(m, int, n);
  b->pivot = BASE_ARRAY(m, int, n);
}

void boxed_bounds_close(boxed_bounds *b) {
  anderson_close(&b->mixing);
  free(b->mem);
  free(b->dense_mem);
  *b = (boxed_bounds){0};
}

base_status boxed_bounds_begin(boxed_bounds *b, int n_contact, base_error *err) {
  b->taken = 0;
  b->first = true;
  b->trial = false;
  b->anew = false;
  b->filled = false;
  if (b->mem == NULL || n_contact > b->cap_contact) {
    b->cap_contact = base_room(n_contact) + 4;
    BASE_TRY(form_memory(&b->mem, layout, b, err));
  }
  return anderson_begin(&b->mixing, n_contact, err);
}

/* ---- Newton's step ----------------------------------------------------------------------------*/

/* Where a row goes from z: to a bound or between. */
static double side_of(const row_form *s, int row, double z) {
  const double step = (s->diagonal[row] > 0) ? s->w[row] / s->diagonal[row] : s->w[row];
  return (z - step >= s->hi[row]) ? 1 : ((z - step <= s->lo[row]) ? -1 : 0);
}

/* Adds what the rows of contact i at their bounds do with its normal impulse to that column. */
static void add_bounds(const boxed_bounds *b, const row_form *s, int i, int count, double *column) {
  for (int row = s->a.row[i] + 1; row < s->a.row[i + 1]; row++) {
    const double *from = b->M + (ptrdiff_t)row * s->a.n_row;
    for (int r = 0; r < count && b->side[row] != 0; r++) {
      column[r] += b->side[row] * s->mu[row] * from[b->between[r]];
    }
  }
}

/* Column c of the system, of a row of group i. */
static void fill_column(const boxed_bounds *b, const row_form *s, int i, int c, int count) {
  const int at = b->between[c];
  const double *from = b->M + (ptrdiff_t)at * s->a.n_row;
  double *column = b->A + (ptrdiff_t)c * count;
  for (int r = 0; r < count; r++) {
    column[r] = from[b->between[r]];
  }
  column[c] += spring * s->diagonal[at];
  if (i < s->a.n_contact && at == s->a.row[i]) {
    add_bounds(b, s, i, count, column);
  }
  b->x[c] = -s->q[at];
}

static base_status fill_matrix(boxed_bounds *b, const row_form *s, base_error *err) {
  if (s->a.n_row > b->cap_row) {
    b->cap_row = base_room(s->a.n_row);
    BASE_TRY(form_memory(&b->dense_mem, layout_dense, b, err));
  }
  lcp_matrix_to_dense(&s->matrix.M, b->M);
  b->filled = true;
  return BASE_OK;
}

/* s->normal of the linear system; as it was where that is singular or larger than what is factored. */
static base_status newton(boxed_bounds *b, row_form *s, const double *z, base_error *err) {
  const int n = s->a.n_row;
  int count = 0;
  if (n > LARGEST) {
    return BASE_OK;
  }
  if (!b->filled) {
    BASE_TRY(fill_matrix(b, s, err));
  }
  for (int row = 0; row < n; row++) {
    b->side[row] = side_of(s, row, z[row]);
    b->between[count] = row;
    count += b->side[row] == 0;
  }
  for (int i = 0, c = 0; i < s->a.n_group; i++) {
    for (; c < count && b->between[c] < s->a.row[i + 1]; c++) {
      fill_column(b, s, i, c, count);
    }
  }
  if (count == 0 ||
      LAPACKE_dgesv(LAPACK_COL_MAJOR, count, 1, b->A, count, b->pivot, b->x, count) != 0) {
    return BASE_OK;
  }
  for (int i = 0, c = 0; i < s->a.n_contact; i++) {
    s->normal[i] = 0;
    for (; c < count && b->between[c] < s->a.row[i + 1]; c++) {
      s->normal[i] = (b->between[c] == s->a.row[i]) ? fmax(b->x[c], 0) : s->normal[i];
    }
  }
  return BASE_OK;
}

/* ---- the loop ---------------------------------------------------------------------------------*/

static void safeguarded(boxed_bounds *b, row_form *s, bool anew) {
  for (int i = 0; i < s->a.n_contact; i++) {
    const double turn = anew ? 0 : s->move[i] * b->moved[i];
    b->share[i] = anew ? 0.5 : b->share[i];
    b->share[i] = (turn < 0) ? 0.5 * b->share[i] : b->share[i];
    b->share[i] = (turn > 0) ? fmin(1, SHARE_UP * b->share[i]) : b->share[i];
    b->moved[i] = s->move[i];
    s->normal[i] += b->share[i] * s->move[i];
    b->base[i] = s->normal[i];
  }
}

static base_status mixed(boxed_bounds *b, row_form *s, base_error *err) {
  if (b->taken == ROUND) {
    b->taken = 0;
    b->first = false;
    BASE_TRY(anderson_begin(&b->mixing, s->a.n_contact, err));
  }
  return anderson_next(&b->mixing, s->move, b->first ? PLAIN : 1, s->normal, err);
}

base_status boxed_bounds_next(boxed_bounds *b, row_form *s, const double *z, bool solved,
                              base_error *err) {
  const bool given_up = b->trial && !solved;
  b->taken++;
  b->trial = false;
  if (b->taken < MIXED || (b->taken == ROUND && !given_up)) {
    return mixed(b, s, err);
  }
  const int turn = (b->taken - MIXED) % (SAFE + TRIAL + 1);
  if (turn < SAFE && !given_up) {
    safeguarded(b, s, b->taken == MIXED);
  } else if (turn < SAFE + TRIAL && !given_up) {
    b->trial = true;
    return newton(b, s, z, err);
  } else {
    memcpy(s->normal, b->base, (size_t)s->a.n_contact * sizeof *s->normal);
  }
  return BASE_OK;
}
