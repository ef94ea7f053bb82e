/* assembly_joint.c - joints out of the contact space.
 *
 * With S = C_bb and R = C_bc of the joint rows b and the contact rows c, joint rows satisfied
 * exactly, r_b + S lambda_b + R lambda_c = 0, leave
 *
 *   C' = C_cc - R' S^-1 R,   r' = r_c - R' S^-1 r_b
 *
 * which is the projected inverse mass of MATHEMATICS 2.1. Joints fall into connected components; each has
 * its own S, and only contacts that touch the same component become coupled. S, scaled to a diagonal between 1 and 4, is
 * factored with pivoting (LAPACK dpstrf): redundant joint rows carry no impulse, nothing is added to S.
 *
 * Whether the joints block a direction of a contact is judged here, where the numbers that it is lost in are known. With
 * w = S^-1 R of its row a blocked direction has J_c = w' J_b: its diagonal of C' is zero, computed with an error of
 * some roundings of (|J_c| + sum |w_k| |J_b,k|)^2, and its velocity is drift_c - w' drift_b, whatever r' says: that
 * holds the correction of joint errors besides, which is no motion of the contact. */
#include "formulations/assembly.h"

#include <assert.h>
#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Pivot of the scaled S at which a joint row says what others have said: a sine of 3e-7 between the two. */
static const double same_row = 1e-13;
/* Share of its diagonal that a direction must have lost before it is asked whether it is blocked. */
static const double much_lost = 1e-6;

static void layout_lists(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->component = BASE_ARRAY(m, int, j->cap_group);
  j->part = BASE_ARRAY(m, form_component, j->cap_group);
  j->member = BASE_ARRAY(m, int, j->cap_group);
  j->mark = BASE_ARRAY(m, int, j->cap_group);
  j->touch = BASE_ARRAY(m, int, 2 * (size_t)j->cap_group);
  j->column = BASE_ARRAY(m, int, 2 * (size_t)j->cap_group);
  j->offset = BASE_ARRAY(m, int, j->cap_group);
  j->near_start = BASE_ARRAY(m, int, j->cap_group + 1);
  j->pivot = BASE_ARRAY(m, int, j->cap_row);
  j->unit = BASE_ARRAY(m, double, j->cap_row);
  j->before = BASE_ARRAY(m, double, j->cap_row);
  j->y = BASE_ARRAY(m, double, j->cap_row);
  j->work = BASE_ARRAY(m, double, 2 * (size_t)j->cap_row);
}

static void layout_dense(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->dense = BASE_ARRAY(m, double, j->cap_dense);
  j->near = BASE_ARRAY(m, int, j->cap_near);
  j->block_at = BASE_ARRAY(m, size_t, j->cap_near + 1);
}

static void layout_blocks(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->block = BASE_ARRAY(m, double, j->cap_block);
}

/* Gives every unlabelled joint that meets g the label of g. */
static int spread(form_assembly *a, int g, int listed) {
  form_joints *j = &a->joints;
  for (int k = a->near_start[g]; k < a->near_start[g + 1]; k++) {
    const int other = a->near[k];
    if (other >= a->n_contact && j->component[other] < 0) {
      j->component[other] = j->component[g];
      j->member[listed++] = other;
    }
  }
  return listed;
}

#ifndef NDEBUG
/* Every one of n joints is a member of one component, the one that it is labelled with. */
static bool partitioned(const form_assembly *a, int n) {
  const form_joints *j = &a->joints;
  const int begin = a->full.n_contact;
  int next = 0;
  bool good = true;
  for (int c = 0; c < j->n_part && good; c++) {
    good = j->part[c].first == next;
    for (int k = 0; k < j->part[c].count && good && next < n; k++) {
      const int g = j->member[next++];
      good = g >= begin && g < begin + n && j->component[g] == c;
      j->mark[g] = good ? -1 - next : 0; /* a second place overwrites the first */
    }
  }
  for (int k = 0; k < next && good; k++) {
    good = j->mark[j->member[k]] == -2 - k;
  }
  return good && next == n;
}
#endif

/* Labels joints that are coupled with the same number; lists them component by component. */
static void find_components(form_assembly *a) {
  form_joints *j = &a->joints;
  const int p = a->n_contact;
  int listed = 0;
  j->n_part = 0;
  for (int g = p; g < a->n_group; g++) {
    j->component[g] = -1;
  }
  for (int seed = p; seed < a->n_group; seed++) {
    if (j->component[seed] >= 0) {
      continue;
    }
    form_component *c = &j->part[j->n_part];
    *c = (form_component){.first = listed};
    j->component[seed] = j->n_part;
    j->member[listed++] = seed;
    for (int head = c->first; head < listed; head++) {
      const int g = j->member[head];
      j->offset[g] = c->rows;
      c->rows += form_rows_of(a, g);
      listed = spread(a, g, listed);
    }
    c->count = listed - c->first;
    j->n_part++;
  }
  assert(partitioned(a, a->n_group - p));
}

