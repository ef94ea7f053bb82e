/* lcp_share.c - the three steps of lcp_share.h: rank of the normals, active rows, the limit on them. */
#include "lcp/lcp_share.h"

#include "lcp/lcp_column.h"
#include "lcp/lcp_share_state.h"

#include <stdlib.h>
#include <string.h>

enum {
  MOST_ROUNDS = 40,
  FIRST_ROUNDS = 10,
  FREE_ROUNDS = 6,
  MOST_CORRECTIONS = 12,
  JOINT_ROUNDS = 4
};

static const double delta_share =
    1e-7; /* of the diagonal; what M leaves open has 1e-16 over this as noise */
static const double friction_share =
    1e-2; /* of delta, on rows without compliance: holds what is left */
static const double joint_share = 1e-5; /* the same, of joints that say the same twice */
static const double body_joint_share =
    1e-3;                        /* the same in body space, where every row needs some */
static const int few_rows = 128; /* of a stored matrix, that are chosen faster in contact space */
static const int most_counted =
    2000; /* contacts whose rank is counted: that fills in as the graph of all of them */
static const double same_tol = 1e-8;    /* z over its terms */
static const double answer_tol = 1e-8;  /* w over its terms in an answer */
static const double solved_tol = 1e-11; /* w over its terms in what is handed back */

base_status lcp_share_open(lcp_share **out, base_error *err) {
  *out = calloc(1, sizeof **out);
  return (*out != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "no memory for shared impulses");
}

void lcp_share_close(lcp_share *s) {
  if (s != NULL) {
    lcp_share_system_close(&s->system);
    lcp_share_bodies_close(&s->bodies);
    lcp_csc_free(&s->copy);
    free(s->mem);
    free(s);
  }
}

static void layout(lcp_share *s, base_arena *a) {
  const int n = s->cap_n;
  s->z = BASE_ARRAY(a, double, n);
  s->w = BASE_ARRAY(a, double, n);
  s->size = BASE_ARRAY(a, double, n);
  s->right = BASE_ARRAY(a, double, n);
  s->anchor = BASE_ARRAY(a, double, n);
  s->diagonal = BASE_ARRAY(a, double, n);
  s->kept = BASE_ARRAY(a, double, n);
  s->lower = BASE_ARRAY(a, double, n);
  s->had = BASE_ARRAY(a, double, n);
  s->before = BASE_ARRAY(a, unsigned char, n);
  s->let_go = BASE_ARRAY(a, bool, n);
  s->contact = BASE_ARRAY(a, int, n);
  s->owner = BASE_ARRAY(a, int, n);
  s->island = BASE_ARRAY(a, int, n);
  s->met = BASE_ARRAY(a, int, s->cap_body);
  s->rests = BASE_ARRAY(a, bool, n);
  s->rows.kind = BASE_ARRAY(a, unsigned char, n);
  s->rows.delta = BASE_ARRAY(a, double, n);
  s->rows.part = BASE_ARRAY(a, int, n);
  s->rows.part_dim = BASE_ARRAY(a, int, n);
  s->rows.slips = BASE_ARRAY(a, int, n);
  s->rows.own = BASE_ARRAY(a, double, n);
  s->rows.pull = BASE_ARRAY(a, double, n);
  s->rows.gain = BASE_ARRAY(a, double, 2 * (size_t)n);
}

static base_status grow(lcp_share *s, int n, int n_body, base_error *err) {
  if (s->mem != NULL && n <= s->cap_n && n_body <= s->cap_body) {
    return BASE_OK;
  }
  s->cap_n = n + n / 2;
  s->cap_body = n_body + n_body / 2;
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  free(s->mem);
  s->mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (s->mem == NULL) {
    s->cap_n = 0;
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to share %d impulses", n);
  }
  base_arena a = base_arena_over(s->mem, measure.used);
  layout(s, &a);
  return BASE_OK;
}

/* w = M z + q; size: the sum of what each row is made of, unless NULL. */
static void product(lcp_share *s, double *size) {
  const int n = s->p->M.n;
  if (s->by_bodies) {
    lcp_share_bodies_product(&s->bodies, s->z, s->w, size);
    return;
  }
  memcpy(s->w, s->p->q, (size_t)n * sizeof *s->w);
  for (int i = 0; i < n && size != NULL; i++) {
    size[i] = fabs(s->p->q[i]);
  }
  for (int j = 0; j < n; j++) {
    if (s->z[j] != 0) {
      const lcp_column c = lcp_column_of(&s->M, j);
      if (size != NULL) {
        lcp_column_add_sized(c, s->z[j], s->w, size);
      } else {
        lcp_column_add(c, s->z[j], s->w);
      }
    }
  }
}

