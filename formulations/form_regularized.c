/* form_regularized.c - the mode iteration of regularized.h (MATHEMATICS 2.3.6): solve the reduced LCP for
 * the current modes, test the friction law, choose new modes, until the law holds. A reduced LCP
 * without a solution means wrong modes, not a step without a solution (MATHEMATICS 2.3.7): all slip then
 * turns to the secant form, whose matrix is symmetric positive semidefinite. */
#include "formulations/regularized/regularized.h"

#include <stdlib.h>
#include <string.h>

typedef reg_options options;

/* The law solved for exactly, and three others (MATHEMATICS 2.3.13). */
static const char *const variants[] = {NULL, "stiffness=fixed,modes=once,prox=0",
                                       "modes=plain,prox=0", "model=lugre"};

static const base_field fields[] = {
    BASE_FIELD_PRESET(options, variant, "newton|paper|plain|lugre", 0, variants,
                      "named choice of the options behind it"),
    BASE_FIELD_CHOICE(options, model, "bristle|viscous|lugre", 0, "law of the static phase"),
    BASE_FIELD_CHOICE(options, bias, "velocity|position", 0, "level of the normal rows"),
    BASE_FIELD_CHOICE(options, stiffness, "ratio|fixed", 0, "scaled to the masses, or k and c"),
    BASE_FIELD(options, ratio, BASE_REAL, "1", 100, 1e-6, 1e15,
               "G/m_t of all contacts of two bodies, G = h^2 k + h c"),
    BASE_FIELD(options, zeta, BASE_REAL, "1", 0.7, 0, 100, "damping of the bristle"),
    BASE_FIELD(options, k, BASE_REAL, "N/m", 1e6, 0, 1e18, "fixed stiffness"),
    BASE_FIELD(options, c, BASE_REAL, "N s/m", 1e3, 0, 1e18, "fixed damping"),
    BASE_FIELD(options, sigma0, BASE_REAL, "N/m", 1e5, 0, 1e15, "LuGre stiffness"),
    BASE_FIELD(options, sigma1, BASE_REAL, "N s/m", 316.22776601683796, 0, 1e15, "LuGre damping"),
    BASE_FIELD(options, sigma2, BASE_REAL, "N s/m", 0.4, 0, 1e15, "LuGre viscous friction"),
    BASE_FIELD(options, v_stribeck, BASE_REAL, "m/s", 1e-3, 1e-12, 1e6, "LuGre Stribeck speed"),
    BASE_FIELD(options, ellipse, BASE_REAL, "1", 1, 1e-3, 1e3, "mu along t2 over mu along t1"),
    BASE_FIELD_CHOICE(options, impact, "keep|boost", 0, "raise G to the ratio at impacts"),
    BASE_FIELD_CHOICE(options, modes, "newton|plain|secant|once", 0, "iteration of stick and slip"),
    BASE_FIELD_CHOICE(options, turned, "sticks|slips", 0, "plain: a slip that has turned round"),
    BASE_FIELD_CHOICE(options, bound, "current|previous", 0, "once: normal impulse of this step"),
    BASE_FIELD_CHOICE(options, integration, "implicit|explicit", 0, "once: force of the bristle"),
    BASE_FIELD_CHOICE(options, bristle, "saturated|reset", 0, "once: deflection while it slides"),
    BASE_FIELD_CHOICE(options, pose, "auto|reduced|cone", 0,
                      "normal impulses alone, or with friction"),
    FORM_STORAGE_FIELD(options),
    BASE_FIELD_CHOICE(options, form, "auto|contact|mass", 0, "where the springs are eliminated"),
    BASE_FIELD_CHOICE(options, factor, "auto|envelope|cholmod", 0, "of form=mass"),
    BASE_FIELD_CHOICE(options, restitution, "newton|none", 0, "law of impact"),
    FORM_ACTIVATION_FIELD(options),
    FORM_DISTRIBUTION_FIELD(options),
    BASE_FIELD(options, tol, BASE_REAL, "1", 1e-9, 1e-15, 1, "law residual to reach"),
    BASE_FIELD(options, mode_iter, BASE_INT, "1", 1000, 1, 1e6, "most solves in a step"),
    BASE_FIELD(options, prox, BASE_REAL, "1", REG_PROX, 0, 1,
               "proximal term from the third solve on"),
    BASE_FIELD(options, newton_iter, BASE_INT, "1", REG_NEWTON_ITER, 0, 1e6,
               "solves before the first secants"),
    FORM_PUSH_FIELDS(options, 0),
    FORM_JOINT_PUSH_FIELD(options),
};

