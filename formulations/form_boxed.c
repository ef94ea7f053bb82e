/* form_boxed.c - friction rows with fixed bounds: |lambda_t| <= mu lambda_n', each tangent on its
 * own, with lambda_n' from the last solve (Peiret, Gholami, Kovecses & Font-Llagunes 2016, and the
 * common game engines). M is symmetric positive semidefinite, so every solve has a solution; the
 * bounds are iterated until the answer satisfies the bounds that follow from it (outer = 1: once,
 * with the impulses of the last step), which takes no second solve where contacts stick inside them. How bounds that do not
 * settle in three solves are found: boxed/boxed_bounds.h.
 * A square box is up to sqrt(2) too strong along its diagonal.
 *
 * bristle=k, damper=c: a friction row gives way like a spring and a damper in parallel, s its deflection, implicit in the step
 * as in regularized.h (MATHEMATICS 2.6.2):
 *
 *   w_t = v_t + (h k / G) s + lambda_t / G,   G = h^2 k + h c,   s+ = (c s - lambda_t) / (h k + c)
 *
 * at a bound and inside; in the plane this is the law of `regularized`. */
#include "formulations/bristle.h"
#include "formulations/row_form.h"

#include <string.h>

typedef row_options options;

/* Missing friction counts by the velocities that it leaves from this share of the sought ones on, times outer_tol: rounding
 * of impulses 1e10 times as large leaves 1e-6. */
static const double seen = 100;

static const base_field fields[] = {
    BASE_FIELD(options, outer, BASE_INT, "1", 300, 1, 1e6, "most solves in a step; 1: lagged"),
    BASE_FIELD(options, bristle, BASE_REAL, "N/m", 0, 0, 1e18,
               "stiffness of friction rows; 0: rigid"),
    BASE_FIELD(options, damper, BASE_REAL, "N s/m", 0, 0, 1e18, "damping of friction rows"),
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
        s->mu[row] = mu[p];
        s->hi[row] = mu[p] * fmax(s->normal[i], 0.0);
        s->lo[row] = -s->hi[row];
      }
    }
  }
}

/* ---- bristles ---------------------------------------------------------------------------------*/

static bool has_bristles(const row_form *s) {
  return s->opt.bristle > 0 || s->opt.damper > 0;
}

/* Stiffness and damping of a row of contact i in those of the options: torsion and rolling have the spring at an arm of their
 * coefficient, and copies of a contact share it. */
static double stiffness_of(const row_form *s, int i, int kind) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  const double arm = (kind == 0) ? 1 : ((kind == 1) ? c->mu_torsion[g] : c->mu_rolling[g]);
  return arm * arm / s->copies[i];
}

static void soften_contact(row_form *s, int i) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  const bool known = contact_memory_old(&s->memory, g) != NULL;
  const double h = c->h;
  double deflection[6] = {0}, soft[6] = {0}, pull[6] = {0};
  for (int kind = 0; kind < LCP_PARTS_MAX; kind++) {
    int first;
    const int dim = form_bristle_rows(c->rows[g], kind, &first);
    const double stiffness = (dim > 0) ? stiffness_of(s, i, kind) : 0;
    const double k = s->opt.bristle * stiffness, G = h * (h * k + s->opt.damper * stiffness);
    double force[2] = {0};
    if (known && k > 0) {
      form_bristle_pull(c, g, kind, &s->memory, force);
    }
    for (int m = 0; m < dim; m++) {
      soft[first + m] = 1 / G;
      pull[first + m] = h * k / G;
      deflection[first + m] = (k > 0) ? force[m] / k : 0;
    }
  }
  const int row = s->a.row[i];
  int at =
      1; /* kinds keep their order in the rows in use, and one stiffness has all rows of a kind */
  form_to_rows(&s->a, i, deflection, s->deflection + row);
  for (int kind = 0; kind < LCP_PARTS_MAX; kind++) {
    int first, unused;
    (void)form_bristle_rows(c->rows[g], kind, &first);
    for (int m = form_bristle_rows(s->a.rows[i], kind, &unused); m > 0; m--, at++) {
      s->soft[row + at] = soft[first];
      s->q[row + at] += pull[first] * s->deflection[row + at];
    }
  }
}

/* The compliance of friction rows into M, what their deflections push into q. */
static void soften(row_form *s) {
  form_bristle_sharers(s->a.set, s->a.n_contact, s->a.group,
                       (s->opt.distribution == FORM_EXTREME) ? FORM_BRISTLE_EACH
                                                             : FORM_BRISTLE_COPIES,
                       s->bodies, s->copies);
  memset(s->soft, 0, (size_t)s->a.n_row * sizeof *s->soft);
  for (int i = 0; i < s->a.n_contact; i++) {
    soften_contact(s, i);
  }
  row_matrix_soften(&s->matrix, s->soft);
}