/* Row i is held against row `other` as well, in its own unit. */
static void level_row(lcp_share *s, int i, int other) {
  const double a = s->diagonal[i], b = s->diagonal[other];
  const double unit = (a > 0 && b > 0) ? sqrt(a / b) : 1;
  s->size[i] = fmax(s->size[i], unit * s->size[other]);
}

/* Rows of one contact share their roundings: those of friction at rest are made of nothing, and are held against
 * the normal row. So do rows of one joint, which are held against all of them. */
static void level_sizes(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    for (int i = b->start + 1; i < lcp_share_end(s, b); i++) {
      level_row(s, i, b->start);
    }
  }
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    for (int i = b->start; i < b->start + b->size && b->set == LCP_FREE; i++) {
      for (int other = b->start; other < b->start + b->size; other++) {
        level_row(s, i, other);
      }
    }
  }
}

/* ---- the three steps ------------------------------------------------------------------------- */

static void set_delta(lcp_share *s, double most_soft) {
  double low = HUGE_VAL, high = 0;
  for (int k = 0; k < s->n_contact; k++) {
    const double d = s->diagonal[lcp_share_block(s, k)->start];
    low = fmin(low, d);
    high = fmax(high, d);
  }
  s->delta = delta_share * sqrt(low) * sqrt(high);
  for (int i = 0; i < s->p->M.n; i++) {
    s->rows.delta[i] = (s->diagonal[i] > 0) ? friction_share * s->delta : 0;
    s->rows.slips[i] = 0;
    s->rows.part[i] = -1;
    s->rows.part_dim[i] = 0;
  }
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    s->rows.delta[b->start] = s->delta * (b->soft / most_soft);
    if (b->set != LCP_CONE) {
      continue;
    }
    s->rows.slips[b->start] = b->start + b->size;
    for (int part = 0, row = b->start + 1; part < b->n_part; part++) {
      for (int m = 0; m < b->part_dim[part]; m++) {
        s->rows.part[row + m] = row;
        s->rows.part_dim[row + m] = b->part_dim[part];
      }
      row += b->part_dim[part];
    }
  }
}

/* The system for the rows as they are. */
static base_status factor(lcp_share *s, bool *regular, base_error *err) {
  if (!s->by_bodies) {
    return lcp_share_system_factor(&s->system, &s->M, &s->rows, regular, err);
  }
  BASE_TRY(lcp_share_system_list(&s->system, s->p->M.n, &s->rows, err));
  s->system.factorizations++;
  return lcp_share_bodies_factor(&s->bodies, &s->rows, regular, err);
}

/* s->z of the unknowns from s->right. */
static void solve(lcp_share *s) {
  if (s->by_bodies) {
    s->system.backsolves += lcp_share_bodies_solve(&s->bodies, &s->rows, s->right, s->z);
  } else {
    lcp_share_system_solve(&s->system, s->right, s->z);
  }
}

/* Factors the active rows; how many of them are too many. */
static base_status rank_of_active(lcp_share *s, int count, int *deficit, base_error *err) {
  bool regular;
  BASE_TRY(factor(s, &regular, err));
  s->normals_regular = regular;
  *deficit = 0;
  if (s->by_bodies) {
    return regular ? lin_body_space_deficit(&s->bodies.space, deficit, err) : BASE_OK;
  }
  *deficit = regular ? lcp_share_system_small_pivots(&s->system, 10.0 * count * s->delta)
                     : s->system.lu.deficient;
  return BASE_OK;
}

static void hold_joints(lcp_share *s, double delta) {
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    for (int i = b->start; i < b->start + b->size && b->set == LCP_FREE; i++) {
      s->rows.kind[i] = SHARE_ACTIVE;
      s->rows.delta[i] = delta;
    }
  }
}

