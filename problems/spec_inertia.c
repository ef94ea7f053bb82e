#include "problems/spec.h"

#include <math.h>

/* Second moment of a homogeneous polygon about the origin over its mass (Green's theorem). */
static double polygon_gyration2(const spec_shape *p) {
  double area = 0.0, moment = 0.0;
  for (int i = 0; i < p->n_vertex; i++) {
    const double *a = p->vertex[i], *b = p->vertex[(i + 1) % p->n_vertex];
    const double cross = a[0] * b[1] - a[1] * b[0];
    area += cross;
    moment +=
        cross * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0] + a[1] * a[1] + a[1] * b[1] + b[1] * b[1]);
  }
  return moment / (6.0 * area);
}

static void planar(const spec_shape *p, double mass, double *inertia) {
  const double *a = p->half;
  switch (p->kind) {
  case SPEC_SPHERE: /* disc */
    inertia[0] = mass * p->r * p->r / 2.0;
    break;
  case SPEC_BOX:
    inertia[0] = mass * (a[0] * a[0] + a[1] * a[1]) / 3.0;
    break;
  case SPEC_ROD:
    inertia[0] = mass * a[0] * a[0] / 3.0;
    break;
  default:
    inertia[0] = mass * polygon_gyration2(p);
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
  if (dim == 2) {
    planar(p, mass, inertia);
  } else {
    spatial(p, mass, inertia);
  }
  return BASE_OK;
}
