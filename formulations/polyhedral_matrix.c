#include "formulations/polyhedral_matrix.h"

#include <string.h>

static void add_part(poly_shape *s, int kind, int row, int dim, int facets) {
  const int p = s->n_part++;
  s->part_kind[p] = kind;
  s->part_start[p] = s->n_column;
  const int n = (dim == 1) ? 2 : facets;
  for (int k = 0; k < n; k++) {
    struct poly_column *col = &s->column[s->n_column++];
    const double angle = 2 * 3.14159265358979323846 * k / n; /* 2 pi k / n */
    col->row = row;
    col->n = dim;
    col->c[0] = cos(angle);
    col->c[1] = (dim == 1) ? 0 : sin(angle);
  }
  /* the four axes exactly, so that a slide along one stays on it */
  for (int k = 0; k < n; k++) {
    struct poly_column *col = &s->column[s->part_start[p] + k];
    if ((4 * k) % n == 0) {
      const int quarter = (4 * k / n) % 4;
      col->c[0] = (quarter == 0) - (quarter == 2);
      col->c[1] = (quarter == 1) - (quarter == 3);
    }
  }
  s->part_start[s->n_part] = s->n_column;
}

void poly_shape_build(poly_shape *s, contact_rows rows, int facets, bool three) {
  s->n_column = 1;
  s->n_part = 0;
  s->part_start[0] = 1;
  s->column[0] = (struct poly_column){0, 1, {1, 0}};
  int row = 1;
  if (rows.tangent > 0) {
    add_part(s, 0, row, rows.tangent, facets);
    row += rows.tangent;
    if (three) { /* lambda_R along +t is the only facet that stays */
      s->n_column = 2;
      s->part_start[1] = 2;
    }
  }
  if (rows.torsion > 0) {
    add_part(s, 1, row, 1, facets);
    row += rows.torsion;
  }
  if (rows.rolling > 0) {
    add_part(s, 2, row, rows.rolling, facets);
  }
}

void poly_shape_identity(poly_shape *s, int rows) {
  s->n_part = 0;
  s->n_column = rows;
  for (int k = 0; k < rows; k++) {
    s->column[k] = (struct poly_column){k, 1, {1, 0}};
  }
}

int poly_columns(const polyhedral *s, int i) {
  return (i < s->a.n_contact) ? s->shape_of[i]->n_column : form_rows_of(&s->a, i);
}

int poly_parts(const polyhedral *s, int i) {
  return (i < s->a.n_contact) ? s->shape_of[i]->n_part : 0;
}

int poly_width(const polyhedral *s, int i) {
  return poly_columns(s, i) + poly_parts(s, i);
}

static bool is_three(const polyhedral *s) {
  return s->opt.planar == POLY_THREE && s->a.set->dim == 2;
}

/* Part of column b of group i, -1 for lambda_n and joint rows. */
static int part_of(const polyhedral *s, int i, int b) {
  for (int p = 0; p < poly_parts(s, i); p++) {
    if (b >= s->shape_of[i]->part_start[p] && b < s->shape_of[i]->part_start[p + 1]) {
      return p;
    }
  }
  return -1;
}

static double unit_of(const polyhedral *s, int i, int b) {
  const int p = part_of(s, i, b);
  return (p < 0) ? 1 : s->scale[s->parts * i + p];
}

void poly_direction(const polyhedral *s, int i, int b, double *f) {
  const struct poly_column *col = &s->shape_of[i]->column[b];
  memset(f, 0, (size_t)form_rows_of(&s->a, i) * sizeof *f);
  const double unit = unit_of(s, i, b);
  for (int k = 0; k < col->n; k++) {
    f[col->row + k] = unit * col->c[k];
  }
  if (b == 0 && poly_parts(s, i) > 0 && is_three(s)) {
    f[1] = -s->bound[s->parts * i];
  }
}

/* out[0..columns_i) = F_i' v, v the velocity of group i's rows. */
static void project(const polyhedral *s, int i, const double *v, double *out) {
  const poly_shape *shape = s->shape_of[i];
  int part = -1;
  int part_end = 1;
  double unit = 1;
  const int n = poly_columns(s, i);
  for (int a = 0; a < n; a++) {
    if (a >= part_end && part + 1 < poly_parts(s, i)) {
      part++;
      part_end = shape->part_start[part + 1];
      unit = s->scale[s->parts * i + part];
    }
    const struct poly_column *col = &shape->column[a];
    double sum = col->c[0] * v[col->row];
    if (col->n == 2) {
      sum += col->c[1] * v[col->row + 1];
    }
    out[a] = unit * sum;
  }
}

/* a_i: normal inverse mass of contact i, 1 where neither side moves. */
static double normal_mass(const polyhedral *s, int i) {
  const double a = form_own_block(&s->a, i)[0];
  return (a > 0) ? a : 1;
}