/* Joints kept as free rows, which are rigid; what their own rows say twice leaves no normal impulse open, and is held. */
static base_status begin_with_joints(lcp_share *s, int *count, int *deficit, base_error *err) {
  for (int k = 0; k < s->p->n_block; k++) {
    *count += (s->p->block[k].set == LCP_FREE) ? s->p->block[k].size : 0;
  }
  for (int i = 0; i < s->p->M.n; i++) {
    s->rows.kind[i] = SHARE_FIXED;
  }
  s->has_joints = *count > 0;
  if (!s->has_joints) {
    return BASE_OK;
  }
  hold_joints(s, s->by_bodies ? body_joint_share * s->delta : 0);
  if (!s->counted) {
    return BASE_OK;
  }
  BASE_TRY(rank_of_active(s, *count, deficit, err));
  if (!s->by_bodies) {
    hold_joints(s, (*deficit > 0) ? joint_share * s->delta : 0);
  }
  return BASE_OK;
}

/* Step 1: the touching normal rows, with joints where M has them. */
static base_status rank_of_normals(lcp_share *s, lcp_share_result *out, base_error *err) {
  int free_rows = 0, free_deficit = 0, count = 0;
  BASE_TRY(begin_with_joints(s, &free_rows, &free_deficit, err));
  for (int k = 0; k < s->n_contact; k++) {
    const int i = lcp_share_block(s, k)->start;
    if (lcp_share_touches(s, i)) {
      s->rows.kind[i] = SHARE_ACTIVE;
      count++;
    }
  }
  if (count < 2) {
    return BASE_OK;
  }
  BASE_TRY(rank_of_active(s, free_rows + count, &out->deficit, err));
  out->deficit -= free_deficit;
  return BASE_OK;
}

/* Right-hand side of the system, with delta C times the point that it is anchored at. */
static void fill_right(lcp_share *s) {
  const int n = s->p->M.n;
  const share_rows *r = &s->rows;
  if (s->by_bodies) {
    lcp_share_bodies_right(&s->bodies, r, s->z, s->right);
  } else {
    memcpy(s->right, s->p->q, (size_t)n * sizeof *s->right);
  }
  for (int j = 0; j < n && !s->by_bodies; j++) {
    if (r->kind[j] == SHARE_FIXED && s->z[j] != 0) {
      lcp_column_add(lcp_column_of(&s->M, j), s->z[j], s->right);
    }
  }
  for (int k = 0; k < s->system.count; k++) {
    const int i = s->system.unknown[k];
    if (r->kind[i] == SHARE_ACTIVE) {
      s->right[i] = r->delta[i] * s->anchor[i] - s->right[i];
    }
  }
  for (int k = 0; k < s->system.count; k++) {
    const int i = s->system.unknown[k], first = r->part[i];
    if (r->kind[i] == SHARE_SLIP && first == i) {
      const double u[2] = {s->right[i], (r->part_dim[i] == 2) ? s->right[i + 1] : 0};
      for (int m = 0; m < r->part_dim[i]; m++) {
        s->right[i + m] = -(r->gain[2 * (i + m)] * u[0] + r->gain[2 * (i + m) + 1] * u[1]);
      }
    }
  }
}

static bool is_finite(const lcp_share *s) {
  double sum = 0;
  for (int k = 0; k < s->system.count; k++) {
    sum += fabs(s->z[s->system.unknown[k]]);
  }
  return sum < HUGE_VAL;
}

/* Are the rows of step 1 those of the first round? Its factor then serves both. */
static bool is_factored(const lcp_share *s) {
  bool same = s->normals_regular;
  for (int i = 0; i < s->p->M.n && same; i++) {
    const bool active = s->rows.kind[i] == SHARE_ACTIVE;
    same = same && s->rows.kind[i] != SHARE_SLIP && active == (s->system.local[i] >= 0);
  }
  return same;
}

/* Joints are rigid: what body space gives them of a spring is taken back by solving again from where they are. */
static void stiffen_joints(lcp_share *s) {
  for (int k = 0; k < JOINT_ROUNDS && s->by_bodies && s->has_joints; k++) {
    for (int m = 0; m < s->p->n_block; m++) {
      const lcp_block *b = &s->p->block[m];
      for (int i = b->start; i < b->start + b->size && b->set == LCP_FREE; i++) {
        s->anchor[i] = s->z[i];
      }
    }
    fill_right(s);
    solve(s);
  }
}

static int changes(const lcp_share *s) {
  int count = 0;
  for (int i = 0; i < s->p->M.n; i++) {
    count += s->before[i] != s->rows.kind[i];
  }
  return count;
}

/* Rows that may change in a second round of a search that is worth going on with. */
static int few_changes(const lcp_share *s) {
  return 8 + s->p->M.n / 64;
}

