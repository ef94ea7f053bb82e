#include "problems/world/body.h"

#include "problems/vec.h"

static unsigned spec_bit(int axis) {
  return 1u << axis;
}

unsigned body_axes(int dim, unsigned effects) {
  unsigned axes = SPEC_X | SPEC_Y;
  if (dim == 3) {
    axes = ((effects & EFFECT_SPATIAL) != 0) ? (unsigned)(SPEC_X | SPEC_Y | SPEC_Z | SPEC_ROT)
                                             : (unsigned)(SPEC_X | SPEC_Z | SPEC_RY);
  } else {
    axes |= SPEC_RZ;
  }
  return ((effects & EFFECT_ROTATION) != 0) ? axes : axes & ~(unsigned)SPEC_ROT;
}

void body_orient(body *b, int dim) {
  if (dim == 3) {
    quat_matrix(b->quat, b->at.R);
    return;
  }
  const double c = cos(b->angle), s = sin(b->angle);
  const double R[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
  memcpy(b->at.R, R, sizeof R);
}

void body_start(body *b, const spec_body *s, int dim, unsigned effects) {
  v3_copy(s->pos, b->at.x);
  b->angle = s->angle;
  memcpy(b->quat, s->quat, sizeof b->quat);
  if (dim == 3) {
    quat_normalise(b->quat);
  }
  body_orient(b, dim);
  b->mass = s->mass;
  for (int k = 0; k < 3; k++) {
    b->inertia[k] = s->inertia[(dim == 3) ? k : 0];
  }
  const unsigned moves = (effects & EFFECT_MOTION) != 0 ? ~0u : 0u;
  const unsigned exist = body_axes(dim, effects);
  const unsigned driven = moves & (s->kinematic ? ~0u : s->prescribed);
  b->driven = false;
  b->spins = false;
  b->n_dof = 0;
  memset(b->v, 0, sizeof b->v);
  memset(b->driven_v0, 0, sizeof b->driven_v0);
  memset(b->driven_a, 0, sizeof b->driven_a);
  for (int k = 0; k < 6; k++) {
    const double v0 = (k < 3) ? s->vel[k] : s->omega[k - 3];
    if ((driven & spec_bit(k)) != 0) {
      b->driven = true;
      b->driven_v0[k] = s->kinematic ? v0 : s->prescribed_v0[k];
      b->driven_a[k] = s->kinematic ? ((k < 3) ? s->acc[k] : 0.0) : s->prescribed_a[k];
      b->v[k] = b->driven_v0[k];
      b->spins |= k >= 3 && (b->driven_v0[k] != 0.0 || b->driven_a[k] != 0.0);
    } else if (!s->kinematic && (exist & ~(s->lock | s->prescribed) & spec_bit(k)) != 0) {
      b->axis[b->n_dof++] = (unsigned char)k;
      b->v[k] = v0;
      b->spins |= k >= 3;
    }
  }
}

bool body_is_moved(const body *b) {
  bool some = false;
  for (int k = 0; b->driven && k < 6 && !some; k++) {
    some = b->driven_v0[k] != 0.0 || b->driven_a[k] != 0.0;
  }
  return some;
}

void body_driven(const body *b, double t, double v[6]) {
  for (int k = 0; k < 6; k++) {
    v[k] = b->driven_v0[k] + b->driven_a[k] * t;
  }
}

void body_set_velocity(body *b, const double *v, double t) {
  if (b->driven) {
    body_driven(b, t, b->v);
  }
  for (int k = 0; k < b->n_dof; k++) {
    b->v[b->axis[k]] = v[b->dof + k];
  }
}

void body_inertia(const body *b, int dim, double I[9]) {
  if (dim == 3) {
    m3_sandwich(b->at.R, b->inertia, I);
    return;
  }
  memset(I, 0, 9 * sizeof *I);
  I[8] = b->inertia[2];
}

static int n_translations(const body *b) {
  int n = 0;
  while (n < b->n_dof && b->axis[n] < 3) {
    n++;
  }
  return n;
}

/* Inverse of the SPD m x m matrix A, m = 1 or 2. */
static base_status invert_small(const double *A, int m, double *inv, base_error *err) {
  const double det = (m == 1) ? A[0] : A[0] * A[3] - A[1] * A[2];
  if (!(A[0] > 0.0) || !(det > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "inertia: need positive definite, determinant is %g", det);
  }
  inv[0] = ((m == 1) ? 1.0 : A[3]) / det;
  if (m == 2) {
    inv[1] = -A[1] / det;
    inv[2] = -A[2] / det;
    inv[3] = A[0] / det;
  }
  return BASE_OK;
}

base_status body_mass_block(const body *b, int dim, double *mass, double *inverse,
                            base_error *err) {
  const int n = b->n_dof, nt = n_translations(b), nr = n - nt;
  for (int i = 0; i < n * n; i++) {
    mass[i] = 0.0;
    inverse[i] = 0.0;
  }
  for (int i = 0; i < nt; i++) {
    mass[i * n + i] = b->mass;
    inverse[i * n + i] = 1.0 / b->mass;
  }
  if (nr == 0) {
    return BASE_OK;
  }
  double I[9], block[9] = {0}, inv[9] = {0};
  body_inertia(b, dim, I);
  for (int i = 0; i < nr; i++) {
    for (int j = 0; j < nr; j++) {
      block[i * nr + j] = I[3 * (b->axis[nt + i] - 3) + (b->axis[nt + j] - 3)];
    }
  }
  if (nr == 3) { /* R diag(1/I) R': as accurate as the data, whatever the ratio of the moments */
    const double d[3] = {1.0 / b->inertia[0], 1.0 / b->inertia[1], 1.0 / b->inertia[2]};
    m3_sandwich(b->at.R, d, inv);
  } else {
    BASE_TRY(invert_small(block, nr, inv, err));
  }
  for (int i = 0; i < nr; i++) {
    for (int j = 0; j < nr; j++) {
      mass[(nt + j) * n + nt + i] = block[i * nr + j];
      inverse[(nt + j) * n + nt + i] = inv[i * nr + j];
    }
  }
  return BASE_OK;
}

/* Solves I (O+ - O) = h (tau - Om x I Om) for O+ by Newton from O+ = O; body axes. */
static base_status midpoint_spin(const double *inertia, const double *O, const double *tau,
                                 double h, double *next, base_error *err) {
  v3_copy(O, next);
  double last = HUGE_VAL;
  for (int it = 0; it < 50; it++) {
    double m[3], L[3], c[3], res[3], step[3];
    for (int k = 0; k < 3; k++) {
      m[k] = 0.5 * (O[k] + next[k]);
      L[k] = inertia[k] * m[k];
    }
    v3_cross(m, L, c);
    double size = 0.0, scale = 0.0;
    for (int k = 0; k < 3; k++) {
      res[k] = inertia[k] * (next[k] - O[k]) - h * (tau[k] - c[k]);
      size = fmax(size, fabs(res[k]));
      scale = fmax(scale, fmax(fabs(L[k]), fabs(h * tau[k])));
    }
    if (size <= 1e-14 * scale && size >= 0.5 * last) { /* no further progress: round-off */
      return BASE_OK;
    }
    last = size;
    /* d res = I + h/2 (m x I - (I m) x), row-major */
    const double g = 0.5 * h;
    const double A[9] = {inertia[0],
                         g * (-m[2] * inertia[1] + L[2]),
                         g * (m[1] * inertia[2] - L[1]),
                         g * (m[2] * inertia[0] - L[2]),
                         inertia[1],
                         g * (-m[0] * inertia[2] + L[0]),
                         g * (-m[1] * inertia[0] + L[1]),
                         g * (m[0] * inertia[1] - L[0]),
                         inertia[2]};
    if (!m3_solve(A, res, step)) {
      break;
    }
    v3_sub(next, step, next);
  }
  return BASE_FAIL(err, BASE_EUNSUPPORTED,
                   "gyroscopic step: midpoint equation not solved, h |omega| = %.3g is too large",
                   h * v3_norm(O));
}

static base_status spin_free(const body *b, double h, const double *torque, double *w_free,
                             base_error *err) {
  double O[3], tau[3], next[3];
  m3_tmul_vec(b->at.R, b->v + 3, O);
  m3_tmul_vec(b->at.R, torque, tau);
  BASE_TRY(midpoint_spin(b->inertia, O, tau, h, next, err));
  m3_mul_vec(b->at.R, next, w_free);
  return BASE_OK;
}

base_status body_free_velocity(const body *b, int dim, bool gyroscopic, double h,
                               const double *inverse, const double f[6], double *v_free,
                               base_error *err) {
  const int n = b->n_dof, nt = n_translations(b);
  double total[6];
  memcpy(total, f, sizeof total);
  const bool turns = dim == 3 && gyroscopic && n > nt;
  if (turns && n - nt < 3) {
    double I[9], L[3], c[3];
    body_inertia(b, dim, I);
    m3_mul_vec(I, b->v + 3, L);
    v3_cross(b->v + 3, L, c);
    v3_sub(total + 3, c, total + 3);
  }
  for (int i = 0; i < n; i++) {
    double a = 0.0;
    for (int j = 0; j < n; j++) {
      a += inverse[j * n + i] * total[b->axis[j]];
    }
    v_free[i] = b->v[b->axis[i]] + h * a;
  }
  if (turns && n - nt == 3) {
    return spin_free(b, h, f + 3, v_free + nt, err);
  }
  return BASE_OK;
}

void body_move(body *b, int dim, double h) {
  v3_add_scaled(b->at.x, h, b->v, b->at.x);
  if (!b->spins) {
    return;
  }
  if (dim == 3) {
    quat_rotate(b->quat, b->v + 3, h);
  } else {
    b->angle += h * b->v[5];
  }
  body_orient(b, dim);
}

void body_shift(body *b, int dim, double h, const double *shift) {
  double v[6];
  memcpy(v, b->v, sizeof v);
  memset(b->v, 0, sizeof v);
  for (int k = 0; k < b->n_dof; k++) {
    b->v[b->axis[k]] = shift[b->dof + k];
  }
  body_move(b, dim, h);
  memcpy(b->v, v, sizeof v);
}

double body_kinetic(const body *b, int dim) {
  double T = 0.5 * b->mass * v3_dot(b->v, b->v);
  if (dim == 2) {
    return T + 0.5 * b->inertia[2] * b->v[5] * b->v[5];
  }
  double O[3];
  m3_tmul_vec(b->at.R, b->v + 3, O);
  for (int k = 0; k < 3; k++) {
    T += 0.5 * b->inertia[k] * O[k] * O[k];
  }
  return T;
}
