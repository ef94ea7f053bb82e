/* solvers/siconos.h - what the adapters of Siconos' solvers share (built with -Dsiconos=enabled). */
#pragma once

#include "lcp/lcp_solver.h"

typedef struct siconos_options {
  lcp_stop stop;
} siconos_options;

/* Copies, so that the library may write where it likes. */
typedef struct siconos_state {
  double *M, *q, *w, *mu; /* n*n column-major (LCPs), n, n, blocks */
  void *blocks;           /* cones: the library's matrix of 3 x 3 blocks, owned */
} siconos_state;

void siconos_layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a);

/* Runs the LCP solver with Siconos' number `id`. The outcome is the library's own claim. */
base_status siconos_solve_lcp(int id, siconos_state *s, const lcp_problem *p, const void *opt,
                              double *z, lcp_result *res);

/* Cones: every block one of one part with two rows. The matrix goes to the library in its sparse blocks, the storage that
 * its own files of friction problems have; it is made here, in the set-up, and again by every
 * further solve, because the library writes to it. */
void siconos_cone_layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a);
base_status siconos_cone_prepare(void *state, const lcp_problem *p, const void *opt,
                                 base_error *err);
void siconos_cone_release(void *state);

/* As above for the cone solver `id`. */
base_status siconos_solve_cone(int id, siconos_state *s, const lcp_problem *p, const void *opt,
                               double *z, lcp_result *res);

enum { SICONOS_FIELDS = 4 };
extern const base_field siconos_fields[SICONOS_FIELDS];

/* What they have in common, inside the initialiser of an lcp_solver. */
#define SICONOS_PEER                                                                               \
  .storages = 1u << LCP_DENSE, .allocates = true, .peer = true, .fields = siconos_fields,          \
  .n_fields = SICONOS_FIELDS, .options_size = sizeof(siconos_options),                             \
  .state_size = sizeof(siconos_state), .layout = siconos_layout

#define SICONOS_CONE_PEER                                                                          \
  .sets = 1u << LCP_CONE, .storages = (1u << LCP_DENSE) | (1u << LCP_CSC), .warm = true,           \
  .allocates = true, .peer = true, .fields = siconos_fields, .n_fields = SICONOS_FIELDS,           \
  .options_size = sizeof(siconos_options), .state_size = sizeof(siconos_state),                    \
  .layout = siconos_cone_layout, .prepare = siconos_cone_prepare, .release = siconos_cone_release
