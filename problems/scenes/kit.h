/* problems/scenes/kit.h - what built-in scenes are made of. The vertical axis is y in the plane and
 * z in space (the last one); solids get the inertia of their shape. */
#pragma once

#include "problems/scenes/scene.h"

#include <math.h>

#define KIT_PI 3.14159265358979323846

static inline double kit_radians(double degrees) {
  return degrees * (KIT_PI / 180.0);
}

/* Sets dim, gravity along the vertical axis [m/s^2], duration [s] and one step [s]. */
void kit_world(scene_spec *s, int dim, double gravity, double duration, double step);

/* "axis of the vertical": 1 or 2. */
static inline int kit_up(const scene_spec *s) {
  return s->dim - 1;
}

base_status kit_floor(scene_spec *s, base_error *err); /* half-space "floor" at height 0 */

/* Vertical plane through `at` along axis (0, 1), free on the side `side` (+1, -1) points to. */
base_status kit_wall(scene_spec *s, const char *name, int axis, double side, double at,
                     base_error *err);

/* half, pos: dim entries; *out may be NULL. */
base_status kit_box(scene_spec *s, const char *name, double mass, const double *half,
                    const double *pos, spec_body **out, base_error *err);
base_status kit_ball(scene_spec *s, const char *name, double mass, double r, const double *pos,
                     spec_body **out, base_error *err);

/* Planar rod or polygon about its centre; vertices are shifted so that the centroid is the origin,
 * `pos` is where that centroid then is (NULL: where the vertices put it). */
base_status kit_polygon(scene_spec *s, const char *name, double density, int n,
                        const double (*vertex)[2], spec_body **out, base_error *err);

/* Turns a body about the axis (unit) by angle [rad]; planar: about z. */
void kit_turn(spec_body *b, const double axis[3], double angle);

/* Checks; tolerance |got - value| <= abs + h_coef h. */
base_status kit_force(scene_spec *s, const char *a, const char *b, bool tangential, double t0,
                      double t1, double value, double abs, spec_check **out, base_error *err);
base_status kit_drift(scene_spec *s, const char *var, double abs, double h2_coef, spec_check **out,
                      base_error *err);
base_status kit_energy(scene_spec *s, double abs, double h_coef, base_error *err);
/* Restricts a check to the two formulations with rigid friction, "velocity" and "position". */
base_status kit_rigid_only(spec_check *c, base_error *err);
void kit_source(spec_check *c, const char *text);

/* State check with |got - value| <= 1e-8 (1 + |value|) + h_coef h. */
base_status kit_expect(scene_spec *s, const char *var, double t, double value, double h_coef,
                       const char *source, base_error *err);
/* No motion of var beyond abs, for the formulations with rigid friction. */
base_status kit_rests(scene_spec *s, const char *var, double abs, const char *source,
                      base_error *err);
/* Moves: |var(T) - var(0)| >= value. */
base_status kit_moves(scene_spec *s, const char *var, double value, const char *source,
                      base_error *err);
base_status kit_finite(scene_spec *s, base_error *err);
/* No bodies leave through others: penetration <= abs + h_coef h. */
base_status kit_penetration(scene_spec *s, double abs, double h_coef, base_error *err);

/* The scene is a mechanism in generalised coordinates: model, and a copy of its parameters. */
base_status kit_model(scene_spec *s, const struct mech_model *m, const void *param, size_t size,
                      double duration, double step, base_error *err);
/* Pose of a planar part: centre (x, y), angle. */
void kit_pose(double x, double y, double angle, double pos[3], double quat[4]);

/* The check added last. */
static inline spec_check *kit_last(scene_spec *s) {
  return &s->check[s->n_check - 1];
}

/* y'' = f(y, y') from y[2] = {y, y'} over time t by 20000 classical Runge-Kutta steps: the
 * references of scenes without a closed form (error far below every tolerance). */
void kit_integrate(double (*f)(double y, double rate, const void *ctx), const void *ctx, double t,
                   double y[2]);

/* A scene's constant: its parameters are the fields of struct TYPE; after the text follow its other
 * members, of which `.situation = SITUATION_...` is not left out. */
#define KIT_SCENE(TYPE, title_, cite_, about_, ...)                                                \
  const scene scene_##TYPE = {.name = #TYPE,                                                       \
                              .title = title_,                                                     \
                              .cite = cite_,                                                       \
                              .about = about_,                                                     \
                              .fields = fields,                                                    \
                              .n_fields = BASE_COUNT(fields),                                      \
                              .param_size = sizeof(TYPE),                                          \
                              .build = build,                                                      \
                              __VA_ARGS__}

/* The members of a planar mech_model that the files of both mechanisms call the same: `dofs` and `parts` name its
 * coordinates and its drawn bodies. */
#define KIT_PLANAR_MODEL                                                                           \
  .dim = 2, .n_dof = BASE_COUNT(dofs), .dof_name = dofs, .start = start, .mass = mass,             \
  .force = force, .potential = potential, .contact = contact, .gap = gap,                          \
  .n_body = BASE_COUNT(parts), .body_name = parts, .half = half, .pose = pose, .place = place

/* "PREFIXk" */
void kit_name(char name[SPEC_NAME], const char *prefix, int k);
