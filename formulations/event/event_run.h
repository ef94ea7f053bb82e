/* formulations/event/event_run.h - what the parts of `event` share; private to them: form_event.c takes
 * steps, event_advance.c integrates a substep and locates the event that ends it, event_resolve.c says what
 * happens there. */
#pragma once

#include "formulations/event/event_arc.h"
#include "formulations/event/event_turns.h"
#include "formulations/event/event_watch.h"
#include "formulations/gsl_library.h"

/* What follows where forces, or impulses by Newton's law of restitution, have no solution. */
enum event_paradox { PARADOX_IMPACT, PARADOX_STOP };
enum event_restitution { EVENT_NEWTON, EVENT_POISSON };

typedef struct event_options {
  int facets, max_events, max_evaluations, distribution;
  int paradox;     /* event_paradox */
  int restitution; /* event_restitution */
  double rest_speed, resolve, rate, rtol, atol;
} event_options;

typedef struct event_run {
  const event_options *opt;
  const formulation_solver *solver; /* borrowed, during step only */
  base_error *err;
  world *w;
  arc arc;
  impulse_log log;
  event_space space;
  event_watch watch;
  slip_problem p;
  facet_turns turns;
  bool started, solved;
  bool without_solution; /* the last problem ended on a ray, or in a proof */
  int n_config, n_dof;
  gsl_library gsl;
  gsl_odeiv2_system system;
  gsl_odeiv2_driver *driver;
  gsl_odeiv2_step *trial;       /* single steps of the bisection */
  double *y, *from, *acc, *dev; /* n_config + n_dof each */
  double *old; /* 2 per contact of the arc: directions at the start of the substep */
  int cap_old;
  double substep;
  double rest;        /* impacts slower than this do not bounce [m/s] */
  double atol;        /* of this step [m], [m/s] */
  double pull;        /* largest free acceleration of a contact at the last event [m/s^2] */
  double speed, slow; /* largest speed so far; what the integrator cannot tell from rest [m/s] */
  double *row, *z;    /* scratch of a problem: three times rows, unknowns */
  int cap_row, cap_contact;
  joint_log joints;
  double *impulse, *bias; /* of the answer */
  int cap_out;
  contact_set out;
  formulation_answer answer;
} event_run;

/* Touching: a gap within this many tolerances of the set, more than the drift of an arc. */
static const double event_touching = 100.0;

/* Rates of y = (configuration, velocities) on the arc, for GSL; params is the event_run. */
int event_rates(double t, const double y[], double dy[], void *params);
/* One accepted substep, cut at the first event; *event says whether it was. */
base_status event_substep(event_run *s, double *t, double end, bool *event, base_error *err);
/* Joints hold to rounding after every substep, so that their drift does not grow. What the integrator
 * knows of the rates at the end of the substep is then no longer true. */
base_status event_onto_joints(event_run *s, double t, base_error *err);
/* s->slow: what the integrator cannot tell from rest, so many of its errors at the largest speed so far. */
void event_set_slow(event_run *s);
/* Everything that happens at one instant: impact, then the contacts that persist and their modes,
 * from the state in s->y and into it. s->solved is false where a problem was not solved. */
base_status event_resolve(event_run *s, double t, base_error *err);

/* Of the contacts that s->space poses, with s->p begun; u0 is n_row of the assembly, as lambda. */

/* Solves u = u0 + C lambda with its facets turned until friction is that of the circle; where
 * it never is, the answer is unsolved and carries how far it is off. */
base_status event_solve(event_run *s, const double *u0, double *lambda, base_error *err);
/* Velocities that are rounding errors of the others are zero: a contact at rest beside an impact
 * would otherwise pose a problem of its own, of noise. */
void event_drop_noise(int n, double *u);
/* term (n_row) of the contacts that s->space poses becomes the nearest that their forces could answer: normal rows, and all of contacts
 * at rest. Joints, and contacts that hold each other, leave fewer ways to move than rows: what no force could make of them would seem
 * to part contacts, or friction to miss its law. Normals that joints hold are left out. BASE_ENOMEM, BASE_EEXTERNAL. */
base_status event_make_consistent(const event_run *s, double *term, base_error *err);

/* Largest free acceleration of u0: what is smaller than 1e-9 of it is none. */
double event_scale(const event_run *s, const double *u0);
/* How contact i starts to move along its tangents under the forces lambda: its acceleration, and the size of that, 0 where it is none. */
double event_departs(const event_run *s, int i, const double *u0, const double *lambda,
                     double along[2]);
/* Contact i is at rest and the forces lambda leave it there. */
bool event_holds(const event_run *s, int i, const double *u0, const double *lambda);
/* Where a contact that holds stands on the edge of its cone, lambda, which answers u0, becomes other forces of the same motion inside
 * all cones, if there are any; forces of at most `least` stay what they are. BASE_ENOMEM, BASE_EEXTERNAL. */
base_status event_inside(const event_run *s, const double *u0, double least, double *lambda,
                         base_error *err);

/* Joint rows of s->space into s->joints: impulses of a jump, or forces over a substep of dt > 0 and, with
 * dt = 0, forces that the next substep starts from. */
base_status event_log_joints(event_run *s, double dt, bool jump, base_error *err);

/* The impact of the contacts of c whose s->space.gap is zero: its impulses and the velocities after it become the state's.
 * s->solved is false where it has no answer. */
base_status event_impact(event_run *s, const contact_set *c, base_error *err);
/* Where no force answers the accelerations, impulses do: the jump is that of a step of length h from here as h goes to 0
 * (Genot & Brogliato 1999), with h so short that free acceleration adds no more than what cannot be told
 * from rest. s->space holds the accelerations of the contacts that persist. */
base_status event_impact_without_collision(event_run *s, const contact_set *c, base_error *err);

/* Frees what event_resolve allocated. */
void event_resolve_close(event_run *s);
