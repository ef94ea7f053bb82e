/* formulations/polyhedral_matrix.h - shapes and the matrix of polyhedral.h; private to it. */
#pragma once

#include "formulations/polyhedral.h"

/* Facets of a contact with these row counts. three: the planar form (lambda_n, lambda_R, x_L). */
void poly_shape_build(poly_shape *s, contact_rows rows, int facets, bool three);
void poly_shape_identity(poly_shape *s, int rows);

/* Unknowns of group i: columns, and one sigma a part. */
int poly_width(const polyhedral *s, int i);

/* Entries of M, counting the zeros of the sigma rows only where they are stored. */
size_t poly_nnz(const polyhedral *s);

void poly_fill_dense(polyhedral *s);
void poly_fill_csc(polyhedral *s);

/* The entries of the sigma rows and columns among them: those of S in the factored form. */
size_t poly_shift_nnz(const polyhedral *s);

/* polyhedral_factored.c: M = J W J' + S. */
size_t poly_jac_size(const polyhedral *s); /* entries of J, zero rows of the sigmas included */
/* Are the rows of every group those that the set has, or mixed from them with numbers that depend on its shape alone, and some of them
 * facets? Torsion and rolling, which have units of their own at each contact, are no such rows. */
bool poly_jac_is_shared(const polyhedral *s);
/* shared: J is that of the set, else it is written out. */
void poly_fill_factored(polyhedral *s, bool shared);

/* What the three share. */
int poly_columns(const polyhedral *s, int i); /* unknowns of group i without the sigmas */
int poly_parts(const polyhedral *s, int i);   /* its sigmas */
/* The impulse of group i, row by row, that a unit of its unknown b stands for. */
void poly_direction(const polyhedral *s, int i, int b, double *f);
/* The sigma rows of group j in its column b, and the column of its sigma p, from val[at] on; the new at. */
int poly_put_cone_rows(const polyhedral *s, const poly_arrays *to, int at, int j, int b);
int poly_put_sigma_column(const polyhedral *s, const poly_arrays *to, int at, int j, int p);
enum { POLY_ROWS_MAX = 8 }; /* rows of one group: at most 6 of a contact or joint */

/* q of group i from u (rows of the group), normal bias b. */
void poly_fill_q(const polyhedral *s, int i, double bias, double *q);

/* lambda += F z of group i. */
void poly_expand(const polyhedral *s, int i, const double *z, double *lambda);

/* s->z0: zero, or with start=previous the unknowns of the last step; where another formulation took that step, unknowns that stand for
 * its impulses. */
void poly_start_point(polyhedral *s);

/* polyhedral_push.c. Speed at which active contact i was met in the step before and that it has not given back, <= 0. */
double poly_owed(const polyhedral *s, int i);
/* Sorts the biases of the step into those of the law and those that push an overlap out; drop: leaves the latter away. */
void poly_pushes_begin(polyhedral *s);
void poly_pushes_drop(polyhedral *s);
/* u of the impulses that are already there: none before the first solve. */
void poly_velocities(polyhedral *s);
/* Does the motion with the impulses s->base have more energy than without them? */
bool poly_makes_energy(polyhedral *s);
/* Ends the step with what z of POLY_PUSH moves beside the motion; where joints and other contacts leave no such way (not
 * solved), overlaps stay, and it counts. */
void poly_push_out(polyhedral *s, const double *z, bool solved);
