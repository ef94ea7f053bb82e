/* lcp_share_limit.c - steps 2 and 3 of lcp_share.h: the active rows, and the limit on them. */
#include "lcp/share/lcp_share_state.h"

#include <float.h>
#include <limits.h>
#include <string.h>

enum {
  MOST_CORRECTIONS = 12,
  PLAIN_CORRECTIONS = 3,
  MOST_SOLUTIONS = 8,
  MOST_CLEARINGS = 4,
  MOST_TURNS = 12,
  JOINT_ROUNDS = 4,
  BLOCK_ROUNDS =
      3 /* without fewer rows that ask for a change: then one by one, which cannot go round (Judice & Pires 1994) */
};

static const double answer_tol = 1e-8;  /* w over its terms in an answer */
static const double clearly = 0.999;    /* of what friction asks for */
static const double slow = 0.99;        /* a round leaves at most this share, or no limit is near */
static const double solved_tol = 1e-11; /* w over its terms in what is handed back */
/* of the largest impulse: to take out less leaves rounding in rows that carry nothing, and turns their signs */
static const double worth_clearing = 1e-10;

/* ---- systems ------------------------------------------------------------------------------------ */

base_status lcp_share_factor(lcp_share *s, bool *regular, base_error *err) {
  if (!s->by_bodies) {
    return lcp_share_system_factor(&s->system, &s->M, &s->rows, regular, err);
  }
  BASE_TRY(lcp_share_system_list(&s->system, s->p->M.n, &s->rows, err));
  s->system.factorizations++;
  return lcp_share_bodies_factor(&s->bodies, &s->rows, regular, err);
}

/* ---- the limit ----------------------------------------------------------------------------------- */

/* What row i of the system misses at s->z, of which s->w is known. */
static double missing(const lcp_share *s, int i) {
  const share_rows *r = &s->rows;
  if (r->kind[i] == SHARE_ACTIVE) {
    return r->delta[i] * (s->anchor[i] - s->z[i]) - s->w[i];
  }
  double sum = 0;
  for (int m = 0; m < r->part_dim[i]; m++) {
    const int at = share_first(r, i) + m;
    const double speed = s->w[at] + r->delta[at] * (s->z[at] - s->anchor[at]);
    sum += r->own[2 * i + m] * s->z[at] + r->gain[2 * i + m] * speed;
  }
  return -sum;
}

/* x = A^-1 s->right, over the unknowns of the system. */
static void solve_for(lcp_share *s, double *x) {
  if (s->by_bodies) {
    lin_body_space_solve(&s->bodies.space, s->right, x);
    s->system.backsolves++;
  } else {
    lcp_share_system_solve(&s->system, s->right, x);
  }
}

/* One correction of s->z towards the solution of the system, in s->step, from s->w = M z + q. */
static void correct(lcp_share *s) {
  const share_rows *r = &s->rows;
  const share_system *y = &s->system;
  for (int k = 0; k < y->count; k++) {
    s->right[y->unknown[k]] = missing(s, y->unknown[k]);
  }
  for (int k = 0; k < y->count && y->slips; k++) {
    const int i = y->unknown[k];
    for (int m = i + 1; r->kind[i] == SHARE_ACTIVE && m < share_slips(r, i); m++) {
      s->right[m] -= (r->kind[m] == SHARE_SLIP) ? r->pull[m] * s->z[i] : 0;
    }
  }
  solve_for(s, s->step);
  for (int k = 0; k < y->count; k++) {
    s->z[y->unknown[k]] += s->step[y->unknown[k]];
  }
}

static double largest_step(const lcp_share *s) {
  double most = 0;
  for (int k = 0; k < s->system.count; k++) {
    const double step = fabs(s->step[s->system.unknown[k]]);
    most = (step > most) ? step : most;
  }
  return most;
}

/* w for the next correction. In contact space, where one is exact, from zero: what z has beside the solution would leave its
 * roundings, over delta, in what M does not see. */
static void prepare(lcp_share *s) {
  for (int k = 0; k < s->system.count && !s->by_bodies; k++) {
    s->z[s->system.unknown[k]] = 0;
  }
  lcp_share_refresh_product(s);
}