static long dimension(int dim, int p, const void *opt) {
  return (((const options *)opt)->pose == REG_CONE) ? (long)dim * p : p;
}

static void layout_groups(void *state, base_arena *m) {
  regularized *s = state;
  const int p = s->cap_contact;
  s->part = BASE_ARRAY(m, reg_part, s->cap_part);
  s->best_part = BASE_ARRAY(m, reg_part, s->cap_part);
  s->base_part = BASE_ARRAY(m, reg_part, s->cap_iterated);
  s->pairs = BASE_ARRAY(m, reg_pairs, s->cap_iterated);
  s->part_start = BASE_ARRAY(m, int, p + 1);
  s->sharers = BASE_ARRAY(m, int, p);
  s->bodies = BASE_ARRAY(m, form_bristle_key, p);
  s->row_of = BASE_ARRAY(m, int, s->cap_group + 1);
  s->rows = BASE_ARRAY(m, reg_row, s->cap_row);
  s->b = BASE_ARRAY(m, double, p);
  s->z0 = BASE_ARRAY(m, double, p);
  s->anchor = BASE_ARRAY(m, double, p);
  s->lambda = BASE_ARRAY(m, double, s->cap_row);
  s->u = BASE_ARRAY(m, double, s->cap_row);
  s->best = BASE_ARRAY(m, double, s->cap_row);
  s->base = BASE_ARRAY(m, double, s->cap_row);
  s->given = BASE_ARRAY(m, double, s->cap_row);
  s->t = BASE_ARRAY(m, double, s->cap_row);
  s->block = BASE_ARRAY(m, lcp_block, p);
}

static void layout_dense(void *state, base_arena *m) {
  regularized *s = state;
  s->sigma = BASE_ARRAY(m, double, s->cap_sigma);
  s->xyc = BASE_ARRAY(m, double, s->cap_xyc);
  s->A = BASE_ARRAY(m, double, s->cap_A);
}

static size_t larger(size_t have, size_t need) {
  return (need > have) ? base_room_of(need) : have;
}

static int count_parts(const contact_set *c) {
  int n = 0;
  for (int i = 0; i < c->n_contact; i++) {
    const contact_rows r = c->rows[i];
    n += (r.tangent > 0) + (r.torsion > 0) + (r.rolling > 0);
  }
  return n;
}

static base_status grow(regularized *s, base_error *err) {
  const contact_set *c = s->a.set;
  const int n_part = count_parts(c);
  const int iterated = (s->opt.pose == REG_CONE) ? 0 : n_part; /* their modes */
  if (s->mem == NULL || c->n_contact > s->cap_contact || c->n_group > s->cap_group ||
      c->n_row > s->cap_row || n_part > s->cap_part || iterated > s->cap_iterated) {
    s->cap_part = (int)larger((size_t)s->cap_part, (size_t)n_part);
    s->cap_iterated = (int)larger((size_t)s->cap_iterated, (size_t)iterated);
    s->cap_contact = (int)larger((size_t)s->cap_contact, (size_t)c->n_contact);
    s->cap_group = (int)larger((size_t)s->cap_group, (size_t)c->n_group);
    s->cap_row = (int)larger((size_t)s->cap_row, (size_t)c->n_row);
    BASE_TRY(form_memory(&s->mem, layout_groups, s, err));
  }
  if (s->opt.pose == REG_CONE) {
    return BASE_OK;
  }
  const size_t p = (size_t)s->a.n_contact;
  const size_t n = s->by_mass ? 0 : (size_t)s->a.n_row - p; /* most compliant rows */
  if (s->dense_mem == NULL || n * n > s->cap_sigma || n * (2 * p + 1) > s->cap_xyc ||
      p * p > s->cap_A) {
    s->cap_sigma = larger(s->cap_sigma, n * n);
    s->cap_xyc = larger(s->cap_xyc, n * (2 * p + 1));
    s->cap_A = larger(s->cap_A, p * p);
    BASE_TRY(form_memory(&s->dense_mem, layout_dense, s, err));
  }
  return BASE_OK;
}