/* 1 for facets; the planar three-unknown form bounds lambda_L + lambda_R by 2 mu lambda_n. */
static double cone_entry(const polyhedral *s, int i, int part) {
  return ((is_three(s)) ? 2 : 1) * s->bound[s->parts * i + part];
}

size_t poly_shift_nnz(const polyhedral *s) {
  size_t nnz = 0;
  for (int j = 0; j < s->a.n_group; j++) {
    for (int p = 0; p < poly_parts(s, j); p++) {
      const int facets = s->shape_of[j]->part_start[p + 1] - s->shape_of[j]->part_start[p];
      nnz += 1 + 2 * (size_t)facets;
    }
  }
  return nnz;
}

size_t poly_nnz(const polyhedral *s) {
  size_t nnz = 0;
  for (int j = 0; j < s->a.n_group; j++) {
    size_t height = 0;
    for (int k = s->a.near_start[j]; k < s->a.near_start[j + 1]; k++) {
      height += (size_t)poly_columns(s, s->a.near[k]);
    }
    nnz += height * (size_t)poly_columns(s, j);
  }
  return nnz + poly_shift_nnz(s);
}

/* Column b of group j in the rows of group i = near[k]: F_i' C_ij f. The stored block is C_ji. */
static void coupled_column(const polyhedral *s, int j, int k, const double *f, double *out) {
  const int i = s->a.near[k];
  const int ri = form_rows_of(&s->a, i);
  const int rj = form_rows_of(&s->a, j);
  const double *block = s->a.block + s->a.block_at[k];
  double v[POLY_ROWS_MAX] = {0};
  for (int q = 0; q < rj; q++) {
    for (int p = 0; p < ri; p++) {
      v[p] += block[q * ri + p] * f[q];
    }
  }
  project(s, i, v, out);
}

void poly_fill_dense(polyhedral *s) {
  const ptrdiff_t n = s->n;
  memset(s->val, 0, (size_t)(n * n) * sizeof *s->val);
  for (int j = 0; j < s->a.n_group; j++) {
    const int nj = poly_columns(s, j);
    for (int b = 0; b < nj; b++) {
      double f[POLY_ROWS_MAX];
      poly_direction(s, j, b, f);
      double *column = s->val + (s->first[j] + b) * n;
      for (int k = s->a.near_start[j]; k < s->a.near_start[j + 1]; k++) {
        coupled_column(s, j, k, f, column + s->first[s->a.near[k]]);
      }
    }
    const double a = normal_mass(s, j);
    for (int p = 0; p < poly_parts(s, j); p++) {
      const int sigma = s->first[j] + nj + p;
      s->val[s->first[j] * n + sigma] = a * cone_entry(s, j, p);
      for (int b = s->shape_of[j]->part_start[p]; b < s->shape_of[j]->part_start[p + 1]; b++) {
        s->val[(s->first[j] + b) * n + sigma] = -a;
        s->val[sigma * n + s->first[j] + b] = a;
      }
    }
  }
}

static int put(const poly_arrays *to, int at, int row, double value) {
  to->rowind[at] = row;
  to->val[at] = value;
  return at + 1;
}

int poly_put_cone_rows(const polyhedral *s, const poly_arrays *to, int at, int j, int b) {
  const double a = normal_mass(s, j);
  const int sigma = s->first[j] + poly_columns(s, j);
  const int own = part_of(s, j, b);
  for (int p = 0; p < poly_parts(s, j); p++) {
    if (b == 0) {
      at = put(to, at, sigma + p, a * cone_entry(s, j, p));
    } else if (p == own) {
      at = put(to, at, sigma + p, -a);
    }
  }
  return at;
}

int poly_put_sigma_column(const polyhedral *s, const poly_arrays *to, int at, int j, int p) {
  const double a = normal_mass(s, j);
  for (int b = s->shape_of[j]->part_start[p]; b < s->shape_of[j]->part_start[p + 1]; b++) {
    at = put(to, at, s->first[j] + b, a);
  }
  return at;
}

/* Column b of group j through all its neighbours, with the sigma rows after the own rows. */
static int put_coupled(polyhedral *s, int at, int j, int b) {
  double f[POLY_ROWS_MAX];
  poly_direction(s, j, b, f);
  for (int k = s->a.near_start[j]; k < s->a.near_start[j + 1]; k++) {
    const int i = s->a.near[k];
    coupled_column(s, j, k, f, s->m.val + at);
    for (int row = 0; row < poly_columns(s, i); row++) {
      s->m.rowind[at++] = s->first[i] + row;
    }
    if (i == j) {
      at = poly_put_cone_rows(s, &s->m, at, j, b);
    }
  }
  return at;
}

