/* problems/spec/spec.h - a scene as data: bodies, contacts' coefficients, loads, joints, declared
 * effects, and what theory says must come out. Built-in scenes fill one in C, scene files (the
 * case format, JSON or YAML) are read into one: everything downstream sees only this. */
#pragma once

#include "lcp/base/status.h"
#include "problems/spec/effects.h"

#include <stdbool.h>
#include <stddef.h>

enum {
  SPEC_NAME = 32,
  SPEC_VERTICES = 32,
  SPEC_PARTS = 8,
  SPEC_FORMS = 9,
  SPEC_PAIRS = 8,
  SPEC_STEPS = 8,
  SPEC_OBSERVE = 16,
  SPEC_COPIES = 256 /* of a contact point */
};

#define SPEC_ANY "*" /* in a pair of a check; no name of a body */

typedef enum spec_shape_kind {
  SPEC_POINT,
  SPEC_SPHERE, /* disc in 2D; r */
  SPEC_BOX,    /* half[dim] */
  SPEC_ROD,    /* segment of zero thickness along body x, contact at its ends; half[0]; r > 0:
                  capsule */
  SPEC_DISC3D, /* thin disc, axis = body z; r (r and half[2] > 0: cylinder) */
  SPEC_POLYGON,
  SPEC_COMPOUND,
} spec_shape_kind;

typedef struct spec_shape {
  spec_shape_kind kind;
  double r;            /* [m] */
  double half[3];      /* [m] */
  int n_vertex;        /* SPEC_POLYGON: convex, counter-clockwise, body frame */
  double (*vertex)[2]; /* n_vertex; owned [m] */
  int n_part;          /* SPEC_COMPOUND: owned, parts with their own pose */
  struct spec_part *part;
} spec_shape;

typedef struct spec_part {
  spec_shape shape;
  double pos[3], quat[4]; /* in the body frame */
  double compliance;      /* [m/N] > 0; 0: that of the body */
} spec_part;

/* Bits of spec_body.lock and .prescribed: translations, then rotations (planar: only SPEC_RZ). */
enum { SPEC_X = 1, SPEC_Y = 2, SPEC_Z = 4, SPEC_RX = 8, SPEC_RY = 16, SPEC_RZ = 32, SPEC_ROT = 56 };

typedef struct spec_body {
  char name[SPEC_NAME];
  spec_shape shape;
  double mass;       /* [kg] > 0 */
  double inertia[3]; /* planar: [0] about the centre of mass; spatial: principal moments [kg m^2] */
  double pos[3];     /* centre of mass [m] */
  double quat[4];    /* w, x, y, z; planar: rotation by angle about z */
  double angle;      /* planar [rad] */
  double vel[3], omega[3]; /* [m/s], [rad/s] world frame; planar: omega[2] */
  unsigned lock;           /* dofs removed */
  unsigned prescribed;     /* dofs driven with prescribed_v0 + prescribed_a t */
  double prescribed_v0[6], prescribed_a[6];
  bool kinematic; /* infinite mass, velocity vel + acc t, omega constant */
  double acc[3];
  double compliance; /* of its surface [m/N] > 0, where redundant contacts press */
} spec_body;

typedef struct spec_static {
  char name[SPEC_NAME];
  double normal[3]; /* unit; half-space normal . x >= offset is free */
  double offset;    /* [m] */
  double surface_velocity[3];
  double compliance; /* of its surface [m/N] >= 0 */
} spec_static;

typedef struct spec_pair {
  char a[SPEC_NAME], b[SPEC_NAME];
  double value;
} spec_pair;

/* A coefficient with a default and exceptions by pair of names. */
typedef struct spec_coefficient {
  double dflt;
  int n_pair;
  spec_pair *pair;
} spec_coefficient;

typedef enum spec_load_kind {
  SPEC_FORCE,       /* constant force (and torque) */
  SPEC_FORCE_RAMP,  /* rate * t * dir */
  SPEC_FORCE_SINE,  /* dir * amplitude * sin(omega t + phase) */
  SPEC_SPRING,      /* to an anchor moving as anchor0 + anchor_vel t: -k (x - anchor).dir dir
                       - c xdot.dir dir */
  SPEC_SPRING_PAIR, /* between two bodies' centres or offsets: stiffness k, damping c, rest length */
  SPEC_TORSION_SPRING, /* -k (angle - rest) - c omega about z (planar) */
} spec_load_kind;

typedef struct spec_load {
  spec_load_kind kind;
  int body, other; /* indices; other = -1 */
  double force[3], torque[3];
  double dir[3], rate; /* rate [N/s], or amplitude [N] */
  double k, c, rest;   /* [N/m], [N s/m], [m] */
  double anchor[3], anchor_vel[3], offset[3], other_offset[3];
  double omega, phase; /* [rad/s], [rad] */
} spec_load;

typedef enum spec_joint_kind {
  SPEC_BALL, /* pin in 2D */
  SPEC_HINGE,
  SPEC_SLIDER,
  SPEC_FIXED,
  SPEC_DISTANCE,
} spec_joint_kind;

