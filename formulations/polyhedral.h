/* formulations/polyhedral.h - Coulomb friction with a faceted cone as one LCP.
 *
 * Per contact the unknowns are (lambda_n, beta_1 .. beta_nd, sigma), in this order, so that one
 * block of the problem is one contact. With facet directions F = [e_n, d_1 .. d_nd]
 *
 *   [ F' C F   a E ] [lambda_n, beta]   [ F' r + b_n ]
 *   [ a (mu, -E')  0 ] [  sigma        ] + [    0       ]   >= 0   perp   >= 0
 *
 * (Anitescu & Potra 1997; Stewart & Trinkle 1996). sigma and its row are scaled by a_i = C_nn of
 * the contact, so that every unknown is an impulse and every row a velocity. Torsion and rolling
 * resistance are further facets with a sigma of their own, scaled by their coefficient [m].
 * storage=factored hands out M = J W J' + S with J the rows F' J, sigma alone in S; joints need
 * joints=mixed for it, and what is not symmetric in F (the planar three-unknown form) is refused.
 * A contact without friction has the unknown lambda_n alone. The matrix is copositive: with b_n >=
 * 0 Lemke's method always finds a solution; with b_n < 0 it may end on a ray. */
#pragma once

#include "formulations/assembly.h"

enum { POLY_FACETS_MAX = 64, POLY_PARTS = 3 };
enum { POLY_COLUMNS = 1 + 2 * POLY_FACETS_MAX + 2 };
enum { POLY_SHAPES = 3 * 2 * 3 }; /* 0 to 2 tangents, torsion or not, 0 to 2 rolling rows */

/* What a memory entry has of its own: how many unknowns the block had, and these. */
enum { POLY_PAST_WIDTH, POLY_PAST_Z };

typedef enum poly_restitution {
  POLY_NEWTON,
  POLY_POISSON,
  POLY_INELASTIC,
  POLY_TWO_STEPS /* position level: the gap closes in one step, the next one rebounds */
} poly_restitution;
typedef enum poly_planar { POLY_FOUR, POLY_THREE } poly_planar;
typedef enum poly_storage { POLY_AUTO, POLY_DENSE, POLY_CSC, POLY_FACTORED } poly_storage;

typedef struct poly_options {
  int facets;       /* directions of the tangent plane; planar contacts always have 2 */
  int cone;         /* 0 inscribed, 1 circumscribed */
  int restitution;  /* poly_restitution */
  int planar;       /* poly_planar: unknowns of a planar contact with friction */
  int storage;      /* poly_storage */
  int level;        /* form_level */
  int joints;       /* 0 eliminated, 1 kept as free rows: a mixed problem */
  int activation;   /* form_activation */
  int distribution; /* form_distribution */
  form_repair repair;
} poly_options;

/* Directions of a contact with given row counts: column k acts on rows row .. row+n-1. */
typedef struct poly_shape {
  int n_column; /* lambda_n and all facets */
  int n_part;
  int part_start[POLY_PARTS + 1]; /* columns of part k: part_start[k] .. part_start[k+1]-1 */
  int part_kind[POLY_PARTS];      /* 0 friction, 1 torsion, 2 rolling */
  struct poly_column {
    int row, n;
    double c[2];
  } column[POLY_COLUMNS];
} poly_shape;

/* Facets as lcp_mixture has them. */
enum { POLY_MIXED_ROWS = 3 };
typedef struct poly_mixture {
  lcp_mixture facets; /* rows 0: not yet made */
  double c[(POLY_FACETS_MAX + 2) * POLY_MIXED_ROWS];
} poly_mixture;

typedef struct poly_arrays {
  double *val;
  int *colptr, *rowind;
} poly_arrays;

/* Solves of a step: all of them may be the first alone. */
typedef enum poly_phase {
  POLY_MOTION,
  POLY_DECOMPRESSION, /* Poisson's */
  POLY_STILL, /* position level: without the push of overlaps, where it has no solution or gives energy */
  POLY_PUSH, /* position level: overlaps, beside the motion and without friction */
  POLY_DONE
} poly_phase;

typedef struct polyhedral {
  form_assembly a;
  contact_memory memory;
  poly_shape *shape[POLY_SHAPES]; /* by rows; owned, built when met */
  poly_shape joint;               /* the identity */

  poly_options opt;
  form_rows rows;
  formulation_start start;
  formulation_reader reader;
  int n; /* unknowns */
  poly_phase phase;
  const poly_shape **shape_of; /* n_group */
  int *first;                  /* n_group+1: first unknown of each group */
  int parts;                   /* that a contact has at most */
  double *scale;               /* parts n_group: unit of each part, 1 or the coefficient [m] */
  double *bound;               /* parts n_group: part's bound per unit of lambda_n */
  double *base;                /* n_row: impulse before this solve [N s] */
  double *cone;                /* n_contact: lambda_n in the bound beyond the unknown [N s] */
  double *u;                   /* n_row: r + C base */
  double *push;     /* n_contact: bias that takes an overlap back beside the motion [m/s] */
  bool pushes;      /* some of them do */
  lcp_block *block; /* n_group */
  double *q, *z0;   /* n */
  double *val;      /* dense n*n */
  poly_arrays m;    /* compressed columns: of M */
  poly_arrays s;    /* of the S of its factors */
  int *at;
  double *jac; /* factored: F_i' J_i of every group, where that is not made from J_i of the set, */
  int *stored_start;                   /* n_group: there, */
  const lcp_mixture **mixture;         /* n_group: in this way */
  poly_mixture mixed[POLY_MIXED_ROWS]; /* by rows of the contact, less one */
  int *jac_start, *body;               /* n_group+1; 2 n_group */
  lcp_csc shift;                       /* S: the rows and columns of sigma */
  lcp_factored factored;
  lcp_matrix M;
  formulation_answer answer;

  int cap_group, cap_row, cap_n, jac_groups, jac_n;
  size_t cap_val, cap_jac, cap_shift;
  void *mem, *val_mem, *jac_mem; /* owned */
} polyhedral;

long poly_dimension(int dim, int p, const void *opt);
formulation_friction poly_friction(int dim, const void *opt);
/* rows: FORM_ROWS_NORMAL for a frictionless model, else FORM_ROWS_ALL. */
base_status poly_begin(polyhedral *s, const contact_set *c, const poly_options *opt, form_rows rows,
                       formulation_start start, base_error *err);
base_status poly_assemble(void *state, lcp_problem *out, const double **z0, bool *pending,
                          base_error *err);
void poly_rows(const void *state, formulation_rows *out);
base_status poly_recover(void *state, const double *z, lcp_outcome claimed, base_error *err);
void poly_answer(const void *state, formulation_answer *out);
void poly_close(void *state);

/* What the descriptors of polyhedral formulations share; `fields`, `options` and `begin` are their own. */
#define POLY_FORM_PARTS                                                                            \
  .fields = fields, .n_fields = BASE_COUNT(fields), .options_size = sizeof(options),               \
  .state_size = sizeof(polyhedral), .memory = offsetof(polyhedral, memory),                        \
  .reader = offsetof(polyhedral, reader), .close = poly_close, .begin = begin,                     \
  .assemble = poly_assemble, .rows = poly_rows, .recover = poly_recover, .answer = poly_answer