static int ascending(const void *x, const void *y) {
  const int a = *(const int *)x;
  const int b = *(const int *)y;
  return (a > b) - (a < b);
}

/* Lists the contacts that meet joint g and are not listed for component c yet. */
static int list_touching(form_assembly *a, int g, int c, int listed) {
  form_joints *j = &a->joints;
  for (int k = a->near_start[g]; k < a->near_start[g + 1]; k++) {
    const int i = a->near[k];
    if (i < a->n_contact && j->mark[i] != c) {
      j->mark[i] = c;
      j->touch[listed++] = i;
    }
  }
  return listed;
}

/* Contacts that touch each component, ascending, with their first column in Y. A body belongs to
 * one component, so a contact touches at most two. */
static void find_touching(form_assembly *a) {
  form_joints *j = &a->joints;
  int listed = 0;
  for (int i = 0; i < a->n_contact; i++) {
    j->mark[i] = -1;
  }
  for (int c = 0; c < j->n_part; c++) {
    form_component *part = &j->part[c];
    part->touch = listed;
    for (int m = part->first; m < part->first + part->count; m++) {
      listed = list_touching(a, j->member[m], c, listed);
    }
    part->n_touch = listed - part->touch;
    qsort(j->touch + part->touch, (size_t)part->n_touch, sizeof *j->touch, ascending);
    part->columns = 0;
    for (int k = part->touch; k < listed; k++) {
      j->column[k] = part->columns;
      part->columns += form_rows_of(a, j->touch[k]);
    }
  }
}

/* Ascending union of contact i's contact neighbours and everything in its components. */
static int widened(const form_assembly *a, int i, int *out) {
  const form_joints *j = &a->joints;
  const int *list[3] = {a->near + a->near_start[i], NULL, NULL};
  int left[3] = {0, 0, 0};
  while (a->near_start[i] + left[0] < a->near_start[i + 1] && list[0][left[0]] < a->n_contact) {
    left[0]++;
  }
  int n_list = 1;
  int last = -1;
  for (int k = a->near_start[i] + left[0]; k < a->near_start[i + 1]; k++) {
    const int c = j->component[a->near[k]];
    if (c != last && (n_list < 2 || list[1] != j->touch + j->part[c].touch)) {
      list[n_list] = j->touch + j->part[c].touch;
      left[n_list++] = j->part[c].n_touch;
    }
    last = c;
  }
  int n = 0;
  for (;;) {
    int least = a->n_contact;
    for (int l = 0; l < n_list; l++) {
      least = (left[l] > 0 && *list[l] < least) ? *list[l] : least;
    }
    if (least == a->n_contact) {
      return n;
    }
    for (int l = 0; l < n_list; l++) {
      if (left[l] > 0 && *list[l] == least) {
        list[l]++;
        left[l]--;
      }
    }
    if (out != NULL) {
      out[n] = least;
    }
    n++;
  }
}

static base_status reserve(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  size_t dense = 0;
  for (int c = 0; c < j->n_part; c++) {
    form_component *part = &j->part[c];
    part->at = dense;
    dense += (size_t)part->rows * (size_t)(part->rows + part->columns);
  }
  size_t near = 0;
  for (int i = 0; i < a->n_contact; i++) {
    near += (size_t)widened(a, i, NULL);
  }
  if (near > (size_t)INT32_MAX / 2) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "joints couple %zu pairs of contacts", near);
  }
  if (j->dense_mem == NULL || dense > j->cap_dense || (int)near > j->cap_near) {
    j->cap_dense = base_room_of(dense) + 1;
    j->cap_near = (int)(base_room_of(near)) + 1;
    BASE_TRY(form_memory(&j->dense_mem, layout_dense, a, err));
  }
  return BASE_OK;
}

