#include "problems/world/contact_set.h"

#include "lcp/base/crew.h"
#include "problems/vec.h"

#include <math.h>
#include <string.h>

static bool all_finite(const double *x, int n) {
  for (int i = 0; i < n; i++) {
    if (!isfinite(x[i])) {
      return false;
    }
  }
  return true;
}

static base_status check_blocks(const contact_set *c, base_error *err) {
  if (c->dof_start[0] != 0 || c->mass_start[0] != 0 || c->dof_start[c->n_body] != c->n_dof) {
    return BASE_FAIL(err, BASE_EINVAL, "dof_start: must run from 0 to n_dof = %d", c->n_dof);
  }
  for (int i = 0; i < c->n_body; i++) {
    const int n = c->dof_start[i + 1] - c->dof_start[i];
    if (n < 1 || c->mass_start[i + 1] - c->mass_start[i] != n * n) {
      return BASE_FAIL(err, BASE_EINVAL, "body %d: %d dofs need a %d x %d mass block", i, n, n, n);
    }
  }
  const int m = c->mass_start[c->n_body];
  if (!all_finite(c->mass, m) || !all_finite(c->inv_mass, m) || !all_finite(c->v, c->n_dof) ||
      !all_finite(c->v_free, c->n_dof)) {
    return BASE_FAIL(err, BASE_EINVAL, "mass, v or v_free: not finite");
  }
  return BASE_OK;
}

static base_status check_groups(const contact_set *c, base_error *err) {
  if (c->n_group < c->n_contact || c->row_start[0] != 0 || c->jac_start[0] != 0 ||
      c->row_start[c->n_group] != c->n_row) {
    return BASE_FAIL(err, BASE_EINVAL, "row_start: must run from 0 to n_row = %d", c->n_row);
  }
  for (int g = 0; g < c->n_group; g++) {
    const int *b = c->body + (ptrdiff_t)(2 * g);
    const int rows = c->row_start[g + 1] - c->row_start[g];
    for (int s = 0; s < 2; s++) {
      if (b[s] < -1 || b[s] >= c->n_body) {
        return BASE_FAIL(err, BASE_EINVAL, "group %d: body %d outside 0..%d", g, b[s],
                         c->n_body - 1);
      }
    }
    const int want = rows * (contact_dofs(c, b[0]) + contact_dofs(c, b[1]));
    if (rows < 1 || c->jac_start[g + 1] - c->jac_start[g] != want) {
      return BASE_FAIL(err, BASE_EINVAL, "group %d: %d rows need %d Jacobian entries", g, rows,
                       want);
    }
  }
  if (!all_finite(c->jac, c->jac_start[c->n_group]) || !all_finite(c->u_drift, c->n_row) ||
      !all_finite(c->u_before, c->n_row)) {
    return BASE_FAIL(err, BASE_EINVAL, "jac, u_drift or u_before: not finite");
  }
  return BASE_OK;
}

static base_status check_contact(const contact_set *c, int i, base_error *err) {
  const contact_rows r = c->rows[i];
  const int rows = 1 + r.tangent + r.torsion + r.rolling;
  if (rows != c->row_start[i + 1] - c->row_start[i] || r.tangent > c->dim - 1) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: %d rows declared, %d present", i, rows,
                     c->row_start[i + 1] - c->row_start[i]);
  }
  if (i > 0 && c->id[i - 1] >= c->id[i]) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: ids must increase", i);
  }
  if (!isfinite(c->gap[i]) || !(c->mu_static[i] >= 0.0) || !(c->mu_kinetic[i] >= 0.0) ||
      (r.tangent == 0 && (c->mu_static[i] > 0.0 || c->mu_kinetic[i] > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: gap finite, mu >= 0, tangent rows iff mu > 0",
                     i);
  }
  const double *n = c->frame + (ptrdiff_t)(9 * i);
  if (!(fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0) < 1e-9)) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: normal must be a unit vector", i);
  }
  return BASE_OK;
}

base_status contact_set_check(const contact_set *c, base_error *err) {
  if (!(c->h > 0.0) || !(c->tol >= 0.0) || (c->dim != 2 && c->dim != 3)) {
    return BASE_FAIL(err, BASE_EINVAL, "contact set: need h > 0, tol >= 0, dim 2 or 3");
  }
  BASE_TRY(check_blocks(c, err));
  BASE_TRY(check_groups(c, err));
  for (int i = 0; i < c->n_contact; i++) {
    BASE_TRY(check_contact(c, i, err));
  }
  return BASE_OK;
}

bool contact_set_is_ordered(const contact_set *c) {
  bool good = c->n_contact <= c->n_group && c->row_start[0] == 0 && c->jac_start[0] == 0 &&
              c->row_start[c->n_group] == c->n_row;
  for (int g = 0; g < c->n_group && good; g++) {
    const int *b = c->body + (ptrdiff_t)(2 * g);
    const int rows = c->row_start[g + 1] - c->row_start[g];
    good = rows > 0 && b[0] >= -1 && b[0] < c->n_body && b[1] >= -1 && b[1] < c->n_body &&
           c->jac_start[g + 1] - c->jac_start[g] ==
               rows * (contact_dofs(c, b[0]) + contact_dofs(c, b[1]));
    if (good && g < c->n_contact) {
      const contact_rows r = c->rows[g];
      good = rows == 1 + r.tangent + r.torsion + r.rolling && (g == 0 || c->id[g - 1] < c->id[g]);
    }
  }
  return good;
}

