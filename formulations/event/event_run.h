/* formulations/event/event_run.h - what the two halves of `event` share; private to them: form_event.c
 * advances smooth arcs and locates events, event_resolve.c says what happens at one. */
#pragma once

#include "formulations/event/event_arc.h"
#include "formulations/event/event_turns.h"

#include <gsl/gsl_odeiv2.h>

typedef struct event_options {
  int facets, max_events;
  double rest_speed, touch_speed, stick_speed, rate, rtol, atol;
} event_options;

typedef struct event_run {
  const event_options *opt;
  const formulation_solver *solver; /* borrowed, during step only */
  base_error *err;
  world *w;
  arc arc;
  impulse_log log;
  contact_set view; /* what the assembly works on */
  form_assembly a;
  contact_memory memory;
  slip_problem p;
  facet_turns turns;
  bool started, solved;
  int n_config, n_dof;
  gsl_odeiv2_system system;
  gsl_odeiv2_driver *driver;
  gsl_odeiv2_step *trial;       /* single steps of the bisection */
  double *y, *from, *acc, *dev; /* n_config + n_dof each */
  double substep;
  double *row, *gap, *z; /* scratch of a problem: rows, contacts, unknowns */
  int cap_row, cap_contact;
  double *impulse, *bias; /* of the answer */
  int cap_out;
  contact_set out;
  formulation_answer answer;
} event_run;

/* Everything that happens at one instant: impact, then the contacts that persist and their modes,
 * from the state in s->y and into it. s->solved is false where a problem was not solved. */
base_status event_resolve(event_run *s, double t, base_error *err);
/* Frees what event_resolve allocated. */
void event_resolve_close(event_run *s);