static void finish(regularized *s, bool solved) {
  s->done = true;
  s->answer.solved = solved;
  reg_commit(s, s->lambda);
  form_assembly_answer(&s->a, s->lambda);
  reg_note_slides(s);
}

/* Redundant contacts leave lambda_n undetermined: a pivoting method jumps from one extreme
 * distribution to another, and the friction bounds with it. The proximal point term
 *
 *   A + delta D,  b - delta D lambda_n',   D = diag C_nn,  lambda_n' of the last iterate
 *
 * keeps what A does not determine at its last value; where the iteration settles it vanishes, and
 * what is left of it counts in the residual (Martinet 1970; Rockafellar 1976). Used from the third
 * solve of a step on: most steps never see it. */
static void add_proximal_term(regularized *s) {
  const int p = s->a.n_contact;
  s->proximal = s->opt.prox > 0 && s->iteration >= 2 && s->opt.distribution == FORM_EXTREME;
  for (int i = 0; i < p && s->proximal; i++) {
    const double delta = s->opt.prox * form_own_block(&s->a, i)[0];
    s->A[(ptrdiff_t)i * p + i] += delta;
    s->b[i] -= delta * s->anchor[i];
  }
}

/* What the proximal term still does to the normal rows, over the largest impulse. */
static double proximal_residual(const regularized *s, const double *z) {
  double worst = 0;
  for (int i = 0; i < s->a.n_contact && s->proximal; i++) {
    worst = fmax(worst, s->opt.prox * fabs(z[i] - s->anchor[i]));
  }
  return (s->largest > 0) ? worst / s->largest : 0;
}

/* A, b for the current modes; where the compliance matrix is singular the step ends unsolved. */
static void reduce(regularized *s) {
  reg_rows_collect(s);
  if (!(s->by_mass ? reg_mass_reduce(s) : reg_contact_reduce(s))) {
    memset(s->lambda, 0, (size_t)s->a.n_row * sizeof *s->lambda);
    finish(s, false);
    return;
  }
  add_proximal_term(s);
}

/* The mass matrix is the cheaper of the two from a few contacts on; contact space is, with joints, and
 * takes friction so stiff that M_hat would lose the mass in it. */
static void choose_form(regularized *s, const contact_set *c) {
  const bool joints = c->n_group > c->n_contact;
  const bool stiff = s->opt.stiffness == 1 || s->opt.ratio > 1e6 || s->opt.modes == REG_ONCE;
  s->by_mass = s->opt.form == 2 || (s->opt.form == 0 && !joints && !stiff && c->n_contact > 2);
}

/* The reduced matrix is full however few bodies meet. Up to about so many contacts it costs Newton's methods no more than the cone problem,
 * whose matrix has the pattern of the contact graph; methods of first order solve less of what is posed over cones (README.md). */
static const int reduced_most = 128;

static bool takes_cone(const regularized *s, const contact_set *c) {
  const reg_options *o = &s->opt;
  return o->pose == REG_CONE || (o->pose == REG_BY_SIZE && c->n_contact > reduced_most &&
                                 o->storage == ROW_AUTO && (s->reader.sets >> LCP_CONE & 1u) != 0 &&
                                 s->reader.newton && reg_cone_admits(o, NULL) == BASE_OK);
}

