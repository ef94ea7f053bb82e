#include "formulations/polyhedral.h"

#include "formulations/polyhedral_matrix.h"

#include <stdlib.h>
#include <string.h>

long poly_dimension(int dim, int p, const void *opt) {
  const poly_options *o = opt;
  const int planar = (o->planar == POLY_THREE) ? 3 : 4;
  return (long)p * ((dim == 2) ? planar : o->facets + 2);
}

/* How far facets are from the middle, over how far their corners are [1]. */
static double facet_height(int facets) {
  return cos(3.14159265358979323846 / facets);
}

formulation_friction poly_friction(int dim, const void *opt) {
  const poly_options *o = opt;
  const bool outside = dim == 3 && o->cone == 1;
  return (formulation_friction){.most = outside ? 1.0 / facet_height(o->facets) : 1.0,
                                .aslant = o->facets % 4 != 0};
}

static void layout_groups(void *state, base_arena *m) {
  polyhedral *s = state;
  const int g = s->cap_group;
  s->shape_of = BASE_ARRAY(m, const poly_shape *, g);
  s->first = BASE_ARRAY(m, int, g + 1);
  s->scale = BASE_ARRAY(m, double, (size_t)s->parts *(size_t)g);
  s->bound = BASE_ARRAY(m, double, (size_t)s->parts *(size_t)g);
  s->cone = BASE_ARRAY(m, double, g);
  s->block = BASE_ARRAY(m, lcp_block, g);
  s->base = BASE_ARRAY(m, double, s->cap_row);
  s->u = BASE_ARRAY(m, double, s->cap_row);
  s->push = BASE_ARRAY(m, double, g);
}

static void layout_values(void *state, base_arena *m) {
  polyhedral *s = state;
  s->q = BASE_ARRAY(m, double, s->cap_n);
  s->z0 = BASE_ARRAY(m, double, s->cap_n);
  s->m.colptr = BASE_ARRAY(m, int, s->cap_n + 1);
  s->m.rowind = BASE_ARRAY(m, int, s->cap_val);
  s->val = s->m.val = BASE_ARRAY(m, double, s->cap_val);
}

static void layout_factors(void *state, base_arena *m) {
  polyhedral *s = state;
  s->jac = BASE_ARRAY(m, double, s->cap_jac);
  s->jac_start = BASE_ARRAY(m, int, s->cap_group + 1);
  s->stored_start = BASE_ARRAY(m, int, s->cap_group);
  s->mixture = BASE_ARRAY(m, const lcp_mixture *, s->cap_group);
  s->body = BASE_ARRAY(m, int, 2 * (size_t)s->cap_group);
  s->s.colptr = BASE_ARRAY(m, int, s->jac_n + 1);
  s->s.rowind = BASE_ARRAY(m, int, s->cap_shift);
  s->s.val = BASE_ARRAY(m, double, s->cap_shift);
}

void poly_close(void *state) {
  polyhedral *s = state;
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  free(s->mem);
  free(s->val_mem);
  free(s->jac_mem);
  for (int k = 0; k < POLY_SHAPES; k++) {
    free(s->shape[k]);
  }
}

/* NULL: there is no memory for it. */
static const poly_shape *shape_for(polyhedral *s, contact_rows rows) {
  poly_shape **shape = &s->shape[(rows.tangent * 2 + rows.torsion) * 3 + rows.rolling];
  if (*shape == NULL) {
    const bool three = s->opt.planar == POLY_THREE && s->a.set->dim == 2;
    *shape = malloc(sizeof **shape);
    if (*shape != NULL) {
      poly_shape_build(*shape, rows, s->opt.facets, three);
    }
  }
  return *shape;
}

/* Friction coefficient of active contact i: the kinetic one where it slipped a step ago. */
static double friction_of(const polyhedral *s, int i) {
  const contact_set *c = s->a.set;
  double mu = contact_memory_mu(&s->memory, c, s->a.group[i]);
  if (s->opt.cone == 1 && c->dim == 3) {
    mu /= facet_height(s->opt.facets); /* the circle touches the facets */
  }
  return mu;
}

