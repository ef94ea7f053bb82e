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
  ID_COPY_BITS = 8,
  ID_FEATURE_BITS = 12,
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
} joint_row;

/* Place of a point in the order of ids. */
typedef struct item_key {
  uint64_t id;
  int item;
} item_key;

/* Arrays behind the contact_set views; they only ever grow. */
typedef struct set_store {
  size_t cap_item, cap_group, cap_row, cap_jac;
  contact_item *item;   /* n_item detected points, as found */
  item_key *key, *swap; /* n_item, by id; and room to sort them */
  int n_item;
  int *row_start, *group_body, *jac_start;
  double *jac, *u_drift, *u_before, *joint_error;
  uint64_t *id;
  contact_rows *rows;
  double *gap, *mu_static, *mu_kinetic, *mu_torsion, *mu_rolling, *restitution, *frame, *spin;
  double *point;
  double *impulse; /* of the last advance; zeros without one */
  /* per body with dofs */
  int *dof_start, *mass_start;
  double *mass, *inv_mass, *v, *v_free;
} set_store;

/* Velocities of the contacts at a displaced configuration (world_curve.c). */
typedef struct curve_store {
  size_t cap_contact, cap_row;
  int n_contact;
  uint64_t *id;   /* n_contact, ascending */
  int *row_start; /* n_contact+1 */
  double *u;      /* rows */
} curve_store;

struct world {
  scene_spec spec;
  unsigned effects;
  int dim;
  double t, h; /* [s]; h of the last set */
  int n_body, n_free, n_dof;
  body *body;
  int *free_body; /* n_free indices of bodies with dofs */
  int n_piece;
  piece *piece;
  double *vertex;
  pair_table mu, mu_kinetic, restitution, rolling, torsion, apart; /* apart: no collision */
  int n_joint;
  joint_data *joint;
  double size; /* smallest body or scene length: scale of tolerances [m] */
  broad_phase broad;
  set_store store;
  contact_set set; /* the last one */
  curve_store ahead, behind;
  double *curve, *displaced; /* u_curve of the last set; scratch of world_contacts_curved */
  size_t cap_curve;
  /* generalised coordinates */
  const mech_model *model;
  double q[MODEL_DOF_MAX], qv[MODEL_DOF_MAX];
};

static inline bool world_has(const world *w, unsigned bit) {
  return (w->effects & bit) != 0;
}

/* Makes *p hold at least `need` items; *cap is shared by arrays grown together, so it is the
 * caller who updates it. */
base_status store_grow(void **p, size_t need, size_t size, base_error *err);

/* world_detect.c: fills store.item with points below margin, and store.key. margin < 0: per pair,
 * from h and the speeds. */
base_status world_detect(world *w, double h, double margin, base_error *err);
/* Least gap over all pairs, HUGE_VAL if there is none. */
base_status detect_min_gap(world *w, double *gap, base_error *err);

/* world_rows.c: capacity of the store, and groups, rows and Jacobians of the detected points and the joints. */
base_status world_assemble(world *w, double h, base_error *err);
base_status store_reserve(set_store *s, size_t n_group, size_t n_row, size_t n_jac,
                          base_error *err);

/* world_forces.c */
base_status world_free_motion(world *w, double h, base_error *err); /* mass blocks, v, v_free */
void world_wrench(const world *w, double *f /* 6 n_body */);
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