double reg_start_impulse(const regularized *s, int i) {
  const double *past = contact_memory_old(&s->memory, s->a.group[i]);
  const double ratio = (s->memory.h_old > 0) ? s->a.set->h / s->memory.h_old : 0;
  return (s->start == FORM_PREVIOUS && past != NULL) ? ratio * past[PAST_IMPULSE] : 0;
}

static void start_point(regularized *s) {
  for (int i = 0; i < s->a.n_contact; i++) {
    s->block[i] = (lcp_block){.start = i,
                              .size = 1,
                              .set = LCP_ORTHANT,
                              .soft = form_soft(s->a.set, s->a.group[i], s->opt.distribution)};
    s->z0[i] = reg_start_impulse(s, i);
  }
}

static base_status collect(regularized *s, const contact_set *c, base_error *err) {
  const form_rule rule = {.level = s->opt.bias,
                          .activation = s->opt.activation,
                          .newton = s->opt.restitution == 0,
                          .gives = s->opt.restitution == 0,
                          .repair = s->opt.repair};
  BASE_TRY(contact_memory_begin(&s->memory, reg_layout(c), c, err));
  if (s->opt.pose == REG_CONE) {
    s->by_mass = false;
    s->cone.storage = (int)row_storage_of((row_storage)s->opt.storage, c);
    if (s->opt.storage == ROW_AUTO && form_factors_alone(c, s->reader.by_factors)) {
      s->cone.storage = ROW_FACTORED;
    }
    s->cone.storage = form_storage_without_joints(s->cone.storage, ROW_FACTORED, c);
    return row_assembly_begin(&s->a, c, (row_storage)s->cone.storage, true, &rule, &s->memory, err);
  }
  choose_form(s, c);
  if (s->by_mass) {
    return form_assembly_begin_own(&s->a, c, FORM_ROWS_ALL, &rule, &s->memory, err);
  }
  BASE_TRY(form_assembly_begin(&s->a, c, FORM_ROWS_ALL, &rule, &s->memory, err));
  return form_assembly_eliminate(&s->a, err);
}

/* Without contacts: a linear solve, already done where joints were eliminated. */
static void joints_alone(regularized *s) {
  if (s->by_mass && s->a.n_row > 0) {
    reduce(s);
  }
  if (!s->done) {
    if (s->by_mass && s->a.n_row > 0) {
      reg_mass_expand(s, s->z0, s->lambda, s->u);
    }
    finish(s, true);
  }
}

static base_status open(void *state, const void *opt, base_error *err) {
  (void)state;
  const options *o = opt;
  const bool once = o->bound != REG_BOUND_CURRENT || o->integration != REG_IMPLICIT ||
                    o->bristle != REG_SATURATED;
  if (once && o->modes != REG_ONCE) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "regularized: bound, integration and bristle are readings of modes=once");
  }
  if (o->turned != REG_TURNED_STICKS && o->modes != REG_PLAIN) {
    return BASE_FAIL(err, BASE_EINVAL, "regularized: turned is a reading of modes=plain");
  }
  if (o->modes == REG_ONCE && (o->model == REG_LUGRE || o->form == 2)) {
    return BASE_FAIL(err, BASE_EINVAL, "regularized: modes=once needs %s",
                     (o->form == 2) ? "form=contact" : "model=bristle or viscous");
  }
  if (o->pose != REG_CONE && o->storage != ROW_AUTO && o->storage != ROW_DENSE) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "regularized: storage: the reduced problem is dense, others need pose=cone");
  }
  return (o->pose == REG_CONE) ? reg_cone_admits(o, err) : BASE_OK;
}

