/* linear/body_space.h - systems whose size is that of the body velocities, however many contacts there are.
 *
 * M = J W J' + S in factors. With W = L L' and G = J L a matrix T + Y (J W J') of contact rows, T and Y block diagonal by
 * groups, is solved through
 *
 *   (T + Y G G') x = r :   (I + G' K G) v = G' T^-1 r,   x = T^-1 r - K G v,   K = T^-1 Y
 *
 * whose pattern is the graph of the bodies (Woodbury's formula), factored by blocks of a body (blocks.h). G and L are also
 * what Gauss-Seidel methods sweep with. */
#pragma once

#include "lcp/lcp_mixture.h"
#include "lcp/linear/blocks.h"

enum { LIN_GROUP_MAX = 96 }; /* rows of a group */

/* Lower Cholesky factors L of the blocks of W (n_weight; a direction without mobility has a zero column). BASE_EINVAL where a block
 * is not positive semidefinite. */
base_status lin_weigh_bodies(const lcp_factored *f, double *L, base_error *err);

/* G = J L, n_jac: all rows, at jac_start. */
void lin_weigh_rows(const lcp_factored *f, const double *L, double *G);

/* G of the rows that jac has, where it has them; its length is lin_stored_length(f). */
void lin_weigh_stored(const lcp_factored *f, const double *L, double *G);
size_t lin_stored_length(const lcp_factored *f);

/* One side of a group: its rows of an array that has all of them, rows x dof, row-major. */
typedef struct lin_side {
  const double *jac;
  int body, dof; /* body < 0: fixed, dof 0 */
} lin_side;

static inline lin_side lin_side_of(const lcp_factored *f, const double *jac, int group, int which) {
  const int *body = &f->body[2 * (ptrdiff_t)group], *dof = f->dof_start;
  const int rows = f->row_start[group + 1] - f->row_start[group];
  const bool second = which == 1 && body[0] >= 0;
  return (lin_side){jac + f->jac_start[group] +
                        (second ? rows * (dof[body[0] + 1] - dof[body[0]]) : 0),
                    body[which], (body[which] >= 0) ? dof[body[which] + 1] - dof[body[which]] : 0};
}

/* The same of the rows that are stored, of J or of G as lin_weigh_stored lays it out. */
BASE_INLINE lin_side lin_stored_side(const lcp_factored *f, const double *G, int group, int which) {
  const int first = (which == 1) ? lcp_factored_dof(f, group, 0) : 0;
  return (lin_side){G + lcp_factored_at(f, group) +
                        (ptrdiff_t)lcp_factored_stored(f, group) * first,
                    f->body[2 * (ptrdiff_t)group + which], lcp_factored_dof(f, group, which)};
}

/* A system over some rows of some groups: T and Y of each group, n x n by columns over its rows in the system. */
typedef struct lin_body_space {
  lin_blocks blocks;
  const lcp_factored *f; /* of the last begin, as all views: */
  const double *G;       /* J L, */
  bool stored;           /* of the rows that jac has */
  const double *scale;   /* of every row, or NULL: the system is in s J W J' s */
  int *first, *row;      /* n_group+1, n: rows of the system by group, ascending */
  size_t *at;            /* n_group+1: where T and Y of a group begin */
  double *T, *Y;         /* after the factorisation T^-1 and K */
  double *v;             /* of the bodies, as the blocks have them */
  int *seen;             /* n_body+1: a body's first in v; a half that no row sees is left out */
  int *pair;             /* of the groups in the system */
  unsigned char *joined; /* n_group */
  int cap_group, cap_n, cap_dof, cap_body;
  size_t cap_matrices;
  void *mem, *matrix_mem; /* owned */
} lin_body_space;

void lin_body_space_close(lin_body_space *s); /* accepts zeroes, and leaves them */

/* Gives its memory back, but for the order of elimination, until the next begin. */
void lin_body_space_rest(lin_body_space *s);

/* BASE_EUNSUPPORTED: a body of more than LIN_BLOCK_MAX velocities, a group of more than LIN_GROUP_MAX rows, an S that couples
 * groups; the line says which. err may be NULL. */
base_status lin_body_space_admits(const lcp_factored *f, base_error *err);

/* Takes the rows where member[i] (n), T = Y = 0, of factors that are admitted. BASE_ENOMEM only. */
base_status lin_body_space_begin(lin_body_space *s, const lcp_factored *f, const double *G,
                                 bool stored, const double *scale, const unsigned char *member,
                                 base_error *err);

/* Rows of group g in the system; *row: which. */
static inline int lin_body_space_rows(const lin_body_space *s, int g, const int **row) {
  *row = s->row + s->first[g];
  return s->first[g + 1] - s->first[g];
}

/* Factors. `symmetric`: T and Y of every group are. The order of elimination is kept while the same bodies meet. *regular = false:
 * T of a group or the system is singular. BASE_ENOMEM only. */
base_status lin_body_space_factor(lin_body_space *s, bool symmetric, bool *regular,
                                  base_error *err);

/* x = the solution for r, zero outside the system; both over all rows, not the same array. */
void lin_body_space_solve(lin_body_space *s, const double *r, double *x);

/* After a symmetric factorisation: the number of rows less the rank of what they see, the sum over rows of
 * 1 - k g (I + G'KG)^-1 g' with k on the diagonal of K, each of which is nearly 0 or 1 where k is large. BASE_ENOMEM only. */
base_status lin_body_space_deficit(lin_body_space *s, int *deficit, base_error *err);
