/* formulations/event/event_arc.h - smooth motion between events: contacts that persist, each sticking or
 * sliding, as equations of an ODE of index one.
 *
 *   v' = a_free + W sum_i (J_n' + J_t' (slip: -mu d; stick: free)) f_i
 *   a_n + 2 s u_n + s^2 gap = 0           every touching contact
 *   a_t + s u_t = 0                       every sticking one          (s: Baumgarte's rate)
 *
 * Redundant contacts leave the forces undetermined: of all that satisfy the equations those nearest
 * to the forces at the start of the arc are taken (least-norm correction, LAPACK dgelsy), which lie
 * in their cones and which the motion changes continuously. d = u_t/|u_t| while sliding, the
 * direction of departure at the start of it.
 */
#pragma once

#include "formulations/impulse_log.h"
#include "problems/world/world.h"

typedef struct arc_contact {
  uint64_t id;
  bool stick;
  double direction[2]; /* of sliding: at the start of the arc, then of the last accepted state */
  double start[3];     /* force at the start of the arc, contact frame [N] */
  /* written by arc_forces */
  bool present;
  double mu, gap, u[3], force[3];
} arc_contact;

typedef struct arc {
  world *w;    /* borrowed */
  double rate; /* s [1/s] */
  arc_contact *contact;
  int n, cap;
  contact_set set; /* of the last evaluation */
  double open_gap; /* least gap of a contact outside the list that is closing, HUGE_VAL if none */
  long evaluations;
  double *mem; /* work arrays, owned */
  size_t cap_mem;
} arc;

base_status arc_reserve(arc *a, int n_contact, base_error *err);
void arc_close(arc *a);

/* Accelerations (n_dof) at the world's present state, with forces, gaps and velocities of the listed
 * contacts. BASE_EEXTERNAL if the equations cannot be solved. */
base_status arc_forces(arc *a, double *acc, base_error *err);
