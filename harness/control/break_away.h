/* harness/control/break_away.h - when friction gives way, or a contact opens that nothing pulls at yet, from what contacts do in both halves of a
 * step. */
#pragma once

#include "harness/control/patience.h"
#include "harness/measure/simulate_state.h"

#include <stdbool.h>

typedef struct break_away {
  double at; /* from the start of the step on [s]; HUGE_VAL: never */
  bool told; /* it held in both halves; else it is at that time or before */
} break_away;

/* Of the first pair of bodies to give way if both change on as between the two halves of a step of h, by what its contacts take each or
 * together. */
break_away break_away_in(const sim_loads half[2], double h);
/* Of the first contact to open if normal forces change on so. Only where the same contacts carry in both halves. */
break_away opening_in(const sim_loads half[2], double h);

/* Whether a run looks for contacts that open. */
typedef struct openings {
  bool vary;      /* loads change with time: otherwise none opens that nothing pulls at yet */
  bool asked;     /* in the next step? */
  bool aimed;     /* the last step kept ended where one should open */
  int vain;       /* so many in a row did, and none opened */
  patience again; /* with asking */
} openings;

void openings_begin(openings *o, bool vary);
/* A step is kept that ends where a contact should open, or in which one has opened. Behind one that was aimed at none may: loads that change
 * unevenly are followed in a few steps, and what does not open behind those is looked for more seldom. */
void openings_note(openings *o, bool aimed, bool opened);
