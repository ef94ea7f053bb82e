/* world_joints.c - bilateral rows.
 *
 *   ball      p_a = p_b                                   (planar: pin)
 *   hinge     ball, and the two axes parallel             (planar: ball)
 *   fixed     ball, and no relative rotation
 *   slider    p_a on the line through p_b along the axis of side b, no relative rotation
 *   distance  |p_a - p_b| = length
 * Side b is the world when it is -1. `curve` is (dJ/dt) v of a row: the rate of its velocity while all
 * velocities v stay; rows across an axis turn with body b. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <stdlib.h>

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static void frame_of(const world *w, int b, double x[3], double R[9], double *angle) {
  if (b < 0) {
    memset(x, 0, 3 * sizeof *x);
    memcpy(R, identity, sizeof identity);
    *angle = 0.0;
    return;
  }
  v3_copy(w->body[b].at.x, x);
  memcpy(R, w->body[b].at.R, 9 * sizeof *R);
  *angle = w->body[b].angle;
}

static void to_local(const world *w, int b, const double *point, double *local) {
  double x[3], R[9], d[3], angle;
  frame_of(w, b, x, R, &angle);
  v3_sub(point, x, d);
  m3_tmul_vec(R, d, local);
}

static base_status start_one(const world *w, const spec_joint *s, joint_data *j, base_error *err) {
  if (s->body < 0 || s->body >= w->n_body || s->other >= w->n_body || s->other == s->body) {
    return BASE_FAIL(err, BASE_EINVAL, "joint %.32s: needs two different bodies, or one and world",
                     s->name);
  }
  double xa[3], xb[3], Ra[9], Rb[9], angle_a, angle_b, axis[3];
  *j = (joint_data){.kind = s->kind, .a = s->body, .b = s->other};
  frame_of(w, j->a, xa, Ra, &angle_a);
  frame_of(w, j->b, xb, Rb, &angle_b);
  to_local(w, j->a, s->anchor, j->anchor_a);
  to_local(w, j->b, (s->kind == SPEC_DISTANCE) ? s->other_anchor : s->anchor, j->anchor_b);
  if (s->kind == SPEC_DISTANCE) {
    double d[3];
    v3_sub(s->anchor, s->other_anchor, d);
    j->length = v3_norm(d);
    if (!(j->length > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL, "joint %.32s: anchors of a distance joint coincide",
                       s->name);
    }
  }
  if (s->kind == SPEC_SLIDER || (s->kind == SPEC_HINGE && w->dim == 3)) {
    const double length = v3_norm(s->axis);
    if (!(length > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL, "joint %.32s: needs an axis", s->name);
    }
    v3_scale(1.0 / length, s->axis, axis);
    m3_tmul_vec(Ra, axis, j->axis_a);
    m3_tmul_vec(Rb, axis, j->axis_b);
  }
  double Rbt[9];
  for (int i = 0; i < 9; i++) {
    Rbt[i] = Rb[3 * (i % 3) + i / 3];
  }
  m3_mul(Rbt, Ra, j->relative);
  if (w->dim == 2) {
    j->relative[0] = angle_a - angle_b;
  }
  return BASE_OK;
}

base_status joints_start(world *w, base_error *err) {
  if (!world_has(w, EFFECT_JOINTS)) {
    w->n_joint = 0;
    return BASE_OK;
  }
  for (int i = 0; i < w->spec.n_joint; i++) {
    BASE_TRY(start_one(w, &w->spec.joint[i], &w->joint[i], err));
  }
  w->n_joint = w->spec.n_joint;
  return BASE_OK;
}

/* Two unit vectors across `axis`; planar: the in-plane one first. */
static void across(const double *axis, int dim, double *u, double *v) {
  if (dim == 2) {
    u[0] = -axis[1], u[1] = axis[0], u[2] = 0.0;
    v[0] = v[1] = 0.0, v[2] = 1.0;
    return;
  }
  v3_perpendicular(axis, u);
  v3_cross(axis, u, v);
}

