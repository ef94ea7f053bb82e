/* joint_faint.c - rows of contacts that joints leave hardly any motion, as at the ends of two rods that a pin joins, which are apart by
 * the error of the pin: with J_c = w' J_b + x and |x| << |J_c|.
 *
 * C_cd - R_c' S^-1 R_d has the rounding of its terms, about 1e-16 |J_c| |J_d|, beside which a row as small as |x| |J_d| keeps few digits: what is
 * left of it is a combination of other rows no longer, though x is one of theirs, and an impulse 1 / |x| times too large solves the
 * difference. So x is computed, and again from what is left of it along the joint rows; then
 *
 *   C'_cd = x W J_d',   r'_c = x v_free + drift_c - w' drift_b,
 *
 * which have the error of their own terms: u_c is the velocity along x of the motion that u_d is seen in. C'_cc is x W x'. Of two such rows
 * C'_cd has the rounding of J_d. */
#include "formulations/dof_kernel.h"
#include "formulations/joint/joint.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_ROWS = 6, MOST_PARTS = 2, PROJECTIONS = 2 };

/* One such row: of contact i, its row p; the components of joints that the contact touches. */
typedef struct faint {
  int i, p, n_part;
  const form_component *part[MOST_PARTS];
  double drift;
} faint;

/* x v_free, and the sum of what it is made of; x W x'. */
typedef struct speed {
  double sum, size, own;
} speed;

static void find_parts(const form_assembly *a, faint *f) {
  const form_joints *j = &a->joints;
  f->n_part = 0;
  for (int k = a->near_start[f->i]; k < a->near_start[f->i + 1]; k++) {
    const int g = a->near[k];
    const form_component *part = (g >= a->n_contact) ? &j->part[j->component[g]] : NULL;
    if (part != NULL && f->n_part < MOST_PARTS && (f->n_part == 0 || f->part[0] != part)) {
      f->part[f->n_part++] = part;
    }
  }
}

/* W x of the bodies of group g of the set. */
static void move_bodies(form_assembly *a, int g) {
  const contact_set *c = a->set;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side], n = contact_dofs(c, b);
    if (n > 0) {
      double *v = a->moved + c->dof_start[b];
      memset(v, 0, (size_t)n * sizeof *v);
      FORM_WITH_DOFS(n, form_add_product, c->inv_mass + c->mass_start[b],
                     a->force + c->dof_start[b], v);
    }
  }
}

static void move(form_assembly *a, const faint *f) {
  move_bodies(a, a->group[f->i]);
  for (int k = 0; k < f->n_part; k++) {
    for (int m = f->part[k]->first; m < f->part[k]->first + f->part[k]->count; m++) {
      move_bodies(a, a->group[a->joints.member[m]]);
    }
  }
}

/* Adds to the speed what the bodies of group g have of it, and leaves them zeros: each is met once. */
static void take_bodies(form_assembly *a, int g, speed *u) {
  const contact_set *c = a->set;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side], n = contact_dofs(c, b);
    const int at = (n > 0) ? c->dof_start[b] : 0;
    for (int d = at; d < at + n; d++) {
      const double term = a->force[d] * c->v_free[d];
      u->sum += term;
      u->size += fabs(term);
      u->own += a->force[d] * a->moved[d];
      a->force[d] = a->moved[d] = 0;
    }
  }
}

static speed take(form_assembly *a, const faint *f) {
  speed u = {0};
  take_bodies(a, a->group[f->i], &u);
  for (int k = 0; k < f->n_part; k++) {
    for (int m = f->part[k]->first; m < f->part[k]->first + f->part[k]->count; m++) {
      take_bodies(a, a->group[a->joints.member[m]], &u);
    }
  }
  return u;
}

