#include "problems/scenes/kit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void kit_world(scene_spec *s, int dim, double gravity, double duration, double step) {
  s->dim = dim;
  s->gravity[dim - 1] = -gravity;
  s->duration = duration;
  s->n_h = 1;
  s->h[0] = step;
}

base_status kit_floor(scene_spec *s, base_error *err) {
  double normal[3] = {0.0};
  normal[kit_up(s)] = 1.0;
  return spec_add_static(s, "floor", normal, 0.0, NULL, err);
}

base_status kit_wall(scene_spec *s, const char *name, int axis, double side, double at,
                     base_error *err) {
  double normal[3] = {0.0};
  normal[axis] = side;
  return spec_add_static(s, name, normal, side * at, NULL, err);
}

static base_status finish(scene_spec *s, spec_body *b, double mass, const double *pos,
                          spec_body **out, base_error *err) {
  b->mass = mass;
  for (int k = 0; k < s->dim; k++) {
    b->pos[k] = pos[k];
  }
  if (out != NULL) {
    *out = b;
  }
  return spec_solid_inertia(&b->shape, s->dim, mass, b->inertia, err);
}

base_status kit_box(scene_spec *s, const char *name, double mass, const double *half,
                    const double *pos, spec_body **out, base_error *err) {
  spec_body *b;
  BASE_TRY(spec_add_body(s, name, &b, err));
  b->shape.kind = SPEC_BOX;
  for (int k = 0; k < s->dim; k++) {
    b->shape.half[k] = half[k];
  }
  return finish(s, b, mass, pos, out, err);
}

base_status kit_ball(scene_spec *s, const char *name, double mass, double r, const double *pos,
                     spec_body **out, base_error *err) {
  spec_body *b;
  BASE_TRY(spec_add_body(s, name, &b, err));
  b->shape.kind = SPEC_SPHERE;
  b->shape.r = r;
  return finish(s, b, mass, pos, out, err);
}

base_status kit_polygon(scene_spec *s, const char *name, double density, int n,
                        const double (*vertex)[2], spec_body **out, base_error *err) {
  double area = 0.0, c[2] = {0.0, 0.0};
  for (int i = 0; i < n; i++) {
    const double *a = vertex[i], *b = vertex[(i + 1) % n];
    const double cross = a[0] * b[1] - a[1] * b[0];
    area += cross / 2.0;
    c[0] += cross * (a[0] + b[0]) / 6.0;
    c[1] += cross * (a[1] + b[1]) / 6.0;
  }
  if (n > SPEC_VERTICES || !(area > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "polygon '%s': %d vertices of area %g", name, n, area);
  }
  spec_body *b;
  BASE_TRY(spec_add_body(s, name, &b, err));
  b->shape.kind = SPEC_POLYGON;
  BASE_TRY(spec_shape_vertices(&b->shape, n, err));
  const double pos[2] = {c[0] / area, c[1] / area};
  for (int i = 0; i < n; i++) {
    b->shape.vertex[i][0] = vertex[i][0] - pos[0];
    b->shape.vertex[i][1] = vertex[i][1] - pos[1];
  }
  return finish(s, b, density * area, pos, out, err);
}

void kit_turn(spec_body *b, const double axis[3], double angle) {
  const double sine = sin(angle / 2.0);
  b->quat[0] = cos(angle / 2.0);
  for (int k = 0; k < 3; k++) {
    b->quat[k + 1] = sine * axis[k];
  }
}

void kit_source(spec_check *c, const char *text) {
  (void)snprintf(c->source, sizeof c->source, "%s", text);
}

/* NOLINTNEXTLINE(readability-function-size): one argument per column of the tables of scenes */
base_status kit_force(scene_spec *s, const char *a, const char *b, bool tangential, double t0,
                      double t1, double value, double abs, spec_check **out, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_CONTACT_FORCE, NULL, &c, err));
  BASE_TRY(spec_text(c->pair[0].a, SPEC_NAME, a, "pair", err));
  BASE_TRY(spec_text(c->pair[0].b, SPEC_NAME, b, "pair", err));
  c->n_pair = 1;
  c->tangential = tangential;
  c->t0 = t0;
  c->t1 = t1;
  c->value = value;
  c->tol.abs = abs;
  if (out != NULL) {
    *out = c;
  }
  return BASE_OK;
}