typedef struct joint_place {
  double pa[3], pb[3], Ra[9], Rb[9], angle_a, angle_b, d[3];
  double xb[3], vb[3]; /* of the centre of b */
  double wa[3], wb[3]; /* angular velocities */
  double va_p[3];      /* velocity of a's point p_a */
  double turn_a[3];    /* w_a x (w_a x arm_a), what turning adds to its rate */
} joint_place;

static void place_joint(const world *w, const joint_data *j, joint_place *p) {
  double xa[3] = {0}, xb[3] = {0};
  *p = (joint_place){0};
  frame_of(w, j->a, xa, p->Ra, &p->angle_a);
  frame_of(w, j->b, xb, p->Rb, &p->angle_b);
  m3_mul_vec(p->Ra, j->anchor_a, p->pa);
  v3_add_scaled(xa, 1.0, p->pa, p->pa);
  m3_mul_vec(p->Rb, j->anchor_b, p->pb);
  v3_add_scaled(xb, 1.0, p->pb, p->pb);
  v3_sub(p->pa, p->pb, p->d);
  const body *a = &w->body[j->a];
  double arm[3], spun[3];
  v3_copy(a->v + 3, p->wa);
  v3_sub(p->pa, xa, arm);
  v3_cross(p->wa, arm, spun);
  v3_add_scaled(a->v, 1.0, spun, p->va_p);
  v3_cross(p->wa, spun, p->turn_a);
  v3_copy(xb, p->xb);
  if (j->b >= 0) {
    v3_copy(w->body[j->b].v, p->vb);
    v3_copy(w->body[j->b].v + 3, p->wb);
  }
}

/* Velocity of b's matter at the world point x. */
static void matter_of_b(const joint_place *p, const double *x, double *v) {
  double arm[3], spun[3];
  v3_sub(x, p->xb, arm);
  v3_cross(p->wb, arm, spun);
  v3_add_scaled(p->vb, 1.0, spun, v);
}

/* Relative rotation of a against b since the start, as a world vector (exact for any angle below
 * pi is not needed: joints keep it small); planar: about z. */
static void rotation_error(const world *w, const joint_data *j, const joint_place *p, double *e) {
  if (w->dim == 2) {
    e[0] = e[1] = 0.0;
    e[2] = p->angle_a - p->angle_b - j->relative[0];
    return;
  }
  double target[9], E[9], Rt[9];
  m3_mul(p->Rb, j->relative, target);
  for (int i = 0; i < 9; i++) {
    Rt[i] = target[3 * (i % 3) + i / 3];
  }
  m3_mul(p->Ra, Rt, E); /* = 1 for no error; its skew part is sin(angle) axis */
  e[0] = 0.5 * (E[7] - E[5]);
  e[1] = 0.5 * (E[2] - E[6]);
  e[2] = 0.5 * (E[3] - E[1]);
}

static void add_row(joint_row *row, int *n, const double *d, const double *pa, const double *pb,
                    bool angular, double error, double curve) {
  joint_row *r = &row[(*n)++];
  v3_copy(d, r->d);
  v3_copy(pa, r->p_a);
  v3_copy(pb, r->p_b);
  r->angular = angular;
  r->error = error;
  r->curve = curve;
}

/* d . (v_a(p_a) - v_b(p)), where side b is felt at p, which moves at p_rate; d turns at d_rate. */
static double point_curve(const joint_place *p, const double *d, const double *d_rate,
                          const double *at, const double *p_rate) {
  double v[3], turn_b[3];
  v3_sub(p_rate, p->vb, v);
  v3_cross(p->wb, v, turn_b);
  const double turned = v3_dot(d, p->turn_a) - v3_dot(d, turn_b);
  if (d_rate == NULL) {
    return turned;
  }
  matter_of_b(p, at, v);
  v3_sub(p->va_p, v, v);
  return turned + v3_dot(d_rate, v);
}