static base_status begin_cone(regularized *s, base_error *err) {
  s->answer.lcp_dim = s->a.n_row;
  BASE_TRY(reg_cone_begin(s, err));
  if (s->a.n_row == 0) {
    finish(s, true);
  }
  return BASE_OK;
}

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  regularized *s = state;
  s->opt = *(const options *)opt;
  s->opt.pose = takes_cone(s, c) ? REG_CONE : REG_REDUCED;
  s->start = start;
  BASE_TRY(collect(s, c, err));
  BASE_TRY(grow(s, err));
  const int p = s->a.n_contact;
  s->answer = (formulation_answer){
      .solved = true, .lcp_dim = p, .n_active = p, .stiffness_ratio = HUGE_VAL};
  s->iteration = 0;
  s->largest = 0;
  s->done = false;
  s->best_residual = HUGE_VAL;
  reg_modes_begin(s);
  reg_parts_build(s);
  if (s->by_mass) {
    BASE_TRY(reg_mass_begin(s, err));
  }
  if (s->opt.pose == REG_CONE) {
    return begin_cone(s, err);
  }
  start_point(s);
  if (s->opt.modes == REG_ONCE) {
    reg_once_begin(s);
  }
  if (p == 0) {
    joints_alone(s);
  } else {
    reduce(s);
  }
  return BASE_OK;
}

/* Strict row dominance with a positive diagonal makes every principal minor positive. */
static bool is_dominant(const double *A, int p) {
  for (int i = 0; i < p; i++) {
    double off = 0;
    for (int j = 0; j < p; j++) {
      off += (j == i) ? 0 : fabs(A[(ptrdiff_t)j * p + i]);
    }
    if (!(A[(ptrdiff_t)i * p + i] > off)) {
      return false;
    }
  }
  return true;
}

static base_status assemble(void *state, lcp_problem *out, const double **z0, bool *pending,
                            base_error *err) {
  (void)err;
  regularized *s = state;
  *pending = !s->done;
  if (s->done) {
    return BASE_OK;
  }
  s->answer.work.solves++;
  if (s->opt.pose == REG_CONE) {
    *out = reg_cone_problem(s);
    *z0 = s->cone.z0;
    return BASE_OK;
  }
  const int p = s->a.n_contact;
  unsigned traits = s->any_slip ? 0u : (unsigned)(LCP_SYMMETRIC | LCP_PSD);
  traits |= is_dominant(s->A, p) ? (unsigned)LCP_P_MATRIX : 0u;
  *out = (lcp_problem){.M = {.storage = LCP_DENSE, .n = p, .val = s->A},
                       .q = s->b,
                       .block = s->block,
                       .n_block = p,
                       .traits = traits};
  *z0 = s->z0;
  return BASE_OK;
}

static void rows(const void *state, formulation_rows *out) {
  const regularized *s = state;
  *out = (formulation_rows){s->a.set, s->a.n_contact, NULL, s->a.group};
  if (s->opt.pose == REG_CONE) {
    out->n_group = s->a.n_group;
    out->first = s->a.row;
  }
}

static void keep_best(regularized *s, double residual) {
  if (residual < s->best_residual) {
    s->best_residual = residual;
    memcpy(s->best, s->lambda, (size_t)s->a.n_row * sizeof *s->best);
    memcpy(s->best_part, s->part, (size_t)s->n_part * sizeof *s->part);
  }
}

/* The limit of solves is reached, or the loop goes in circles: the best iterate stands, declared as not solved. */
static void give_up(regularized *s) {
  if (s->best_residual < HUGE_VAL) {
    memcpy(s->lambda, s->best, (size_t)s->a.n_row * sizeof *s->best);
    memcpy(s->part, s->best_part, (size_t)s->n_part * sizeof *s->part);
  }
  s->answer.residual = s->best_residual;
  finish(s, false);
}

