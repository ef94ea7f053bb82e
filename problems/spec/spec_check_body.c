/* Bodies, their shapes and half-spaces of a scene: positive sizes and masses, convex polygons, inertias
 * that a body can have. */
#include "problems/spec/spec_check.h"
#include "problems/vec.h"

#define BAD(...) BASE_FAIL(err, BASE_EINVAL, __VA_ARGS__)

static bool same_point(const double *a, const double *b) {
  return a[0] == b[0] && a[1] == b[1];
}

/* Every vertex lies on the left of every edge or in line with it, which an outline that crosses itself does
 * not do; not all lie in one line, and none is there twice, as in an outline that goes round twice. */
static bool is_convex(const spec_shape *p) {
  double most = 0.0;
  for (int i = 0; i < p->n_vertex; i++) {
    const double *a = p->vertex[i], *b = p->vertex[(i + 1) % p->n_vertex];
    for (int k = 1; k < p->n_vertex; k++) {
      const double *c = p->vertex[(i + k) % p->n_vertex];
      const double left = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
      if (left < 0.0 || same_point(a, c)) {
        return false;
      }
      most = fmax(most, left);
    }
  }
  return most > 0.0;
}

static base_status check_polygon(const scene_spec *s, const spec_body *b, const spec_shape *p,
                                 base_error *err) {
  if (s->dim != 2) {
    return BAD("scene '%s': body '%s': a polygon is planar, dim is %d", s->id, b->name, s->dim);
  }
  if (p->n_vertex < 3 || p->n_vertex > SPEC_VERTICES) {
    return BAD("scene '%s': body '%s': polygon needs 3 to %d vertices, has %d", s->id, b->name,
               SPEC_VERTICES, p->n_vertex);
  }
  for (int i = 0; i < p->n_vertex; i++) {
    if (!spec_all_finite(p->vertex[i], 2)) {
      return BAD("scene '%s': body '%s': vertex %d is not finite", s->id, b->name, i + 1);
    }
  }
  if (!is_convex(p)) {
    return BAD(
        "scene '%s': body '%s': polygon must be convex, counter-clockwise, once round, without "
        "repeated vertices",
        s->id, b->name);
  }
  return BASE_OK;
}

static bool is_unit_quat(const double *q) {
  return fabs(quat_norm(q) - 1.0) <= 1e-6; /* false for what is not finite */
}

static base_status check_extent(const scene_spec *s, const spec_body *b, const char *what,
                                double value, base_error *err) {
  if (!(value > 0.0) || !isfinite(value)) {
    return BAD("scene '%s': body '%s': shape %s = %g, need a finite value > 0", s->id, b->name,
               what, value);
  }
  return BASE_OK;
}

static base_status check_shape(const scene_spec *s, const spec_body *b, const spec_shape *p,
                               bool is_part, base_error *err);

static base_status check_parts(const scene_spec *s, const spec_body *b, const spec_shape *p,
                               base_error *err) {
  if (p->n_part < 1 || p->n_part > SPEC_PARTS) {
    return BAD("scene '%s': body '%s': compound needs 1 to %d parts, has %d", s->id, b->name,
               SPEC_PARTS, p->n_part);
  }
  for (int i = 0; i < p->n_part; i++) {
    if (!spec_all_finite(p->part[i].pos, 3) || !is_unit_quat(p->part[i].quat)) {
      return BAD("scene '%s': body '%s': part %d needs a finite position and a quat of length 1",
                 s->id, b->name, i + 1);
    }
    if (!(p->part[i].compliance >= 0.0) || !isfinite(p->part[i].compliance)) {
      return BAD("scene '%s': body '%s': part %d: compliance = %g, need a finite value >= 0", s->id,
                 b->name, i + 1, p->part[i].compliance);
    }
    BASE_TRY(check_shape(s, b, &p->part[i].shape, true, err));
  }
  return BASE_OK;
}

static base_status check_shape(const scene_spec *s, const spec_body *b, const spec_shape *p,
                               bool is_part, base_error *err) {
  switch (p->kind) {
  case SPEC_POINT:
    return BASE_OK;
  case SPEC_SPHERE:
    return check_extent(s, b, "r", p->r, err);
  case SPEC_BOX:
    for (int k = 0; k < s->dim; k++) {
      BASE_TRY(check_extent(s, b, "half", p->half[k], err));
    }
    return BASE_OK;
  case SPEC_ROD:
    if (!(p->r >= 0.0) || !isfinite(p->r)) {
      return BAD("scene '%s': body '%s': rod r = %g, need >= 0", s->id, b->name, p->r);
    }
    return check_extent(s, b, "half_length", p->half[0], err);
  case SPEC_DISC3D:
    if (s->dim != 3 || !(p->half[2] >= 0.0) || !isfinite(p->half[2])) {
      return BAD("scene '%s': body '%s': disc3d or cylinder needs dim 3 and half height >= 0",
                 s->id, b->name);
    }
    return check_extent(s, b, "r", p->r, err);
  case SPEC_POLYGON:
    return check_polygon(s, b, p, err);
  case SPEC_COMPOUND:
    if (is_part) {
      return BAD("scene '%s': body '%s': a compound inside a compound", s->id, b->name);
    }
    return check_parts(s, b, p, err);
  }
  return BAD("scene '%s': body '%s': unknown shape %d", s->id, b->name, (int)p->kind);
}

