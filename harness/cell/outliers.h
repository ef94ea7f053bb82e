/* harness/cell/outliers.h - samples far from the others of their process: modified z-score above 3.5
 * (Iglewicz & Hoaglin 1993: 0.6745 |x - median| / MAD). They are flagged and kept. */
#pragma once

#include "harness/plan/record.h"

/* Flags `outlier` by t_total_s, from five timed rows on; returns how many are far. */
int outliers_flag(record *row, int n);
