/* formulations/event/event_watch.h - the contacts that no arc holds: do they close?
 *
 * A contact closes where its gap falls below its limit, -tol, with tol the set's. One that touched without
 * force when the arc began (a redundant corner) has its gap of then, if negative, as zero: its limit
 * is tol below that. Two bodies may also touch and part again within one substep, as the
 * corner of a box that turns does. Such a contact closes at the start of the substep and opens at its end;
 * if the two tangents of its gap meet below the limit, the substep is searched for the least gap. */
#pragma once

#include "formulations/event/event_arc.h"

typedef struct watched {
  uint64_t id;
  double gap, u; /* [m], [m/s] at the last accepted state */
  double base;   /* gap when the arc began, where it touched; else 0 [m] */
} watched;

typedef struct event_watch {
  watched *was, *now; /* by id */
  int n_was, cap;
} event_watch;

void watch_close(event_watch *w);
/* Takes the contacts outside the arc from its last evaluation. begins: an arc begins here, and contacts
 * with a gap of at most `touching` are those that touch. BASE_ENOMEM. */
base_status watch_take(event_watch *w, const arc *a, bool begins, double touching, base_error *err);
/* Is some contact outside the arc below its limit in the arc's last evaluation? */
bool watch_closes(const event_watch *w, const arc *a);
/* The next contact from *g on (of the set) that closed at the last accepted state (*old), opens in the last
 * evaluation (*now), dt later, and may have been below its limit between, granted `slack` times dt times
 * its change of speed. *g moves behind it. */
bool watch_passes(const event_watch *w, const arc *a, double dt, double slack, int *g, watched *old,
                  watched *now);
/* The same contact in the last evaluation, false if it is not there. */
bool watch_find(const arc *a, uint64_t id, double *gap, double *u);
/* The gap at which the tangents of two states of one contact meet, dt apart. */
double watch_least(double gap0, double u0, double gap1, double u1, double dt);
