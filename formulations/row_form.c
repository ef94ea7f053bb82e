#include "formulations/row_form.h"

#include "lcp/base/crew.h"

#include <stdlib.h>
#include <string.h>

static void layout(void *state, base_arena *m) {
  row_form *s = state;
  s->q = BASE_ARRAY(m, double, s->cap_row);
  s->z0 = BASE_ARRAY(m, double, s->cap_row);
  s->lambda = BASE_ARRAY(m, double, s->cap_row);
  s->lo = BASE_ARRAY(m, double, s->cap_row);
  s->hi = BASE_ARRAY(m, double, s->cap_row);
  s->normal = BASE_ARRAY(m, double, s->cap_group);
  s->move = BASE_ARRAY(m, double, s->cap_group);
  if (s->opt.outer > 0) {
    s->w = BASE_ARRAY(m, double, s->cap_row);
    s->diagonal = BASE_ARRAY(m, double, s->cap_row);
    s->scratch = BASE_ARRAY(m, double, s->cap_scratch);
    s->deflection = BASE_ARRAY(m, double, s->cap_row);
    s->soft = BASE_ARRAY(m, double, s->cap_row);
    s->mu = BASE_ARRAY(m, double, s->cap_row);
    s->copies = BASE_ARRAY(m, int, s->cap_group);
    s->bodies = BASE_ARRAY(m, form_bristle_key, s->cap_group);
  }
  s->block = BASE_ARRAY(m, lcp_block, 4 * (size_t)s->cap_group);
}

void row_form_close(void *state) {
  row_form *s = state;
  boxed_bounds_close(&s->bounds);
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  row_matrix_close(&s->matrix);
  free(s->mem);
}

int row_form_parts(const row_form *s, int i, int dim[LCP_PARTS_MAX], double mu[LCP_PARTS_MAX]) {
  const int g = s->a.group[i];
  const contact_rows rows = s->a.rows[i];
  int n = 0;
  if (rows.tangent > 0) {
    dim[n] = rows.tangent;
    mu[n++] = contact_memory_mu(&s->memory, s->a.set, g);
  }
  if (rows.torsion > 0) {
    dim[n] = rows.torsion;
    mu[n++] = s->a.set->mu_torsion[g];
  }
  if (rows.rolling > 0) {
    dim[n] = rows.rolling;
    mu[n++] = s->a.set->mu_rolling[g];
  }
  return n;
}

/* q = r + b_n; start point and bounds from the impulses of the last step. */
static void fill_vectors(row_form *s) {
  const contact_set *c = s->a.set;
  const double ratio = (s->memory.h_old > 0) ? c->h / s->memory.h_old : 0;
  memcpy(s->q, s->a.r, (size_t)s->a.n_row * sizeof *s->q);
  memset(s->z0, 0, (size_t)s->a.n_row * sizeof *s->z0);
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const double *past = contact_memory_old(&s->memory, g);
    s->q[s->a.row[i]] += s->a.bias[g];
    const bool behind = s->start == FORM_PREVIOUS || s->opt.outer == 1; /* lagged by the model */
    const double own = form_own_block(&s->a, i)[0];
    const double alone = (own > 0) ? fmax(-s->q[s->a.row[i]], 0) / own : 0; /* stops the approach */
    s->normal[i] = behind ? ((past != NULL) ? ratio * past[PAST_IMPULSE] : 0) : alone;
    if (s->start == FORM_PREVIOUS && past != NULL) {
      double *z0 = s->z0 + s->a.row[i];
      form_to_rows(&s->a, i, past + PAST_IMPULSE, z0);
      for (int k = 0; k < form_rows_of(&s->a, i); k++) {
        z0[k] *= ratio;
      }
    }
  }
}

