/* linear/body_space_inside.h - what the parts of body_space share; private to lcp/linear. */
#pragma once

#include "lcp/base/clones.h"
#include "lcp/linear/body_space.h"

/* G of group g on one side, of the rows that are stored where it is. */
BASE_INLINE lin_side lin_body_space_side(const lin_body_space *s, int g, int which) {
  return s->stored ? lin_stored_side(s->f, s->G, g, which) : lin_side_of(s->f, s->G, g, which);
}

/* How its rows are mixed of them; NULL: they are these. */
static inline const lcp_mixture *lin_body_space_mixture(const lin_body_space *s, int g) {
  return s->stored ? lcp_mixture_of(s->f, g) : NULL;
}

/* Where group g has one row in the system, and that is one of those stored, as a normal is: which; else -1. */
static inline int lin_body_space_only(const lin_body_space *s, int g, const lcp_mixture *m, int n) {
  const int r = s->row[s->first[g]] - s->f->row_start[g];
  const double *c = m->c + (ptrdiff_t)r * m->stored;
  int which = -1;
  bool only = n == 1;
  for (int k = 0; k < m->stored && only; k++) {
    only = c[k] == 0.0 || (c[k] == 1.0 && which < 0);
    which = (c[k] != 0.0) ? k : which;
  }
  return only ? which : -1;
}

/* How many velocities of a body the system has; 0: it is fixed. */
BASE_INLINE int lin_body_space_seen(const lin_body_space *s, int body) {
  return (body >= 0) ? s->seen[body + 1] - s->seen[body] : 0;
}

/* Rows first .. first+n-1 of one side, over the velocities that are seen; copied to `room` only where these are fewer. */
const double *lin_body_space_copy(const lin_side *a, int first, int n, int seen, double *room);

BASE_INLINE const double *lin_body_space_narrowed(const lin_side *a, int first, int n, int seen,
                                                  double *room) {
  return (seen < a->dof) ? lin_body_space_copy(a, first, n, seen, room)
                         : a->jac + (ptrdiff_t)first * a->dof;
}

/* A copy of what lin_body_space_part gives. */
const double *lin_body_space_gather(const lin_body_space *s, int g, const lin_side *a,
                                    double *room);

/* s G of the n > 0 rows of group g, none of them mixed, in the system, of one side, over the velocities that are seen; copied to `room`
 * only where these are fewer or the rows have gaps or a scale. */
BASE_INLINE const double *lin_body_space_part(const lin_body_space *s, int g, int n,
                                              const lin_side *a, double *room) {
  const int *row = s->row + s->first[g];
  if (s->scale != NULL || row[n - 1] - row[0] + 1 != n) {
    return lin_body_space_gather(s, g, a, room);
  }
  return lin_body_space_narrowed(a, row[0] - s->f->row_start[g], n, lin_body_space_seen(s, a->body),
                                 room);
}
