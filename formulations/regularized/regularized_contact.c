/* regularized_contact.c - the reduced LCP in contact space.
 *
 * With Q the compliant directions (sticking and secant parts), g their compliances and
 * offsets o, B the columns e_n - mu d of the normals with their slip friction:
 *
 *   (Q C Q' + g) lambda_q = -(Q r + o) - Q C B lambda_n
 *   A = N C B - N C Q' (Q C Q' + g)^-1 Q C B
 *   b = N r + b_n - N C Q' (Q C Q' + g)^-1 (Q r + o)
 *
 * Nothing is inverted but the compliance matrix, so that G = infinity (g = 0) is fine. */
#include "formulations/regularized/regularized.h"

#include <cblas.h>
#include <lapacke.h>
#include <string.h>

enum { MOST_ROWS = 8 };

static void add_row(regularized *s, int group, int row, int n, const double *c, double stiffness,
                    double offset) {
  reg_row *q = &s->rows[s->n_rows++];
  *q = (reg_row){.group = group, .row = row, .n = n, .stiffness = stiffness, .offset = offset};
  q->compliance = 1 / stiffness;
  q->c[0] = c[0];
  q->c[1] = (n == 2) ? c[1] : 0;
}

/* The compliant directions of one part. */
static void part_rows(regularized *s, const reg_part *p) {
  const double axis[2] = {1, p->axis2};
  const double r = (p->mode == REG_STICK || s->opt.modes == REG_ONCE) ? 1 : p->r;
  const double stiffness = p->G * r;
  if (!(stiffness > 0) || p->mode == REG_GIVEN) {
    return;
  }
  const double spring = p->pull / p->G; /* of s, as a velocity */
  if (p->mode != REG_SLIP) {
    for (int m = 0; m < p->dim; m++) {
      add_row(s, p->contact, p->row + m, 1, &axis[m], stiffness, spring * p->s[m]);
    }
  } else if (p->dim == 2 && s->opt.modes != REG_PLAIN && s->opt.modes != REG_ONCE) {
    const double across[2] = {-p->d[1], p->d[0]};
    const double scaled[2] = {across[0], p->axis2 * across[1]};
    add_row(s, p->contact, p->row, 2, scaled, stiffness,
            spring * (across[0] * p->s[0] + across[1] * p->s[1]));
  }
}

void reg_rows_collect(regularized *s) {
  s->n_rows = 0;
  s->any_slip = false;
  for (int i = 0; i < s->a.n_contact; i++) {
    s->row_of[i] = s->n_rows;
    for (int k = s->part_start[i]; k < s->part_start[i + 1]; k++) {
      part_rows(s, &s->part[k]);
      s->any_slip = s->any_slip || s->part[k].mode == REG_SLIP;
    }
  }
  s->row_of[s->a.n_contact] = s->n_rows;
}

static double friction_bound(const reg_part *p) {
  return p->sliding ? p->mu_kinetic : p->mu_static;
}

/* f = column of B of contact j, over its own rows. */
void reg_slip_column(const regularized *s, int j, double *f) {
  memset(f, 0, MOST_ROWS * sizeof *f);
  f[0] = 1;
  for (int k = s->part_start[j]; k < s->part_start[j + 1]; k++) {
    const reg_part *p = &s->part[k];
    if (p->mode == REG_SLIP) {
      for (int m = 0; m < p->dim; m++) {
        const double unit = (m == 1) ? p->axis2 : 1;
        f[p->row - s->a.row[j] + m] = -friction_bound(p) * p->d[m] * unit;
      }
    }
  }
}

/* v = C_ij f over the rows of i; block is C_ji, row-major. */
static void through(const double *block, int ri, int rj, const double *f, double *v) {
  memset(v, 0, (size_t)ri * sizeof *v);
  for (int q = 0; q < rj; q++) {
    for (int p = 0; p < ri; p++) {
      v[p] += block[q * ri + p] * f[q];
    }
  }
}

/* v = C_ij c for compliant row q of group j: for an axis the row of the block as it stands. */
static const double *row_velocity(const reg_row *q, int first, const double *block, int ri,
                                  double *v) {
  const double *row = block + (ptrdiff_t)(q->row - first) * ri;
  if (q->n == 1 && q->c[0] == 1) {
    return row;
  }
  for (int p = 0; p < ri; p++) {
    v[p] = q->c[0] * row[p] + ((q->n == 2) ? q->c[1] * row[ri + p] : 0);
  }
  return v;
}

