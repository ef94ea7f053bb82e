/* formulations/contact_memory.h - what a formulation remembers of each contact from one step to
 * the next, found again by contact id. An entry is laid out for what the contacts need (contact_layout); a contact that was
 * not listed in the last step has no past. Both lists are sorted by id, so that matching is one merge.
 *
 * Head, impulses and pulls of an entry mean the same to all formulations, so that one can go on where another was
 * (formulation_take_over); what only one of them understands lies behind them and is zero after such a change. */
#pragma once

#include "problems/world/contact_set.h"

/* Impulses are over the rows of the set. What springs pull with is a force or moment, since their deflections mean nothing to
 * another stiffness: k times the deflection, as form_bristle_remember keeps it, for friction, torsion and rolling. */
enum {
  PAST_CLOSED, /* it was active */
  PAST_SLIDES, /* 1: it slid, by kinetic friction; -1: it rested in the step and slid on, by static friction until it rests or is driven */
  PAST_APPROACH, /* at which it was met, to be given back in the next step, <= 0 [m/s] */
  /* 3: where kinetic friction is less than static, its slip at the end, in the world [m/s] */
  PAST_WAY,
  /* the last law with springs left them pulling with what is behind the impulses */
  PAST_SPRUNG = PAST_WAY + 3,
  PAST_ENERGY, /* in springs [J] */
  PAST_IMPULSE /* [N s], [N m s]; behind them the pulls [N], [N m] */
};

enum {
  CONTACT_KINDS = 3,
  PAST_PULL_NUMBERS = 3
}; /* of a kind of friction: a vector in the world */

/* Numbers of an entry, behind each other. */
typedef struct contact_layout {
  int head; /* PAST_IMPULSE; less where only the first of them are read and there is no more than them and `own` */
  int impulse; /* over the first rows of a contact */
  int pull;    /* PAST_PULL_NUMBERS of each kind of friction, or 0 */
  int own;     /* what only one of the formulations understands */
} contact_layout;

/* Kinds of friction that some contact of the set has room for: 1 friction alone, 2 torsion, 3 rolling. */
int contact_memory_kinds(const contact_set *c);
/* Entries for contacts with so many kinds of friction, 0: without any; with springs or not. */
contact_layout contact_memory_need(int kinds, bool springs, int own);

typedef struct contact_memory {
  contact_layout layout;
  int stride; /* numbers of an entry */
  int n, n_old, cap;
  void *mem; /* owned; the arrays below */
  uint64_t *id, *id_old;
  double *now, *old; /* an entry per contact */
  int *match;        /* n: index in old, -1: new */
  double h_old;      /* step length of the remembered step [s], 0: none */
  double h_now;
} contact_memory;

/* A copy of what is remembered, to come back to. */
typedef struct contact_past {
  contact_layout layout;
  int n, cap;
  double h;       /* [s], as h_now */
  double *number; /* n ids, then an entry a contact; owned */
} contact_past;

/* The next contact_memory_begin after a recall finds what it would have found after the keep. */
base_status contact_memory_keep(const contact_memory *m, contact_past *past, base_error *err);
base_status contact_memory_recall(contact_memory *m, const contact_past *past, base_error *err);
double contact_memory_energy(const contact_past *past); /* in the springs of all contacts [J] */
base_status contact_memory_copy(const contact_past *from, contact_past *to, base_error *err);
void contact_memory_drop(contact_past *past);

/* Moves the entries of `from` whose contact is one of `those` to `to`, with impulses over a step as long as that of `to`. Entries of both have room
 * for what either had. BASE_ENOMEM leaves both as they were. */
base_status contact_memory_move(contact_past *from, contact_past *to,
                                bool (*those)(const void *of, uint64_t id), const void *of,
                                base_error *err);
/* Leaves what every formulation understands. */
void contact_memory_strip(contact_past *past);
/* Steps were taken that nothing is remembered of: what was owed is past. */
void contact_memory_settle(contact_past *past);

/* Moves the present to the past and matches the contacts of c with it; new entries are zero. They have room for what is asked
 * for and for what there was: contacts with torsion or rolling come and go, entries only grow, each part by zeros at its end. BASE_ENOMEM. */
base_status contact_memory_begin(contact_memory *m, contact_layout need, const contact_set *c,
                                 base_error *err);
/* Tells of each contact of the last step by how much it differs from the step before [N s]: by what springs pull with over the step and, where bounds
 * of friction are `lagged`, the normal impulse. HUGE_VAL: it is new. */
void contact_memory_changes(const contact_memory *m, bool lagged,
                            void (*tell)(void *of, uint64_t id, double by), void *of);
void contact_memory_forget(contact_memory *m);
void contact_memory_close(contact_memory *m);

/* The past of contact i of the set, NULL if it has none. */
static inline const double *contact_memory_old(const contact_memory *m, int i) {
  return (m->match[i] < 0) ? NULL : m->old + (ptrdiff_t)m->match[i] * m->stride;
}
/* Was contact i of the set closed in the last step? A new one was if one of the same two shapes was closed that is no longer
 * listed: where faces lie on each other the corner of one takes the place of the corner of the other. */
bool contact_memory_closed(const contact_memory *m, int i);
/* Does contact i of set c slide since the last step: 1, 0, or -1 (PAST_SLIDES)? What moves by less than 1e-9 of what its friction did to
 * it in that step is at rest, and what slides against its way then has turned round since, as an extrapolated state may. Where kinetic friction
 * is less than static, a contact that was open, or is not remembered as in the first step, slides where it
 * slips, as in an impact. */
int contact_memory_slides(const contact_memory *m, const contact_set *c, int i);
/* The slip u, over the rows of contact i of the set, in the world. */
void contact_memory_way(const contact_set *c, int i, const double *u, double way[3]);
/* The coefficient of friction of contact i of set c: the kinetic one where contact_memory_slides says 1. */
static inline double contact_memory_mu(const contact_memory *m, const contact_set *c, int i) {
  return (contact_memory_slides(m, c, i) > 0) ? c->mu_kinetic[i] : c->mu_static[i];
}
/* Where pulls, and what only one formulation understands, begin in an entry. */
static inline int contact_memory_pulls(const contact_memory *m) {
  return m->layout.head + m->layout.impulse;
}
static inline int contact_memory_own(const contact_memory *m) {
  return m->stride - m->layout.own;
}
/* Where the present of contact i is written. */
static inline double *contact_memory_now(contact_memory *m, int i) {
  return m->now + (ptrdiff_t)i * m->stride;
}
