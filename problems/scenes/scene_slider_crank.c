/* Slider-crank with clearance. */
#include "problems/scenes/kit.h"
#include "problems/world/model.h"

typedef struct slider_crank {
  double clearance, restitution, mu, duration, step;
} slider_crank;

static const base_field fields[] = {
    BASE_FIELD(slider_crank, clearance, BASE_REAL, "m", 0.001, 1e-6, 0.02, "slider to guide"),
    BASE_FIELD(slider_crank, restitution, BASE_REAL, "1", 0.4, 0.0, 1.0, "of slider and guide"),
    BASE_FIELD(slider_crank, mu, BASE_REAL, "1", 0.01, 0.0, 5.0, "friction of slider and guide"),
    BASE_FIELD(slider_crank, duration, BASE_REAL, "s", 0.02, 1e-5, 10.0, "time simulated"),
    BASE_FIELD(slider_crank, step, BASE_REAL, "s", 1e-5, 1e-8, 1e-3, "step length"),
};

/* Flores, Leine & Glocker (2010): crank, rod [m], half length and height of the slider; masses,
 * inertias about the centres. Angles to the guide's axis. */
static const double g = 9.81, l1 = 0.153, l2 = 0.306, a = 0.05, b = 0.025;
static const double m1 = 0.038, m2 = 0.038, m3 = 0.076, J1 = 7.4e-5, J2 = 5.9e-4, J3 = 2.7e-6;

static void start(const void *param, double *q, double *v) {
  static const double v0[3] = {150.0, -75.0, -0.01};
  (void)param;
  for (int i = 0; i < 3; i++) {
    q[i] = 0.0;
    v[i] = v0[i];
  }
}

static double coupling(void) {
  return (0.5 * m2 + m3) * l1 * l2;
}

static void mass(const void *param, const double *q, double *M) {
  (void)param;
  for (int i = 0; i < 9; i++) {
    M[i] = 0.0;
  }
  M[0] = J1 + (0.25 * m1 + m2 + m3) * l1 * l1;
  M[4] = J2 + (0.25 * m2 + m3) * l2 * l2;
  M[8] = J3;
  M[1] = M[3] = coupling() * cos(q[0] - q[1]);
}

static void force(const void *param, double t, const double *q, const double *v, double *f) {
  const double s = coupling() * sin(q[0] - q[1]);
  (void)param;
  (void)t;
  f[0] = -s * v[1] * v[1] - (0.5 * m1 + m2 + m3) * g * l1 * cos(q[0]);
  f[1] = s * v[0] * v[0] - (0.5 * m2 + m3) * g * l2 * cos(q[1]);
  f[2] = 0.0;
}

static double potential(const void *param, double t, const double *q) {
  (void)param;
  (void)t;
  return g * ((0.5 * m1 + m2 + m3) * l1 * sin(q[0]) + (0.5 * m2 + m3) * l2 * sin(q[1]));
}

static void contact(const void *param, int i, mech_contact *out) {
  static const char *const names[] = {"corner0", "corner1", "corner2", "corner3"};
  const slider_crank *p = param;
  *out = (mech_contact){names[i], "guide", p->mu, p->restitution};
}

/* Corner (side along, level across) of the slider, centre at l1 e(q0) + l2 e(q1); the guide spans
 * +-(b + clearance). */
static void gap(const void *param, const double *q, int i, double *value, double *jn, double *jt) {
  const slider_crank *p = param;
  const double x = (i % 2 == 0) ? -a : a, level = (i < 2) ? 1.0 : -1.0, y = level * b;
  const double s3 = sin(q[2]), c3 = cos(q[2]);
  const double height = l1 * sin(q[0]) + l2 * sin(q[1]) + x * s3 + y * c3;
  *value = b + p->clearance - level * height;
  jn[0] = -level * l1 * cos(q[0]);
  jn[1] = -level * l2 * cos(q[1]);
  jn[2] = -level * (x * c3 - y * s3);
  jt[0] = -l1 * sin(q[0]);
  jt[1] = -l2 * sin(q[1]);
  jt[2] = -x * s3 - y * c3;
}

/* ---- pictures */

static const char *const parts[] = {"crank", "rod", "slider", "upper", "lower"};

static void half(const void *param, int part, double size[2]) {
  static const double sizes[][2] = {
      {0.5 * 0.153, 0.006}, {0.5 * 0.306, 0.006}, {0.05, 0.025}, {0.35, 0.004}, {0.35, 0.004}};
  (void)param;
  size[0] = sizes[part][0];
  size[1] = sizes[part][1];
}

static void pose(const void *param, const double *q, int part, double pos[3], double quat[4]) {
  const slider_crank *p = param;
  const double x1 = l1 * cos(q[0]), y1 = l1 * sin(q[0]);
  const double x2 = l2 * cos(q[1]), y2 = l2 * sin(q[1]), wall = b + p->clearance + 0.004;
  const double at[5][3] = {{x1 / 2.0, y1 / 2.0, q[0]},
                           {x1 + x2 / 2.0, y1 + y2 / 2.0, q[1]},
                           {x1 + x2, y1 + y2, q[2]},
                           {0.35, wall, 0.0},
                           {0.35, -wall, 0.0}};
  kit_pose(at[part][0], at[part][1], at[part][2], pos, quat);
}

static void place(const void *param, const double *q, int i, double point[3], double normal[3],
                  double tangent[3]) {
  const double x = (i % 2 == 0) ? -a : a, level = (i < 2) ? 1.0 : -1.0, y = level * b;
  (void)param;
  point[0] = l1 * cos(q[0]) + l2 * cos(q[1]) + x * cos(q[2]) - y * sin(q[2]);
  point[1] = l1 * sin(q[0]) + l2 * sin(q[1]) + x * sin(q[2]) + y * cos(q[2]);
  normal[0] = tangent[1] = 0.0;
  normal[1] = -level;
  tangent[0] = 1.0;
}

static const char *const dofs[] = {"theta1", "theta2", "theta3"};
static const mech_model model = {.name = "slider_crank", .n_contact = 4, KIT_PLANAR_MODEL};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const slider_crank *p = param;
  BASE_TRY(kit_model(s, &model, p, sizeof *p, p->duration, p->step, err));
  s->effects = EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_RESTITUTION;
  BASE_TRY(spec_add_observe(s, "theta1", err));
  BASE_TRY(spec_add_observe(s, "theta3", err));
  BASE_TRY(kit_finite(s, err));
  /* kinetic energy about 25 J; nothing drives it */
  BASE_TRY(kit_energy(s, 1e-3, 1e4, err));
  return kit_penetration(s, 1e-6, 30.0, err);
}

KIT_SCENE(slider_crank, "slider-crank with clearance", "flores2010",
          "A crank at 150 rad/s drives a slider with play in its guide: three coordinates with a "
          "configuration-dependent mass matrix, four corners that hit and slide. No closed form; "
          "energy must not grow beyond the integrator's error and the slider must stay in its "
          "guide (MATHEMATICS B10).",
          .situation = SITUATION_IMPACT);
