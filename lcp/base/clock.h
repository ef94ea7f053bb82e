/* base/clock.h - the only clock of the suite. */
#pragma once

/* CLOCK_MONOTONIC in seconds since an arbitrary origin [s]. */
double base_seconds(void);

/* CPU time of the calling thread [s]. */
double base_cpu_seconds(void);
