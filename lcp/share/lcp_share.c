/* lcp_share.c - the three steps of lcp_share.h: rank of the normals, active rows, the limit on them. */
#include "lcp/share/lcp_share.h"

#include "lcp/lcp_column.h"
#include "lcp/share/lcp_share_state.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 40, RESTING_ROUNDS = 20, FREE_ROUNDS = 6, FOLLOW_ROUNDS = 6 };

static const double friction_share =
    1e-2; /* of delta, on rows without compliance: holds what is left */
static const double joint_share = 1e-5; /* the same, of joints that say the same twice */
static const double body_joint_share =
    1e-3;                        /* the same in body space, where every row needs some */
static const int few_rows = 128; /* of a stored matrix, that are chosen faster in contact space */
static const int most_counted =
    2000; /* contacts whose rank is counted: that fills in as the graph of all of them */
static const double same_tol = 1e-8; /* z over its terms */

base_status lcp_share_open(lcp_share **out, base_error *err) {
  *out = calloc(1, sizeof **out);
  return (*out != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "no memory for shared impulses");
}

void lcp_share_close(lcp_share *s) {
  if (s != NULL) {
    lcp_share_system_close(&s->system);
    lcp_share_bodies_close(&s->bodies);
    lcp_csc_free(&s->copy);
    free(s->count.touches);
    free(s->mem);
    free(s);
  }
}

void lcp_share_rest(lcp_share *s) {
  lcp_share_system_close(&s->system);
  lcp_share_bodies_rest(&s->bodies);
  lcp_csc_free(&s->copy);
  free(s->mem);
  s->mem = NULL;
}

static void layout(lcp_share *s, base_arena *a) {
  const int n = s->cap_n;
  s->z = BASE_ARRAY(a, double, n);
  s->w = BASE_ARRAY(a, double, n);
  s->size = BASE_ARRAY(a, double, n);
  s->right = BASE_ARRAY(a, double, n);
  s->step = BASE_ARRAY(a, double, n);
  s->anchor = BASE_ARRAY(a, double, n);
  s->diagonal = BASE_ARRAY(a, double, n);
  s->base = BASE_ARRAY(a, double, n);
  s->open = BASE_ARRAY(a, double, n);
  s->answer_w = BASE_ARRAY(a, double, n);
  s->answer_size = BASE_ARRAY(a, double, n);
  s->lower = BASE_ARRAY(a, double, n);
  s->had = BASE_ARRAY(a, double, n);
  s->before = BASE_ARRAY(a, unsigned char, n);
  s->by_limit = BASE_ARRAY(a, unsigned char, n);
  s->contact = BASE_ARRAY(a, int, n);
  s->owner = BASE_ARRAY(a, int, n);
  s->island = BASE_ARRAY(a, int, n);
  s->met = BASE_ARRAY(a, int, s->cap_body);
  s->rests = BASE_ARRAY(a, bool, n);
  s->held = BASE_ARRAY(a, bool, n);
  s->rows.kind = BASE_ARRAY(a, unsigned char, n);
  s->rows.delta = BASE_ARRAY(a, double, n);
  s->rows.into = BASE_ARRAY(a, unsigned char, n);
  s->rows.part_dim = BASE_ARRAY(a, unsigned char, n);
  s->rows.slips = BASE_ARRAY(a, unsigned char, n);
  /* of cones that slip, and of slow limits */
  s->rows.own = BASE_ARRAY(a, double, 2 * (size_t)n);
  s->rows.pull = BASE_ARRAY(a, double, n);
  s->rows.gain = BASE_ARRAY(a, double, 2 * (size_t)n);
  lin_anderson_layout(&s->mixed, n, a);
}

