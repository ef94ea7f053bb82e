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

/* q of group i from u (rows of the group), normal bias b. */
void poly_fill_q(const polyhedral *s, int i, double bias, double *q);

/* lambda += F z of group i. */
void poly_expand(const polyhedral *s, int i, const double *z, double *lambda);
