/* formulations/contact_memory.h - what a formulation remembers of each contact from one step to
 * the next, found again by contact id. An entry is `stride` doubles; a contact that was not listed
 * in the last step has no past. Both lists are sorted by id, so that matching is one merge.
 *
 * The first PAST_COMMON numbers of an entry mean the same to all formulations, so that one can go on where another was
 * (formulation_take_over); what only one of them understands lies behind them and is zero after such a change. */
#pragma once

#include "problems/world/contact_set.h"

/* Impulses are over the rows of the set. What springs pull with is a force or moment, since their deflections mean nothing to
 * another stiffness: k times the deflection, as form_bristle_remember keeps it, for friction, torsion and rolling. */
enum {
  PAST_CLOSED,   /* it was active */
  PAST_SLIDES,   /* its friction slid: the kinetic coefficient holds */
  PAST_APPROACH, /* at which it was met, to be given back in the next step, <= 0 [m/s] */
  PAST_IMPULSE,  /* [N s], [N m s] */
  PAST_SPRUNG = PAST_IMPULSE + 6, /* the last law with springs left them pulling with: */
  PAST_PULL,                      /* [N], [N m] */
  PAST_COMMON = PAST_PULL + 9
};

typedef struct contact_memory {
  int stride;
  int n, n_old, cap;
  void *mem; /* owned; the arrays below */
  uint64_t *id, *id_old;
  double *now, *old; /* stride per contact */
  int *match;        /* n: index in old, -1: new */
  double h_old;      /* step length of the remembered step [s], 0: none */
  double h_now;
} contact_memory;

/* A copy of what is remembered, to come back to. */
typedef struct contact_past {
  int stride, n, cap;
  double h;       /* [s], as h_now */
  double *number; /* n ids, then stride numbers a contact; owned */
} contact_past;

/* The next contact_memory_begin after a recall finds what it would have found after the keep. */
base_status contact_memory_keep(const contact_memory *m, contact_past *past, base_error *err);
base_status contact_memory_recall(contact_memory *m, const contact_past *past, base_error *err);
void contact_memory_drop(contact_past *past);

/* Leaves what every formulation understands. */
void contact_memory_strip(contact_past *past);
/* Steps were taken that nothing is remembered of: what was owed is past. */
void contact_memory_settle(contact_past *past);

/* Moves the present to the past and matches the contacts of c with it; new entries are zero. Of entries of another length the
 * first numbers of both stay. */
base_status contact_memory_begin(contact_memory *m, int stride, const contact_set *c,
                                 base_error *err);
void contact_memory_forget(contact_memory *m);
void contact_memory_close(contact_memory *m);

/* The past of contact i of the set, NULL if it has none. */
static inline const double *contact_memory_old(const contact_memory *m, int i) {
  return (m->match[i] < 0) ? NULL : m->old + (ptrdiff_t)m->match[i] * m->stride;
}
/* Was contact i of the set closed in the last step? A new one was if one of the same two shapes was closed that is no longer
 * listed: where faces lie on each other the corner of one takes the place of the corner of the other. */
bool contact_memory_closed(const contact_memory *m, int i);
/* The coefficient of friction of contact i of set c: the kinetic one where it slid in the last step. */
static inline double contact_memory_mu(const contact_memory *m, const contact_set *c, int i) {
  const double *past = contact_memory_old(m, i);
  return (past != NULL && past[PAST_SLIDES] > 0) ? c->mu_kinetic[i] : c->mu_static[i];
}
/* Where the present of contact i is written. */
static inline double *contact_memory_now(contact_memory *m, int i) {
  return m->now + (ptrdiff_t)i * m->stride;
}