typedef struct spec_joint {
  spec_joint_kind kind;
  char name[SPEC_NAME];
  int body, other;        /* other = -1: the world */
  double anchor[3];       /* world point at t = 0 [m]; SPEC_DISTANCE: on `body` */
  double other_anchor[3]; /* SPEC_DISTANCE only */
  double axis[3];         /* hinge, slider: world axis at t = 0 */
} spec_joint;

/* ---- what must come out -------------------------------------------------------------------- */

#define SPEC_CHECK_LIST(X)                                                                         \
  X(CHECK_STATE, "state")                                                                          \
  X(CHECK_STATE_AFTER_STEPS, "state_after_steps")                                                  \
  X(CHECK_MAX_DRIFT, "max_drift")                                                                  \
  X(CHECK_WINDOW_MAX, "window_max")                                                                \
  X(CHECK_WINDOW_MIN, "window_min")                                                                \
  X(CHECK_MIN_CHANGE, "min_change")                                                                \
  X(CHECK_MAX_PENETRATION, "max_penetration")                                                      \
  X(CHECK_CONTACT_FORCE, "contact_force")                                                          \
  X(CHECK_CONTACT_FORCE_SUM, "contact_force_sum")                                                  \
  X(CHECK_EVENT_TIME, "event_time")                                                                \
  X(CHECK_ENERGY_NONINCREASE, "energy_nonincrease")                                                \
  X(CHECK_ENERGY_GROWTH_REL, "energy_growth_rel")                                                  \
  X(CHECK_ENERGY_DRIFT_REL, "energy_drift_rel")                                                    \
  X(CHECK_ANGULAR_MOMENTUM_DRIFT_REL, "angular_momentum_drift_rel")                                \
  X(CHECK_MOMENTUM_X, "momentum_x")                                                                \
  X(CHECK_FINITE, "finite")                                                                        \
  X(CHECK_MAX_SPEED, "max_speed")                                                                  \
  X(CHECK_STATIC_DEFLECTION, "static_deflection")                                                  \
  X(CHECK_BRISTLE_DEFLECTION, "tangential_bristle_deflection")

#define SPEC_CHECK_ENUM_(id, text) id,
typedef enum spec_check_kind { SPEC_CHECK_LIST(SPEC_CHECK_ENUM_) CHECK_COUNT } spec_check_kind;
const char *spec_check_name(spec_check_kind k);

typedef enum spec_event {
  EVENT_FIRST_CONTACT,
  EVENT_STOP,        /* |var| <= threshold */
  EVENT_START,       /* |var| >= threshold */
  EVENT_LEAVE,       /* last contact of the pair */
  EVENT_SIGN_CHANGE, /* of var */
} spec_event;

/* |value - expected| <= abs + h_coef h + h2_coef h^2  (+ inv_h / h)
 *   and for the regularised form + reg_h h + reg_v v_s + reg_d delta. */
typedef struct spec_tolerance {
  double abs, h, h2, inv_h;
  double reg_h, reg_v, reg_d;
  double rel;
} spec_tolerance;

typedef struct spec_check {
  spec_check_kind kind;
  char var[2 * SPEC_NAME]; /* "body.quantity" as scene_observe understands it; "" if unused */
  bool has_dir;
  double dir[3];    /* component of a vector quantity */
  double t, t0, t1; /* [s]; t1 = HUGE_VAL: the end */
  int n;            /* steps */
  double value, dvalue_dh;
  spec_tolerance tol;
  int n_form; /* 0: every formulation */
  char form[SPEC_FORMS][SPEC_NAME];
  int nd; /* facets this check was made for; 0: any */
  int n_pair;
  spec_pair pair[SPEC_PAIRS]; /* contact pairs, value unused; b = SPEC_ANY: all that touch a */
  bool tangential;            /* component of the force */
  spec_event event;
  double threshold;
  char source[160]; /* formula, reference or remark */
} spec_check;

/* What the scene must give when one effect is switched off. */
typedef struct spec_off {
  unsigned effect;
  spec_check check;
} spec_off;

/* Painleve: the sliding contact's normal acceleration is p N + b (MATHEMATICS 2.3.8). */
typedef struct spec_acceleration {
  bool given;
  double p, b, mu_crit;
  char regime[SPEC_NAME]; /* slip, flight, inconsistent, indeterminate */
} spec_acceleration;

