/* problems/pair_table.h - a value per pair of sides, with a default. Sides are the bodies, then
 * the half-spaces of a scene. */
#pragma once

#include "problems/spec.h"

#include <stdint.h>

typedef struct pair_table {
  double dflt;
  int n;
  uint64_t *key; /* sorted */
  double *value;
} pair_table;

/* Index of the side called `name`, -1 if there is none. */
int pair_side(const scene_spec *s, const char *name);

/* A later pair overrides an earlier one of the same sides. */
base_status pair_table_open(pair_table *t, const scene_spec *s, double dflt, const spec_pair *pair,
                            int n_pair, base_error *err);
void pair_table_close(pair_table *t);
double pair_value(const pair_table *t, int side_a, int side_b);
bool pair_any_positive(const pair_table *t);