/* Units and bounds of the parts; torsion and rolling impulses are divided by their coefficient, so
 * that they are bounded by lambda_n itself. */
static void set_parts(polyhedral *s, int i) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  for (int p = 0; p < s->shape_of[i]->n_part; p++) {
    const int kind = s->shape_of[i]->part_kind[p];
    double *scale = &s->scale[s->parts * i + p];
    double *bound = &s->bound[s->parts * i + p];
    *scale = 1;
    *bound = 1;
    if (kind == 0) {
      *bound = friction_of(s, i);
    } else {
      *scale = (kind == 1) ? c->mu_torsion[g] : c->mu_rolling[g];
    }
  }
}

/* Parts of a faceted cone and its compliance; the planar three-unknown form has no facets of its own. */
static void describe_facets(const polyhedral *s, int i, lcp_block *block) {
  const poly_shape *shape = s->shape_of[i];
  block->soft = form_soft(s->a.set, s->a.group[i], s->opt.distribution);
  if (s->opt.planar == POLY_THREE && s->a.set->dim == 2) {
    return;
  }
  block->n_part = shape->n_part;
  for (int p = 0; p < shape->n_part; p++) {
    block->part_dim[p] = shape->part_start[p + 1] - shape->part_start[p];
  }
}

/* rubs: false for normal impulses alone. */
static base_status number_unknowns(polyhedral *s, bool rubs, base_error *err) {
  const form_assembly *a = &s->a;
  s->first[0] = 0;
  for (int i = 0; i < a->n_group; i++) {
    const bool contact = i < a->n_contact;
    s->shape_of[i] = contact ? shape_for(s, rubs ? a->rows[i] : (contact_rows){0}) : &s->joint;
    if (s->shape_of[i] == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "polyhedral LCP: no memory for the facets");
    }
    if (contact) {
      set_parts(s, i);
    }
    s->cone[i] = 0;
    s->first[i + 1] = s->first[i] + poly_width(s, i);
    s->block[i] = (lcp_block){
        .start = s->first[i], .size = poly_width(s, i), .set = contact ? LCP_ORTHANT : LCP_FREE};
    if (contact) {
      describe_facets(s, i, &s->block[i]);
    }
  }
  s->n = s->first[a->n_group];
  return BASE_OK;
}

static poly_storage storage_of(const polyhedral *s, size_t nnz) {
  const size_t all = (size_t)s->n * (size_t)s->n;
  if (s->opt.storage != POLY_AUTO) {
    return (poly_storage)s->opt.storage;
  }
  return (s->n <= 64 || nnz > all / 4) ? POLY_DENSE : POLY_CSC;
}

static base_status room_for(polyhedral *s, size_t need, base_error *err) {
  if (need > (size_t)INT32_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "polyhedral LCP: %zu stored entries, more than 2^31",
                     need);
  }
  if (s->val_mem == NULL || s->n > s->cap_n || need > s->cap_val) {
    s->cap_n = (s->n > s->cap_n) ? base_room(s->n) : s->cap_n;
    s->cap_val = (need > s->cap_val) ? base_room_of(need) : s->cap_val;
    BASE_TRY(form_memory(&s->val_mem, layout_values, s, err));
  }
  return BASE_OK;
}

static base_status fill_factors(polyhedral *s, base_error *err) {
  const bool shared = poly_jac_is_shared(s);
  const size_t rows = poly_jac_size(s), jac = shared ? 0 : rows, shift = poly_shift_nnz(s);
  if (rows > (size_t)INT32_MAX || shift > (size_t)INT32_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "polyhedral LCP: %zu entries of J, more than 2^31",
                     rows);
  }
  if (s->jac_mem == NULL || jac > s->cap_jac || shift > s->cap_shift || s->n > s->jac_n ||
      s->cap_group > s->jac_groups) {
    s->cap_jac = (jac > s->cap_jac) ? base_room_of(jac) : s->cap_jac;
    s->cap_shift = (shift > s->cap_shift) ? base_room_of(shift) : s->cap_shift;
    s->jac_n = (s->n > s->jac_n) ? base_room(s->n) : s->jac_n;
    s->jac_groups = s->cap_group;
    BASE_TRY(form_memory(&s->jac_mem, layout_factors, s, err));
  }
  poly_fill_factored(s, shared);
  s->M.factored = &s->factored;
  return BASE_OK;
}

