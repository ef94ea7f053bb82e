/* The woodpecker toy. */
#include "problems/scenes/kit.h"
#include "problems/world/model.h"

typedef struct woodpecker {
  double mu, restitution, duration, step;
} woodpecker;

static const base_field fields[] = {
    BASE_FIELD(woodpecker, mu, BASE_REAL, "1", 0.3, 0.0, 5.0, "friction of sleeve and beak"),
    BASE_FIELD(woodpecker, restitution, BASE_REAL, "1", 0.5, 0.0, 1.0, "of the beak"),
    BASE_FIELD(woodpecker, duration, BASE_REAL, "s", 0.3, 1e-4, 100.0, "time simulated"),
    BASE_FIELD(woodpecker, step, BASE_REAL, "s", 2e-5, 1e-8, 1e-2, "step length"),
};

/* Data of Glocker & Studer (2005): masses [kg], inertias [kg m^2], lengths [m]; M: sleeve,
 * S: woodpecker. */
static const double g = 9.81, mM = 3e-4, mS = 4.5e-3, JM = 5e-9, JS = 7e-7, spring = 0.0056;
static const double rO = 2.5e-3, rM = 3.1e-3, hM = 5.8e-3, lM = 10e-3, lG = 15e-3, hS = 20e-3,
                    lS = 20.1e-3;

static void start(const void *param, double *q, double *v) {
  static const double q0[3] = {0.0, -0.1036, -0.2788}, v0[3] = {-0.3411, 0.0, -7.4583};
  (void)param;
  for (int i = 0; i < 3; i++) {
    q[i] = q0[i];
    v[i] = v0[i];
  }
}

static void mass(const void *param, const double *q, double *M) {
  const double m[9] = {mS + mM,      mS * lM, mS * lG,      mS * lM,          JM + mS * lM * lM,
                       mS * lM * lG, mS * lG, mS * lM * lG, JS + mS * lG * lG};
  (void)param;
  (void)q;
  for (int i = 0; i < 9; i++) {
    M[i] = m[i];
  }
}

static void force(const void *param, double t, const double *q, const double *v, double *f) {
  const double pull = spring * (q[1] - q[2]);
  (void)param;
  (void)t;
  (void)v;
  f[0] = -g * (mS + mM);
  f[1] = -g * mS * lM - pull;
  f[2] = -g * mS * lG + pull;
}

static double potential(const void *param, double t, const double *q) {
  (void)param;
  (void)t;
  return g * ((mS + mM) * q[0] + mS * lM * q[1] + mS * lG * q[2]) +
         0.5 * spring * (q[1] - q[2]) * (q[1] - q[2]);
}

static void contact(const void *param, int i, mech_contact *out) {
  static const char *const names[] = {"beak", "sleeve_top", "sleeve_bottom"};
  const woodpecker *p = param;
  *out = (mech_contact){names[i], "pole", p->mu, (i == 0) ? p->restitution : 0.0};
}

/* Beak against the pole, sleeve jammed in either direction. */
static void gap(const void *param, const double *q, int i, double *value, double *jn, double *jt) {
  const double gaps[3] = {lM + lG - lS - rO - hS * q[2], rM - rO + hM * q[1], rM - rO - hM * q[1]};
  const double n[3][3] = {{0, 0, -hS}, {0, hM, 0}, {0, -hM, 0}};
  const double t[3][3] = {{1, lM, lG - lS}, {1, rM, 0}, {1, rM, 0}};
  (void)param;
  *value = gaps[i];
  for (int k = 0; k < 3; k++) {
    jn[k] = n[i][k];
    jt[k] = t[i][k];
  }
}

/* ---- pictures: the pole, the sleeve around it, the bird on its spring */

static const char *const parts[] = {"pole", "sleeve", "spring", "bird", "beak"};

static void half(const void *param, int part, double size[2]) {
  static const double sizes[][2] = {
      {2.5e-3, 50e-3}, {3.1e-3, 5.8e-3}, {0.5 * 25e-3, 0.4e-3}, {4e-3, 22e-3}, {10e-3, 1.2e-3}};
  (void)param;
  size[0] = sizes[part][0];
  size[1] = sizes[part][1];
}

static void pose(const void *param, const double *q, int part, double pos[3], double quat[4]) {
  const double bird = lM + lG; /* of the bird's centre from the pole */
  const double y = q[0] + lM * q[1];
  const double at[5][3] = {{0.0, -20e-3, 0.0},
                           {0.0, q[0], q[1]},
                           {bird / 2.0, y + lG / 2.0 * q[2], q[2]},
                           {bird, y + lG * q[2], q[2]},
                           {bird - lS + 10e-3 - hS * q[2], y + lG * q[2] + hS, q[2]}};
  (void)param;
  kit_pose(at[part][0], at[part][1], at[part][2], pos, quat);
}

static void place(const void *param, const double *q, int i, double point[3], double normal[3],
                  double tangent[3]) {
  const double heights[3] = {q[0] + lM * q[1] + lG * q[2] + hS, q[0] - hM, q[0] + hM};
  (void)param;
  point[0] = rO;
  point[1] = heights[i];
  normal[0] = tangent[1] = 1.0;
  normal[1] = tangent[0] = 0.0;
}

static const char *const dofs[] = {"y", "phi_M", "phi_S"};
static const mech_model model = {.name = "woodpecker", .n_contact = 3, KIT_PLANAR_MODEL};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const woodpecker *p = param;
  BASE_TRY(kit_model(s, &model, p, sizeof *p, p->duration, p->step, err));
  s->effects =
      EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_LOADS;
  BASE_TRY(spec_add_observe(s, "y", err));
  BASE_TRY(spec_add_observe(s, "phi_S", err));
  /* one and two cycles of 0.1461 s in a stored run of another code (Siconos, theta = 1/2) */
  static const double t[] = {0.146, 0.292}, y[] = {-1.946946e-2, -3.892131e-2};
  for (int i = 0; i < 2 && p->mu == 0.3 && p->restitution == 0.5 && t[i] <= p->duration; i++) {
    BASE_TRY(spec_add_state(s, "y", t[i], y[i], 2e-4, 5.0, err));
    kit_source(kit_last(s), "19.5 mm a cycle of 0.1461 s (Glocker & Studer 2005; Siconos)");
    BASE_TRY(spec_check_only(kit_last(s), "velocity", err));
    BASE_TRY(spec_check_only(kit_last(s), "coulomb", err));
  }
  return kit_finite(s, err);
}

KIT_SCENE(
    woodpecker, "woodpecker toy", "glocker2005",
    "A woodpecker on a spring slides down a pole in a limit cycle of jamming, slipping and "
    "beak impacts: three generalised coordinates, three frictional contacts with impacts, "
    "period 0.1461 s and 19.5 mm a cycle. The best comparison with another code (MATHEMATICS B9).",
    .situation = SITUATION_IMPACT);
