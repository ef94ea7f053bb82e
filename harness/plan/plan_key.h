/* harness/plan/plan_key.h - the content key of a cell: same key, same experiment, on any machine. */
#pragma once

#include "harness/plan/plan.h"

/* Contents of the problems of one plan: a file is read once, not for every solver. */
typedef struct problem_hash {
  const char *problem; /* the pointer is the key: a plan's store has every text once */
  bool is_scene;
  char sha256[65];
} problem_hash;
typedef struct problem_hashes {
  int n, cap;
  problem_hash *at; /* owned */
} problem_hashes;

/* Fills id, problem_sha256 and solver_version of a cell whose texts are set. Errors: what the solver
 * or the formulation says of its options; BASE_EIO for a problem's file that cannot be read. */
base_status cell_key(const campaign *camp, problem_hashes *known, cell *c, base_error *err);

/* Is the file of the cell's problem still the one with this hash? BASE_EINVAL: it is not; scenes and
 * families have no file. */
base_status cell_file_unchanged(const cell *c, const char *recorded, base_error *err);