/* u += A v for the rows x n row-major matrix A; returns the end of A. */
static const double *add_product(const double *A, int rows, int n, const double *v, double *u) {
  for (int r = 0; r < rows; r++, A += n) {
    double sum = 0.0;
    for (int k = 0; k < n; k++) {
      sum += A[k] * v[k];
    }
    u[r] += sum;
  }
  return A;
}

typedef struct velocities {
  const contact_set *c;
  const double *v, *u_drift;
  double *u;
} velocities;

/* Of the rows of some groups. */
static void share_velocities(void *of, int part, int hand) {
  const velocities *s = of;
  const contact_set *c = s->c;
  const int end = base_part_end(part, c->n_group, CONTACT_SHARE);
  (void)hand;
  for (int g = part * CONTACT_SHARE; g < end; g++) {
    const int first = c->row_start[g], rows = c->row_start[g + 1] - first;
    const double *jac = c->jac + c->jac_start[g];
    for (int r = first; r < first + rows; r++) {
      s->u[r] = (s->u_drift != NULL) ? s->u_drift[r] : 0.0;
    }
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * g + side];
      if (b >= 0) {
        const int d = c->dof_start[b];
        jac = add_product(jac, rows, c->dof_start[b + 1] - d, s->v + d, s->u + first);
      }
    }
  }
}

void contact_relative_velocity(const contact_set *c, const double *v, const double *u_drift,
                               double *u) {
  velocities s = {.c = c, .v = v, .u_drift = u_drift};
  s.u = u;
  base_share(base_parts(c->n_group, CONTACT_SHARE), share_velocities, &s);
}

/* The Jacobian of row k of contact i for the body of its side s. */
static const double *row_of(const contact_set *c, int i, int k, int s) {
  const int rows = c->row_start[i + 1] - c->row_start[i];
  const int first = (s == 0) ? 0 : contact_dofs(c, c->body[2 * i]);
  const int n = contact_dofs(c, c->body[2 * i + s]);
  return c->jac + c->jac_start[i] + (ptrdiff_t)rows * first + (ptrdiff_t)k * n;
}

void contact_push(const contact_set *c, int i, int k, double impulse, double *v) {
  for (int s = 0; s < 2; s++) {
    const int b = c->body[2 * i + s];
    const int n = contact_dofs(c, b);
    const double *row = row_of(c, i, k, s);
    for (int p = 0; p < n * n; p++) {
      v[c->dof_start[b] + p / n] += c->inv_mass[c->mass_start[b] + p] * row[p % n] * impulse;
    }
  }
}

double contact_coupling(const contact_set *c, int i, int k, int j, int m) {
  double sum = 0.0;
  for (int s = 0; s < 4; s++) {
    const int b = c->body[2 * i + s / 2];
    if (b != c->body[2 * j + s % 2]) {
      continue;
    }
    const int n = contact_dofs(c, b);
    const double *one = row_of(c, i, k, s / 2);
    const double *other = row_of(c, j, m, s % 2);
    for (int p = 0; p < n * n; p++) {
      sum += one[p / n] * c->inv_mass[c->mass_start[b] + p] * other[p % n];
    }
  }
  return sum;
}

int contact_pair_end(const contact_set *c, int first) {
  const int *body = c->body + 2 * (size_t)first;
  int end = first + 1;
  while (end < c->n_contact && c->body[2 * end] == body[0] && c->body[2 * end + 1] == body[1]) {
    end++;
  }
  return end;
}

contact_friction contact_friction_of(const contact_set *c, int first, int end,
                                     const double *impulse) {
  double sum[3] = {0};
  double could = 0.0;
  for (int i = first; i < end; i++) {
    const double *l = impulse + c->row_start[i];
    could += c->mu_static[i] * l[0];
    for (int k = 1; k <= c->rows[i].tangent; k++) {
      v3_add_scaled(sum, l[k], c->frame + 9 * (size_t)i + 3 * (size_t)k, sum);
    }
  }
  return (contact_friction){v3_norm(sum), could};
}

double contact_mobility(const contact_set *c, int i, int k) {
  return contact_coupling(c, i, k, i, k);
}

double contact_free_speed(const contact_set *c, int i) {
  const int rows = c->row_start[i + 1] - c->row_start[i];
  const double *jac = c->jac + c->jac_start[i];
  double u = c->u_drift[c->row_start[i]];
  for (int s = 0; s < 2; s++) {
    const int b = c->body[2 * i + s];
    const int n = contact_dofs(c, b);
    for (int k = 0; k < n; k++) {
      u += jac[k] * c->v_free[c->dof_start[b] + k];
    }
    jac += (ptrdiff_t)rows * n;
  }
  return u;
}

double contact_approach(const contact_set *c) {
  double farthest = 0.0;
  for (int i = 0; i < c->n_contact; i++) {
    const double travel = (c->gap[i] > c->tol) ? -c->h * contact_free_speed(c, i) : 0.0;
    farthest = (c->gap[i] < travel) ? fmax(farthest, travel) : farthest;
  }
  return farthest;
}