/* Next deflections of contact i, and what is said of them. */
static void deflect(row_form *s, int i, const double *lambda) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i], row = s->a.row[i];
  const double h = c->h, creep = h * s->opt.bristle + s->opt.damper;
  double next[6] = {0}, force[6] = {0}, whole[6] = {0}; /* force: of the springs */
  double *now = contact_memory_now(&s->memory, g);
  int dim[LCP_PARTS_MAX], at = 1;
  double mu[LCP_PARTS_MAX];
  const int parts = row_form_parts(s, i, dim, mu);
  formulation_answer *out = &s->answer;
  for (int p = 0, kind = 0; p < parts; p++, kind++) {
    int first;
    while (form_bristle_rows(s->a.rows[i], kind, &first) == 0) {
      kind++;
    }
    const double stiffness = stiffness_of(s, i, kind);
    for (int m = 0; m < dim[p]; m++, at++) {
      next[at] = (s->opt.damper * stiffness * s->deflection[row + at] - lambda[row + at]) /
                 (creep * stiffness);
      force[at] = s->opt.bristle * stiffness * next[at];
      const double energy = 0.5 * s->opt.bristle * stiffness * next[at] * next[at];
      out->spring_energy += energy;
      now[PAST_ENERGY] += energy;
    }
    if (kind == 0) {
      const double mass = 1 / form_mobility(&s->a, i, 1, dim[p]),
                   bound = mu[p] * fmax(lambda[row], 0.0);
      out->stiffness_ratio = fmin(out->stiffness_ratio, h * creep / mass);
      if (s->opt.bristle > 0) {
        out->deflection = fmax(out->deflection, bound / (h * s->opt.bristle * stiffness));
      } else {
        out->v_slip = fmax(out->v_slip, bound / (h * s->opt.damper * stiffness));
      }
    }
  }
  form_to_set(&s->a, i, force, whole);
  for (int kind = 0; kind < LCP_PARTS_MAX; kind++) {
    int first;
    const int rows = form_bristle_rows(c->rows[g], kind, &first);
    if (rows > 0) {
      form_bristle_remember(c, g, rows, whole + first,
                            now + contact_memory_pulls(&s->memory) +
                                (ptrdiff_t)PAST_PULL_NUMBERS * kind);
    }
  }
}

static void finish(row_form *s, const double *z, bool solved) {
  for (int i = 0; i < s->a.n_contact && has_bristles(s); i++) {
    double *now = contact_memory_now(&s->memory, s->a.group[i]);
    now[PAST_SPRUNG] = s->opt.bristle > 0;
    now[PAST_ENERGY] = 0;
    memset(now + contact_memory_pulls(&s->memory), 0, (size_t)s->memory.layout.pull * sizeof *now);
    if (z[s->a.row[i]] > 0 || s->a.set->gap[s->a.group[i]] <= 10 * s->a.set->tol) {
      deflect(s, i, z); /* else separated: forgotten */
    }
  }
  row_form_finish(s, z, solved);
}

/* ---- a step -----------------------------------------------------------------------------------*/

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  row_form *s = state;
  BASE_TRY(row_form_begin(s, c, opt, start, err));
  if (has_bristles(s)) {
    soften(s);
  }
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
  return boxed_bounds_begin(&s->bounds, s->a.n_contact, err);
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
 * impulse. Friction counts: where nothing presses, bounds of the last answer may have let it push all the same.
 * Impulses of a jam grow from solve to solve and would hide any friction that is missing, so what it
 * moves its row by is also measured against the velocities that are to be stopped, over `seen`. */
static double residual(row_form *s, const double *z, double largest) {
  double most = 0, moved = 0, size = 0;
  lcp_matrix_apply(&s->matrix.M, z, s->q, s->w, s->scratch);
  for (int i = 0; i < s->a.n_contact; i++) {
    for (int row = s->a.row[i]; row < s->a.row[i + 1]; row++) {
      const double unit = (s->diagonal[row] > 0) ? sqrt(s->diagonal[row]) : 0;
      size = (unit > 0) ? fmax(size, fabs(s->q[row]) / unit) : size;
      if (row == s->a.row[i]) {
        continue;
      }
      const double end = (s->w[row] > 0) ? HUGE_VAL : ((s->w[row] < 0) ? -HUGE_VAL : 0);
      const double step = (s->diagonal[row] > 0) ? s->w[row] / s->diagonal[row] : end;
      const double wanted = fmin(fmax(z[row] - step, s->lo[row]), s->hi[row]);
      most = fmax(most, fabs(z[row] - wanted));
      moved = fmax(moved, unit * fabs(z[row] - wanted));
      largest = fmax(largest, fabs(z[row]));
    }
  }
  const double of_data = (size > 0) ? moved / size / seen : 0;
  return (largest > 0) ? fmax(most / largest, of_data) : 0;
}

/* Bounds for the next solve: where friction feeds back on the normal impulses, bounds that only follow them turn in circles
 * (boxed/boxed_bounds.h). */
static base_status go_on(row_form *s, const double *z, bool solved, base_error *err) {
  for (int i = 0; i < s->a.n_contact; i++) {
    s->normal[i] -= s->move[i];
  }
  set_bounds(s); /* those of the answer, which say what stands where */
  BASE_TRY(boxed_bounds_next(&s->bounds, s, z, solved, err));
  set_bounds(s);
  if (s->bounds.anew) { /* the way from zero ends elsewhere within the tolerance */
    memset(s->z0, 0, (size_t)s->a.n_row * sizeof *s->z0);
  } else if (s->start == FORM_PREVIOUS && solved) {
    memcpy(s->z0, z, (size_t)s->a.n_row * sizeof *z);
  }
  return BASE_OK;
}

/* Did the solver give its start back, under the bounds of that? It stops at its tolerance, which may be looser than the loop's: then
 * nothing changes any more. */
static bool given_back(const row_form *s, const double *z) {
  bool same = s->start == FORM_PREVIOUS;
  for (int i = 0; i < s->a.n_contact && same; i++) {
    same = s->move[i] == 0;
  }
  return same && memcmp(s->z0, z, (size_t)s->a.n_row * sizeof *z) == 0;
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
  const bool solved = claimed == LCP_SOLVED, last = s->answer.work.solves >= s->opt.outer;
  const bool settled = solved && s->answer.residual <= s->opt.outer_tol;
  if (settled || last || (!solved && !s->bounds.trial)) {
    finish(s, z, solved && (settled || s->opt.outer == 1));
    return BASE_OK;
  }
  s->bounds.anew = s->bounds.anew || (solved && given_back(s, z));
  return go_on(s, z, solved, err);
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