/* The planar form of three unknowns has no facets to make factors of. */
static bool is_faceted(const polyhedral *s, const contact_set *c) {
  return s->opt.planar != POLY_THREE || c->dim != 2 || s->rows == FORM_ROWS_NORMAL;
}

static base_status fill_matrix(polyhedral *s, base_error *err) {
  if (s->opt.storage == POLY_FACTORED) {
    BASE_TRY(room_for(s, 0, err));
    s->M = (lcp_matrix){.storage = LCP_FACTORED, .n = s->n};
    return fill_factors(s, err);
  }
  const size_t nnz = poly_nnz(s);
  const bool dense = storage_of(s, nnz) == POLY_DENSE;
  BASE_TRY(room_for(s, dense ? (size_t)s->n * (size_t)s->n : nnz, err));
  s->M = (lcp_matrix){.storage = dense ? LCP_DENSE : LCP_CSC, .n = s->n};
  if (dense) {
    poly_fill_dense(s);
    s->M.val = s->val;
  } else {
    poly_fill_csc(s);
    s->M.csc = (lcp_csc){s->n, s->n, s->m.colptr, s->m.rowind, s->m.val};
  }
  return (form_keeps_factors(&s->a, s->n) && is_faceted(s, s->a.set)) ? fill_factors(s, err)
                                                                      : BASE_OK;
}

/* Contacts and C; a factored problem needs no more of C than the own blocks. */
static base_status begin_assembly(polyhedral *s, const contact_set *c, form_rows rows,
                                  const form_rule *rule, base_error *err) {
  const poly_options *o = &s->opt;
  if (o->storage != POLY_FACTORED) {
    BASE_TRY(form_assembly_begin(&s->a, c, rows, rule, &s->memory, err));
    return (o->joints == 0) ? form_assembly_eliminate(&s->a, err) : form_assembly_mix(&s->a, err);
  }
  if (o->planar == POLY_THREE && c->dim == 2 && rows != FORM_ROWS_NORMAL) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "storage=factored: not with planar=three");
  }
  return form_assembly_begin_own(&s->a, c, rows, rule, &s->memory, err);
}

/* Room for the unknowns of any contact of the set. */
static contact_layout past_layout(const contact_set *c, const poly_options *opt, form_rows rows) {
  const int kinds = (rows == FORM_ROWS_NORMAL) ? 0 : contact_memory_kinds(c);
  const int facets = (opt->facets > 2) ? opt->facets : 2;
  static const int sigma = 1;
  const int widest = 1 + ((kinds > 0) ? facets + sigma : 0) + ((kinds > 1) ? 2 + sigma : 0) +
                     ((kinds > 2) ? facets + sigma : 0);
  return contact_memory_need(kinds, false, POLY_PAST_Z + widest);
}

base_status poly_begin(polyhedral *s, const contact_set *c, const poly_options *opt, form_rows rows,
                       formulation_start start, base_error *err) {
  const form_rule rule = {.level = opt->level,
                          .activation = opt->activation,
                          .newton = opt->restitution == POLY_NEWTON,
                          .gives = opt->restitution != POLY_INELASTIC,
                          .repair = opt->repair};
  s->opt = *opt;
  s->rows = rows;
  if (opt->storage == POLY_AUTO && is_faceted(s, c) &&
      form_factors_alone(c, s->reader.by_factors)) {
    s->opt.storage = POLY_FACTORED;
  }
  if (opt->joints == 0) {
    s->opt.storage = form_storage_without_joints(s->opt.storage, POLY_FACTORED, c);
  }
  s->start = start;
  BASE_TRY(contact_memory_begin(&s->memory, past_layout(c, opt, rows), c, err));
  BASE_TRY(begin_assembly(s, c, rows, &rule, err));
  if (s->joint.n_column == 0) {
    poly_shape_identity(&s->joint, 6);
  }
  const int parts = contact_memory_kinds(c);
  if (s->mem == NULL || c->n_group > s->cap_group || c->n_row > s->cap_row || parts > s->parts) {
    s->parts = (parts > s->parts) ? parts : s->parts;
    s->cap_group = base_room(c->n_group);
    s->cap_row = base_room(c->n_row);
    BASE_TRY(form_memory(&s->mem, layout_groups, s, err));
  }
  BASE_TRY(number_unknowns(s, true, err));
  BASE_TRY(fill_matrix(s, err));
  memset(s->base, 0, (size_t)s->a.n_row * sizeof *s->base);
  poly_pushes_begin(s);
  s->phase = POLY_MOTION;
  s->answer = (formulation_answer){
      .solved = true, .lcp_dim = s->n, .n_active = s->a.n_contact, .stiffness_ratio = HUGE_VAL};
  form_assembly_answer(&s->a, s->base);
  if (s->n == 0) {
    s->phase = POLY_DONE;
  }
  return BASE_OK;
}