/* Column of group j into Sigma (lower part), X, Y and A; block is C_ji, j's rows. */
static void fill_pair(regularized *s, int j, int k) {
  const form_assembly *a = &s->a;
  const int i = a->near[k];
  const int ri = form_rows_of(a, i);
  const int p = a->n_contact;
  const double *block = a->block + a->block_at[k];
  double scratch[MOST_ROWS] = {0};
  for (int col = s->row_of[j]; col < s->row_of[j + 1]; col++) {
    const double *v = row_velocity(&s->rows[col], a->row[j], block, ri, scratch);
    double *column = s->sigma + (ptrdiff_t)col * s->n_rows;
    for (int row = s->row_of[i]; i >= j && row < s->row_of[i + 1]; row++) {
      column[row] = reg_along(&s->rows[row], v + (s->rows[row].row - a->row[i]));
    }
    s->xyc[(ptrdiff_t)i * s->n_rows + col] = v[0]; /* X = (N C Q')' */
  }
  if (!s->any_slip) {
    s->A[(ptrdiff_t)j * p + i] = block[0];
    return;
  }
  double f[MOST_ROWS] = {0};
  reg_slip_column(s, j, f);
  through(block, ri, form_rows_of(a, j), f, scratch);
  s->A[(ptrdiff_t)j * p + i] = scratch[0];
  double *Y = s->xyc + (ptrdiff_t)(p + j) * s->n_rows;
  for (int row = s->row_of[i]; row < s->row_of[i + 1]; row++) {
    Y[row] = reg_along(&s->rows[row], scratch + (s->rows[row].row - a->row[i]));
  }
}

bool reg_contact_reduce(regularized *s) {
  const form_assembly *a = &s->a;
  const int p = a->n_contact;
  const int n = s->n_rows;
  memset(s->A, 0, (size_t)p * (size_t)p * sizeof *s->A);
  memset(s->sigma, 0, (size_t)n * (size_t)n * sizeof *s->sigma);
  memset(s->xyc, 0, (size_t)n * (2 * (size_t)p + 1) * sizeof *s->xyc);
  for (int j = 0; j < a->n_group; j++) {
    for (int k = a->near_start[j]; k < a->near_start[j + 1]; k++) {
      fill_pair(s, j, k);
    }
  }
  for (int i = 0; i < p; i++) {
    s->b[i] = a->r[a->row[i]] + a->bias[a->group[i]];
  }
  if (n == 0) {
    return true;
  }
  double *c = s->xyc + 2 * (ptrdiff_t)p * n;
  for (int row = 0; row < n; row++) {
    const reg_row *q = &s->rows[row];
    s->sigma[(ptrdiff_t)row * n + row] += q->compliance;
    c[row] = reg_along(q, a->r + q->row) + q->offset;
  }
  s->answer.work.factorizations++;
  if (LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', n, s->sigma, n) != 0) {
    return false;
  }
  /* X, and Y where it differs, and c */
  const CBLAS_LAYOUT lay = CblasColMajor;
  cblas_dtrsm(lay, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, p, 1, s->sigma, n, s->xyc,
              n);
  cblas_dtrsm(lay, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, 1, 1, s->sigma, n, c, n);
  if (s->any_slip) {
    double *Y = s->xyc + (ptrdiff_t)p * n;
    cblas_dtrsm(lay, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, p, 1, s->sigma, n, Y, n);
    cblas_dgemm(lay, CblasTrans, CblasNoTrans, p, p, n, -1, s->xyc, n, Y, n, 1, s->A, p);
  } else {
    cblas_dsyrk(lay, CblasLower, CblasTrans, p, n, -1, s->xyc, n, 1, s->A, p);
    for (int j = 0; j < p; j++) {
      for (int i = j + 1; i < p; i++) {
        s->A[(ptrdiff_t)i * p + j] = s->A[(ptrdiff_t)j * p + i];
      }
    }
  }
  cblas_dgemv(lay, CblasTrans, n, p, -1, s->xyc, n, c, 1, 1, s->b, 1);
  return true;
}

void reg_contact_expand(regularized *s, const double *lambda_n, double *lambda) {
  const form_assembly *a = &s->a;
  const int n = s->n_rows;
  const int p = a->n_contact;
  memset(lambda, 0, (size_t)a->n_row * sizeof *lambda);
  for (int i = 0; i < p; i++) {
    double f[MOST_ROWS] = {0};
    reg_slip_column(s, i, f);
    for (int m = 0; m < form_rows_of(a, i); m++) {
      lambda[a->row[i] + m] = f[m] * lambda_n[i];
    }
  }
  if (n == 0) {
    return;
  }
  const double *Y = s->any_slip ? s->xyc + (ptrdiff_t)p * n : s->xyc;
  memcpy(s->t, s->xyc + 2 * (ptrdiff_t)p * n, (size_t)n * sizeof *s->t);
  cblas_dgemv(CblasColMajor, CblasNoTrans, n, p, -1, Y, n, lambda_n, 1, -1, s->t, 1);
  cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, n, s->sigma, n, s->t, 1);
  for (int row = 0; row < n; row++) {
    const reg_row *q = &s->rows[row];
    for (int m = 0; m < q->n; m++) {
      lambda[q->row + m] += q->c[m] * s->t[row];
    }
  }
}