static void point_rows(const world *w, const joint_place *p, joint_row *row, int *n) {
  double vb_p[3];
  matter_of_b(p, p->pb, vb_p);
  for (int k = 0; k < w->dim; k++) {
    const double *d = identity + 3 * (ptrdiff_t)k;
    add_row(row, n, d, p->pa, p->pb, false, p->d[k], point_curve(p, d, NULL, p->pb, vb_p));
  }
}

static void rotation_rows(const world *w, const joint_data *j, const joint_place *p, joint_row *row,
                          int *n) {
  double e[3];
  rotation_error(w, j, p, e);
  for (int k = (w->dim == 3) ? 0 : 2; k < 3; k++) {
    add_row(row, n, identity + 3 * (ptrdiff_t)k, p->pa, p->pb, true, e[k], 0.0);
  }
}

/* One of the two rows of a hinge that keep its axes parallel; u, across the axis, turns with b. */
static void axis_row(const joint_place *p, const double *u, const double *c, joint_row *row,
                     int *n) {
  double u_rate[3], w[3];
  v3_cross(p->wb, u, u_rate);
  v3_sub(p->wa, p->wb, w);
  add_row(row, n, u, p->pa, p->pb, true, v3_dot(c, u), v3_dot(u_rate, w));
}

/* One of the rows of a slider: u, across the line, turns with b, and both sides are felt at p_a. */
static void line_row(const joint_place *p, const double *u, joint_row *row, int *n) {
  double u_rate[3];
  v3_cross(p->wb, u, u_rate);
  add_row(row, n, u, p->pa, p->pa, false, v3_dot(p->d, u),
          point_curve(p, u, u_rate, p->pa, p->va_p));
}

/* The row of a distance joint: u = d/|d|, whose rate is the part of d' across it over |d|. */
static void length_row(const joint_data *j, const joint_place *p, joint_row *row, int *n) {
  const double far = v3_norm(p->d);
  double u[3], u_rate[3], v[3], vb_p[3];
  v3_scale((far > 0.0) ? 1.0 / far : 0.0, p->d, u);
  matter_of_b(p, p->pb, vb_p);
  v3_sub(p->va_p, vb_p, v);
  v3_scale((far > 0.0) ? 1.0 / far : 0.0, v, u_rate);
  v3_add_scaled(u_rate, -v3_dot(u_rate, u), u, u_rate);
  add_row(row, n, u, p->pa, p->pb, false, far - j->length, point_curve(p, u, u_rate, p->pb, vb_p));
}

int joint_rows(const world *w, const joint_data *j, joint_row *row) {
  joint_place p;
  double axis_a[3] = {0}, axis_b[3] = {0}, u[3] = {0}, v[3] = {0}, c[3];
  int n = 0;
  place_joint(w, j, &p);
  switch (j->kind) {
  case SPEC_BALL:
    point_rows(w, &p, row, &n);
    break;
  case SPEC_FIXED:
    point_rows(w, &p, row, &n);
    rotation_rows(w, j, &p, row, &n);
    break;
  case SPEC_HINGE:
    point_rows(w, &p, row, &n);
    if (w->dim == 3) {
      m3_mul_vec(p.Ra, j->axis_a, axis_a);
      m3_mul_vec(p.Rb, j->axis_b, axis_b);
      across(axis_b, 3, u, v);
      v3_cross(axis_b, axis_a, c); /* rotation that brought b's axis to a's */
      axis_row(&p, u, c, row, &n);
      axis_row(&p, v, c, row, &n);
    }
    break;
  case SPEC_SLIDER:
    m3_mul_vec(p.Rb, j->axis_b, axis_b);
    across(axis_b, w->dim, u, v);
    line_row(&p, u, row, &n);
    if (w->dim == 3) {
      line_row(&p, v, row, &n);
    }
    rotation_rows(w, j, &p, row, &n);
    break;
  case SPEC_DISTANCE:
    length_row(j, &p, row, &n);
    break;
  }
  return n;
}
