/* harness/measure/series.h - what a simulation leaves behind for the checks: one row per step (row 0 is
 * the start), one column per quantity. Columns exist only for what the scene's checks ask. */
#pragma once

#include "formulations/formulation.h"
#include "problems/spec/spec.h"

enum series_fixed_column {
  SERIES_TIME,        /* [s] */
  SERIES_ENERGY,      /* kinetic + potential [J] */
  SERIES_PENETRATION, /* -min gap, or 0 [m] */
  SERIES_SPEED,       /* largest body speed [m/s] */
  SERIES_ANGULAR,     /* |L| about the origin [kg m^2/s] */
  SERIES_MOMENTUM_X,  /* [kg m/s] */
  SERIES_ANY_FORCE,   /* sum of all normal forces over the step that ends here [N] */
  SERIES_STEP,        /* what the step that ends here took, all phases [s]; 0 in row 0 */
  SERIES_FIXED
};

typedef struct series_pair {
  char a[SPEC_NAME], b[SPEC_NAME];
  int normal, tangential; /* columns [N] */
} series_pair;

typedef struct series_var {
  char var[2 * SPEC_NAME];
  bool has_dir;
  double dir[3];
  int column;
} series_var;

typedef struct series {
  int n_row, cap;
  int n_column;
  double **column; /* n_column arrays of cap */
  int n_var;
  series_var *var;
  int n_pair;
  series_pair *pair;
} series;

/* Columns for the checks of the spec; rows for n_step steps are reserved. */
base_status series_open(series *s, const scene_spec *spec, int n_step, base_error *err);
void series_close(series *s);

/* The force of a contact [N]: its normal part, and friction in the world. */
typedef struct series_force {
  uint64_t id;
  double normal, tangent[3];
} series_force;

/* Contacts that are in no set and go on with the force that they have, as of bodies that sleep. */
typedef struct series_resting {
  int n, cap;
  series_force *force; /* owned */
} series_resting;

/* Of contact i of a set. */
series_force series_force_of(const contact_set *c, const double *impulse, int i);
/* BASE_ENOMEM. */
base_status series_resting_add(series_resting *r, const series_force *f, base_error *err);
void series_resting_close(series_resting *r);

/* Appends the world's present state. set and impulse: of the step just taken (NULL: the start, or
 * a step without contact forces to show); resting: what goes on besides (NULL: nothing does); stored: energy in springs of the
 * contact law [J], which is part of the energy. False on a quantity that the world does not know. */
base_status series_record(series *s, world *w, const contact_set *set, const double *impulse,
                          const series_resting *resting, double stored, base_error *err);

/* The last two rows, of two halves of a step, become one of the whole: mean forces, and the state that the world has now. */
base_status series_join(series *s, const world *w, double stored, base_error *err);

/* Deepest penetration of the state about to be left: -min gap over the set, into the last row. */
void series_penetration(series *s, const contact_set *set);

const series_var *series_find_var(const series *s, const spec_check *c);  /* NULL if absent */
const series_pair *series_find_pair(const series *s, const spec_pair *p); /* NULL if absent */

/* Value of a column at time t, linear between rows; false outside the recorded time. */
bool series_at(const series *s, int column, double t, double *value);
