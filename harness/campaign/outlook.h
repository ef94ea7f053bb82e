/* harness/campaign/outlook.h - how long the processes of a plan will take, from rows of earlier runs. */
#pragma once

#include "harness/plan/plan.h"

/* What one evaluation of a cell took in earlier rows. */
typedef struct outlook_row {
  const record *r; /* borrowed */
  double seconds;  /* of one evaluation; 0: it was refused; < 0: killed, and not known */
} outlook_row;

typedef struct outlook {
  outlook_row *row; /* owned: one a cell */
  int n;
} outlook;

/* From rows of any build and machine, which are borrowed and stay where they are. */
base_status outlook_open(outlook *out, const record_table *rows, int n_table, base_error *err);
void outlook_close(outlook *o);

/* Wall time of one process of this cell [s]; HUGE_VAL where no row tells: from the rows that agree with it in most of
 * problem, solver, formulation and part (in this order), scaled to its step and duration. A process that was killed
 * earlier takes between its limit then and the limit now. */
double outlook_seconds(const outlook *o, const plan *p, const cell *c);