base_status kit_drift(scene_spec *s, const char *var, double abs, double h2_coef, spec_check **out,
                      base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_MAX_DRIFT, var, &c, err));
  kit_source(c, "stays where it is");
  c->tol.abs = abs;
  c->tol.h2 = h2_coef;
  if (out != NULL) {
    *out = c;
  }
  return BASE_OK;
}

base_status kit_energy(scene_spec *s, double abs, double h_coef, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_ENERGY_NONINCREASE, NULL, &c, err));
  kit_source(c, "contacts give no energy");
  c->tol.abs = abs;
  c->tol.h = h_coef;
  return BASE_OK;
}

base_status kit_rigid_only(spec_check *c, base_error *err) {
  BASE_TRY(spec_check_only(c, "velocity", err));
  return spec_check_only(c, "position", err);
}

base_status kit_expect(scene_spec *s, const char *var, double t, double value, double h_coef,
                       const char *source, base_error *err) {
  BASE_TRY(spec_add_state(s, var, t, value, 1e-8 * (1.0 + fabs(value)), h_coef, err));
  kit_source(kit_last(s), source);
  return BASE_OK;
}

base_status kit_rests(scene_spec *s, const char *var, double abs, const char *source,
                      base_error *err) {
  BASE_TRY(kit_drift(s, var, abs, 0.0, NULL, err));
  kit_source(kit_last(s), source);
  return kit_rigid_only(kit_last(s), err);
}

base_status kit_moves(scene_spec *s, const char *var, double value, const char *source,
                      base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_MIN_CHANGE, var, &c, err));
  c->t = s->duration;
  c->value = value;
  kit_source(c, source);
  return BASE_OK;
}

base_status kit_finite(scene_spec *s, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_FINITE, NULL, &c, err));
  kit_source(c, "no NaN, no infinity");
  return BASE_OK;
}

base_status kit_penetration(scene_spec *s, double abs, double h_coef, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_MAX_PENETRATION, NULL, &c, err));
  kit_source(c, "bodies do not overlap");
  c->tol.abs = abs;
  c->tol.h = h_coef;
  return BASE_OK;
}

base_status kit_model(scene_spec *s, const struct mech_model *m, const void *param, size_t size,
                      double duration, double step, base_error *err) {
  s->model_param = malloc(size);
  if (s->model_param == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the model");
  }
  memcpy(s->model_param, param, size);
  s->model = m;
  s->model_param_size = size;
  s->duration = duration;
  s->h[0] = step;
  return BASE_OK;
}

void kit_pose(double x, double y, double angle, double pos[3], double quat[4]) {
  pos[0] = x;
  pos[1] = y;
  pos[2] = 0.0;
  quat[0] = cos(angle / 2.0);
  quat[1] = quat[2] = 0.0;
  quat[3] = sin(angle / 2.0);
}

void kit_integrate(double (*f)(double y, double rate, const void *ctx), const void *ctx, double t,
                   double y[2]) {
  enum { STEPS = 20000 };
  const double h = t / STEPS;
  for (int i = 0; i < STEPS; i++) {
    const double a1 = f(y[0], y[1], ctx), v2 = y[1] + 0.5 * h * a1;
    const double a2 = f(y[0] + 0.5 * h * y[1], v2, ctx), v3 = y[1] + 0.5 * h * a2;
    const double a3 = f(y[0] + 0.5 * h * v2, v3, ctx), v4 = y[1] + h * a3;
    const double a4 = f(y[0] + h * v3, v4, ctx);
    y[0] += h / 6.0 * (y[1] + 2.0 * v2 + 2.0 * v3 + v4);
    y[1] += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
}

void kit_name(char name[SPEC_NAME], const char *prefix, int k) {
  (void)snprintf(name, SPEC_NAME, "%s%d", prefix, k);
}
