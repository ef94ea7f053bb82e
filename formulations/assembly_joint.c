/* assembly_joint.c - joints out of the contact space.
 *
 * With S = C_bb and R = C_bc of the joint rows b and the contact rows c, joint rows satisfied
 * exactly, r_b + S lambda_b + R lambda_c = 0, leave
 *
 *   C' = C_cc - R' S^-1 R,   r' = r_c - R' S^-1 r_b
 *
 * which is the projected inverse mass of MATHEMATICS 2.1. Joints fall into connected components; each has
 * its own S, and only contacts that touch the same component become coupled. S, scaled to a diagonal between 1 and 4, is
 * factored with pivoting (LAPACK dpstrf): redundant joint rows carry no impulse, nothing is added to S. */
#include "formulations/joint/joint.h"

#include <assert.h>
#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

/* Pivot of the scaled S at which a joint row says what others have said: a sine of 3e-7 between the two. */
static const double same_row = 1e-13;

static int touch_column(const form_joints *j, const form_component *part, int i) {
  int low = part->touch;
  int high = part->touch + part->n_touch - 1;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (j->touch[mid] < i) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  return j->column[low];
}

/* S and R of one component from the blocks of its joints. */
static void gather(form_assembly *a, const form_component *part, double *S, double *R, double *y) {
  const form_joints *j = &a->joints;
  const int n = part->rows;
  memset(S, 0, (size_t)n * (size_t)(n + part->columns) * sizeof *S);
  for (int m = part->first; m < part->first + part->count; m++) {
    const int g = j->member[m];
    const int rg = form_rows_of(a, g);
    memcpy(y + j->offset[g], a->r + a->row[g], (size_t)rg * sizeof *y);
    for (int k = a->near_start[g]; k < a->near_start[g + 1]; k++) {
      const int o = a->near[k];
      const int ro = form_rows_of(a, o);
      const double *block = a->block + a->block_at[k];
      const int column = (o >= a->n_contact) ? j->offset[o] : touch_column(j, part, o);
      double *to = ((o >= a->n_contact) ? S : R) + (ptrdiff_t)column * n + j->offset[g];
      form_put_block(block, rg, ro, to, n);
    }
  }
}

/* Rows of x (n x m) into the order of the pivots. */
static void permute(double *x, int n, int m, const int *pivot, double *work) {
  for (int c = 0; c < m; c++) {
    double *column = x + (ptrdiff_t)c * n;
    for (int k = 0; k < n; k++) {
      work[k] = column[pivot[k] - 1];
    }
    memcpy(column, work, (size_t)n * sizeof *column);
  }
}

/* block -= Y_i' Y_j over the first `rank` rows. */
static void reduce_block(const double *Yi, int ri, const double *Yj, int rj, int n, int rank,
                         double *block) {
  for (int p = 0; p < ri; p++) {
    for (int q = 0; q < rj; q++) {
      block[p * rj + q] -= cblas_ddot(rank, Yi + (ptrdiff_t)p * n, 1, Yj + (ptrdiff_t)q * n, 1);
    }
  }
}

static void subtract(form_assembly *a, const form_component *part, const double *Y,
                     const double *y) {
  form_joints *j = &a->joints;
  const int n = part->rows;
  for (int t = part->touch; t < part->touch + part->n_touch; t++) {
    const int i = j->touch[t];
    const int ri = form_rows_of(a, i);
    const double *Yi = Y + (ptrdiff_t)j->column[t] * n;
    for (int p = 0; p < ri; p++) {
      a->r[a->row[i] + p] -= cblas_ddot(part->rank, Yi + (ptrdiff_t)p * n, 1, y, 1);
    }
    int k = j->left.near_start[i];
    for (int o = part->touch; o < part->touch + part->n_touch; o++) {
      while (j->left.near[k] != j->touch[o]) {
        k++;
      }
      const double *Yj = Y + (ptrdiff_t)j->column[o] * n;
      reduce_block(Yi, ri, Yj, form_rows_of(a, j->touch[o]), n, part->rank,
                   j->left.block + j->left.block_at[k]);
    }
  }
}

