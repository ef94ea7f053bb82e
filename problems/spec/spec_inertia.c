#include "problems/spec/spec.h"

#include <math.h>

/* Second moment of a homogeneous polygon about the origin over its mass (Green's theorem), and its centroid. */
static double polygon_gyration2(const spec_shape *p, double centroid[2]) {
  double area = 0.0, moment = 0.0;
  centroid[0] = centroid[1] = 0.0;
  for (int i = 0; i < p->n_vertex; i++) {
    const double *a = p->vertex[i], *b = p->vertex[(i + 1) % p->n_vertex];
    const double cross = a[0] * b[1] - a[1] * b[0];
    area += cross;
    centroid[0] += cross * (a[0] + b[0]);
    centroid[1] += cross * (a[1] + b[1]);
    moment +=
        cross * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0] + a[1] * a[1] + a[1] * b[1] + b[1] * b[1]);
  }
  centroid[0] /= 3.0 * area;
  centroid[1] /= 3.0 * area;
  return moment / (6.0 * area);
}

/* Disc cut in two and drawn apart by 2a, a rectangle between; r = 0: a thin rod. */
static double stadium_gyration2(double a, double r) {
  const double pi = 3.14159265358979323846;
  const double bar = 4.0 * a * r, caps = pi * r * r, share = (r > 0.0) ? bar / (bar + caps) : 1.0;
  return share * (a * a + r * r) / 3.0 +
         (1.0 - share) * (r * r / 2.0 + a * a + 2.0 * a * 4.0 * r / (3.0 * pi));
}

static void planar(const spec_shape *p, double mass, double *inertia) {
  const double *a = p->half;
  double centroid[2];
  switch (p->kind) {
  case SPEC_SPHERE: /* disc */
    inertia[0] = mass * p->r * p->r / 2.0;
    break;
  case SPEC_BOX:
    inertia[0] = mass * (a[0] * a[0] + a[1] * a[1]) / 3.0;
    break;
  case SPEC_ROD:
    inertia[0] = mass * stadium_gyration2(a[0], p->r);
    break;
  default:
    inertia[0] = mass * polygon_gyration2(p, centroid);
    break;
  }
}

static void spatial(const spec_shape *p, double mass, double *inertia) {
  const double *a = p->half;
  switch (p->kind) {
  case SPEC_SPHERE:
    inertia[0] = inertia[1] = inertia[2] = 0.4 * mass * p->r * p->r;
    break;
  case SPEC_BOX:
    inertia[0] = mass * (a[1] * a[1] + a[2] * a[2]) / 3.0;
    inertia[1] = mass * (a[0] * a[0] + a[2] * a[2]) / 3.0;
    inertia[2] = mass * (a[0] * a[0] + a[1] * a[1]) / 3.0;
    break;
  case SPEC_ROD: { /* capsule: cylinder of length 2a and two half balls; half_length a > 0 */
    const double r2 = p->r * p->r, l = 2.0 * a[0];
    const double cylinder = mass * l / (l + 4.0 * p->r / 3.0), balls = mass - cylinder;
    inertia[0] = cylinder * r2 / 2.0 + 0.4 * balls * r2;
    inertia[1] = inertia[2] = cylinder * (l * l / 12.0 + r2 / 4.0) +
                              balls * (0.4 * r2 + l * l / 4.0 + 3.0 * l * p->r / 8.0);
    break;
  }
  default: { /* disc, cylinder about body z */
    const double r2 = p->r * p->r;
    inertia[0] = inertia[1] = mass * (r2 / 4.0 + a[2] * a[2] / 3.0);
    inertia[2] = mass * r2 / 2.0;
    break;
  }
  }
}

base_status spec_solid_inertia(const spec_shape *p, int dim, double mass, double inertia[3],
                               base_error *err) {
  const bool thin = p->kind == SPEC_ROD && dim == 3 && !(p->r > 0.0);
  if (p->kind == SPEC_POINT || p->kind == SPEC_COMPOUND || thin) {
    return BASE_FAIL(err, BASE_EINVAL, "inertia: a %s has none of its own, give it",
                     p->kind == SPEC_POINT ? "point"
                     : thin                ? "rod of zero thickness"
                                           : "compound");
  }
  double at[2] = {0.0, 0.0}, size = 0.0;
  if (p->kind == SPEC_POLYGON) {
    size = sqrt(fabs(polygon_gyration2(p, at)));
  }
  if (hypot(at[0], at[1]) > 1e-3 * size) { /* what a shift adds is its square */
    return BASE_FAIL(
        err, BASE_EINVAL,
        "inertia: the centre of the homogeneous polygon is at (%g, %g), that of mass at "
        "(0, 0): give it",
        at[0], at[1]);
  }
  if (dim == 2) {
    planar(p, mass, inertia);
  } else {
    spatial(p, mass, inertia);
  }
  return BASE_OK;
}
