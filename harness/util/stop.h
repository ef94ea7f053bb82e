/* harness/util/stop.h - SIGINT and SIGTERM as something that work looks at, so that what was measured is told. */
#pragma once

#include <stdbool.h>

/* From now on both only raise a flag: each time, or the first time. Behind the first, one that comes at once is the same request (GNU
 * timeout sends two: to its child, and to the group of both), and one that comes later ends the process. */
void stop_catch_signals(void);
void stop_catch_first_signal(void);

/* The signal that came, or 0. */
int stop_requested(void);

/* Did one come, or is it base_seconds() `until` by now; 0: no time is set? */
bool stop_due(double until);