/* What is known of the matrix: frictionless contacts give a Delassus matrix, facets a copositive
 * one with zero diagonal entries. The planar three-unknown form guarantees nothing. */
static unsigned traits(const polyhedral *s) {
  bool sigma = false;
  for (int i = 0; i < s->a.n_contact; i++) {
    sigma = sigma || s->shape_of[i]->n_part > 0;
  }
  if (!sigma) {
    return LCP_SYMMETRIC | LCP_PSD;
  }
  const bool three = s->opt.planar == POLY_THREE && s->a.set->dim == 2;
  return LCP_ZERO_DIAGONAL | (three ? 0u : (unsigned)LCP_COPOSITIVE);
}

base_status poly_assemble(void *state, lcp_problem *out, const double **z0, bool *pending,
                          base_error *err) {
  (void)err;
  polyhedral *s = state;
  *pending = s->phase != POLY_DONE;
  if (!*pending) {
    return BASE_OK;
  }
  poly_velocities(s);
  for (int i = 0; i < s->a.n_group; i++) {
    double bias = (i < s->a.n_contact) ? s->a.bias[s->a.group[i]] : 0;
    if (s->phase == POLY_PUSH && i < s->a.n_contact) {
      bias = fmin(bias, s->push[i]);
    }
    poly_fill_q(s, i, bias, s->q + s->first[i]);
  }
  poly_start_point(s);
  *out = (lcp_problem){
      .M = s->M, .q = s->q, .block = s->block, .n_block = s->a.n_group, .traits = traits(s)};
  *z0 = s->z0;
  s->answer.work.solves++;
  return BASE_OK;
}

void poly_rows(const void *state, formulation_rows *out) {
  const polyhedral *s = state;
  *out = (formulation_rows){s->a.set, s->a.n_group, s->first, s->a.group};
}

/* Speed won in this step by the applied forces, of contact g of the set. */
static double gained(const polyhedral *s, int g) {
  const contact_set *c = s->a.set;
  return fmax(0.0, c->u_before[c->row_start[g]] - s->a.r_normal[g]);
}

/* Poisson: adds e lambda_n of the compression to the impulses and to the friction bounds. Of
 * lambda_n only the share that stopped the approach is given back, not what carried the loads of
 * the step; a single contact without friction then bounces as with Newton's law. True if there is
 * anything to give back. */
static bool decompress(polyhedral *s) {
  const contact_set *c = s->a.set;
  bool any = false;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const double u = c->u_before[c->row_start[g]];
    const double gain = gained(s, g);
    double *lambda = s->base + s->a.row[i];
    if (c->restitution[g] > 0 && lambda[0] > 0 && -u > s->opt.repair.rest * gain) {
      s->cone[i] = c->restitution[g] * lambda[0] * u / (u - gain);
      lambda[0] += s->cone[i];
      if (s->opt.planar == POLY_THREE && c->dim == 2 && s->shape_of[i]->n_part > 0) {
        lambda[1] -= s->bound[s->parts * i] * s->cone[i];
      }
      any = true;
    }
  }
  return any;
}