/* A normal impulse of a resting island is so far below what carries its friction that no further correction lifts it. */
static bool will_be_held(const lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const int i = lcp_share_block(s, k)->start;
    if (s->rests[k] && s->rows.kind[i] == SHARE_ACTIVE && s->z[i] < clearly * s->lower[i]) {
      return true;
    }
  }
  return false;
}

/* s->z is the solution of the system, w that of z. In body space delta costs seven to ten digits of a correction: there are more
 * until the next one would be rounding. `until_held`: or until a contact is held up, w being left as it was. */
static void solve(lcp_share *s, bool until_held) {
  double first = 0, last = HUGE_VAL, step = 0;
  int count = 0;
  prepare(s);
  do {
    correct(s);
    if (until_held && will_be_held(s)) {
      return;
    }
    lcp_share_product(s, NULL);
    last = (count > 0) ? step : HUGE_VAL;
    step = largest_step(s);
    first = (count == 0) ? step : first;
    count++;
  } while (s->by_bodies && count < MOST_SOLUTIONS && step < 0.5 * last &&
           (count == 1 || step * (step / last) > DBL_EPSILON * first));
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
    solve(s, false);
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

/* Step 2. SHARE_FOUND: active rows and z of M + delta C agree. */
static base_status find_rows(lcp_share *s, const share_search *how, int last, share_end *end,
                             lcp_share_result *out, base_error *err) {
  const int first = out->rounds;
  for (int k = 0; k < s->n_contact; k++) {
    s->anchor[lcp_share_block(s, k)->start] =
        0; /* Tikhonov's term; all other rows stay near the answer */
  }
  int fewest = INT_MAX, more = BLOCK_ROUNDS;
  *end = SHARE_LOST;
  s->one_by_one = false;
  s->pull = 1;
  s->speed_slack = 1e-2 * LCP_SHARE_DELTA;
  while (*end == SHARE_LOST && out->rounds < last) {
    bool regular = true;
    if (out->rounds++ > 0 || !is_factored(s)) {
      BASE_TRY(lcp_share_factor(s, &regular, err));
    }
    if (!regular) {
      return BASE_OK;
    }
    solve(s, how->until_held);
    stiffen_joints(s);
    if (!is_finite(s)) {
      return BASE_OK;
    }
    memcpy(s->before, s->rows.kind, (size_t)s->p->M.n);
    if (!lcp_share_settle(s)) {
      *end = SHARE_FOUND;
    } else if (how->until_held && lcp_share_note_held(s)) {
      *end = SHARE_HELD;
    }
    more = (s->asked < fewest) ? BLOCK_ROUNDS : more - 1;
    fewest = (s->asked < fewest) ? s->asked : fewest;
    s->one_by_one = more <= 0;
    if (how->brief && out->rounds > first + 1 && changes(s) > few_changes(s)) {
      *end = SHARE_LOST;
      return BASE_OK;
    }
  }
  return BASE_OK;
}

/* After some rounds what is left decays by delta / (delta + sigma) a round, sigma small: loads on what hardly holds them. The points
 * are mixed then, with weights of sum one, which leave them where Cz is in the range of A. What does not decay has no limit. */
static base_status mix(lcp_share *s, base_error *err) {
  const int n = s->p->M.n;
  for (int i = 0; i < n; i++) {
    s->step[i] = s->z[i] - s->anchor[i];
    s->z[i] = s->anchor[i];
  }
  return lin_anderson_next(&s->mixed, s->step, 1, s->z, err);
}

/* D s->open in the rows of the system. */
static void pull_open(lcp_share *s) {
  const share_rows *r = &s->rows;
  for (int k = 0; k < s->system.count; k++) {
    const int i = s->system.unknown[k];
    s->right[i] = (r->kind[i] == SHARE_ACTIVE) ? r->delta[i] * s->open[i] : 0;
    for (int m = 0; m < r->part_dim[i] && r->kind[i] == SHARE_SLIP; m++) {
      const int at = share_first(r, i) + m;
      s->right[i] += r->gain[2 * i + m] * r->delta[at] * s->open[at];
    }
  }
}

/* Is s->open more of z than its own solves leave in rows that carry nothing? In the unit of impulses of one energy. */
static bool is_worth_clearing(const lcp_share *s) {
  double most = 0, largest = 0;
  for (int k = 0; k < s->system.count; k++) {
    const int i = s->system.unknown[k];
    most = fmax(most, s->diagonal[i] * s->open[i] * s->open[i]);
    largest = fmax(largest, s->diagonal[i] * s->z[i] * s->z[i]);
  }
  return most > worth_clearing * worth_clearing * largest;
}

/* Every solution has its roundings, over delta, in what M does not see: 1e-9 of z, and more where q is not quite in the range of M.
 * z - base, whose D (z - base) is w, has nothing there. B = A^-1 D leaves that part u of z - base as it is, and of the rest delta
 * a time: it is repeated until M u, which is D times what the last time changed, is rounding. Where that takes long u stays. */
static void clear_open(lcp_share *s, double limit) {
  const share_system *y = &s->system;
  double off = HUGE_VAL;
  for (int k = 0; k < y->count; k++) {
    const int i = y->unknown[k];
    s->open[i] = s->z[i] - s->base[i];
  }
  for (int times = 0; times < MOST_CLEARINGS && off > limit; times++) {
    off = 0;
    pull_open(s);
    solve_for(s, s->step);
    for (int k = 0; k < y->count; k++) {
      const int i = y->unknown[k];
      const double changed = s->rows.delta[i] * fabs(s->step[i] - s->open[i]);
      off = (s->size[i] > 0 && changed > off * s->size[i]) ? changed / s->size[i] : off;
      s->open[i] = s->step[i];
    }
  }
  const bool clears = off <= limit && is_worth_clearing(s);
  for (int k = 0; k < y->count && clears; k++) {
    s->z[y->unknown[k]] -= s->open[y->unknown[k]];
  }
}

/* Step 3, on the factor of the rows found: every solution is anchored at the last one. */
static base_status approach_limit(lcp_share *s, base_error *err) {
  const double limit = 1e-2 * LCP_SHARE_ROW_TOL;
  double off = HUGE_VAL;
  bool mixes = false;
  lin_anderson_begin(&s->mixed, s->p->M.n);
  for (int k = 0; k < MOST_CORRECTIONS; k++) {
    const double last = off;
    off = 0;
    memcpy(s->anchor, s->z, (size_t)s->p->M.n * sizeof *s->z);
    prepare(s);
    correct(s);
    for (int m = 0; m < s->system.count; m++) {
      const int i = s->system.unknown[m];
      const double moved = s->rows.delta[i] * fabs(s->z[i] - s->anchor[i]);
      off = (s->size[i] > 0 && moved > off * s->size[i]) ? moved / s->size[i] : off;
    }
    if (off <= limit || (off <= solved_tol && off > 0.5 * last)) {
      break;
    }
    mixes = (k == PLAIN_CORRECTIONS) ? off < slow * last : mixes;
    if (mixes) {
      BASE_TRY(mix(s, err));
    }
  }
  /* What hands back an answer goes on in what M does not see without end, by rounding of q; what does not is on its way to where a
   * contact closes. In body space friction of cones that slip would turn. */
  if (off <= solved_tol && !(s->system.slips && s->by_bodies)) {
    clear_open(s, limit);
  }
  return BASE_OK;
}

/* Does z solve the problem itself, or but for what delta leaves? w is that of z; signs are settled. */
static share_end judged(const lcp_share *s) {
  share_end end = SHARE_DONE;
  for (int i = 0; i < s->p->M.n; i++) {
    const int k = s->owner[i];
    const bool bound = k >= 0 && s->rests[k] && i == lcp_share_block(s, k)->start &&
                       s->z[i] > LCP_SHARE_ROW_TOL * lcp_share_scale(s, i);
    const double off = fabs(s->w[i]), allowed = solved_tol * s->size[i] + (bound ? s->had[i] : 0);
    if (!(bound || s->rows.kind[i] == SHARE_ACTIVE) || off <= allowed) {
      continue;
    }
    if (!(off <= LCP_SHARE_DELTA * s->size[i])) {
      return SHARE_LOST;
    }
    end = SHARE_OFF;
  }
  return end;
}

/* w and the sizes of s->z, with delta gone. */
static void drop_delta(lcp_share *s) {
  lcp_share_product(s, s->size);
  lcp_share_level_sizes(s);
  s->pull = 0;
  s->one_by_one = false;
  s->speed_slack = solved_tol;
}

void lcp_share_keep_answer(lcp_share *s, const double *z) {
  const size_t n = (size_t)s->p->M.n;
  s->answer = z;
  memcpy(s->answer_w, s->w, n * sizeof *s->w);
  memcpy(s->answer_size, s->size, n * sizeof *s->size);
  for (size_t i = 0; i < n; i++) {
    const double off = fabs(s->w[i]);
    s->had[i] = (off <= answer_tol * s->size[i]) ? off : 0;
  }
}

void lcp_share_restore_answer(lcp_share *s) {
  const size_t n = (size_t)s->p->M.n;
  memcpy(s->z, s->answer, n * sizeof *s->z);
  memcpy(s->w, s->answer_w, n * sizeof *s->w);
  memcpy(s->size, s->answer_size, n * sizeof *s->size);
  lcp_share_note_product(s);
}

static void begin(lcp_share *s, const share_search *how) {
  const size_t n = (size_t)s->p->M.n;
  lcp_share_restore_answer(s);
  s->pull = 0;
  memset(s->by_limit, 0, n);
  lcp_share_begin_rows(s);
  if (how->start != NULL) {
    lcp_share_recall_rows(s, how->start);
  }
  if (how->held) {
    lcp_share_begin_held(s);
  }
  memcpy(s->anchor, s->z, n * sizeof *s->z);
}

static base_status settle_once(lcp_share *s, bool *changed, base_error *err) {
  BASE_TRY(approach_limit(s, err));
  drop_delta(s);
  memcpy(s->before, s->rows.kind, (size_t)s->p->M.n);
  *changed = lcp_share_settle(s);
  return BASE_OK;
}

/* Step 3, and whether rows then ask for another kind. Without delta friction that slips has another direction, which the same rows
 * meet: from where they are and not with delta again. *lost: they do not. */
static base_status settle_limit(lcp_share *s, int last, bool *changed, bool *lost,
                                lcp_share_result *out, base_error *err) {
  bool regular = true;
  BASE_TRY(settle_once(s, changed, err));
  for (int k = 0; k < MOST_TURNS && *changed && changes(s) == 0 && out->rounds < last; k++) {
    out->rounds++;
    BASE_TRY(lcp_share_factor(s, &regular, err));
    if (!regular) {
      break;
    }
    BASE_TRY(settle_once(s, changed, err));
  }
  *lost = !regular || (*changed && changes(s) == 0);
  return BASE_OK;
}

base_status lcp_share_search(lcp_share *s, const share_search *how, share_end *end,
                             lcp_share_result *out, base_error *err) {
  const int last = out->rounds + how->rounds;
  begin(s, how);
  *end = SHARE_FOUND;
  while (*end == SHARE_FOUND && out->rounds < last) {
    BASE_TRY(find_rows(s, how, last, end, out, err));
    if (*end != SHARE_FOUND) {
      return BASE_OK;
    }
    bool changed, lost;
    memcpy(s->base, s->anchor, (size_t)s->p->M.n * sizeof *s->base);
    BASE_TRY(settle_limit(s, last, &changed, &lost, out, err));
    if (lost) {
      *end = SHARE_LOST;
      return BASE_OK;
    }
    if (!changed) {
      *end = judged(s);
    } else if (how->until_held && lcp_share_note_held(s)) {
      *end = SHARE_HELD;
    }
  }
  *end = (*end == SHARE_FOUND) ? SHARE_LOST : *end;
  return BASE_OK;
}

base_status lcp_share_follow(lcp_share *s, int rounds, share_end *end, lcp_share_result *out,
                             base_error *err) {
  memset(s->rests, 0, (size_t)s->n_contact * sizeof *s->rests);
  lcp_share_begin_rows(s);
  lcp_share_hold_bounds(s);
  memcpy(s->base, s->z, (size_t)s->p->M.n * sizeof *s->base);
  for (int k = 0; k < rounds; k++) {
    bool regular;
    out->rounds++;
    BASE_TRY(lcp_share_factor(s, &regular, err));
    if (!regular) {
      return BASE_OK;
    }
    BASE_TRY(approach_limit(s, err));
    drop_delta(s);
    if (!lcp_share_settle(s)) {
      *end = judged(s);
      return BASE_OK;
    }
  }
  return BASE_OK;
}
