/* body_space_solve.c - solutions in body velocities, and the rank of what the rows see. */
#include "lcp/linear/body_space_inside.h"

#include <math.h>
#include <string.h>

static double unit_of(const lin_body_space *s, int i) {
  return (s->scale != NULL) ? s->scale[i] : 1;
}

/* v += A' x of n rows, and y += A v. */
BASE_INLINE void push(int n, int dof, const double *A, const double *x, double *restrict v) {
  for (int m = 0; m < n; m++) {
    for (int i = 0; i < dof; i++) {
      v[i] += A[m * dof + i] * x[m];
    }
  }
}

BASE_INLINE void pull(int n, int dof, const double *A, const double *v, double *restrict y) {
  for (int m = 0; m < n; m++) {
    double sum = 0;
    for (int i = 0; i < dof; i++) {
      sum += A[m * dof + i] * v[i];
    }
    y[m] += sum;
  }
}

/* y = B x, n x n by columns. */
BASE_INLINE void block_times(int n, const double *B, const double *x, double *restrict y) {
  for (int i = 0; i < n; i++) {
    y[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      y[i] += B[i + j * n] * x[j];
    }
  }
}

/* v += A' x of one body, and y += A v; A of n rows over what is seen of it. */
BASE_INLINE void push_side(lin_body_space *s, int body, int n, const double *A, const double *x) {
  const int dof = lin_body_space_seen(s, body);
  double *to = s->v + ((dof > 0) ? s->seen[body] : 0);
  if (dof == 6) {
    push(n, 6, A, x, to);
  } else if (dof == 3) {
    push(n, 3, A, x, to);
  } else if (dof > 0) {
    push(n, dof, A, x, to);
  }
}

BASE_INLINE void pull_side(const lin_body_space *s, int body, int n, const double *A, double *y) {
  const int dof = lin_body_space_seen(s, body);
  const double *from = s->v + ((dof > 0) ? s->seen[body] : 0);
  if (dof == 6) {
    pull(n, 6, A, from, y);
  } else if (dof == 3) {
    pull(n, 3, A, from, y);
  } else if (dof > 0) {
    pull(n, dof, A, from, y);
  }
}

/* Of the rows that a mixed group has stored: `only` that one, or all. */
BASE_INLINE const double *stored_rows(const lin_body_space *s, const lin_side *a, int only, int n,
                                      double *room) {
  return lin_body_space_narrowed(a, (only >= 0) ? only : 0, (only >= 0) ? 1 : n,
                                 lin_body_space_seen(s, a->body), room);
}

/* Rows of group g that are mixed: `only` the stored one of them that is the one in the system, or the sum of all stored. */
BASE_INLINE void push_mixed(lin_body_space *s, int g, const lcp_mixture *m, int n,
                            const double *x) {
  const int only = lin_body_space_only(s, g, m, n), *row = s->row + s->first[g];
  double stored[LCP_STORED_MAX] = {0}, room[LCP_MIXED_MAX];
  for (int i = 0; only < 0 && i < n; i++) {
    lcp_mixture_add(m->c + (ptrdiff_t)(row[i] - s->f->row_start[g]) * m->stored, m->stored, x[i],
                    stored);
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_stored_side(s->f, s->G, g, k);
    const double *A = stored_rows(s, &a, only, m->stored, room);
    if (only >= 0) {
      push_side(s, a.body, 1, A, x);
    } else if (m->stored == 3) {
      push_side(s, a.body, 3, A, stored);
    } else {
      push_side(s, a.body, m->stored, A, stored);
    }
  }
}

BASE_INLINE void pull_mixed(const lin_body_space *s, int g, const lcp_mixture *m, int n,
                            double *y) {
  const int only = lin_body_space_only(s, g, m, n), *row = s->row + s->first[g];
  double stored[LCP_STORED_MAX] = {0}, room[LCP_MIXED_MAX];
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_stored_side(s->f, s->G, g, k);
    const double *A = stored_rows(s, &a, only, m->stored, room);
    if (only >= 0) {
      pull_side(s, a.body, 1, A, y);
    } else if (m->stored == 3) {
      pull_side(s, a.body, 3, A, stored);
    } else {
      pull_side(s, a.body, m->stored, A, stored);
    }
  }
  for (int i = 0; only < 0 && i < n; i++) {
    const double *c = m->c + (ptrdiff_t)(row[i] - s->f->row_start[g]) * m->stored;
    y[i] = lcp_mixture_dot(c, m->stored, stored);
  }
}

