/* formulations/impulse_log.h - impulses of contacts over one step of a formulation that integrates
 * the motion itself: trapezoids of the forces at accepted states, plus jumps, keyed by contact id. */
#pragma once

#include "problems/world/contact_set.h"

typedef struct impulse_entry {
  uint64_t id;
  double force[3];   /* at the last accepted state, contact frame [N] */
  double impulse[3]; /* of this step [N s] */
  double memory;     /* one number the owner keeps while the contact lasts */
  bool seen;         /* touching at the last accepted state */
} impulse_entry;

typedef struct impulse_log {
  impulse_entry *entry; /* owned */
  int n, cap;
} impulse_log;

impulse_entry *impulse_log_find(impulse_log *l, uint64_t id); /* NULL if absent */
/* The entry of id, a new one (zero, with `memory`) if there is none. */
base_status impulse_log_at(impulse_log *l, uint64_t id, double memory, impulse_entry **out,
                           base_error *err);
/* One accepted substep of dt: begin, then add every touching contact, then end. */
void impulse_log_begin(impulse_log *l);
void impulse_log_add(impulse_entry *e, double dt, const double force[3]);
void impulse_log_end(impulse_log *l, double dt); /* contacts not seen have lost their force */
/* After a step: forgets contacts that no longer touch, zeroes the impulses of the others. */
void impulse_log_next_step(impulse_log *l);
/* impulse[n_row] of the set from the log, zero where the log has no entry; returns how many of the
 * set's contacts have one. What a contact did that is no longer listed is told by the first of the same two shapes, as where
 * the corner of one took the place of the corner of the other within the step. */
int impulse_log_write(impulse_log *l, const contact_set *c, double *impulse);
void impulse_log_close(impulse_log *l);

/* The same for the joint rows of the set, by their place. */
typedef struct joint_log {
  double *force, *impulse; /* n: at the last accepted state [N], of this step [N s]; owned as one */
  int n, cap;
} joint_log;

/* Adds what the joints of c carry, `lambda` over its rows: impulses of a jump, or forces at the end of a substep of dt >= 0.
 * A joint row that nothing can move is not listed, and comes and goes: the log then begins anew. */
base_status joint_log_add(joint_log *l, const contact_set *c, const double *lambda, double dt,
                          bool jump, base_error *err);
void joint_log_next_step(joint_log *l);
/* Into the joint rows of impulse[n_row], where the log has as many. */
void joint_log_write(const joint_log *l, const contact_set *c, double *impulse);
void joint_log_close(joint_log *l);