/* x -= w' J_b with w = S^-1 J_b W x, W x being known; takes w' drift_b from the drift. */
static void project(form_assembly *a, faint *f, const form_component *part) {
  const form_joints *j = &a->joints;
  double *w = j->work + j->cap_row;
  memset(w, 0, (size_t)part->rows * sizeof *w);
  for (int m = part->first; m < part->first + part->count; m++) {
    const int g = j->member[m];
    form_add_velocity(a->set, a->group[g], form_rows_of(a, g), a->moved, w + j->offset[g]);
  }
  form_joints_solve(j, part, w, j->work);
  for (int m = part->first; m < part->first + part->count; m++) {
    const int g = j->member[m], rows = form_rows_of(a, g);
    const double *drift = a->set->u_drift + a->set->row_start[a->group[g]];
    double *own = w + j->offset[g];
    for (int k = 0; k < rows; k++) {
      f->drift -= own[k] * drift[k];
      own[k] = -own[k];
    }
    form_add_force(a, a->group[g], rows, own);
  }
}

/* Where contact `other` stands among those that contact i meets in C'. */
static int place_of(const form_blocks *left, int i, int other) {
  int low = left->near_start[i], high = left->near_start[i + 1] - 1;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (left->near[mid] < other) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  return low;
}

/* The row and the column of C', from W x. */
static void write_row(form_assembly *a, const faint *f) {
  const form_blocks *left = &a->joints.left;
  const int rows = form_rows_of(a, f->i);
  for (int k = left->near_start[f->i]; k < left->near_start[f->i + 1]; k++) {
    const int o = left->near[k], columns = form_rows_of(a, o);
    double u[MOST_ROWS] = {0};
    form_add_velocity(a->set, a->group[o], columns, a->moved, u);
    double *row = left->block + left->block_at[k] + (ptrdiff_t)f->p * columns;
    double *column = left->block + left->block_at[place_of(left, o, f->i)] + f->p;
    for (int q = 0; q < columns; q++) {
      row[q] = column[(ptrdiff_t)q * rows] = u[q];
    }
  }
}

/* What C' has of row p of contact i with itself. */
static double *own_of(const form_assembly *a, int i, int p) {
  const form_blocks *left = &a->joints.left;
  return left->block + left->block_at[a->self[i]] + (ptrdiff_t)p * (form_rows_of(a, i) + 1);
}

static void renew(form_assembly *a, int i, int p) {
  static const double noise = 16 * DBL_EPSILON;
  const int g = a->group[i], row = a->row[i] + p;
  faint f = {.i = i, .p = p, .drift = a->set->u_drift[a->set->row_start[g] + p]};
  double one[MOST_ROWS] = {0};
  one[p] = 1;
  find_parts(a, &f);
  form_add_force(a, g, form_rows_of(a, i), one);
  move(a, &f);
  for (int k = 0; k < PROJECTIONS; k++) {
    for (int m = 0; m < f.n_part; m++) {
      project(a, &f, f.part[m]);
    }
    move(a, &f);
  }
  write_row(a, &f);
  const speed u = take(a, &f);
  *own_of(a, i, p) = u.own;
  a->r[row] = ((fabs(u.sum) <= noise * u.size) ? 0 : u.sum) + f.drift;
}

/* Of contact i the row p, by its diagonals: not blocked, and all but `FORM_MUCH_LOST` of it gone. */
static bool is_faint(const form_assembly *a, int i, int p) {
  const form_joints *j = &a->joints;
  const double own = *own_of(a, i, p);
  const int row = a->row[i] + p;
  return own > a->known[row].noise && own <= FORM_MUCH_LOST * j->before[row];
}

void form_joints_renew(form_assembly *a) {
  bool begun = false;
  for (int i = 0; i < a->n_contact; i++) {
    for (int p = 0; p < form_rows_of(a, i); p++) {
      if (!is_faint(a, i, p)) {
        continue;
      }
      if (!begun) {
        memset(a->force, 0, (size_t)a->set->n_dof * sizeof *a->force);
        memset(a->moved, 0, (size_t)a->set->n_dof * sizeof *a->moved);
        begun = true;
      }
      renew(a, i, p);
    }
  }
}
