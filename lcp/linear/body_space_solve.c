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

/* Group g, n rows of it in the system: x = T^-1 r there, and v += G' s x. */
BASE_INLINE void go_down(lin_body_space *s, int g, int n, const double *r, double *x) {
  const int *row = s->row + s->first[g];
  double room[LIN_GROUP_MAX * LIN_BLOCK_MAX], in[LIN_GROUP_MAX], out[LIN_GROUP_MAX];
  for (int i = 0; i < n; i++) {
    in[i] = r[row[i]];
  }
  block_times(n, s->T + s->at[g], in, out);
  for (int i = 0; i < n; i++) {
    x[row[i]] = out[i];
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_side_of(s->f, s->G, g, k);
    double *to = s->v + ((a.dof > 0) ? s->f->dof_start[a.body] : 0);
    if (a.dof == 6) {
      push(n, 6, lin_body_space_part(s, g, n, &a, room), out, to);
    } else if (a.dof > 0) {
      push(n, a.dof, lin_body_space_part(s, g, n, &a, room), out, to);
    }
  }
}

/* x -= K s G v there. */
BASE_INLINE void come_up(const lin_body_space *s, int g, int n, double *x) {
  const int *row = s->row + s->first[g];
  double room[LIN_GROUP_MAX * LIN_BLOCK_MAX], y[LIN_GROUP_MAX], out[LIN_GROUP_MAX];
  for (int i = 0; i < n; i++) {
    y[i] = 0;
  }
  for (int k = 0; k < 2; k++) {
    const lin_side a = lin_side_of(s->f, s->G, g, k);
    const double *from = s->v + ((a.dof > 0) ? s->f->dof_start[a.body] : 0);
    if (a.dof == 6) {
      pull(n, 6, lin_body_space_part(s, g, n, &a, room), from, y);
    } else if (a.dof > 0) {
      pull(n, a.dof, lin_body_space_part(s, g, n, &a, room), from, y);
    }
  }
  block_times(n, s->Y + s->at[g], y, out);
  for (int i = 0; i < n; i++) {
    x[row[i]] -= out[i];
  }
}

BASE_CLONES void lin_body_space_solve(lin_body_space *s, const double *r, double *x) {
  const lcp_factored *f = s->f;
  memset(s->v, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->v);
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
  double form = 0;
  for (int k = 0; k < 2; k++) {
    side[k] = lin_side_of(s->f, s->G, g, k);
    side[k].jac += (ptrdiff_t)r * side[k].dof;
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
  *deficit = (int)lround(left);
  return BASE_OK;
}
