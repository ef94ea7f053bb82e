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

#include "lcp/lcp_problem.h"
#include "lcp/linear/blocks.h"

enum { LIN_GROUP_MAX = 96 }; /* rows of a group */

/* Lower Cholesky factors L of the blocks of W (n_weight; a direction without mobility has a zero column), and G = J L
 * (n_jac, as jac is laid out). BASE_EINVAL where a block is not positive semidefinite. */
base_status lin_weigh(const lcp_factored *f, double *L, double *G, base_error *err);

/* One side of a group: its rows of J or of a product with it, rows x dof, row-major. */
typedef struct lin_side {
  const double *jac;
  int body, dof; /* body < 0: fixed, dof 0 */
} lin_side;

static inline lin_side lin_side_of(const lcp_factored *f, const double *jac, int group, int which) {
  const int *body = &f->body[2 * (ptrdiff_t)group];
  int dof[2];
  for (int k = 0; k < 2; k++) {
    dof[k] = (body[k] >= 0) ? f->dof_start[body[k] + 1] - f->dof_start[body[k]] : 0;
  }
  const int rows = f->row_start[group + 1] - f->row_start[group];
  return (lin_side){jac + f->jac_start[group] + ((which == 0) ? 0 : rows * dof[0]), body[which],
                    dof[which]};
}

typedef struct lin_body_space {
  lin_blocks blocks;
  int *pair; /* of the groups in the system */
  size_t cap_pair;
} lin_body_space;

void lin_body_space_close(lin_body_space *s); /* accepts zeroes, and leaves them */

/* I, with room for the groups g where joined[g]. The order of elimination is kept while the same bodies meet. BASE_EUNSUPPORTED: a
 * body of more than LIN_BLOCK_MAX velocities, a group of more than LIN_GROUP_MAX rows. */
base_status lin_body_space_begin(lin_body_space *s, const lcp_factored *f,
                                 const unsigned char *joined, bool symmetric, base_error *err);

/* Adds G' K G of a joined group, K as wide as the group, column-major: rows `row` .. `row`+`count`-1 of it are read. */
void lin_body_space_add(lin_body_space *s, const lcp_factored *f, const double *G, int group,
                        int row, int count, const double *K);

/* v += G' x, and y = G v, over the rows of one group. */
void lin_body_space_push(const lcp_factored *f, const double *G, int group, const double *x,
                         double *v);
void lin_body_space_pull(const lcp_factored *f, const double *G, int group, const double *v,
                         double *y);
