/* problems/world/world_data.h - what the files world*.c share. Not for other layers. */
#pragma once

#include "problems/geometry/broad_phase.h"
#include "problems/world/body.h"
#include "problems/world/model.h"
#include "problems/world/pair_table.h"
#include "problems/world/world.h"

/* One detected contact point. Sides are bodies, then half-spaces; a is always a body. */
typedef struct contact_item {
  uint64_t id;
  int a, b;
  double x[3], n[3], gap;
} contact_item;

/* id = side a | side b | piece of a | piece of b | feature | copy, 64 bits in all */
enum {
  ID_COPY_BITS = CONTACT_COPY_BITS,
  ID_FEATURE_BITS = CONTACT_FEATURE_BITS,
  ID_PIECE_BITS = 3,
  ID_SIDE_BITS = 19,
  ID_SIDE_B_SHIFT = ID_COPY_BITS + ID_FEATURE_BITS + 2 * ID_PIECE_BITS,
  ID_SIDE_A_SHIFT = ID_SIDE_B_SHIFT + ID_SIDE_BITS,
};
_Static_assert(SPEC_COPIES <= 1 << ID_COPY_BITS, "a copy needs its bits in the id");

/* A joint in body axes. */
typedef struct joint_data {
  spec_joint_kind kind;
  int a, b; /* bodies; b = -1: the world */
  double anchor_a[3], anchor_b[3];
  double axis_a[3], axis_b[3]; /* hinge, slider */
  double relative[9];          /* R_b' R_a at t = 0, or the planar angle in [0] */
  double length;               /* distance joint [m] */
} joint_data;

enum { JOINT_ROWS_MAX = 6 };

/* One row of a joint: velocity d . (v_a(p_a) - v_b(p_b)) or d . (w_a - w_b). */
typedef struct joint_row {
  double d[3];
  double p_a[3], p_b[3]; /* where the two sides are felt, world */
  bool angular;
  double error; /* [m] or [rad] */
  double
      curve; /* rate of the row's velocity while the bodies keep theirs: what turning adds [m/s^2] or [rad/s^2] */
} joint_row;

/* Place of a point in the order of ids. */
typedef struct item_key {
  uint64_t id;
  int item;
} item_key;

/* What the arrays of a world are counted in. Those of one unit grow together (world_reserve). */
typedef enum world_unit {
  PER_BODY,
  PER_JOINT,
  PER_PIECE,
  PER_VERTEX,
  PER_MOVING, /* body with dofs */
  PER_DOF,
  PER_MASS,  /* entry of the mass blocks */
  PER_POINT, /* detected point */
  PER_GROUP, /* contact or joint */
  PER_ROW,
  PER_JACOBIAN, /* entry of the Jacobians */
  PER_SEEN,     /* contact at a displaced configuration */
  PER_SEEN_ROW,
  PER_CURVE,     /* row of a set with u_curve */
  PER_DISPLACED, /* scratch of world_contacts_curved */
  PER_COUNT
} world_unit;

enum { WORLD_RESIDUAL = 40 }; /* numbers of what acts on a body without the effects left out */

/* Every array of a world has one line here, X(element, name, unit, elements for one unit). The line declares the
 * array, and world_memory.c grows and frees it. */
#define WORLD_ARRAYS(X)                                                                            \
  X(body, body, PER_BODY, 1)                                                                       \
  X(joint_data, joint, PER_JOINT, 1)                                                               \
  X(piece, piece, PER_PIECE, 1)                                                                    \
  X(double, vertex, PER_VERTEX, 3)                                                                 \
  X(int, free_body, PER_MOVING, 1)              /* bodies with dofs */                             \
  X(int, link, PER_BODY, 1)                     /* world_sleep.c */                                \
  X(double, residual, PER_BODY, WORLD_RESIDUAL) /* world_omitted.c */                              \
  X(double, curve, PER_CURVE, 1)                /* u_curve of the last set */                      \
  X(double, displaced, PER_DISPLACED, 1)

/* Behind the contact_set views. */
#define SET_ARRAYS(X)                                                                              \
  X(contact_item, item, PER_POINT, 1) /* as found */                                               \
  X(item_key, key, PER_POINT, 1)      /* by id */                                                  \
  X(item_key, swap, PER_POINT, 1)     /* room to sort them */                                      \
  X(int, row_start, PER_GROUP, 1)                                                                  \
  X(int, jac_start, PER_GROUP, 1)                                                                  \
  X(int, group_body, PER_GROUP, 2)                                                                 \
  X(uint64_t, id, PER_GROUP, 1)                                                                    \
  X(contact_rows, rows, PER_GROUP, 1)                                                              \
  X(double, gap, PER_GROUP, 1)                                                                     \
  X(double, mu_static, PER_GROUP, 1)                                                               \
  X(double, mu_kinetic, PER_GROUP, 1)                                                              \
  X(double, mu_torsion, PER_GROUP, 1)                                                              \
  X(double, mu_rolling, PER_GROUP, 1)                                                              \
  X(double, restitution, PER_GROUP, 1)                                                             \
  X(double, compliance, PER_GROUP, 1)                                                              \
  X(double, frame, PER_GROUP, 9)                                                                   \
  X(double, spin, PER_GROUP, 3)                                                                    \
  X(double, point, PER_GROUP, 3)                                                                   \
  X(double, u_drift, PER_ROW, 1)                                                                   \
  X(double, u_before, PER_ROW, 1)                                                                  \
  X(double, joint_error, PER_ROW, 1)                                                               \
  X(double, joint_curve, PER_ROW, 1)                                                               \
  X(double, impulse, PER_ROW, 1) /* of the last advance; zeros without one */                      \
  X(double, jac, PER_JACOBIAN, 1)                                                                  \
  X(int, dof_start, PER_MOVING, 1)                                                                 \
  X(int, mass_start, PER_MOVING, 1)                                                                \
  X(double, mass, PER_MASS, 1)                                                                     \
  X(double, inv_mass, PER_MASS, 1)                                                                 \
  X(double, v, PER_DOF, 1)                                                                         \
  X(double, v_free, PER_DOF, 1)                                                                    \
  X(double, wrench, PER_BODY, 6) /* force and torque of the loads */

