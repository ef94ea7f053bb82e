/* form_boxed.c - friction rows with fixed bounds: |lambda_t| <= mu lambda_n', each tangent on its
 * own, with lambda_n' from the last solve (Peiret, Gholami, Kovecses & Font-Llagunes 2016, and the
 * common game engines). M is symmetric positive semidefinite, so every solve has a solution; the
 * bounds are iterated until they stand still (outer = 1: once, with the impulses of the last
 * step). A square box is up to sqrt(2) too strong along its diagonal. */
#include "formulations/row_form.h"

#include <string.h>

typedef row_options options;

static const base_field fields[] = {
    BASE_FIELD(options, outer, BASE_INT, "1", 100, 1, 1e6, "most solves in a step; 1: lagged"),
    BASE_FIELD(options, outer_tol, BASE_REAL, "1", 1e-8, 1e-15, 1, "change of the bounds"),
    ROW_FORM_FIELDS(options),
};

static long dimension(int dim, int p, const void *opt) {
  (void)opt;
  return (long)p * dim;
}

static void set_bounds(row_form *s) {
  for (int i = 0; i < s->a.n_contact; i++) {
    int dim[LCP_PARTS_MAX];
    double mu[LCP_PARTS_MAX];
    const int parts = row_form_parts(s, i, dim, mu);
    int row = s->a.row[i] + 1;
    for (int p = 0; p < parts; p++) {
      for (int k = 0; k < dim[p]; k++, row++) {
        s->hi[row] = mu[p] * fmax(s->normal[i], 0.0);
        s->lo[row] = -s->hi[row];
      }
    }
  }
}

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  row_form *s = state;
  BASE_TRY(row_form_begin(s, c, opt, start, err));
  for (int i = 0; i < s->a.n_group; i++) {
    const int rows = form_rows_of(&s->a, i);
    const int row = s->a.row[i];
    if (i >= s->a.n_contact) {
      s->block[s->n_block++] = (lcp_block){.start = row, .size = rows, .set = LCP_FREE};
      continue;
    }
    s->lo[row] = 0;
    s->hi[row] = HUGE_VAL;
    s->block[s->n_block++] = (lcp_block){.start = row, .size = 1, .set = LCP_ORTHANT};
    if (rows > 1) {
      s->block[s->n_block++] = (lcp_block){.start = row + 1, .size = rows - 1, .set = LCP_BOX};
    }
  }
  for (int i = s->a.n_contact; i < s->a.n_group; i++) {
    for (int row = s->a.row[i]; row < s->a.row[i + 1]; row++) {
      s->lo[row] = -HUGE_VAL;
      s->hi[row] = HUGE_VAL;
    }
  }
  set_bounds(s);
  return BASE_OK;
}

static base_status assemble(void *state, lcp_problem *out, const double **z0, bool *pending,
                            base_error *err) {
  (void)err;
  row_form *s = state;
  *pending = !s->done;
  if (*pending) {
    *out = (lcp_problem){.M = s->matrix.M,
                         .q = s->q,
                         .lo = s->lo,
                         .hi = s->hi,
                         .block = s->block,
                         .n_block = s->n_block,
                         .traits = LCP_SYMMETRIC | LCP_PSD};
    *z0 = s->z0;
    s->answer.work.solves++;
  }
  return BASE_OK;
}

static base_status recover(void *state, const double *z, lcp_outcome claimed, base_error *err) {
  (void)err;
  row_form *s = state;
  double change = 0;
  double largest = 0;
  for (int i = 0; i < s->a.n_contact; i++) {
    const double now = fmax(z[s->a.row[i]], 0.0);
    const bool friction = form_rows_of(&s->a, i) > 1;
    change = fmax(change, friction ? fabs(now - s->normal[i]) : 0);
    largest = fmax(largest, now);
    s->normal[i] = now;
  }
  s->answer.residual = (largest > 0) ? change / largest : 0;
  const bool settled = s->answer.residual <= s->opt.outer_tol;
  if (settled || claimed != LCP_SOLVED || s->answer.work.solves >= s->opt.outer) {
    row_form_finish(s, z, claimed == LCP_SOLVED && (settled || s->opt.outer == 1));
    return BASE_OK;
  }
  if (s->start == FORM_PREVIOUS) {
    memcpy(s->z0, z, (size_t)s->a.n_row * sizeof *z);
  }
  set_bounds(s);
  return BASE_OK;
}

const formulation form_boxed = {
    .name = "boxed",
    .title = "Boxed friction, bounds from the last normal impulse",
    .cite = "Peiret, Gholami, Kovecses & Font-Llagunes 2016",
    .model = FORM_UNILATERAL | FORM_FRICTION | FORM_BOUNDS_LAGGED,
    .stands_for = NULL,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(row_form),
    .dimension = dimension,
    .close = row_form_close,
    .forget = row_form_forget,
    .begin = begin,
    .assemble = assemble,
    .recover = recover,
    .answer = row_form_answer,
};
