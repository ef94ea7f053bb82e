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

/* Wall time of the processes of one cell [s]; HUGE_VAL where no row tells. */
typedef struct outlook_cell {
  double first; /* of its first process */
  double later; /* of each other one: none where the first one fails, which ends the cell */
  bool refused; /* every row that tells was refused: no evaluation, no time */
} outlook_cell;

/* From the rows that agree with the cell in most of problem, solver, family of problems, formulation and part (in this order),
 * scaled to its step and duration and, of other problems of its family, along the numbers that differ (ladder.h). A process that was killed
 * earlier takes between its limit then and the limit now. */
outlook_cell outlook_ask(const outlook *o, const plan *p, const cell *c);