/* Velocities of the contacts at a displaced configuration (world_curve.c). */
#define CURVE_ARRAYS(X)                                                                            \
  X(uint64_t, id, PER_SEEN, 1) /* ascending */                                                     \
  X(int, row_start, PER_SEEN, 1)                                                                   \
  X(double, u, PER_SEEN_ROW, 1)

#define DECLARE_ARRAY_(type, name, unit, each) type *name;

typedef struct set_store {
  int n_item; /* detected points */
  SET_ARRAYS(DECLARE_ARRAY_)
} set_store;

typedef struct curve_store {
  int n_contact;
  CURVE_ARRAYS(DECLARE_ARRAY_)
} curve_store;

struct world {
  scene_spec
      spec; /* read only; what it points to is owned, or borrowed from the spec that was given: */
  bool borrows;
  unsigned effects;
  int dim;
  double t, h; /* [s]; h of the last set */
  int n_body, n_free, n_dof, n_piece, n_joint;
  WORLD_ARRAYS(DECLARE_ARRAY_)
  size_t cap[PER_COUNT]; /* units that the arrays have room for; 0: not allocated */
  pair_table mu, mu_kinetic, restitution, rolling, torsion, apart; /* apart: no collision */
  bool compliant; /* some surface has another compliance than 1 */
  double size;    /* smallest body or scene length: scale of tolerances [m] */
  double
      friction_reach; /* most friction over mu times the normal force, for what it would do [1] */
  broad_phase broad;
  base_gather found; /* points, by the parts of the search */
  set_store store;
  contact_set set; /* the last one */
  bool reached;    /* a side of one of its contacts sleeps */
  int n_asleep;    /* bodies that sleep */
  curve_store ahead, behind;
  /* generalised coordinates */
  const mech_model *model;
  double q[MODEL_DOF_MAX], qv[MODEL_DOF_MAX];
};

static inline bool world_has(const world *w, unsigned bit) {
  return (w->effects & bit) != 0;
}

/* world_memory.c: makes every array of `unit` hold n units and one more, which is the end of a list of offsets. What
 * they hold is kept, nothing else is initialised, and no array shrinks. BASE_ENOMEM leaves the capacity as it was. */
base_status world_reserve(world *w, world_unit unit, size_t n, base_error *err);
/* Frees all arrays; the world is left without any. */
void world_release(world *w);
/* Axes that are neither free nor driven do not move from here on. */
void world_still_locked(world *w);
/* Numbers the dofs anew, which are others now: bodies stay as they are. */
base_status world_renumber(world *w, base_error *err);

/* A body with dofs, or one that has them but sleeps: not one that is fixed or driven all the way. */
static inline bool body_is_free(const body *b) {
  return b->n_dof > 0 || b->sleeps != 0;
}

/* world_detect.c: fills store.item with points below margin, and store.key. margin < 0: per pair,
 * from h and the speeds. */
base_status world_detect(world *w, double h, double margin, base_error *err);
/* Least gap over all pairs, HUGE_VAL if there is none. */
base_status detect_min_gap(world *w, double *gap, base_error *err);
/* Of sides a and b, where bodies come first and then the half-spaces: may they touch, and the gap between them [m]. */
bool detect_may_collide(const world *w, int a, int b);
double detect_pair_gap(const world *w, int a, int b);
/* How deep two sides are in each other at most [m]; 0: none are. */
base_status detect_depth(world *w, double *depth, base_error *err);

/* world_state.c: pose and velocity of body i in a saved state. */
void world_saved_body(const double *state, int i, body *out);

/* world_rows.c: groups, rows and Jacobians of the detected points and the joints. */
base_status world_assemble(world *w, double h, base_error *err);
/* Rows of a joint that some dof can move: those that are posed. */
int joint_rows_posed(const world *w, const joint_data *j, joint_row *row);
/* Room for a set of this size. */
base_status world_reserve_set(world *w, size_t n_group, size_t n_row, size_t n_jac,
                              base_error *err);

/* world_needs.c: the effects that an axis (0 to 5) needs, it counts for each. */
enum { AXES = 6 };
unsigned world_axis_needs(int axis, int dim);
/* Velocity of the point `at` of a side at the end of the last set's step, and the side's angular velocity. */
void world_side_motion(const world *w, int side, const double *v_next, const double *at,
                       double *velocity, double *spin);
/* The same of the first side of contact i over the second, at its point. */
void world_contact_motion(const world *w, int i, const double *v_next, double *velocity,
                          double *spin);

/* world_forces.c */
base_status world_free_motion(world *w, double h, base_error *err); /* mass blocks, v, v_free */
double world_load_energy(const world *w);
base_status loads_check(const world *w, base_error *err);

/* world_joints.c */
base_status joints_start(world *w, base_error *err);
int joint_rows(const world *w, const joint_data *j, joint_row *row); /* count */

/* world_model.c */
base_status model_open(world *w, base_error *err);
void model_start(world *w);
base_status model_acceleration(world *w, double *a, base_error *err);
base_status model_contacts(world *w, double h, double margin, base_error *err);
double model_min_gap(const world *w);
double model_energy(const world *w, bool kinetic_only);
bool model_observe(const world *w, const char *var, double *value);
