/* problems/world/pair_table.h - a value per pair of sides (name_index.h), with a default. */
#pragma once

#include "problems/spec/name_index.h"

#include <stdint.h>

typedef struct pair_entry {
  uint64_t key; /* the two sides, smaller first */
  double value;
  int order;
} pair_entry;

typedef struct pair_table {
  double dflt;
  int n;
  pair_entry *entry; /* sorted by key */
} pair_table;

/* A later pair overrides an earlier one of the same sides. */
base_status pair_table_open(pair_table *t, const name_index *names, double dflt,
                            const spec_pair *pair, int n_pair, base_error *err);
void pair_table_close(pair_table *t);
double pair_value(const pair_table *t, int side_a, int side_b);