/* Speed at which active contact i was met in this step, to be given back in the next one, <= 0. */
static double approach_met(const polyhedral *s, int i) {
  const int g = s->a.group[i];
  const double u = s->a.set->u_before[s->a.set->row_start[g]];
  const bool met = s->base[s->a.row[i]] > 0 && -u > s->opt.repair.rest * gained(s, g);
  return (met && !(poly_owed(s, i) < 0)) ? fmin(u, 0) : 0;
}

/* 0 open, 1 stick, 2 slip; and the memory of the next step. */
static void note_modes(polyhedral *s, const double *z) {
  const form_slip slip = form_slip_of(&s->a, s->opt.repair.rest);
  const bool three = s->opt.planar == POLY_THREE && s->a.set->dim == 2;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const double *zi = z + s->first[i];
    const poly_shape *shape = s->shape_of[i];
    double *now = contact_memory_now(&s->memory, g);
    const bool friction = shape->n_part > 0 && shape->part_kind[0] == 0;
    const double normal = s->base[s->a.row[i]];
    /* the third of three unknowns is the slip to one side alone */
    const bool slides = friction && (three || zi[shape->n_column] > 0) &&
                        form_slides(&s->a, i, s->bound[s->parts * i] * normal, &slip);
    s->a.mode[g] = (unsigned char)((normal > 0) ? (slides || !friction) + 1 : 0);
    now[PAST_SLIDES] = 0;
    if (slides) {
      form_note_slide(&s->a, i, &slip, &s->memory);
    }
    memset(now + PAST_IMPULSE, 0, (size_t)s->memory.layout.impulse * sizeof *now);
    form_to_set(&s->a, i, s->base + s->a.row[i], now + PAST_IMPULSE);
    if (s->opt.restitution == POLY_TWO_STEPS) {
      now[PAST_APPROACH] = approach_met(s, i);
    }
    double *own = now + contact_memory_own(&s->memory);
    own[POLY_PAST_WIDTH] = poly_width(s, i);
    memcpy(own + POLY_PAST_Z, zi, (size_t)poly_width(s, i) * sizeof *zi);
  }
}

static base_status begin_push(polyhedral *s, base_error *err) {
  BASE_TRY(number_unknowns(s, false, err));
  return fill_matrix(s, err);
}

base_status poly_recover(void *state, const double *z, lcp_outcome claimed, base_error *err) {
  polyhedral *s = state;
  s->answer.work.rays += claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  if (s->phase == POLY_PUSH) {
    poly_push_out(s, z, claimed == LCP_SOLVED);
    return BASE_OK;
  }
  for (int i = 0; i < s->a.n_group; i++) {
    poly_expand(s, i, z + s->first[i], s->base + s->a.row[i]);
  }
  if (s->phase == POLY_MOTION && s->pushes && (claimed != LCP_SOLVED || poly_makes_energy(s))) {
    s->phase = POLY_STILL;
    s->answer.work.fallbacks++;
    memset(s->base, 0, (size_t)s->a.n_row * sizeof *s->base);
    poly_pushes_drop(s);
    return BASE_OK;
  }
  s->answer.solved = s->answer.solved && claimed == LCP_SOLVED;
  const bool poisson = s->phase == POLY_MOTION && s->opt.restitution == POLY_POISSON &&
                       s->a.set->restitution != NULL;
  form_assembly_answer(&s->a, s->base);
  note_modes(s, z);
  s->phase = (s->phase == POLY_STILL && s->answer.solved) ? POLY_PUSH : POLY_DONE;
  s->phase = (poisson && s->answer.solved && decompress(s)) ? POLY_DECOMPRESSION : s->phase;
  return (s->phase == POLY_PUSH) ? begin_push(s, err) : BASE_OK;
}

void poly_answer(const void *state, formulation_answer *out) {
  const polyhedral *s = state;
  *out = s->answer;
  out->impulse = s->a.impulse;
  out->v_next = s->a.v_next;
  out->shift = form_shift_of(&s->a);
  out->bias = s->a.bias;
  out->mode = s->a.mode;
}