/* Step 2. True: active rows and z of M + delta C agree. `brief`: given up where the second round changes many rows. */
static base_status find_rows(lcp_share *s, int last, bool brief, lcp_share_result *out, bool *found,
                             base_error *err) {
  const int first = out->rounds;
  for (int k = 0; k < s->n_contact; k++) {
    s->anchor[lcp_share_block(s, k)->start] =
        0; /* Tikhonov's term; all other rows stay near the answer */
  }
  *found = false;
  s->pull = 1;
  s->speed_slack = 1e-2 * delta_share;
  while (!*found && out->rounds < last) {
    bool regular = true;
    if (out->rounds++ > 0 || !is_factored(s)) {
      BASE_TRY(factor(s, &regular, err));
    }
    if (!regular) {
      return BASE_OK;
    }
    fill_right(s);
    solve(s);
    stiffen_joints(s);
    product(s, NULL);
    if (!is_finite(s)) {
      return BASE_OK;
    }
    memcpy(s->before, s->rows.kind, (size_t)s->p->M.n);
    *found = !lcp_share_settle(s);
    if (brief && out->rounds > first + 1 && changes(s) > few_changes(s)) {
      return BASE_OK;
    }
  }
  return BASE_OK;
}

/* Step 3, on the factor of the rows found. */
static void approach_limit(lcp_share *s) {
  for (int k = 0; k < MOST_CORRECTIONS; k++) {
    double off = 0;
    memcpy(s->anchor, s->z, (size_t)s->p->M.n * sizeof *s->z);
    fill_right(s);
    if (s->by_bodies) { /* each step corrects what the last one left */
      lcp_share_bodies_correct(&s->bodies, &s->rows, s->right, s->z);
      s->system.backsolves++;
    } else {
      solve(s);
    }
    for (int m = 0; m < s->system.count; m++) {
      const int i = s->system.unknown[m];
      const double moved = s->rows.delta[i] * fabs(s->z[i] - s->anchor[i]);
      off = fmax(off, (s->size[i] > 0) ? moved / s->size[i] : 0);
    }
    if (off <= 1e-2 * LCP_SHARE_ROW_TOL) {
      return;
    }
  }
}

/* Does z solve the problem itself? w is that of z; signs are settled. */
static bool solves(const lcp_share *s) {
  for (int i = 0; i < s->p->M.n; i++) {
    const int k = s->owner[i];
    const bool bound = k >= 0 && s->rests[k] && i == lcp_share_block(s, k)->start && s->z[i] > 0;
    const double allowed = solved_tol * s->size[i] + (bound ? s->had[i] : 0);
    if ((bound || s->rows.kind[i] == SHARE_ACTIVE) && !(fabs(s->w[i]) <= allowed)) {
      return false;
    }
  }
  return true;
}

/* Steps 2 and 3 from the rows of the solver's answer z; *made: s->z is the answer asked for. */
static base_status choose(lcp_share *s, const double *z, int most_rounds, bool brief, bool *made,
                          lcp_share_result *out, base_error *err) {
  const size_t n = (size_t)s->p->M.n;
  const int last = out->rounds + most_rounds;
  memcpy(s->z, z, n * sizeof *z);
  product(s, s->size);
  level_sizes(s);
  for (int i = 0; i < s->p->M.n; i++) {
    s->had[i] = (fabs(s->w[i]) <= answer_tol * s->size[i]) ? fabs(s->w[i]) : 0;
  }
  memset(s->let_go, 0, n * sizeof *s->let_go);
  lcp_share_begin_rows(s);
  memcpy(s->anchor, s->z, n * sizeof *z);
  *made = false;
  bool found = true;
  while (found && out->rounds < last) {
    BASE_TRY(find_rows(s, last, brief, out, &found, err));
    if (!found) {
      return BASE_OK;
    }
    approach_limit(s);
    product(s, s->size);
    level_sizes(s);
    s->pull = 0;
    s->speed_slack = solved_tol;
    if (!lcp_share_settle(s)) {
      *made = solves(s);
      return BASE_OK;
    }
  }
  return BASE_OK;
}

/* A contact of a resting island is held up by the friction that it was found with. */
static bool is_held(const lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const int i = lcp_share_block(s, k)->start;
    if (s->rests[k] && s->rows.kind[i] == SHARE_FIXED && s->lower[i] > 0) {
      return true;
    }
  }
  return false;
}