/* S, R and y in units in which the diagonal of S lies between 1 and 4; powers of two, which round nothing. */
static void equilibrate(const form_component *part, double *S, double *R, double *y, double *unit) {
  const int n = part->rows;
  for (int k = 0; k < n; k++) {
    int exponent;
    (void)frexp(S[(ptrdiff_t)k * n + k], &exponent);
    unit[k] = (S[(ptrdiff_t)k * n + k] > 0) ? ldexp(1, -((exponent - 1) >> 1)) : 1;
    y[k] *= unit[k];
  }
  for (int c = 0; c < n; c++) {
    for (int k = 0; k < n; k++) {
      S[(ptrdiff_t)c * n + k] *= unit[c] * unit[k];
    }
  }
  for (int c = 0; c < part->columns; c++) {
    for (int k = 0; k < n; k++) {
      R[(ptrdiff_t)c * n + k] *= unit[k];
    }
  }
}

/* Where contacts touch the component, joints alone take their errors back, in a velocity beside the motion that contacts do not feel (Cline & Pai
 * 2003): a contact that jams them would answer a correction of a micrometre with impulses of any size, and their work with energy. Elsewhere
 * the correction is part of the velocity: it makes up for what a step along the tangent adds to a circle. */
static void set_apart(form_assembly *a, const form_component *part, double *y, const double *unit) {
  const form_joints *j = &a->joints;
  const bool apart = part->n_touch > 0;
  for (int m = part->first; m < part->first + part->count; m++) {
    const int g = j->member[m];
    for (int k = 0; k < form_rows_of(a, g); k++) {
      double *repair = &a->repair[a->row[g] + k];
      *repair = apart ? *repair : 0;
      y[j->offset[g] + k] -= unit[j->offset[g] + k] * *repair;
    }
  }
}

static void eliminate_one(form_assembly *a, form_component *part, int first_row) {
  form_joints *j = &a->joints;
  const int n = part->rows;
  double *S = j->dense + part->at;
  double *Y = S + (ptrdiff_t)n * n;
  double *y = j->y + first_row;
  int *pivot = j->pivot + first_row;
  part->row = first_row;
  gather(a, part, S, Y, y);
  equilibrate(part, S, Y, y, j->unit + first_row);
  /* a positive return only says that the rank is less than n */
  (void)LAPACKE_dpstrf_work(LAPACK_COL_MAJOR, 'L', n, S, n, pivot, &part->rank, same_row, j->work);
  permute(Y, n, part->columns, pivot, j->work);
  set_apart(a, part, y, j->unit + first_row);
  permute(y, n, 1, pivot, j->work);
  if (part->rank > 0) {
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, part->rank,
                part->columns, 1, S, n, Y, n);
    cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, part->rank, S, n, y, 1);
  }
  subtract(a, part, Y, y);
}

void form_joints_solve(const form_joints *j, const form_component *part, double *x, double *work) {
  const int n = part->rows;
  const double *S = j->dense + part->at;
  const int *pivot = j->pivot + part->row;
  const double *unit = j->unit + part->row;
  for (int k = 0; k < part->rank; k++) {
    work[k] = unit[pivot[k] - 1] * x[pivot[k] - 1];
  }
  if (part->rank > 0) {
    cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, part->rank, S, n, work, 1);
    cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, part->rank, S, n, work, 1);
  }
  memset(x, 0, (size_t)n * sizeof *x);
  for (int k = 0; k < part->rank; k++) {
    x[pivot[k] - 1] = unit[pivot[k] - 1] * work[k];
  }
}

/* What joints take all of leaves rounding in r', which is no motion. */
static void drop_rounding(form_assembly *a) {
  static const double noise = 16 * DBL_EPSILON;
  for (int i = 0; i < a->n_contact; i++) {
    double fastest = 0;
    for (int row = a->row[i]; row < a->row[i + 1]; row++) {
      fastest = fmax(fastest, a->joints.speed[row]);
    }
    for (int row = a->row[i]; row < a->row[i + 1]; row++) {
      a->r[row] = (fabs(a->r[row]) <= noise * fastest) ? 0 : a->r[row];
    }
  }
}

/* Factors S and leaves C' in the blocks of the joints, r' in r, and what is known of the contacts' rows. */
static base_status project(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  BASE_TRY(form_joints_find(a, err));
  form_assembly_know_locks(a);
  for (int i = 0; i < a->n_contact; i++) {
    for (int p = 0; p < form_rows_of(a, i); p++) {
      j->speed[a->row[i] + p] = fabs(a->r[a->row[i] + p]);
      j->before[a->row[i] + p] = form_own_block(a, i)[(ptrdiff_t)p * (form_rows_of(a, i) + 1)];
    }
  }
  BASE_TRY(form_joints_widen(a, err));
  int first_row = 0;
  for (int c = 0; c < j->n_part; c++) {
    eliminate_one(a, &j->part[c], first_row);
    first_row += j->part[c].rows;
  }
  drop_rounding(a);
  form_joints_judge(a);
  form_joints_renew(a);
  a->beside = true;
  return BASE_OK;
}