void poly_fill_csc(polyhedral *s) {
  int at = 0;
  int column = 0;
  for (int j = 0; j < s->a.n_group; j++) {
    for (int b = 0; b < poly_columns(s, j); b++) {
      s->m.colptr[column++] = at;
      at = put_coupled(s, at, j, b);
    }
    for (int p = 0; p < poly_parts(s, j); p++) {
      s->m.colptr[column++] = at;
      at = poly_put_sigma_column(s, &s->m, at, j, p);
    }
  }
  s->m.colptr[column] = at;
}

void poly_fill_q(const polyhedral *s, int i, double bias, double *q) {
  project(s, i, s->u + s->a.row[i], q);
  if (i < s->a.n_contact) {
    q[0] += bias;
    for (int p = 0; p < poly_parts(s, i); p++) {
      q[poly_columns(s, i) + p] = normal_mass(s, i) * cone_entry(s, i, p) * s->cone[i];
    }
  }
}

void poly_expand(const polyhedral *s, int i, const double *z, double *lambda) {
  double f[POLY_ROWS_MAX];
  for (int b = 0; b < poly_columns(s, i); b++) {
    poly_direction(s, i, b, f);
    for (int p = 0; p < form_rows_of(&s->a, i); p++) {
      lambda[p] += f[p] * z[b];
    }
  }
}

/* ---- where a solve begins ---------------------------------------------------------------------- */

/* Unknowns >= 0 of a part that give the impulse l over its rows: on the two facets beside it. */
static void put_part(const poly_shape *shape, int part, double unit, const double *l, double *z) {
  const int first = shape->part_start[part];
  const int n = shape->part_start[part + 1] - first;
  if (shape->column[first].n == 1) {
    z[first + (l[0] < 0)] = fabs(l[0]) / unit;
    return;
  }
  const double width = 2 * 3.14159265358979323846 / n;
  const double size = hypot(l[0], l[1]) / unit;
  const double turn = atan2(l[1], l[0]);
  const double angle = (turn < 0) ? turn + n * width : turn;
  const int k = (int)(angle / width) % n;
  const double over = fmax(angle - k * width, 0);
  z[first + k] = size * sin(fmax(width - over, 0)) / sin(width);
  z[first + (k + 1) % n] = size * sin(over) / sin(width);
}

/* sigma of a part: the speed at which it slides against its steepest facet. */
static double sliding(const poly_shape *shape, int part, const double *along) {
  double most = 0;
  for (int b = shape->part_start[part]; b < shape->part_start[part + 1]; b++) {
    most = fmax(most, -along[b]);
  }
  return most;
}

static void from_impulses(polyhedral *s, int i, const double *past, double ratio, double *z) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  const poly_shape *shape = s->shape_of[i];
  double l[POLY_ROWS_MAX] = {0}, before[POLY_ROWS_MAX] = {0}, along[POLY_COLUMNS];
  form_to_rows(&s->a, i, past + PAST_IMPULSE, l);
  form_to_rows(&s->a, i, c->u_before + c->row_start[g], before);
  project(s, i, before, along);
  for (int r = 0; r < form_rows_of(&s->a, i); r++) {
    l[r] *= ratio;
  }
  z[0] = fmax(l[0], 0);
  if (shape->n_part > 0 && is_three(s)) { /* lambda_t = lambda_R - mu lambda_n */
    z[1] = fmax(l[1] + s->bound[s->parts * i] * z[0], 0);
    return;
  }
  for (int p = 0; p < shape->n_part; p++) {
    const double unit = s->scale[s->parts * i + p];
    put_part(shape, p, unit, l + shape->column[shape->part_start[p]].row, z);
    if (past[PAST_SLIDES] > 0 && shape->part_kind[p] == 0) {
      z[shape->n_column + p] = sliding(shape, p, along) / normal_mass(s, i);
    }
  }
}

void poly_start_point(polyhedral *s) {
  memset(s->z0, 0, (size_t)s->n * sizeof *s->z0);
  if (s->start != FORM_PREVIOUS || s->phase != POLY_MOTION || !(s->memory.h_old > 0)) {
    return;
  }
  const double ratio = s->a.set->h / s->memory.h_old;
  for (int i = 0; i < s->a.n_contact; i++) {
    const double *past = contact_memory_old(&s->memory, s->a.group[i]);
    double *z = s->z0 + s->first[i];
    if (past == NULL || !(past[PAST_CLOSED] > 0)) {
      continue;
    }
    const double *own = past + contact_memory_own(&s->memory);
    if (own[POLY_PAST_WIDTH] == 0) {
      from_impulses(s, i, past, ratio, z);
    }
    for (int k = 0; own[POLY_PAST_WIDTH] == poly_width(s, i) && k < poly_width(s, i); k++) {
      z[k] = ratio * own[POLY_PAST_Z + k];
    }
  }
}
