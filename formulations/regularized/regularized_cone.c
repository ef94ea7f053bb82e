/* regularized_cone.c - the step as one cone problem (option pose=cone). The law of regularized.h is Coulomb's with a compliance: with
 *
 *   w_t = v_t + lambda_t / G + h k s / G
 *
 * friction inside its bound asks for w_t = 0, which is lambda_t = -(h k s + G v_t), and at its bound for lambda_t against w_t,
 * which is against tau, as h tau = G w_t - lambda_t. So the modes of stick and slip are the solver's to find, together with
 * the normal impulses, and the matrix C + 1/G has the pattern of contact space; in factors nothing else is stored. */
#include "formulations/regularized/regularized.h"

#include <stdlib.h>
#include <string.h>

static void layout(void *state, base_arena *m) {
  reg_cone *c = state;
  c->q = BASE_ARRAY(m, double, c->cap_row);
  c->z0 = BASE_ARRAY(m, double, c->cap_row);
  c->w = BASE_ARRAY(m, double, c->cap_row);
  c->give = BASE_ARRAY(m, double, c->cap_row);
  c->scratch = BASE_ARRAY(m, double, c->cap_scratch);
  c->block = BASE_ARRAY(m, lcp_block, c->cap_group);
}

void reg_cone_close(reg_cone *c) {
  row_matrix_close(&c->matrix);
  free(c->mem);
}

base_status reg_cone_admits(const reg_options *o, base_error *err) {
  const char *why = NULL;
  if (o->model == REG_LUGRE) {
    why = "model=lugre: its bristles are not linear";
  } else if (o->ellipse != 1) {
    why = "an ellipse: its cone is not round";
  } else if (o->modes != REG_NEWTON) {
    why = "modes=plain, secant or once: the solver finds the modes";
  } else if (o->form != 0 || o->factor != 0) {
    why = "form and factor: no springs are eliminated";
  } else if (o->prox != REG_PROX || o->newton_iter != REG_NEWTON_ITER) {
    why = "prox and newton_iter: there is no loop of modes";
  }
  return (why == NULL) ? BASE_OK
                       : BASE_FAIL(err, BASE_EINVAL, "regularized: pose=cone is not for %s", why);
}

/* Friction of the last step where it slips, the force of its spring where it does not. */
static void start_part(regularized *s, const reg_part *p, double *z0) {
  const double normal = z0[s->a.row[p->contact]];
  const double bound = (p->sliding ? p->mu_kinetic : p->mu_static) * normal;
  const double spring = p->pull * hypot(p->s[0], (p->dim == 2) ? p->s[1] : 0);
  for (int m = 0; m < p->dim; m++) {
    z0[p->row + m] = (p->mode == REG_SLIP)
                         ? -bound * p->d[m]
                         : -p->pull * p->s[m] * ((spring > bound) ? bound / spring : 1);
  }
}

static void fill(regularized *s) {
  reg_cone *c = &s->cone;
  memcpy(c->q, s->a.r, (size_t)s->a.n_row * sizeof *c->q);
  memset(c->z0, 0, (size_t)s->a.n_row * sizeof *c->z0);
  memset(c->give, 0, (size_t)s->a.n_row * sizeof *c->give);
  for (int i = 0; i < s->a.n_contact; i++) {
    c->q[s->a.row[i]] += s->a.bias[s->a.group[i]];
    c->z0[s->a.row[i]] = reg_start_impulse(s, i);
  }
  for (int k = 0; k < s->n_part; k++) {
    const reg_part *p = &s->part[k];
    for (int m = 0; m < p->dim && p->G > 0; m++) {
      c->q[p->row + m] += p->pull / p->G * p->s[m];
      c->give[p->row + m] = 1 / p->G;
    }
    if (s->start == FORM_PREVIOUS) {
      start_part(s, p, c->z0);
    }
  }
}

/* Friction of part `kind` of contact i; without a part, or with a spring that is nothing, nothing rubs. */
static double coefficient(const regularized *s, int i, int kind) {
  for (int k = s->part_start[i]; k < s->part_start[i + 1]; k++) {
    const reg_part *p = &s->part[k];
    if (p->kind == kind && p->G > 0) {
      return p->sliding ? p->mu_kinetic : p->mu_static;
    }
  }
  return 0;
}

bool reg_cone_bounds(regularized *s) {
  bool changed = false;
  for (int i = 0; i < s->a.n_contact; i++) {
    lcp_block *b = &s->cone.block[i];
    const int dim[REG_KINDS] = {s->a.rows[i].tangent, s->a.rows[i].torsion, s->a.rows[i].rolling};
    for (int kind = 0, part = 0; kind < REG_KINDS; kind++) {
      if (dim[kind] > 0) {
        const double mu = coefficient(s, i, kind);
        changed = changed || mu != b->part_mu[part];
        b->part_mu[part++] = mu;
      }
    }
  }
  return changed;
}

static void fill_blocks(regularized *s) {
  for (int i = 0; i < s->a.n_group; i++) {
    lcp_block *b = &s->cone.block[i];
    *b = (lcp_block){.start = s->a.row[i], .size = form_rows_of(&s->a, i), .set = LCP_FREE};
    if (i >= s->a.n_contact) {
      continue;
    }
    const int dim[REG_KINDS] = {s->a.rows[i].tangent, s->a.rows[i].torsion, s->a.rows[i].rolling};
    for (int kind = 0; kind < REG_KINDS; kind++) {
      if (dim[kind] > 0) {
        b->part_dim[b->n_part++] = dim[kind];
      }
    }
    b->set = (b->n_part > 0) ? LCP_CONE : LCP_ORTHANT;
    b->soft = form_soft(s->a.set, s->a.group[i], s->opt.distribution);
  }
  (void)reg_cone_bounds(s);
}

base_status reg_cone_begin(regularized *s, base_error *err) {
  reg_cone *c = &s->cone;
  BASE_TRY(row_matrix_build(&c->matrix, &s->a, (row_storage)c->storage, err));
  const size_t scratch = lcp_matrix_scratch(&c->matrix.M);
  if (c->mem == NULL || s->a.n_row > c->cap_row || s->a.n_group > c->cap_group ||
      scratch > c->cap_scratch) {
    c->cap_row = base_room(s->a.n_row);
    c->cap_group = base_room(s->a.n_group);
    c->cap_scratch = scratch;
    BASE_TRY(form_memory(&c->mem, layout, c, err));
  }
  fill(s);
  row_matrix_soften(&c->matrix, c->give); /* 1/G on the diagonal */
  fill_blocks(s);
  return BASE_OK;
}

lcp_problem reg_cone_problem(const regularized *s) {
  const reg_cone *c = &s->cone;
  return (lcp_problem){.M = c->matrix.M,
                       .q = c->q,
                       .block = c->block,
                       .n_block = s->a.n_group,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
}

const double *reg_cone_slips(regularized *s, const double *z) {
  reg_cone *c = &s->cone;
  lcp_matrix_apply(&c->matrix.M, z, c->q, c->w, c->scratch);
  return c->w;
}
