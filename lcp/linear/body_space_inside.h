/* linear/body_space_inside.h - what the parts of body_space share; private to lcp/linear. */
#pragma once

#include "lcp/base/clones.h"
#include "lcp/linear/body_space.h"

/* A copy of what lin_body_space_part gives. */
const double *lin_body_space_gather(const lin_body_space *s, int g, const lin_side *a,
                                    double *room);

/* s G of the n > 0 rows of group g in the system, of one side; copied to `room` only where these have gaps or a scale. */
BASE_INLINE const double *lin_body_space_part(const lin_body_space *s, int g, int n,
                                              const lin_side *a, double *room) {
  const int *row = s->row + s->first[g];
  if (s->scale != NULL || row[n - 1] - row[0] + 1 != n) {
    return lin_body_space_gather(s, g, a, room);
  }
  return a->jac + (ptrdiff_t)(row[0] - s->f->row_start[g]) * a->dof;
}
