/* lcp/share/lcp_share_state.h - what the parts of lcp_share share; private to lcp_share*.c. lcp_share_rows.c finds which rows
 * are active, lcp_share.c solves for them. */
#pragma once

#include "lcp/linear/anderson.h"
#include "lcp/share/lcp_share.h"
#include "lcp/share/lcp_share_bodies.h"
#include "lcp/share/lcp_share_system.h"

#include <stdint.h>

#define LCP_SHARE_DELTA                                                                            \
  1e-7 /* of the diagonal; what M leaves open has 1e-16 over this as noise in a solution */
#define LCP_SHARE_TOUCHING 1e-7  /* w over its terms below which a row touches */
#define LCP_SHARE_ROW_TOL  1e-12 /* w, or z, over its terms: rounding */
#define LCP_SHARE_AT_BOUND 1e-9  /* a normal impulse over what its friction asks for, less one */

/* Owner of a row that belongs to no contact; a joint's rows have smaller ones. */
enum { LCP_SHARE_NOBODY = -1 };

/* How many touching normals were too many when that was last counted, and which contacts touched. */
typedef struct share_count {
  int deficit, n, cap;
  bool *touches; /* cap; owned */
} share_count;

struct lcp_share {
  share_count count;
  share_system system;
  share_bodies bodies; /* in its place where M is held in factors */
  bool by_bodies, has_joints;
  share_rows rows;
  double *z, *w, *size, *right, *step, *anchor, *diagonal; /* cap_n */
  double *base, *open; /* cap_n: where the rows found were anchored; what M does not see of a z */
  double *lower;       /* cap_n: least value of a normal impulse */
  lin_anderson mixed;  /* points of a slow limit */
  uint64_t seen;       /* of z of the last product, of which w is: sum_of in lcp_share_product.c; */
  bool stale;          /* but w has been changed since */
  const double *answer;                 /* view: the one that came in, */
  double *answer_w, *answer_size, *had; /* cap_n: its w, its sizes, its |w| where small */
  unsigned char *before;                /* cap_n: kinds of the round before */
  unsigned char
      *by_limit; /* cap_n: 1 + the kind of a normal row that the limit asked for, else 0 */
  int *contact;  /* cap_n: blocks with compliance */
  int *owner;    /* cap_n: contact of a row, or a number below zero */
  int *island;   /* cap_n: of a contact or a joint: an earlier one, or itself */
  int *met;      /* cap_body: a contact or joint at a body, -1 */
  bool *rests;   /* cap_n: of a contact's island */
  bool *held;    /* cap_n: of a contact: lcp_share_note_held */
  int n_island;  /* contacts and joints not yet joined to an earlier one */
  int n_contact;
  int n_whole; /* contacts of the problem of which this is an island; 0: it is all of it */
  int cap_n, cap_body;
  void *mem;            /* owned */
  const lcp_problem *p; /* view, with its factors for storage where by_bodies */
  lcp_problem view;
  lcp_matrix M; /* of p, or its columns where p has factors that the body space does not take */
  lcp_csc copy; /* owned */
  double delta;
  bool normals_regular; /* step 1 left a factor */
  bool counted;         /* step 1 was taken */
  bool one_by_one;      /* of resting normal rows one may change in a round */
  int asked;            /* of them asked for a change in the last round */
  double pull;          /* 1 while delta is in the problem, 0 once it has gone */
  double speed_slack;   /* slip speeds below zero by this share: delta's doing, until it has gone */
};

static inline const lcp_block *lcp_share_block(const lcp_share *s, int k) {
  return &s->p->block[s->contact[k]];
}

/* One past the last row of the contact of block b: the friction of a box is the block behind its normal. */
static inline int lcp_share_end(const lcp_share *s, const lcp_block *b) {
  const bool boxed = b + 1 < s->p->block + s->p->n_block && b[1].set == LCP_BOX;
  return b->start + b->size + (boxed ? b[1].size : 0);
}

/* Of the friction of a part, one or two rows. */
static inline double lcp_share_length(const double *x, int n) {
  return (n == 1) ? fabs(x[0]) : sqrt(x[0] * x[0] + x[1] * x[1]);
}

