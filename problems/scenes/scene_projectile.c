/* Free flight. */
#include "problems/scenes/kit.h"

typedef struct projectile {
  double speed_x, speed_up, spin, gravity, duration;
  int dim;
} projectile;

static const base_field fields[] = {
    BASE_FIELD(projectile, speed_x, BASE_REAL, "m/s", 3.0, -1e4, 1e4, "initial speed along x"),
    BASE_FIELD(projectile, speed_up, BASE_REAL, "m/s", 4.0, -1e4, 1e4, "initial speed upwards"),
    BASE_FIELD(projectile, spin, BASE_REAL, "rad/s", 2.0, -1e3, 1e3, "initial spin about z"),
    BASE_FIELD(projectile, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(projectile, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(projectile, duration, BASE_REAL, "s", 0.8, 1e-6, 1e4, "time simulated"),
};

/* z = v t - g t^2/2; semi-implicit Euler is off by exactly -g h t/2. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const projectile *p = param;
  const double T = p->duration, g = p->gravity, pos[3] = {0.0};
  const bool flat = p->dim == 2;
  spec_body *b;
  kit_world(s, p->dim, g, T, 0.01);
  BASE_TRY(kit_ball(s, "ball", 0.7, 0.1, pos, &b, err));
  b->vel[0] = p->speed_x;
  b->vel[kit_up(s)] = p->speed_up;
  b->omega[2] = p->spin;
  BASE_TRY(spec_add_observe(s, "ball.pos", err));
  BASE_TRY(kit_expect(s, "ball.x", T, p->speed_x * T, 0.0, "v t", err));
  BASE_TRY(kit_expect(s, flat ? "ball.y" : "ball.z", T, p->speed_up * T - g * T * T / 2.0,
                      0.55 * g * T, "v t - g t^2/2", err));
  BASE_TRY(
      kit_expect(s, flat ? "ball.vy" : "ball.vz", T, p->speed_up - g * T, 0.0, "v - g t", err));
  return kit_expect(s, flat ? "ball.omega" : "ball.omega.z", T, p->spin, 0.0, "spin stays", err);
}

KIT_SCENE(projectile, "free flight", "galilei1638",
          "A spinning ball in flight without contact: velocities are exact for every step, the "
          "height is off by exactly g h t/2 in semi-implicit Euler, so an error in the integrator "
          "shows before any contact does (MATHEMATICS S1).",
          .situation = SITUATION_OTHER);
