/* lcp_share_limit.c - steps 2 and 3 of lcp_share.h: the active rows, and the limit on them. */
#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"
#include "lcp/share/lcp_share_state.h"

#include <limits.h>
#include <string.h>

enum {
  MOST_CORRECTIONS = 12,
  JOINT_ROUNDS = 4,
  BLOCK_ROUNDS =
      3 /* without fewer rows that ask for a change: then one by one, which cannot go round (Judice & Pires 1994) */
};

static const double answer_tol = 1e-8;  /* w over its terms in an answer */
static const double solved_tol = 1e-11; /* w over its terms in what is handed back */

/* ---- products and systems ---------------------------------------------------------------------- */

BASE_CLONES void lcp_share_product(lcp_share *s, double *size) {
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
void lcp_share_level_sizes(lcp_share *s) {
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
base_status lcp_share_factor(lcp_share *s, bool *regular, base_error *err) {
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

/* ---- the limit ----------------------------------------------------------------------------------- */

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
  int fewest = INT_MAX, more = BLOCK_ROUNDS;
  *found = false;
  s->one_by_one = false;
  s->pull = 1;
  s->speed_slack = 1e-2 * LCP_SHARE_DELTA;
  while (!*found && out->rounds < last) {
    bool regular = true;
    if (out->rounds++ > 0 || !is_factored(s)) {
      BASE_TRY(lcp_share_factor(s, &regular, err));
    }
    if (!regular) {
      return BASE_OK;
    }
    fill_right(s);
    solve(s);
    stiffen_joints(s);
    lcp_share_product(s, NULL);
    if (!is_finite(s)) {
      return BASE_OK;
    }
    memcpy(s->before, s->rows.kind, (size_t)s->p->M.n);
    *found = !lcp_share_settle(s);
    more = (s->asked < fewest) ? BLOCK_ROUNDS : more - 1;
    fewest = (s->asked < fewest) ? s->asked : fewest;
    s->one_by_one = more <= 0;
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

static void begin(lcp_share *s, const share_search *how) {
  const size_t n = (size_t)s->p->M.n;
  memcpy(s->z, how->z, n * sizeof *s->z);
  lcp_share_product(s, s->size);
  lcp_share_level_sizes(s);
  for (int i = 0; i < s->p->M.n; i++) {
    s->had[i] = (fabs(s->w[i]) <= answer_tol * s->size[i]) ? fabs(s->w[i]) : 0;
  }
  memset(s->by_limit, 0, n);
  lcp_share_begin_rows(s);
  if (how->start != NULL) {
    lcp_share_recall_rows(s, how->start);
  }
  memcpy(s->anchor, s->z, n * sizeof *s->z);
}

base_status lcp_share_search(lcp_share *s, const share_search *how, share_end *end,
                             lcp_share_result *out, base_error *err) {
  const int last = out->rounds + how->rounds;
  begin(s, how);
  *end = SHARE_LOST;
  bool found = true;
  while (found && out->rounds < last) {
    BASE_TRY(find_rows(s, last, how->brief, out, &found, err));
    if (!found) {
      return BASE_OK;
    }
    approach_limit(s);
    drop_delta(s);
    if (!lcp_share_settle(s)) {
      *end = judged(s);
      return BASE_OK;
    }
  }
  return BASE_OK;
}

base_status lcp_share_follow(lcp_share *s, int rounds, share_end *end, lcp_share_result *out,
                             base_error *err) {
  memset(s->rests, 0, (size_t)s->n_contact * sizeof *s->rests);
  lcp_share_begin_rows(s);
  lcp_share_hold_bounds(s);
  for (int k = 0; k < rounds; k++) {
    bool regular;
    out->rounds++;
    BASE_TRY(lcp_share_factor(s, &regular, err));
    if (!regular) {
      return BASE_OK;
    }
    approach_limit(s);
    drop_delta(s);
    if (!lcp_share_settle(s)) {
      *end = judged(s);
      return BASE_OK;
    }
  }
  return BASE_OK;
}