/* Speed of friction row i, with what delta asks of it while delta is in the problem: zero where it sticks. */
static inline double lcp_share_speed(const lcp_share *s, int i) {
  return s->w[i] + s->pull * s->rows.delta[i] * (s->z[i] - s->anchor[i]);
}

/* What z of row i is measured against. */
static inline double lcp_share_scale(const lcp_share *s, int i) {
  return (s->diagonal[i] > 0) ? s->size[i] / s->diagonal[i] : 0;
}

static inline bool lcp_share_carries(const lcp_share *s, int i) {
  return s->z[i] > LCP_SHARE_TOUCHING * lcp_share_scale(s, i);
}

/* Normal row i touches: it carries something, or does not part. Iterative solvers leave w above zero there. */
static inline bool lcp_share_touches(const lcp_share *s, int i) {
  return s->w[i] <= LCP_SHARE_TOUCHING * s->size[i] || lcp_share_carries(s, i);
}

/* Contacts that M couples, and of which islands every touching contact is still: there only normal impulses are
 * chosen, and friction stays as it was found. */
void lcp_share_find_islands(lcp_share *s);

/* Least normal impulse that carries the friction that contact b has in z. */
double lcp_share_carried(const lcp_share *s, const lcp_block *b, const double *z);

/* Contact b has no more in z than its friction asks for. */
bool lcp_share_is_at_least(const lcp_share *s, const lcp_block *b, const double *z);

/* The same for one part of a cone or of facets, whose first row is `row`. */
double lcp_share_carried_by(const lcp_share *s, const lcp_block *b, int part, int row,
                            const double *z);

/* Notes in s->held which contacts of resting islands are held up by the friction that they were found with; true: some. */
bool lcp_share_note_held(lcp_share *s);

/* ---- rows ---- */

/* The active rows of the answer in s->z, with its w and sizes. */
void lcp_share_begin_rows(lcp_share *s);

/* After it: of the contacts that touch, those are held that were held in `start`, which carried nothing there or no more than
 * their friction asked for. */
void lcp_share_recall_rows(lcp_share *s, const double *start);

/* After it: the contacts noted by lcp_share_note_held are held, or have friction at its bound where it is chosen anew. */
void lcp_share_begin_held(lcp_share *s);

/* After it: facets of friction that is at its bound stay there. */
void lcp_share_hold_bounds(lcp_share *s);

/* Brings the active rows into agreement with z and w; true where they changed. */
bool lcp_share_settle(lcp_share *s);

/* ---- the limit ---- */

/* w = M z + q of s->z; size: the sum of what each row is made of, unless NULL. */
void lcp_share_product(lcp_share *s, double *size);
/* w is that of z. */
void lcp_share_note_product(lcp_share *s);
/* The same without sizes, unless z is that of the last time, by a sum of 64 bits over it. */
void lcp_share_refresh_product(lcp_share *s);
/* Rows of one contact share their roundings, as do those of one joint. */
void lcp_share_level_sizes(lcp_share *s);

/* The system for the rows as they are. *regular = false: singular. */
base_status lcp_share_factor(lcp_share *s, bool *regular, base_error *err);

/* Keeps z, of which s->w and s->size are, as the answer that searches begin from; takes it back. */
void lcp_share_keep_answer(lcp_share *s, const double *z);
void lcp_share_restore_answer(lcp_share *s);

/* How a search ended: no active rows found that solve the problem; found, with delta; given up since a contact is held up; solved,
 * but for what delta leaves of a motion; s->z is the answer asked for. */
typedef enum share_end { SHARE_LOST, SHARE_FOUND, SHARE_HELD, SHARE_OFF, SHARE_DONE } share_end;

typedef struct share_search {
  const double *
      start; /* an answer of the step before, whose rows are tried first; NULL: those of the answer */
  int rounds;      /* most */
  bool brief;      /* given up where the second round changes many rows */
  bool until_held; /* given up where lcp_share_note_held finds some */
  bool
      held; /* the noted ones begin with friction at its bound, or at the normal impulse that it asks for */
} share_search;

/* Steps 2 and 3. */
base_status lcp_share_search(lcp_share *s, const share_search *how, share_end *end,
                             lcp_share_result *out, base_error *err);

/* After SHARE_OFF: normal impulses and friction together, from where they are. */
base_status lcp_share_follow(lcp_share *s, int rounds, share_end *end, lcp_share_result *out,
                             base_error *err);
