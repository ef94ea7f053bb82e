/* Block on a movable wedge. */
#include "problems/scenes/kit.h"

typedef struct wedge {
  double theta_deg, mass_block, mass_wedge, gravity;
} wedge;

static const base_field fields[] = {
    BASE_FIELD(wedge, theta_deg, BASE_REAL, "deg", 30.0, 5.0, 60.0, "angle of the wedge"),
    BASE_FIELD(wedge, mass_block, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of the block"),
    BASE_FIELD(wedge, mass_wedge, BASE_REAL, "kg", 3.0, 1e-6, 1e6, "mass of the wedge"),
    BASE_FIELD(wedge, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Wedge m g sin cos/(M + m sin^2) backwards; the block (M g sin cos, -(M+m) g sin^2)/(M + m sin^2). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const wedge *p = param;
  const double th = kit_radians(p->theta_deg), m = p->mass_block, M = p->mass_wedge;
  const double sine = sin(th), cosine = cos(th), D = M + m * sine * sine, g = p->gravity;
  const double base = 2.0, height = base * tan(th), T = sqrt(0.9 / (g * sine)) * 0.8;
  const double corners[3][2] = {{0.0, 0.0}, {base, 0.0}, {0.0, height}};
  const double half[2] = {0.15, 0.1};
  const double pos[2] = {0.4 * base + half[1] * sine, 0.6 * height + half[1] * cosine};
  spec_body *b;
  spec_check *c;
  kit_world(s, 2, g, T, 0.01);
  BASE_TRY(kit_polygon(s, "wedge", M / (0.5 * base * height), 3, corners, &b, err));
  b->lock = SPEC_RZ;
  BASE_TRY(kit_box(s, "block", m, half, pos, &b, err));
  b->angle = -th;
  b->lock = SPEC_RZ;
  BASE_TRY(kit_floor(s, err));
  s->effects = EFFECT_CONTACT;
  BASE_TRY(spec_add_observe(s, "wedge.vx", err));
  BASE_TRY(kit_expect(s, "wedge.vx", T, -m * g * sine * cosine / D * T, 2.0,
                      "-m g sin cos/(M + m sin^2) T", err));
  BASE_TRY(kit_expect(s, "block.vx", T, M * g * sine * cosine / D * T, 2.0,
                      "M g sin cos/(M + m sin^2) T", err));
  BASE_TRY(kit_expect(s, "block.vy", T, -(M + m) * g * sine * sine / D * T, 2.0,
                      "-(M+m) g sin^2/(M + m sin^2) T", err));
  BASE_TRY(spec_add_check(s, CHECK_MOMENTUM_X, NULL, &c, err));
  kit_source(c, "no force from outside along x");
  c->t = T;
  c->tol.abs = 1e-8 * (m + M);
  return BASE_OK;
}

KIT_SCENE(wedge, "block on a movable wedge", "lagrange1788",
          "A frictionless block slides down a wedge that is pushed away on a smooth floor; both "
          "accelerations are constant and momentum along the floor stays zero (MATHEMATICS S8).",
          .situation = SITUATION_GRASP);
