/* form_boxed.c - friction rows with fixed bounds: |lambda_t| <= mu lambda_n', each tangent on its
 * own, with lambda_n' from the last solve (Peiret, Gholami, Kovecses & Font-Llagunes 2016, and the
 * common game engines). M is symmetric positive semidefinite, so every solve has a solution; the
 * bounds are iterated until the answer satisfies the bounds that follow from it (outer = 1: once,
 * with the impulses of the last step), which takes no second solve where contacts stick inside them. Bounds that do not
 * settle in three solves are mixed (anderson.h).
 * A square box is up to sqrt(2) too strong along its diagonal. */
#include "formulations/row_form.h"

#include <string.h>

typedef row_options options;

static const base_field fields[] = {
    BASE_FIELD(options, outer, BASE_INT, "1", 100, 1, 1e6, "most solves in a step; 1: lagged"),
    BASE_FIELD(options, outer_tol, BASE_REAL, "1", 1e-8, 1e-15, 1, "what moved bounds change"),
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
  lcp_matrix_diagonal(&s->matrix.M, s->diagonal); /* the bounds move in a step, M does not */
  for (int i = 0; i < s->a.n_group; i++) {
    const int rows = form_rows_of(&s->a, i);
    const int row = s->a.row[i];
    if (i >= s->a.n_contact) {
      s->block[s->n_block++] = (lcp_block){.start = row, .size = rows, .set = LCP_FREE};
      continue;
    }
    s->lo[row] = 0;
    s->hi[row] = HUGE_VAL;
    s->block[s->n_block++] = (lcp_block){.start = row,
                                         .size = 1,
                                         .set = LCP_ORTHANT,
                                         .soft = form_soft(c, s->a.group[i], s->opt.distribution)};
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
  return anderson_begin(&s->mixing, s->a.n_contact, err);
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

/* How far the friction impulses of z are from those that the bounds now in place ask for, by the
 * natural map of each row, which takes a row that cannot move to the bound that its velocity asks for; over the largest
 * normal impulse. */
static double residual(row_form *s, const double *z, double largest) {
  double most = 0;
  lcp_matrix_apply(&s->matrix.M, z, s->q, s->w, s->scratch);
  for (int i = 0; i < s->a.n_contact; i++) {
    for (int row = s->a.row[i] + 1; row < s->a.row[i + 1]; row++) {
      const double end = (s->w[row] > 0) ? HUGE_VAL : ((s->w[row] < 0) ? -HUGE_VAL : 0);
      const double step = (s->diagonal[row] > 0) ? s->w[row] / s->diagonal[row] : end;
      const double wanted = fmin(fmax(z[row] - step, s->lo[row]), s->hi[row]);
      most = fmax(most, fabs(z[row] - wanted));
    }
  }
  return (largest > 0) ? most / largest : 0;
}

enum { PLAIN = 3 }; /* solves whose bounds follow the last answer: most steps need no more */

/* Bounds for the next solve. Where friction feeds back on the normal impulses, bounds that only follow them turn in
 * circles: their moves are mixed. */
static base_status go_on(row_form *s, base_error *err) {
  for (int i = 0; i < s->a.n_contact; i++) {
    s->normal[i] -= s->move[i];
  }
  BASE_TRY(anderson_next(&s->mixing, s->move, PLAIN, s->normal, err));
  set_bounds(s);
  return BASE_OK;
}

static base_status recover(void *state, const double *z, lcp_outcome claimed, base_error *err) {
  row_form *s = state;
  double largest = 0;
  for (int i = 0; i < s->a.n_contact; i++) {
    const double found = fmax(z[s->a.row[i]], 0.0);
    s->move[i] = found - s->normal[i];
    s->normal[i] = found;
    largest = fmax(largest, found);
  }
  set_bounds(s);
  s->answer.residual = residual(s, z, largest);
  const bool settled = s->answer.residual <= s->opt.outer_tol;
  if (settled || claimed != LCP_SOLVED || s->answer.work.solves >= s->opt.outer) {
    row_form_finish(s, z, claimed == LCP_SOLVED && (settled || s->opt.outer == 1));
    return BASE_OK;
  }
  BASE_TRY(go_on(s, err));
  if (s->start == FORM_PREVIOUS) {
    memcpy(s->z0, z, (size_t)s->a.n_row * sizeof *z);
  }
  return BASE_OK;
}

const formulation form_boxed = {
    .name = "boxed",
    .title = "Boxed friction, bounds from the last normal impulse",
    .cite = "peiret2016",
    .words = "Friction is bounded by the last normal impulse.",
    .when = "Normal forces change little from one iteration to the next, and a solver of boxes is "
            "at hand.",
    .model = FORM_UNILATERAL | FORM_FRICTION | FORM_BOUNDS_LAGGED,
    .stands_for = NULL,
    .sets = 1u << LCP_ORTHANT | 1u << LCP_BOX,
    ROW_FORM_PARTS,
};
