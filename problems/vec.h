/* problems/vec.h - vectors of three, rotation matrices (row-major, world = R local) and unit
 * quaternions (w, x, y, z). Planar scenes use the same with z = 0. */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <string.h>

static inline double v3_dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void v3_cross(const double *a, const double *b, double *c) {
  const double x = a[1] * b[2] - a[2] * b[1];
  const double y = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
  c[0] = x;
  c[1] = y;
}

static inline void v3_sub(const double *a, const double *b, double *c) {
  c[0] = a[0] - b[0];
  c[1] = a[1] - b[1];
  c[2] = a[2] - b[2];
}

/* c = a + s b */
static inline void v3_add_scaled(const double *a, double s, const double *b, double *c) {
  c[0] = a[0] + s * b[0];
  c[1] = a[1] + s * b[1];
  c[2] = a[2] + s * b[2];
}

static inline void v3_scale(double s, const double *a, double *c) {
  c[0] = s * a[0];
  c[1] = s * a[1];
  c[2] = s * a[2];
}

static inline void v3_copy(const double *a, double *c) {
  memcpy(c, a, 3 * sizeof *c);
}

static inline double v3_norm(const double *a) {
  return sqrt(v3_dot(a, a));
}

/* Is a along the unit vector n, either way, but for `slack` of its length? */
static inline bool v3_along(const double *a, const double *n, double slack) {
  return fabs(v3_dot(n, a)) > (1.0 - slack) * v3_norm(a);
}

/* A unit vector at right angles to the unit vector d: across the x axis, or y where d is near x. */
static inline void v3_perpendicular(const double *d, double *out) {
  const double e[3] = {fabs(d[0]) <= 0.7, fabs(d[0]) > 0.7, 0.0};
  v3_cross(d, e, out);
  v3_scale(1.0 / v3_norm(out), out, out);
}

static inline void m3_mul_vec(const double *R, const double *x, double *y) {
  const double a = v3_dot(R, x);
  const double b = v3_dot(R + 3, x);
  y[2] = v3_dot(R + 6, x);
  y[0] = a;
  y[1] = b;
}

/* y = R' x */
static inline void m3_tmul_vec(const double *R, const double *x, double *y) {
  const double a = R[0] * x[0] + R[3] * x[1] + R[6] * x[2];
  const double b = R[1] * x[0] + R[4] * x[1] + R[7] * x[2];
  y[2] = R[2] * x[0] + R[5] * x[1] + R[8] * x[2];
  y[0] = a;
  y[1] = b;
}

/* C = A B, no aliasing */
static inline void m3_mul(const double *A, const double *B, double *C) {
  for (int i = 0; i < 3; i++, A += 3, C += 3) {
    for (int j = 0; j < 3; j++) {
      C[j] = A[0] * B[j] + A[1] * B[3 + j] + A[2] * B[6 + j];
    }
  }
}

/* S = R diag(d) R', exactly symmetric */
static inline void m3_sandwich(const double *R, const double *d, double *S) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j <= i; j++) {
      double s = 0.0;
      for (int k = 0; k < 3; k++) {
        s += R[3 * i + k] * d[k] * R[3 * j + k];
      }
      S[3 * i + j] = s;
      S[3 * j + i] = s;
    }
  }
}

/* Solves A x = b for a general 3 x 3 matrix by Cramer's rule; false if A is singular. */
static inline int m3_solve(const double *A, const double *b, double *x) {
  double c0[3], c1[3], c2[3]; /* cross products of the rows give the adjugate */
  v3_cross(A + 3, A + 6, c0);
  v3_cross(A + 6, A, c1);
  v3_cross(A, A + 3, c2);
  const double det = v3_dot(A, c0);
  if (!(fabs(det) > 0.0)) {
    return 0;
  }
  for (int i = 0; i < 3; i++) {
    x[i] = (b[0] * c0[i] + b[1] * c1[i] + b[2] * c2[i]) / det;
  }
  return 1;
}

static inline void quat_matrix(const double *q, double *R) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  R[0] = 1.0 - 2.0 * (y * y + z * z);
  R[1] = 2.0 * (x * y - w * z);
  R[2] = 2.0 * (x * z + w * y);
  R[3] = 2.0 * (x * y + w * z);
  R[4] = 1.0 - 2.0 * (x * x + z * z);
  R[5] = 2.0 * (y * z - w * x);
  R[6] = 2.0 * (x * z - w * y);
  R[7] = 2.0 * (y * z + w * x);
  R[8] = 1.0 - 2.0 * (x * x + y * y);
}

/* c = a b (Hamilton), no aliasing */
static inline void quat_mul(const double *a, const double *b, double *c) {
  c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static inline double quat_norm(const double *q) {
  return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

static inline void quat_normalise(double *q) {
  const double n = quat_norm(q);
  for (int i = 0; i < 4; i++) {
    q[i] /= n;
  }
}

/* q <- exp(h w / 2) q: rotation by the constant world angular velocity w over h, exact. */
static inline void quat_rotate(double *q, const double *w, double h) {
  const double speed = v3_norm(w);
  const double half = 0.5 * h * speed;
  /* sin(half)/speed without dividing by zero */
  const double s = (half > 1e-8 || half < -1e-8) ? sin(half) / speed : 0.5 * h;
  const double d[4] = {cos(half), s * w[0], s * w[1], s * w[2]};
  double r[4];
  quat_mul(d, q, r);
  quat_normalise(r);
  memcpy(q, r, sizeof r);
}
