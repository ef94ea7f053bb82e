/* form_coulomb.c - the exact Coulomb cone: K* in u + (b_n + mu |u_t|) e_n  _|_  lambda in K, one
 * second-order cone a contact (De Saxce & Feng 1998; Acary, Bremond & Huber 2018), torsion and
 * rolling as further parts of it. Nothing of the law is approximated: the accuracy reference. */
#include "formulations/row_form.h"

typedef row_options options;

static const base_field fields[] = {ROW_FORM_FIELDS(options)};

static long dimension(int dim, int p, const void *opt) {
  (void)opt;
  return (long)p * dim;
}

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  row_form *s = state;
  row_options own = *(const options *)opt;
  own.storage = (int)row_storage_of((row_storage)own.storage, c);
  s->round_cone = true;
  BASE_TRY(row_form_begin(s, c, &own, start, err));
  for (int i = 0; i < s->a.n_group; i++) {
    lcp_block *block = &s->block[s->n_block++];
    *block = (lcp_block){.start = s->a.row[i], .size = form_rows_of(&s->a, i), .set = LCP_FREE};
    if (i < s->a.n_contact) {
      block->n_part = row_form_parts(s, i, block->part_dim, block->part_mu);
      block->set = (block->n_part > 0) ? LCP_CONE : LCP_ORTHANT;
      block->soft = form_soft(c, s->a.group[i], own.distribution);
    }
  }
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
  s->answer.work.rays += claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  row_form_finish(s, z, claimed == LCP_SOLVED);
  return BASE_OK;
}

const formulation form_coulomb = {
    .name = "coulomb",
    .title = "Exact Coulomb cone",
    .cite = "desaxce1998; acary2018",
    .words = "The exact round friction cone.",
    .when = "The direction of sliding matters; it needs a solver of cones.",
    .model = FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_EXACT,
    .stands_for = "coulomb",
    .sets = 1u << LCP_ORTHANT | 1u << LCP_CONE,
    ROW_FORM_PARTS,
};
