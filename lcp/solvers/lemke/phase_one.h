/* solvers/lemke/phase_one.h - is there a point with w - M z = q, w >= 0, z >= 0 at all? Phase one of the simplex method
 * (Dantzig 1963) with the rule of Bland 1977, which never cycles, on the tableau of a path: z0 falls as far as it can. */
#pragma once

#include "lcp/solvers/lemke/path.h"

typedef struct lemke_phase {
  const unsigned char
      *allowed; /* 2 rows: variables that may be positive, others stay at zero; NULL: all */
  double lift;  /* added to every entry of M' */
} lemke_phase;

/* Of a system that fits the table. SOLVED: the table holds such a point, z0 being zero. RAY: there is none, and y (rows)
 * is the proof: y >= 0, M'y <= 0, q'y < 0 up to round-off, with M'y <= -lift sum y. Else the limits of the path
 * are met, or the system does not fit. */
lemke_end lemke_phase_one(lemke_path *t, lemke_table *table, const lemke_system *s,
                          lemke_phase phase, double *y);