/* The solver found the modes; what is left is which of two coefficients holds. */
static void recover_cone(regularized *s, const double *z, lcp_outcome claimed) {
  const size_t n = (size_t)s->a.n_row;
  memcpy(s->lambda, z, n * sizeof *z);
  s->answer.residual = reg_law_residual(s, s->lambda, reg_cone_slips(s, z));
  if (claimed != LCP_SOLVED || !reg_cone_bounds(s)) {
    finish(s, claimed == LCP_SOLVED);
  } else if (s->iteration >= s->opt.mode_iter) {
    finish(s, false);
  } else {
    memcpy(s->cone.z0, z, n * sizeof *z);
  }
}

static base_status recover(void *state, const double *z, lcp_outcome claimed, base_error *err) {
  (void)err;
  regularized *s = state;
  /* frozen modes may have no solution, which iterative solvers cannot tell from one that they do not reach */
  const bool broken = claimed != LCP_SOLVED && claimed != LCP_TIME_LIMIT;
  s->iteration++;
  s->answer.work.rays += claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  if (s->opt.pose == REG_CONE) {
    recover_cone(s, z, claimed);
    return BASE_OK;
  }
  const bool free = s->opt.modes == REG_NEWTON || s->opt.modes == REG_SECANT_ONLY;
  if (broken && s->any_slip && free && s->iteration < s->opt.mode_iter) {
    reg_modes_without_solution(s);
    reduce(s);
    return BASE_OK;
  }
  if (s->by_mass) {
    reg_mass_expand(s, z, s->lambda, s->u);
  } else {
    reg_contact_expand(s, z, s->lambda);
    form_assembly_velocity(&s->a, s->lambda, s->u);
  }
  for (int r = 0; r < s->a.n_row && s->opt.modes == REG_ONCE; r++) {
    s->lambda[r] += s->given[r];
  }
  const double residual = fmax(reg_law_residual(s, s->lambda, s->u), proximal_residual(s, z));
  memcpy(s->anchor, z, (size_t)s->a.n_contact * sizeof *z);
  if (broken || residual <= s->opt.tol || s->opt.modes == REG_ONCE) {
    s->answer.residual = residual;
    finish(s, claimed == LCP_SOLVED);
    return BASE_OK;
  }
  keep_best(s, residual);
  if (s->iteration >= s->opt.mode_iter) {
    give_up(s);
    return BASE_OK;
  }
  memcpy(s->z0, z, (size_t)s->a.n_contact * sizeof *z);
  reg_modes_next(s, residual);
  s->answer.circle = reg_modes_circle(s);
  if (s->answer.circle > 0) {
    give_up(s);
    return BASE_OK;
  }
  reduce(s);
  return BASE_OK;
}

static void answer(const void *state, formulation_answer *out) {
  const regularized *s = state;
  *out = s->answer;
  out->impulse = s->a.impulse;
  out->v_next = s->a.v_next;
  out->shift = form_shift_of(&s->a);
  out->bias = s->a.bias;
  out->mode = s->a.mode;
}

static void close(void *state) {
  regularized *s = state;
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  reg_mass_close(&s->mass);
  reg_cone_close(&s->cone);
  free(s->mem);
  free(s->dense_mem);
}

const formulation form_regularized = {
    .name = "regularized",
    .title = "Normal-impulse LCP with regularised friction",
    .cite = "gholami2016",
    .words = "Solves for normal impulses only; friction acts as a stiff spring.",
    .when = "Many contacts rub and the smallest problem is wanted; a sticking contact may give way "
            "a little.",
    .apart = "variant model",
    .model =
        FORM_NORMAL_ONLY | FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_EXACT | FORM_REGULARISED,
    .stands_for = "regularized",
    .sets = 1u << LCP_ORTHANT,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(regularized),
    .memory = offsetof(regularized, memory),
    .reader = offsetof(regularized, reader),
    .dimension = dimension,
    .open = open,
    .close = close,
    .begin = begin,
    .assemble = assemble,
    .rows = rows,
    .recover = recover,
    .answer = answer,
};
