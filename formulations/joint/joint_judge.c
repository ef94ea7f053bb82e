/* joint_judge.c - whether the joints block a direction of a contact, where the numbers that it is lost in are known. With
 * w = S^-1 R of its row a blocked direction has J_c = w' J_b: its diagonal of C' is zero, computed with an error of
 * some roundings of (|J_c| + sum |w_k| |J_b,k|)^2, and its velocity is drift_c - w' drift_b, whatever r' says: that
 * holds the correction of joint errors besides, which is no motion of the contact. */
#include "formulations/joint/joint.h"

#include <cblas.h>
#include <float.h>
#include <math.h>
#include <string.h>

/* The drift of the joint rows of one component. */
static void joint_drift(const form_assembly *a, const form_component *part, double *drift) {
  const form_joints *j = &a->joints;
  for (int m = part->first; m < part->first + part->count; m++) {
    const int g = j->member[m];
    memcpy(drift + j->offset[g], a->set->u_drift + a->set->row_start[a->group[g]],
           (size_t)form_rows_of(a, g) * sizeof *drift);
  }
}

/* Adds to what is known of contact row `row` what the joints of one component do to it; column: its part of Y. */
static void know_row(form_assembly *a, const form_component *part, const double *S,
                     const double *column, const double *drift, int row) {
  form_joints *j = &a->joints;
  form_blocked *known = &a->known[row];
  double *w = j->work;
  double size = sqrt(j->before[row]);
  memcpy(w, column, (size_t)part->rank * sizeof *w);
  if (part->rank > 0) {
    cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, part->rank, S, part->rows, w,
                1);
  }
  for (int k = 0; k < part->rank; k++) {
    const int at = j->pivot[part->row + k] - 1;
    const double moved = w[k] * j->unit[part->row + at] * drift[at];
    size += 2 * fabs(w[k]);
    known->u -= moved;
    known->u_noise += 1e-9 * fabs(moved);
  }
  known->noise += 4 * DBL_EPSILON * (part->rank + 8) * size * size;
}

/* The symmetric c[left][3] without its row and column k, which the last then takes. */
static void take_out(double *c, int left, int k) {
  const double pivot = c[4 * k];
  double column[3];
  for (int p = 0; p < left; p++) {
    column[p] = c[3 * p + k];
  }
  for (int p = 0; p < left; p++) {
    for (int q = 0; q < left; q++) {
      c[3 * p + q] -= column[p] / pivot * column[q];
    }
  }
  const int last = left - 1;
  for (int p = 0; p < last; p++) {
    c[3 * p + k] = c[3 * p + last];
  }
  for (int q = 0; q < last; q++) {
    c[3 * k + q] = c[3 * last + q];
  }
  c[4 * k] = c[4 * last];
}

/* Of the n <= 3 rows of contact i from `first` on, some direction may have lost all of its diagonal: the last pivot of their
 * block, the largest first. */
static bool may_be_blocked(const form_assembly *a, int i, int first, int n) {
  const form_joints *j = &a->joints;
  const int rows = form_rows_of(a, i);
  const double *own =
      j->left.block + j->left.block_at[a->self[i]] + (ptrdiff_t)first * rows + first;
  double c[9], lost = 0;
  for (int p = 0; p < n; p++) {
    memcpy(c + 3 * p, own + (ptrdiff_t)p * rows, (size_t)n * sizeof *c);
    lost += FORM_MUCH_LOST * j->before[a->row[i] + first + p];
  }
  for (int left = n; left > 0; left--) {
    int k = 0;
    for (int p = 1; p < left; p++) {
      k = (c[4 * p] > c[4 * k]) ? p : k;
    }
    if (c[4 * k] <= lost) {
      return true;
    }
    take_out(c, left, k);
  }
  return false;
}

static void know_part(form_assembly *a, const form_component *part, int t, int first, int n,
                      const double *drift) {
  const form_joints *j = &a->joints;
  const int i = j->touch[t];
  if (n == 0 || !may_be_blocked(a, i, first, n)) {
    return;
  }
  const double *S = j->dense + part->at;
  const double *Y = S + (ptrdiff_t)part->rows * part->rows;
  for (int p = first; p < first + n; p++) {
    know_row(a, part, S, Y + (ptrdiff_t)(j->column[t] + p) * part->rows, drift, a->row[i] + p);
  }
}

void form_joints_judge(form_assembly *a) {
  form_joints *j = &a->joints;
  for (int c = 0; c < j->n_part; c++) {
    const form_component *part = &j->part[c];
    double *drift = j->work + j->cap_row;
    joint_drift(a, part, drift);
    for (int t = part->touch; t < part->touch + part->n_touch; t++) {
      const contact_rows rows = a->rows[j->touch[t]];
      know_part(a, part, t, 0, 1 + rows.tangent, drift);
      know_part(a, part, t, 1 + rows.tangent, rows.torsion, drift);
      know_part(a, part, t, 1 + rows.tangent + rows.torsion, rows.rolling, drift);
    }
  }
}
