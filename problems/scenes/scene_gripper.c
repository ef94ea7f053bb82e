/* Parallel gripper. */
#include "problems/scenes/kit.h"

typedef struct gripper {
  double squeeze, mu, mass, lift, gravity, duration;
  int dim, facets;
} gripper;

static const base_field fields[] = {
    BASE_FIELD(gripper, squeeze, BASE_REAL, "N", 20.0, 1e-6, 1e9, "force of each finger"),
    BASE_FIELD(gripper, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(gripper, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass of the object"),
    BASE_FIELD(gripper, lift, BASE_REAL, "m/s^2", 1.0, 0.0, 1e3, "acceleration of the fingers up"),
    BASE_FIELD(gripper, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(gripper, facets, BASE_INT, "1", 4, 4, 64,
               "facets the prediction for polyhedral cones is made for (3D)"),
    BASE_FIELD(gripper, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(gripper, duration, BASE_REAL, "s", 0.3, 1e-3, 1e3, "time simulated"),
};

static base_status add_finger(scene_spec *s, const gripper *p, const char *name, double side,
                              base_error *err) {
  const double half[3] = {0.05, 0.3, 0.3}, pos[3] = {0.15 * side, 0.0, 0.0};
  const int up = kit_up(s);
  spec_body *b;
  spec_load *l;
  BASE_TRY(kit_box(s, name, 1.0, half, pos, &b, err));
  b->lock = (p->dim == 2) ? SPEC_RZ : (SPEC_ROT | SPEC_Y);
  b->prescribed = 1u << up;
  b->prescribed_a[up] = p->lift;
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE;
  l->body = spec_find_body(s, name);
  l->force[0] = -side * p->squeeze;
  return BASE_OK;
}

/* Holds iff 2 mu F k >= m (g + a); else the object moves with 2 mu F k/m - g. k = 1 on a circular
 * cone; on an nd-gon the vertical lies between facets: k = cos(pi/nd)/cos(90 deg mod 2pi/nd -
 * pi/nd) (MATHEMATICS S2). */
static base_status predict(scene_spec *s, const gripper *p, double share, bool polyhedral,
                           base_error *err) {
  const double hold = 2.0 * p->mu * p->squeeze * share / p->mass - p->gravity;
  const double a = fmin(p->lift, hold), T = p->duration;
  const char *z = (p->dim == 2) ? "object.y" : "object.z";
  BASE_TRY(kit_expect(
      s, z, T, a * T * T / 2.0, fabs(a) * T + 0.2,
      polyhedral ? "polyhedral capacity 2 mu F cos(pi/nd)/cos(..)" : "capacity 2 mu F", err));
  kit_last(s)->nd = polyhedral ? p->facets : 0;
  kit_last(s)->tol.reg_h = 0.6 * p->gravity;
  kit_last(s)->tol.reg_v = 2.0 * T;
  if (polyhedral) {
    return kit_rigid_only(kit_last(s), err);
  }
  BASE_TRY(spec_check_only(kit_last(s), "coulomb", err));
  BASE_TRY(spec_check_only(kit_last(s), "regularized", err));
  return (p->dim == 2) ? kit_rigid_only(kit_last(s), err) : BASE_OK;
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const gripper *p = param;
  const double half[3] = {0.1, 0.1, 0.1}, pos[3] = {0.0};
  const double step = 2.0 * KIT_PI / p->facets;
  const double share = cos(KIT_PI / p->facets) / cos(fmod(KIT_PI / 2.0, step) - KIT_PI / p->facets);
  spec_body *b;
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  BASE_TRY(kit_box(s, "object", p->mass, half, pos, &b, err));
  b->lock = (p->dim == 2) ? SPEC_RZ : SPEC_ROT;
  BASE_TRY(add_finger(s, p, "left", -1.0, err));
  BASE_TRY(add_finger(s, p, "right", 1.0, err));
  BASE_TRY(spec_add_no_collision(s, "left", "right", err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, (p->dim == 2) ? "object.y" : "object.z", err));
  BASE_TRY(predict(s, p, 1.0, false, err));
  if (p->dim == 3) {
    BASE_TRY(predict(s, p, share, true, err));
  }
  BASE_TRY(kit_force(s, "object", "left", false, p->duration / 2.0, p->duration, p->squeeze,
                     1e-5 * p->squeeze, NULL, err));
  kit_source(kit_last(s), "squeeze");
  return kit_rigid_only(kit_last(s), err);
}

KIT_SCENE(
    gripper, "parallel gripper lifts an object", "mason1985",
    "Two fingers press an object and lift it: it holds if and only if 2 mu F >= m (g + a). In "
    "3D a polyhedral cone loses up to 1 - cos(pi/nd) of that capacity when the load lies "
    "between facets, and drops what a circular cone holds; a viscous regularisation creeps "
    "(MATHEMATICS B14).",
    .situation = SITUATION_GRASP);
