/* formulations/event/event_arc.h - smooth motion between events: contacts that persist, each sticking or
 * sliding, as equations of an ODE of index one.
 *
 *   v' = a_free + W sum_i (J_n' + J_t' (slip: -mu d; stick: free)) f_i + W J_b' f_b
 *   a_n + 2 s u_n + s^2 gap = 0           every touching contact
 *   a_t + s u_t = 0                       every sticking one          (s: Baumgarte's rate)
 *   a_b = 0                               every joint; eliminated first (event_space.h)
 *
 * Redundant contacts leave the forces undetermined. Of all that satisfy the equations those are taken that springs
 * share (MATHEMATICS 2.8), or with FORM_EXTREME those nearest to the forces at the start of the arc (least-norm correction,
 * LAPACK dgelsy). The latter lie in their cones at the start, the former only where arc_carries says so; both change
 * continuously with the motion. d = u_t/|u_t| while sliding. Friction turns a slip u_t towards what drives it at the rate
 * mu f/(m |u_t|), which has no bound where sliding begins: there d is the direction of a_t, the limit of a fast turn, as long
 * as u_t leaves it by nothing that the integrator can tell from none. It is found by turning; where 50 turns do not settle it the last is
 * taken, and that counts.
 */
#pragma once

#include "formulations/event/event_space.h"
#include "formulations/impulse_log.h"
#include "problems/world/world.h"

typedef struct arc_contact {
  uint64_t id;
  bool stick;
  bool starts;         /* slides from rest: its tangential speed at the start of the arc is none */
  bool follows;        /* started so, and slides where it is accelerated to since */
  bool edge;           /* at rest on the edge of its cone, and its kinetic coefficient is smaller */
  bool held;           /* there, by its neighbours */
  double direction[2]; /* of sliding: at the start of the arc, then of the last accepted state */
  double start[3];     /* force at the start of the arc, contact frame [N] */
  /* written by arc_forces */
  bool present;
  int at; /* in the assembly; only where present */
  double mu, gap, u[3], force[3];
  double rate[2]; /* of the tangential velocity [m/s^2] */
} arc_contact;

typedef struct arc {
  world *w;           /* borrowed */
  event_space *space; /* borrowed: after arc_forces it holds the forces of the joints */
  double rate;        /* s [1/s] */
  int distribution;   /* form_distribution */
  double
      probe; /* step that contacts are looked for in: no longer than the one that is asked for [s] */
  double margin; /* contacts with a larger gap are not looked for [m] */
  double slow;   /* what cannot be told from rest [m/s]: such a slip keeps its direction */
  double load;   /* largest sum of what the forces, one by one, do to a row [m/s^2] */
  arc_contact *contact;
  int n, cap;
  contact_set set;            /* of the last evaluation */
  long evaluations, unshared; /* answers where redundant contacts could not share as springs do */
  long unsettled;             /* those with directions that had not settled where sliding begins */
  double *mem;                /* work arrays, owned */
  size_t cap_mem;
} arc;

base_status arc_reserve(arc *a, int n_contact, base_error *err);
void arc_close(arc *a);

/* Accelerations (n_dof) at the world's present state, with forces, gaps and velocities of the listed
 * contacts. BASE_ENOMEM; BASE_EEXTERNAL if the equations cannot be solved. */
base_status arc_forces(arc *a, double *acc, base_error *err);
/* Is contact k, which begins to slide, hardly accelerated, beside what its friction would do to it alone? Then its slip takes long to
 * have a direction of its own. As of the last evaluation. */
bool arc_begins_slowly(const arc *a, const arc_contact *k);
/* How fast contact k slides across its direction [m/s]. */
double arc_across(const arc_contact *k);
/* Does contact k stick by a force that lies outside its cone? As of the last evaluation. */
bool arc_slips(const arc *a, const arc_contact *k);
/* Can the contacts carry the forces last evaluated: all touching, none pulls, sticking ones inside their cones? */
bool arc_carries(const arc *a);
/* Takes out of v (n_dof, the world's present velocities) what is left of the normal velocities of the listed
 * contacts and of the tangential ones of those at rest: an impulse without restitution, least in norm. */
base_status arc_settle(arc *a, double *v, base_error *err);