typedef struct scene_spec {
  char id[64];
  char title[160];
  char formula[320];
  char note[320]; /* remark or source */
  int dim;
  double gravity[3];
  unsigned effects; /* declared: what the scene calls for, EFFECT_ bits */
  bool declares;    /* also where `effects` is 0: nothing but what the data bring with them */
  unsigned present; /* what occurs in the data, needed or not; set by spec_check_all */
  int n_body;
  spec_body *body; /* owned, as all arrays below */
  int n_static;
  spec_static *fixed;
  spec_coefficient friction, friction_kinetic, restitution, rolling, torsion;
  /* friction_kinetic.dflt < 0: same as static */
  int n_load;
  spec_load *load;
  int n_joint;
  spec_joint *joint;
  int n_no_collision;
  spec_pair *no_collision;
  int contact_multiplicity; /* >= 1: every contact point listed that often */
  double duration;          /* T [s] */
  int n_h;
  double h[SPEC_STEPS]; /* steps at which it is judged; {0.01} where none is given */
  int facets;           /* nd the checks were made for; 0: any */
  int order;            /* order of convergence in h */
  int n_not_applicable;
  char not_applicable[SPEC_FORMS][SPEC_NAME];
  int n_check;
  spec_check *check;
  int n_off;
  spec_off *off;
  bool expect_unsolved;     /* the honest end is "infeasible" or "unsolved" */
  bool is_long;             /* too many steps for a quick run */
  double contact_stiffness; /* normal compliance 1/k instead of a rigid contact [N/m]; 0: rigid */
  spec_acceleration acceleration; /* regime of the acceleration-level problem at t = 0 */
  double sweep_rate;              /* known convergence rate of Gauss-Seidel sweeps; 0: unknown */
  double sweeps_to_1e6;           /* sweeps to reduce the error by 1e6; 0: unknown */
  int n_observe;                  /* quantities to report; 0: those of the checks */
  char observe[SPEC_OBSERVE][2 * SPEC_NAME];
  const struct mech_model *model; /* generalised coordinates in C (woodpecker, ...); NULL */
  void *model_param;              /* owned, freed with free(); plain data without pointers */
  size_t model_param_size;        /* [bytes]; 0: none */
} scene_spec;

/* An empty spec with defaults (dim 2, no gravity, multiplicity 1, one step 0.01, friction_kinetic
 * follows static). */
void spec_init(scene_spec *s);
void spec_free(scene_spec *s); /* accepts a partly built one */
base_status spec_copy(const scene_spec *from, scene_spec *to, base_error *err);

/* Room for n vertices of a polygon, all zero; BASE_ENOMEM without memory. */
base_status spec_shape_vertices(spec_shape *p, int n, base_error *err);

/* Growing arrays; the returned item is zeroed and valid until the next call. */
base_status spec_add_body(scene_spec *s, const char *name, spec_body **out, base_error *err);
base_status spec_add_static(scene_spec *s, const char *name, const double *normal, double offset,
                            spec_static **out, base_error *err);
base_status spec_add_load(scene_spec *s, spec_load **out, base_error *err);
base_status spec_add_joint(scene_spec *s, const char *name, spec_joint **out, base_error *err);
base_status spec_add_check(scene_spec *s, spec_check_kind kind, const char *var, spec_check **out,
                           base_error *err);
base_status spec_add_pair(spec_coefficient *c, const char *a, const char *b, double value,
                          base_error *err);
/* Does a load change with time, whatever the bodies do: a ramp, one that swings, the anchor of a spring that moves? */
bool spec_loads_vary(const scene_spec *s);
int spec_find_body(const scene_spec *s, const char *name); /* -1 if absent */

/* A state check |var(t) - value| <= abs + h_coef h, the commonest kind. */
base_status spec_add_state(scene_spec *s, const char *var, double t, double value, double abs,
                           double h_coef, base_error *err);
base_status spec_add_off(scene_spec *s, unsigned effect_bit, const char *var, double t,
                         double value, double abs, double h_coef, base_error *err);
base_status spec_add_no_collision(scene_spec *s, const char *a, const char *b, base_error *err);
base_status spec_add_observe(scene_spec *s, const char *var, base_error *err);
/* Restricts a check to a formulation (may be called again for another one). */
base_status spec_check_only(spec_check *c, const char *formulation, base_error *err);
/* Copies a name or text into a fixed buffer; refuses what does not fit. */
base_status spec_text(char *to, size_t cap, const char *from, const char *what, base_error *err);

/* Names the culprit and the rule: positive finite masses and inertias, unit-able normals, known
 * names in pairs, loads and checks, no empty scene, T > 0, ... Also derives `effects` where the
 * scene does not declare them (bit set iff something of it occurs). */
base_status spec_check_all(scene_spec *s, base_error *err);

/* Part of spec_check_all: sets `present`, and `effects` to what is declared (no declaration: all
 * that is present). Gravity, joints, loads, motion and the dimension belong to the data and always
 * count as declared; a rotating body that is not round always is gyroscopic. */
base_status spec_settle_effects(scene_spec *s, base_error *err);

/* Moments of inertia of a homogeneous solid of that shape and mass (planar: [0] per the disc, box,
 * rod, polygon about its centroid, which must be the origin of its vertices). Compounds and points
 * have none of their own: BASE_EINVAL. */
base_status spec_solid_inertia(const spec_shape *p, int dim, double mass, double inertia[3],
                               base_error *err);

/* Does the check list this word among its `forms`? */
bool spec_check_names(const spec_check *c, const char *word);

/* Does the check apply to this formulation at these facets (0: no facets)? It does where it lists no
 * forms, or the formulation, or the one that it stands for ("": none). */
bool spec_check_applies(const spec_check *c, const char *formulation, const char *stands_for,
                        int facets);