static base_status grow(lcp_share *s, int n, int n_body, base_error *err) {
  if (s->mem != NULL && n <= s->cap_n && n_body <= s->cap_body) {
    return BASE_OK;
  }
  s->cap_n = base_room(n);
  s->cap_body = base_room(n_body);
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

/* ---- the three steps ------------------------------------------------------------------------- */

static void set_delta(lcp_share *s, double most_soft) {
  double low = HUGE_VAL, high = 0;
  for (int k = 0; k < s->n_contact; k++) {
    const double d = s->diagonal[lcp_share_block(s, k)->start];
    low = (d > 0) ? fmin(low, d) : low; /* a row that cannot move has none */
    high = fmax(high, d);
  }
  s->delta = (high > 0) ? LCP_SHARE_DELTA * sqrt(low) * sqrt(high) : 0;
  for (int i = 0; i < s->p->M.n; i++) {
    s->rows.delta[i] = (s->diagonal[i] > 0) ? friction_share * s->delta : 0;
    s->rows.slips[i] = 0;
    s->rows.into[i] = 0;
    s->rows.part_dim[i] = 0;
  }
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    s->rows.delta[b->start] = s->delta * (b->soft / most_soft);
    if (b->set != LCP_CONE) {
      continue;
    }
    s->rows.slips[b->start] = (unsigned char)(b->size - 1);
    for (int part = 0, row = b->start + 1; part < b->n_part; part++) {
      for (int m = 0; m < b->part_dim[part]; m++) {
        s->rows.into[row + m] = (unsigned char)m;
        s->rows.part_dim[row + m] = (unsigned char)b->part_dim[part];
      }
      row += b->part_dim[part];
    }
  }
}
/* Factors the active rows; how many of them are too many. */
static base_status rank_of_active(lcp_share *s, int count, int *deficit, base_error *err) {
  bool regular;
  BASE_TRY(lcp_share_factor(s, &regular, err));
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

static bool touches(const lcp_share *s, int k) {
  return lcp_share_touches(s, lcp_share_block(s, k)->start);
}

/* The same contacts touch as when too many were last counted. */
static bool touch_as_counted(const lcp_share *s) {
  bool same = s->count.deficit > 0 && s->count.n == s->n_contact;
  for (int k = 0; k < s->n_contact && same; k++) {
    same = s->count.touches[k] == touches(s, k);
  }
  return same;
}

static base_status note_count(lcp_share *s, int deficit, base_error *err) {
  share_count *c = &s->count;
  if (c->cap < s->n_contact) {
    free(c->touches);
    *c = (share_count){.cap = base_room(s->n_contact)};
    c->touches = base_alloc((size_t)c->cap * sizeof *c->touches);
    if (c->touches == NULL) {
      *c = (share_count){0};
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to count the rank of %d contacts",
                       s->n_contact);
    }
  }
  c->deficit = deficit;
  c->n = s->n_contact;
  for (int k = 0; k < s->n_contact; k++) {
    c->touches[k] = touches(s, k);
  }
  return BASE_OK;
}

/* Joints kept as free rows, which are rigid; what their own rows say twice leaves no normal impulse open, and is held. Their rank is
 * told where `ranked`. */
static base_status begin_with_joints(lcp_share *s, bool ranked, int *count, int *deficit,
                                     base_error *err) {
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
  if (!ranked) {
    return BASE_OK;
  }
  BASE_TRY(rank_of_active(s, *count, deficit, err));
  if (!s->by_bodies) {
    hold_joints(s, (*deficit > 0) ? joint_share * s->delta : 0);
  }
  return BASE_OK;
}

/* Step 1: the touching normal rows, with joints where M has them. Counting them costs more than all that is left where a last step's
 * choice is at hand: not done again while the same contacts touch. */
static base_status rank_of_normals(lcp_share *s, bool recalls, lcp_share_result *out,
                                   base_error *err) {
  const bool same = recalls && s->by_bodies && touch_as_counted(s);
  int free_rows = 0, free_deficit = 0, count = 0;
  BASE_TRY(begin_with_joints(s, !same, &free_rows, &free_deficit, err));
  if (same) {
    out->deficit = s->count.deficit;
    return BASE_OK;
  }
  for (int k = 0; k < s->n_contact; k++) {
    if (touches(s, k)) {
      s->rows.kind[lcp_share_block(s, k)->start] = SHARE_ACTIVE;
      count++;
    }
  }
  if (count < 2) {
    return BASE_OK;
  }
  BASE_TRY(rank_of_active(s, free_rows + count, &out->deficit, err));
  out->deficit -= free_deficit;
  return s->by_bodies ? note_count(s, out->deficit, err) : BASE_OK;
}