base_status row_form_begin(row_form *s, const contact_set *c, const row_options *opt,
                           formulation_start start, base_error *err) {
  const form_rule rule = {.level = opt->level,
                          .activation = opt->activation,
                          .newton = opt->restitution == 0,
                          .gives = opt->restitution == 0,
                          .repair = opt->repair};
  s->opt = *opt;
  if (opt->storage == ROW_AUTO && form_factors_alone(c, s->reader.by_factors)) {
    s->opt.storage = ROW_FACTORED;
  }
  if (opt->joints == 0) {
    s->opt.storage = form_storage_without_joints(s->opt.storage, ROW_FACTORED, c);
  }
  s->start = start;
  BASE_TRY(contact_memory_begin(
      &s->memory,
      contact_memory_need(contact_memory_kinds(c), opt->bristle > 0 || opt->damper > 0, 0), c,
      err));
  BASE_TRY(row_assembly_begin(&s->a, c, (row_storage)s->opt.storage, opt->joints == 0, &rule,
                              &s->memory, err));
  BASE_TRY(row_matrix_build(&s->matrix, &s->a, (row_storage)s->opt.storage, err));
  const size_t scratch = lcp_matrix_scratch(&s->matrix.M);
  if (s->mem == NULL || c->n_row > s->cap_row || c->n_group > s->cap_group ||
      scratch > s->cap_scratch) {
    s->cap_row = base_room(c->n_row);
    s->cap_group = base_room(c->n_group);
    s->cap_scratch = scratch;
    BASE_TRY(form_memory(&s->mem, layout, s, err));
  }
  fill_vectors(s);
  s->n_block = 0;
  s->done = false;
  s->answer = (formulation_answer){.solved = true,
                                   .lcp_dim = s->a.n_row,
                                   .n_active = s->a.n_contact,
                                   .stiffness_ratio = HUGE_VAL};
  if (s->a.n_row == 0) {
    row_form_finish(s, s->z0, true);
  }
  return BASE_OK;
}

typedef struct ending {
  row_form *s;
  const double *lambda;
  form_slip slip;
} ending;

/* Modes of the contacts of one part, and what the next step remembers of them. */
static void settle_contacts(void *of, int part, int hand) {
  const ending *e = of;
  row_form *s = e->s;
  (void)hand;
  for (int i = part * CONTACT_SHARE; i < base_part_end(part, s->a.n_contact, CONTACT_SHARE); i++) {
    const int g = s->a.group[i];
    const double *l = e->lambda + s->a.row[i];
    double *now = contact_memory_now(&s->memory, g);
    const int tangent = s->a.rows[i].tangent;
    const double bound = contact_memory_mu(&s->memory, s->a.set, s->a.group[i]) * l[0];
    const double pull = (tangent > 0) ? hypot(l[1], (tangent > 1) ? l[2] : 0) : 0;
    /* to rounding; what bristles let creep inside the cone does not slide */
    const bool on_cone = pull >= (1 - 1e-6) * bound;
    const bool falls = s->round_cone && s->a.set->mu_kinetic[g] < s->a.set->mu_static[g];
    const bool slides = l[0] > 0 && on_cone && form_slides(&s->a, i, bound, &e->slip) &&
                        !(falls && !form_opposes(&s->a, i, l + 1));
    now[PAST_SLIDES] = 0;
    if (slides) {
      form_note_slide(&s->a, i, &e->slip, &s->memory);
    }
    form_to_set(&s->a, i, l, now + PAST_IMPULSE);
    s->a.mode[g] = (unsigned char)((l[0] > 0) ? 1 + (slides || tangent == 0) : 0);
  }
}

void row_form_finish(row_form *s, const double *lambda, bool solved) {
  /* Sweeps leave a slip that is no more, and where friction falls as a slip begins that would begin it. */
  static const double swept = 1e-5;
  s->done = true;
  s->answer.solved = solved;
  form_assembly_answer(&s->a, lambda);
  ending e = {s, lambda, form_slip_of(&s->a, s->opt.repair.rest)};
  if (s->round_cone) {
    e.slip.share = swept;
  }
  base_share(base_parts(s->a.n_contact, CONTACT_SHARE), settle_contacts, &e);
}

void row_form_rows(const void *state, formulation_rows *out) {
  const row_form *s = state;
  *out = (formulation_rows){s->a.set, s->a.n_group, s->a.row, s->a.group};
}

void row_form_answer(const void *state, formulation_answer *out) {
  const row_form *s = state;
  *out = s->answer;
  out->impulse = s->a.impulse;
  out->v_next = s->a.v_next;
  out->shift = form_shift_of(&s->a);
  out->bias = s->a.bias;
  out->mode = s->a.mode;
}