/* From now on C is what `from` holds. */
static void read_blocks(form_assembly *a, const form_blocks *from) {
  a->near_start = from->near_start;
  a->near = from->near;
  a->block_at = from->block_at;
  a->block = from->block;
}

base_status form_assembly_eliminate(form_assembly *a, base_error *err) {
  if (a->n_group == a->n_contact) {
    return BASE_OK;
  }
  BASE_TRY(project(a, err));
  a->n_joint_group = a->n_group - a->n_contact;
  a->n_group = a->n_contact;
  a->n_row = a->row[a->n_contact];
  read_blocks(a, &a->joints.left);
  form_assembly_unblock(a);
  return BASE_OK;
}

static void find_self(form_assembly *a) {
  for (int i = 0; i < a->n_contact; i++) {
    int k = a->near_start[i];
    while (a->near[k] != i) {
      k++;
    }
    a->self[i] = k;
  }
}

base_status form_assembly_mix(form_assembly *a, base_error *err) {
  if (a->n_group == a->n_contact || a->n_contact == 0) {
    return BASE_OK;
  }
  memcpy(a->lambda, a->r, (size_t)a->n_row * sizeof *a->r);
  BASE_TRY(project(a, err));
  for (int r = 0; r < a->n_row; r++) {
    a->r[r] = a->lambda[r] - ((r < a->row[a->n_contact]) ? 0 : a->repair[r]);
  }
  read_blocks(a, &a->joints.left);
  const bool fewer = form_assembly_choose_rows(a);
  read_blocks(a, &a->home);
  if (fewer) {
    form_assembly_compress(a);
  } else {
    find_self(a);
  }
  return BASE_OK;
}

/* lambda_b = -S^-1 (r_b + R lambda_c) into lambda, which holds all rows of `full`. */
void form_assembly_joint_impulses(form_assembly *a, double *lambda) {
  form_joints *j = &a->joints;
  const int *row = a->full.row;
  assert(a->n_joint_group == 0 || form_joints_partitioned(a, a->n_joint_group));
  for (int c = 0; a->n_joint_group > 0 && c < j->n_part; c++) {
    const form_component *part = &j->part[c];
    const int n = part->rows;
    const double *S = j->dense + part->at;
    const double *Y = S + (ptrdiff_t)n * n;
    double *x = j->work;
    double *all = j->work + j->cap_row;
    memset(all, 0, (size_t)n * sizeof *all);
    memcpy(x, j->y + part->row, (size_t)n * sizeof *x);
    for (int t = part->touch; t < part->touch + part->n_touch; t++) {
      const int i = j->touch[t];
      for (int p = 0; p < row[i + 1] - row[i]; p++) {
        cblas_daxpy(part->rank, lambda[row[i] + p], Y + (ptrdiff_t)(j->column[t] + p) * n, 1, x, 1);
      }
    }
    if (part->rank > 0) {
      cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, part->rank, S, n, x, 1);
    }
    for (int k = 0; k < part->rank; k++) {
      const int at = j->pivot[part->row + k] - 1;
      all[at] = -x[k] * j->unit[part->row + at];
    }
    for (int m = part->first; m < part->first + part->count; m++) {
      const int g = j->member[m];
      memcpy(lambda + row[g], all + j->offset[g], (size_t)(row[g + 1] - row[g]) * sizeof *all);
    }
  }
}

bool form_assembly_repair_impulses(const form_assembly *a, double *lambda) {
  const form_joints *j = &a->joints;
  const int *row = a->full.row;
  bool any = false;
  for (int r = row[a->full.n_contact]; r < row[a->full.n_contact + form_joints_of(a)]; r++) {
    any = any || a->repair[r] != 0;
  }
  for (int c = 0; any && c < j->n_part; c++) {
    const form_component *part = &j->part[c];
    double *x = j->work + j->cap_row;
    for (int m = part->first; m < part->first + part->count; m++) {
      const int g = j->member[m];
      memcpy(x + j->offset[g], a->repair + row[g], (size_t)(row[g + 1] - row[g]) * sizeof *x);
    }
    form_joints_solve(j, part, x, j->work);
    for (int m = part->first; m < part->first + part->count; m++) {
      const int g = j->member[m];
      memcpy(lambda + row[g], x + j->offset[g], (size_t)(row[g + 1] - row[g]) * sizeof *x);
    }
  }
  return any;
}