/* A contact of a resting island was held up by its friction in `start`. */
static bool was_held(const lcp_share *s, const double *start) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    if (s->rests[k] && start[b->start] > 0 && lcp_share_is_at_least(s, b, start)) {
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

/* The rows of the last step's answer first, where there is one; then those of the solver's. */
static base_status search(lcp_share *s, const share_search *how, share_end *end,
                          lcp_share_result *out, base_error *err) {
  share_search own = *how;
  own.start = NULL;
  *end = SHARE_LOST;
  if (how->start != NULL) {
    share_search recalled = *how;
    recalled.rounds = RESTING_ROUNDS;
    BASE_TRY(lcp_share_search(s, &recalled, end, out, err));
  }
  return (*end == SHARE_LOST) ? lcp_share_search(s, &own, end, out, err) : BASE_OK;
}

/* Friction is chosen anew with the normal impulses. */
static base_status choose_anew(lcp_share *s, const share_search *how, share_end *end,
                               lcp_share_result *out, base_error *err) {
  memset(s->rests, 0, (size_t)s->n_contact * sizeof *s->rests);
  return lcp_share_search(s, how, end, out, err);
}

static bool any_rests(const lcp_share *s) {
  bool any = false;
  for (int k = 0; k < s->n_contact; k++) {
    any = any || s->rests[k];
  }
  return any;
}

/* Where nothing moves normal impulses alone are chosen. Where the friction found stands in the way of that, friction is chosen anew
 * with them, unless the last step left it so; and where that does not end it stays. */
static base_status find_choice(lcp_share *s, const double *start, share_end *end,
                               lcp_share_result *out, base_error *err) {
  lcp_share_find_islands(s);
  share_search resting = {.start = start, .rounds = MOST_ROUNDS};
  if (!any_rests(s)) {
    return search(s, &resting, end, out, err);
  }
  resting.rounds = RESTING_ROUNDS;
  resting.until_held = !(start != NULL && was_held(s, start));
  BASE_TRY(search(s, &resting, end, out, err));
  if (*end == SHARE_HELD) {
    const share_search brief = {.rounds = FREE_ROUNDS, .brief = true, .held = true};
    BASE_TRY(choose_anew(s, &brief, end, out, err));
    if (*end == SHARE_DONE) {
      return BASE_OK;
    }
    lcp_share_restore_answer(s);
    lcp_share_find_islands(s);
    resting.until_held = false;
    BASE_TRY(search(s, &resting, end, out, err));
  }
  if (*end == SHARE_OFF) {
    BASE_TRY(lcp_share_follow(s, FOLLOW_ROUNDS, end, out, err));
  }
  const share_search whole = {.rounds = MOST_ROUNDS};
  return (*end == SHARE_DONE) ? BASE_OK : choose_anew(s, &whole, end, out, err);
}

static base_status choose_among(lcp_share *s, const double *start, double *z, lcp_share_result *out,
                                base_error *err) {
  const size_t n = (size_t)s->p->M.n;
  share_end end;
  lcp_share_keep_answer(s, z);
  BASE_TRY(find_choice(s, start, &end, out, err));
  out->outcome = (end == SHARE_DONE) ? LCP_SHARE_MADE : LCP_SHARE_MISSED;
  if (out->outcome == LCP_SHARE_MADE && !s->counted && is_same(s, z, s->z)) {
    out->outcome = LCP_SHARE_UNIQUE; /* as far as delta tells */
  } else if (out->outcome == LCP_SHARE_MADE) {
    memcpy(z, s->z, n * sizeof *z);
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

/* `start`, unless it says nothing: no contact carries there. */
static const double *known(const lcp_share *s, const double *start) {
  bool any = false;
  for (int k = 0; start != NULL && k < s->n_contact; k++) {
    any = any || start[lcp_share_block(s, k)->start] > 0;
  }
  return any ? start : NULL;
}

base_status lcp_share_apply(lcp_share *s, const lcp_problem *p, const double *start, double *z,
                            lcp_share_result *out, base_error *err) {
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
  if (s->by_bodies) {
    lcp_share_bodies_diagonal(&s->bodies, s->diagonal);
  } else {
    lcp_matrix_diagonal(&s->M, s->diagonal);
  }
  lcp_share_product(s, s->size);
  lcp_share_level_sizes(s);
  set_delta(s, most_soft);
  s->normals_regular = false;
  const int contacts = (s->n_whole > 0) ? s->n_whole : s->n_contact;
  s->counted = !(s->by_bodies && contacts > most_counted);
  if (s->counted) {
    BASE_TRY(rank_of_normals(s, known(s, start) != NULL, out, err));
  } else {
    int joints = 0;
    BASE_TRY(begin_with_joints(s, false, &joints, &out->deficit, err));
    out->deficit = LCP_SHARE_UNCOUNTED;
  }
  if (out->deficit != 0) {
    BASE_TRY(choose_among(s, known(s, start), z, out, err));
  }
  out->factorizations = s->system.factorizations - factored;
  out->backsolves = s->system.backsolves - solved;
  return BASE_OK;
}