/* v += G' x of the n rows of group g in the system, and y = G v there. */
BASE_INLINE void push_group(lin_body_space *s, int g, int n, const double *x) {
  const lcp_mixture *m = lin_body_space_mixture(s, g);
  double room[LIN_GROUP_MAX * LIN_BLOCK_MAX];
  if (m != NULL) {
    push_mixed(s, g, m, n, x);
    return;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_body_space_side(s, g, k);
    if (a.dof > 0) {
      push_side(s, a.body, n, lin_body_space_part(s, g, n, &a, room), x);
    }
  }
}

BASE_INLINE void pull_group(const lin_body_space *s, int g, int n, double *y) {
  const lcp_mixture *m = lin_body_space_mixture(s, g);
  double room[LIN_GROUP_MAX * LIN_BLOCK_MAX];
  for (int i = 0; i < n; i++) {
    y[i] = 0;
  }
  if (m != NULL) {
    pull_mixed(s, g, m, n, y);
    return;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_body_space_side(s, g, k);
    if (a.dof > 0) {
      pull_side(s, a.body, n, lin_body_space_part(s, g, n, &a, room), y);
    }
  }
}

/* Group g, n rows of it in the system: x = T^-1 r there, and v += G' s x. */
BASE_INLINE void go_down(lin_body_space *s, int g, int n, const double *r, double *x) {
  const int *row = s->row + s->first[g];
  double in[LIN_GROUP_MAX], out[LIN_GROUP_MAX];
  for (int i = 0; i < n; i++) {
    in[i] = r[row[i]];
  }
  block_times(n, s->T + s->at[g], in, out);
  for (int i = 0; i < n; i++) {
    x[row[i]] = out[i];
  }
  push_group(s, g, n, out);
}

/* x -= K s G v there. */
BASE_INLINE void come_up(const lin_body_space *s, int g, int n, double *x) {
  const int *row = s->row + s->first[g];
  double y[LIN_GROUP_MAX], out[LIN_GROUP_MAX];
  pull_group(s, g, n, y);
  block_times(n, s->Y + s->at[g], y, out);
  for (int i = 0; i < n; i++) {
    x[row[i]] -= out[i];
  }
}

BASE_CLONES void lin_body_space_solve(lin_body_space *s, const double *r, double *x) {
  const lcp_factored *f = s->f;
  memset(s->v, 0, (size_t)s->seen[f->n_body] * sizeof *s->v);
  memset(x, 0, (size_t)f->row_start[f->n_group] * sizeof *x);
  for (int g = 0; g < f->n_group; g++) {
    const int n = s->first[g + 1] - s->first[g];
    if (n == 1) {
      go_down(s, g, 1, r, x);
    } else if (n == 3) {
      go_down(s, g, 3, r, x);
    } else if (n > 0) {
      go_down(s, g, n, r, x);
    }
  }
  lin_blocks_solve(&s->blocks, s->v);
  for (int g = 0; g < f->n_group; g++) {
    const int n = s->first[g + 1] - s->first[g];
    if (n == 1) {
      come_up(s, g, 1, x);
    } else if (n == 3) {
      come_up(s, g, 3, x);
    } else if (n > 0) {
      come_up(s, g, n, x);
    }
  }
}

/* g (I + G'KG)^-1 g' of row r of group g. */
static double seen_by(const lin_body_space *s, int g, int r) {
  lin_side side[2];
  double form = 0, mixed[2][LIN_BLOCK_MAX];
  const lcp_mixture *m = lin_body_space_mixture(s, g);
  for (int k = 0; k < 2; k++) {
    side[k] = lin_body_space_side(s, g, k);
    if (m != NULL && side[k].dof > 0) {
      lcp_mixture_row(m, r, side[k].dof, side[k].jac, mixed[k]);
      side[k].jac = mixed[k];
    } else {
      side[k].jac += (ptrdiff_t)r * side[k].dof;
    }
  }
  for (int k = 0; k < 2; k++) {
    for (int l = 0; l < 2 && side[k].body >= 0; l++) {
      if (side[l].body >= 0) {
        form += lin_blocks_inverse_form(&s->blocks, side[k].body, side[k].jac, side[l].body,
                                        side[l].jac);
      }
    }
  }
  return form;
}

base_status lin_body_space_deficit(lin_body_space *s, int *deficit, base_error *err) {
  const lcp_factored *f = s->f;
  double left = 0;
  BASE_TRY(lin_blocks_invert(&s->blocks, err));
  for (int g = 0; g < f->n_group; g++) {
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    for (int k = 0; k < n; k++) {
      const double unit = unit_of(s, row[k]);
      const double form = seen_by(s, g, row[k] - f->row_start[g]);
      left += 1 - s->Y[s->at[g] + (size_t)(k + k * n)] * unit * unit * form;
    }
  }
  lin_blocks_drop_inverse(&s->blocks);
  *deficit = (int)lround(left);
  return BASE_OK;
}
