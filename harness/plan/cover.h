/* harness/plan/cover.h - the cells of a plan in an order that may be cut anywhere. Each cell that comes next brings the most that
 * no cell before it has: values of every axis of every part first, then pairs of values, then what is left, cheap
 * cells first. A greedy cover (Chvatal 1979); the cells of the quick form come before all others. */
#pragma once

#include "harness/plan/plan.h"

/* The texts of a cell by axis. */
void cell_values(const cell *c, const char *value[AXIS_COUNT]);

#define COVER_STAGES(X)         X(quick) X(values) X(pairs) X(rest)
#define COVER_STAGE_ENUM_(name) COVER_##name,
/* What brought a cell into the order: the quick form names it, a new value, a new pair, nothing new. */
typedef enum cover_stage { COVER_STAGES(COVER_STAGE_ENUM_) COVER_STAGE_COUNT } cover_stage;
const char *cover_stage_name(cover_stage s);
base_status cover_stage_find(const char *name, cover_stage *out, base_error *err);

/* What is foretold of a cell. It decides between cells that bring equally much; a wrong one costs time, no value. */
typedef struct cover_hint {
  double seconds; /* of all its processes [s] */
  bool refused;   /* ends without an answer to judge: comes where no other cell brings as much */
} cover_hint;

typedef struct cover {
  int n;              /* cells with units: those of a shard */
  int *cell;          /* [n] indices into the plan's cells, in the order of measuring; owned */
  cover_stage *stage; /* [n], of cell[k]; owned */
} cover;

/* quick: the quick form of the same campaign, whole. hint[n_cell]. The order is one of texts and hints alone: the same on any
 * machine, and of any build. BASE_ENOMEM. */
base_status cover_make(const plan *p, const plan *quick, const cover_hint *hint, cover *out,
                       base_error *err);
void cover_free(cover *c);

/* Cells up to the end of this stage. */
int cover_until(const cover *c, cover_stage last);

/* The units in the order of the cover, all processes of a cell in a row: what is cut off was not begun, but for one cell. */
void cover_order(const cover *c, plan *p);