static base_status check_inertia(const scene_spec *s, const spec_body *b, base_error *err) {
  const double *I = b->inertia;
  const int n = (s->dim == 2) ? 1 : 3;
  for (int k = 0; k < n; k++) {
    if (!(I[k] > 0.0) || !isfinite(I[k])) {
      return BAD("scene '%s': body '%s': inertia = %g, need a finite value > 0", s->id, b->name,
                 I[k]);
    }
  }
  const double slack = 1.0 + 1e-12; /* a flat body meets the bound with equality */
  if (n == 3 && (I[0] > (I[1] + I[2]) * slack || I[1] > (I[0] + I[2]) * slack ||
                 I[2] > (I[0] + I[1]) * slack)) {
    return BAD("scene '%s': body '%s': inertia (%g, %g, %g): each moment is at most the sum of "
               "the others",
               s->id, b->name, I[0], I[1], I[2]);
  }
  return BASE_OK;
}

base_status spec_check_body(const scene_spec *s, const spec_body *b, base_error *err) {
  const bool fine = spec_all_finite(b->pos, 3) && spec_all_finite(b->quat, 4) &&
                    isfinite(b->angle) && spec_all_finite(b->vel, 3) &&
                    spec_all_finite(b->omega, 3) && spec_all_finite(b->acc, 3) &&
                    spec_all_finite(b->prescribed_v0, 6) && spec_all_finite(b->prescribed_a, 6);
  if (!fine) {
    return BAD("scene '%s': body '%s': position, velocity or motion is not finite", s->id, b->name);
  }
  if (!is_unit_quat(b->quat)) {
    return BAD("scene '%s': body '%s': quat has length %g, need 1", s->id, b->name,
               quat_norm(b->quat));
  }
  if (!(b->mass > 0.0) || !isfinite(b->mass)) {
    return BAD("scene '%s': body '%s': mass = %g, need a finite value > 0", s->id, b->name,
               b->mass);
  }
  if (!(b->compliance > 0.0) || !isfinite(b->compliance)) {
    return BAD("scene '%s': body '%s': compliance = %g, need a finite value > 0", s->id, b->name,
               b->compliance);
  }
  BASE_TRY(check_shape(s, b, &b->shape, false, err));
  if (!b->kinematic && spec_can_rotate(s, b)) {
    BASE_TRY(check_inertia(s, b, err));
  }
  const double *w = b->prescribed_v0 + 3, *alpha = b->prescribed_a + 3;
  double turn[3];
  v3_cross(w, alpha, turn);
  if (v3_norm(turn) > 1e-12 * v3_norm(w) * v3_norm(alpha)) {
    return BAD(
        "scene '%s': body '%s': prescribed rotation needs an axis that stands still: v0 and a "
        "along one line",
        s->id, b->name);
  }
  if (b->kinematic && b->prescribed != 0) {
    return BAD("scene '%s': body '%s': both kinematic and prescribed", s->id, b->name);
  }
  if (b->kinematic && (b->lock & (SPEC_X | SPEC_Y | SPEC_Z)) != 0) {
    return BAD("scene '%s': body '%s': a kinematic body has no dofs to lock", s->id, b->name);
  }
  if ((b->lock & b->prescribed) != 0) {
    return BAD("scene '%s': body '%s': a dof is both locked and prescribed", s->id, b->name);
  }
  const unsigned allowed =
      (s->dim == 2) ? (SPEC_X | SPEC_Y | SPEC_RZ) : (SPEC_X | SPEC_Y | SPEC_Z | SPEC_ROT);
  if (((b->lock | b->prescribed) & ~allowed) != 0) {
    return BAD("scene '%s': body '%s': lock or prescribed names a dof absent in dim %d", s->id,
               b->name, s->dim);
  }
  return BASE_OK;
}

base_status spec_check_static(const scene_spec *s, const spec_static *p, base_error *err) {
  const double length = v3_norm(p->normal);
  if (!spec_all_finite(p->normal, 3) || !(fabs(length - 1.0) <= 1e-6)) {
    return BAD("scene '%s': static '%s': normal has length %g, need 1", s->id, p->name, length);
  }
  if (!isfinite(p->offset) || !spec_all_finite(p->surface_velocity, 3)) {
    return BAD("scene '%s': static '%s': offset or surface velocity is not finite", s->id, p->name);
  }
  if (!(p->compliance >= 0.0) || !isfinite(p->compliance)) {
    return BAD("scene '%s': static '%s': compliance = %g, need a finite value >= 0", s->id, p->name,
               p->compliance);
  }
  return BASE_OK;
}