/* Copies C_cc into the widened pattern. */
static base_status widen(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  j->near_start[0] = 0;
  j->block_at[0] = 0;
  for (int i = 0; i < a->n_contact; i++) {
    const int at = j->near_start[i];
    j->near_start[i + 1] = at + widened(a, i, j->near + at);
    for (int k = at; k < j->near_start[i + 1]; k++) {
      j->block_at[k + 1] =
          j->block_at[k] + (size_t)form_rows_of(a, i) * (size_t)form_rows_of(a, j->near[k]);
    }
  }
  const size_t size = j->block_at[j->near_start[a->n_contact]];
  if (j->block_mem == NULL || size > j->cap_block) {
    j->cap_block = base_room_of(size) + 1;
    BASE_TRY(form_memory(&j->block_mem, layout_blocks, a, err));
  }
  memset(j->block, 0, size * sizeof *j->block);
  for (int i = 0; i < a->n_contact; i++) {
    int old = a->near_start[i];
    for (int k = j->near_start[i]; k < j->near_start[i + 1]; k++) {
      if (j->near[k] == i) {
        a->self[i] = k;
      }
      if (old < a->near_start[i + 1] && a->near[old] == j->near[k]) {
        memcpy(j->block + j->block_at[k], a->block + a->block_at[old],
               (j->block_at[k + 1] - j->block_at[k]) * sizeof *j->block);
        old++;
      }
    }
  }
  return BASE_OK;
}

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
    int k = j->near_start[i];
    for (int o = part->touch; o < part->touch + part->n_touch; o++) {
      while (j->near[k] != j->touch[o]) {
        k++;
      }
      const double *Yj = Y + (ptrdiff_t)j->column[o] * n;
      reduce_block(Yi, ri, Yj, form_rows_of(a, j->touch[o]), n, part->rank,
                   j->block + j->block_at[k]);
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

/* x = S^-1 x over the rows of one component, in their order; 0 where a row says what others have said. */
static void solve_rows(const form_joints *j, const form_component *part, double *x, double *work) {
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
  const double *own = j->block + j->block_at[a->self[i]] + (ptrdiff_t)first * rows + first;
  double c[9], lost = 0;
  for (int p = 0; p < n; p++) {
    memcpy(c + 3 * p, own + (ptrdiff_t)p * rows, (size_t)n * sizeof *c);
    lost += much_lost * j->before[a->row[i] + first + p];
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

/* What the joints block. */
static void know_joints(form_assembly *a) {
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

/* Factors S and leaves C' in the blocks of the joints, r' in r, and what is known of the contacts' rows. */
static base_status project(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  if (j->mem == NULL || a->n_group > j->cap_group || a->n_row > j->cap_row) {
    j->cap_group = base_room(a->n_group);
    j->cap_row = base_room(a->n_row);
    BASE_TRY(form_memory(&j->mem, layout_lists, a, err));
  }
  assert(form_assembly_is_linked(a));
  find_components(a);
  find_touching(a);
  form_assembly_know_locks(a);
  for (int i = 0; i < a->n_contact; i++) {
    for (int p = 0; p < form_rows_of(a, i); p++) {
      j->before[a->row[i] + p] = form_own_block(a, i)[(ptrdiff_t)p * (form_rows_of(a, i) + 1)];
    }
  }
  BASE_TRY(reserve(a, err));
  BASE_TRY(widen(a, err));
  int first_row = 0;
  for (int c = 0; c < j->n_part; c++) {
    eliminate_one(a, &j->part[c], first_row);
    first_row += j->part[c].rows;
  }
  know_joints(a);
  a->beside = true;
  return BASE_OK;
}

static void read_projected(form_assembly *a) {
  a->near_start = a->joints.near_start;
  a->near = a->joints.near;
  a->block_at = a->joints.block_at;
  a->block = a->joints.block;
}

base_status form_assembly_eliminate(form_assembly *a, base_error *err) {
  if (a->n_group == a->n_contact) {
    return BASE_OK;
  }
  BASE_TRY(project(a, err));
  a->n_joint_group = a->n_group - a->n_contact;
  a->n_group = a->n_contact;
  a->n_row = a->row[a->n_contact];
  read_projected(a);
  form_assembly_unblock(a);
  return BASE_OK;
}

static void read_home(form_assembly *a) {
  a->near_start = a->home.near_start;
  a->near = a->home.near;
  a->block_at = a->home.block_at;
  a->block = a->home.block;
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
  read_projected(a);
  const bool fewer = form_assembly_choose_rows(a);
  read_home(a);
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
  assert(a->n_joint_group == 0 || partitioned(a, a->n_joint_group));
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
    solve_rows(j, part, x, j->work);
    for (int m = part->first; m < part->first + part->count; m++) {
      const int g = j->member[m];
      memcpy(lambda + row[g], x + j->offset[g], (size_t)(row[g + 1] - row[g]) * sizeof *x);
    }
  }
  return any;
}

void form_joints_close(form_joints *j) {
  free(j->mem);
  free(j->dense_mem);
  free(j->block_mem);
}