/* No normal impulse moves by more than delta can tell. */
static bool is_same(const lcp_share *s, const double *z, const double *chosen) {
  for (int k = 0; k < s->n_contact; k++) {
    const int i = lcp_share_block(s, k)->start;
    if (!(fabs(z[i] - chosen[i]) <= same_tol * lcp_share_scale(s, i))) {
      return false;
    }
  }
  return true;
}

/* Where nothing moves normal impulses alone are chosen; where the friction found stands in the way of that, friction
 * is chosen anew with them. */
static base_status choose_among(lcp_share *s, double *z, lcp_share_result *out, base_error *err) {
  const size_t n = (size_t)s->p->M.n;
  bool made, better = false, any_rest = false;
  lcp_share_find_islands(s);
  for (int k = 0; k < s->n_contact; k++) {
    any_rest = any_rest || s->rests[k];
  }
  BASE_TRY(choose(s, z, any_rest ? FIRST_ROUNDS : MOST_ROUNDS, false, &made, out, err));
  const bool again = any_rest && (!made || is_held(s));
  if (again) {
    memcpy(s->kept, s->z, n * sizeof *z);
    for (int k = 0; k < s->n_contact; k++) {
      s->rests[k] = false;
    }
    BASE_TRY(choose(s, z, made ? FREE_ROUNDS : MOST_ROUNDS, made, &better, out, err));
  }
  const double *chosen = (again && !better) ? s->kept : s->z;
  out->outcome = (made || better) ? LCP_SHARE_MADE : LCP_SHARE_MISSED;
  if (out->outcome == LCP_SHARE_MADE && !s->counted && is_same(s, z, chosen)) {
    out->outcome = LCP_SHARE_UNIQUE; /* as far as delta tells */
  } else if (out->outcome == LCP_SHARE_MADE) {
    memcpy(z, chosen, n * sizeof *z);
  }
  return BASE_OK;
}

/* Contacts with compliance; false where there are not two. */
static bool collect(lcp_share *s, double *most_soft) {
  s->n_contact = 0;
  *most_soft = 0;
  for (int k = 0; k < s->p->n_block; k++) {
    if (s->p->block[k].soft > 0) {
      s->contact[s->n_contact++] = k;
      *most_soft = fmax(*most_soft, s->p->block[k].soft);
    }
  }
  return s->n_contact > 1;
}

base_status lcp_share_apply(lcp_share *s, const lcp_problem *p, double *z, lcp_share_result *out,
                            base_error *err) {
  const int n = p->M.n;
  *out = (lcp_share_result){.outcome = LCP_SHARE_UNIQUE};
  if (p->block == NULL || n < 2) {
    return BASE_OK;
  }
  s->view = *p;
  s->by_bodies = p->M.factored != NULL && (p->M.storage == LCP_FACTORED || n > few_rows) &&
                 lin_body_space_admits(p->M.factored, NULL) == BASE_OK;
  if (s->by_bodies) {
    s->view.M = lcp_matrix_in_factors(&p->M);
  }
  p = s->p = &s->view;
  const int n_body = s->by_bodies ? p->M.factored->n_body : 0;
  BASE_TRY(grow(s, n, n_body, err));
  double most_soft;
  if (!collect(s, &most_soft)) {
    return BASE_OK;
  }
  s->M = p->M;
  if (s->by_bodies) {
    BASE_TRY(lcp_share_bodies_begin(&s->bodies, p, err));
  } else if (p->M.storage == LCP_FACTORED) {
    lcp_csc_free(&s->copy);
    BASE_TRY(lcp_matrix_to_csc(&p->M, &s->copy, err));
    s->M = (lcp_matrix){.storage = LCP_CSC, .n = n, .csc = s->copy};
  }
  const long factored = s->system.factorizations, solved = s->system.backsolves;
  memcpy(s->z, z, (size_t)n * sizeof *z);
  lcp_matrix_diagonal(&s->M, s->diagonal);
  product(s, s->size);
  level_sizes(s);
  set_delta(s, most_soft);
  s->counted = !(s->by_bodies && s->n_contact > most_counted);
  if (s->counted) {
    BASE_TRY(rank_of_normals(s, out, err));
  } else {
    int joints = 0;
    BASE_TRY(begin_with_joints(s, &joints, &out->deficit, err));
    s->normals_regular = false;
    out->deficit = LCP_SHARE_UNCOUNTED;
  }
  if (out->deficit != 0) {
    BASE_TRY(choose_among(s, z, out, err));
  }
  out->factorizations = s->system.factorizations - factored;
  out->backsolves = s->system.backsolves - solved;
  return BASE_OK;
}
