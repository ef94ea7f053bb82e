/* lcp/lcp_share_state.h - what the parts of lcp_share share; private to lcp_share*.c. lcp_share_rows.c finds which rows
 * are active, lcp_share.c solves for them. */
#pragma once

#include "lcp/lcp_share.h"
#include "lcp/lcp_share_bodies.h"
#include "lcp/lcp_share_system.h"

#define LCP_SHARE_TOUCHING 1e-7  /* w over its terms below which a row touches */
#define LCP_SHARE_ROW_TOL  1e-12 /* w, or z, over its terms: rounding */

/* Owner of a row that belongs to no contact; a joint's rows have smaller ones. */
enum { LCP_SHARE_NOBODY = -1 };

struct lcp_share {
  share_system system;
  share_bodies bodies; /* in its place where M is held in factors */
  bool by_bodies, has_joints;
  share_rows rows;
  double *z, *w, *size, *right, *anchor, *diagonal; /* cap_n */
  double *kept;          /* cap_n: an answer, while a better one is looked for */
  double *lower;         /* cap_n: least value of a normal impulse */
  double *had;           /* cap_n: |w| of the answer that came in */
  unsigned char *before; /* cap_n: kinds of the round before */
  bool *let_go;          /* cap_n: of a resting normal row: the limit asked for it */
  int *contact;          /* cap_n: blocks with compliance */
  int *owner;            /* cap_n: contact of a row, or a number below zero */
  int *island;           /* cap_n: of a contact or a joint: an earlier one, or itself */
  int *met;              /* cap_body: a contact or joint at a body, -1 */
  bool *rests;           /* cap_n: of a contact's island */
  int n_contact;
  int cap_n, cap_body;
  void *mem;            /* owned */
  const lcp_problem *p; /* view, with its factors for storage where by_bodies */
  lcp_problem view;
  lcp_matrix M; /* of p, or its columns where p has factors that the body space does not take */
  lcp_csc copy; /* owned */
  double delta;
  bool normals_regular; /* step 1 left a factor */
  bool counted;         /* step 1 was taken */
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

/* The active rows of the answer in s->z, with its w and sizes. */
void lcp_share_begin_rows(lcp_share *s);

/* Brings the active rows into agreement with z and w; true where they changed. */
bool lcp_share_settle(lcp_share *s);
