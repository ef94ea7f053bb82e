/* formulations/assembly.h - the contact space of one step, shared by every formulation that poses
 * a complementarity problem.
 *
 *   u = r + C lambda,    C = J W J'  [1/kg],    r = J v_free + drift  [m/s]
 *
 * over the rows of the active contacts (of each contact a prefix of its rows: the normal, then the
 * tangents, then torsion and rolling) followed by the joint rows, whose r carries the stabilising
 * bias. C is kept as blocks, one for each pair of groups that share a body; nothing of the size of
 * all dofs squared is ever formed. */
#pragma once

#include "formulations/contact_memory.h"
#include "formulations/formulation.h"
#include "formulations/workspace.h"

/* Which prefix of a contact's rows a formulation wants. */
typedef enum form_rows { FORM_ROWS_NORMAL, FORM_ROWS_TANGENT, FORM_ROWS_ALL } form_rows;

/* Which contacts are active and with what normal bias b in
 *   0 <= lambda_n  _|_  u_n + b >= 0
 * (MATHEMATICS 2.0.1): closed contacts b = min(e min(u-, 0), max(gamma gap/h, -v_max)), the first only
 * where the approach is faster than `rest` times what the applied forces add in one step; open
 * ones at position level b = gap/h. */
typedef enum form_level { FORM_LEVEL_VELOCITY, FORM_LEVEL_POSITION } form_level;
typedef enum form_activation { FORM_CLOSED, FORM_MOREAU } form_activation;
/* The numbers of that bias, which are options of every formulation with normal rows. */
typedef struct form_repair {
  double push;       /* gamma [1] */
  double push_speed; /* v_max [m/s] */
  double rest;       /* steps of load below which an approach does not bounce [1] */
  double joint_push; /* share of the joint error removed in one step [1] */
} form_repair;
typedef struct form_rule {
  int level;      /* form_level */
  int activation; /* form_activation: closed gap <= tol, or gap + h u-/2 <= tol */
  bool newton;    /* e enters the bias */
  bool gives; /* what the step before met without giving it back, this one does (PAST_APPROACH) */
  bool all_rows; /* blocked directions stay, as exact zero rows */
  form_repair repair;
} form_rule;

/* Their fields and those that formulations share, for a table of options of the struct T, which has the member
 * `form_repair repair` or one named as the field. push_ is the default of `push`. */
#define FORM_PUSH_FIELDS(T, push_)                                                                 \
  BASE_FIELD_NAMED(T, repair.push, "push", BASE_REAL, "1", push_, 0, 1,                            \
                   "share of an overlap removed a step"),                                          \
      BASE_FIELD_NAMED(T, repair.push_speed, "push_speed", BASE_REAL, "m/s", 1e9, 0, 1e9,          \
                       "limit of that speed"),                                                     \
      BASE_FIELD_NAMED(T, repair.rest, "rest", BASE_REAL, "1", 2, 0, 1e6,                          \
                       "approach in steps of load: no bounce")
#define FORM_JOINT_PUSH_FIELD(T)                                                                   \
  BASE_FIELD_NAMED(T, repair.joint_push, "joint_push", BASE_REAL, "1", 0.2, 0, 1,                  \
                   "share of a joint error removed")
/* What is asked where redundant contacts leave the normal impulses undetermined (lcp/share/lcp_share.h, MATHEMATICS 2.8). */
typedef enum form_distribution { FORM_LEAST_NORM, FORM_EXTREME, FORM_COMPLIANT } form_distribution;
#define FORM_DISTRIBUTION_FIELD(T)                                                                 \
  BASE_FIELD_CHOICE(T, distribution, "least_norm|extreme|compliant", FORM_LEAST_NORM,              \
                    "of redundant contacts: equal springs, the solver's, springs of the scene")
/* Relative compliance of the block (lcp_block) of contact g of the set. */
static inline double form_soft(const contact_set *c, int g, int distribution) {
  if (distribution == FORM_COMPLIANT && c->compliance != NULL) {
    return c->compliance[g];
  }
  return (distribution == FORM_EXTREME) ? 0.0 : 1.0;
}
#define FORM_ACTIVATION_FIELD(T)                                                                   \
  BASE_FIELD_CHOICE(T, activation, "closed|moreau", 0, "gap, or gap half a step ahead")
#define FORM_STORAGE_FIELD(T)                                                                      \
  BASE_FIELD_CHOICE(T, storage, "auto|dense|csc|factored", 0,                                      \
                    "matrix handed to the solver; with joints, factored needs joints=mixed")
#define FORM_JOINTS_FIELD(T)                                                                       \
  BASE_FIELD_CHOICE(T, joints, "eliminated|mixed", 0, "or free rows of the problem")

/* One connected set of joints. */
typedef struct form_component {
  int first, count;   /* in member */
  int rows, rank;     /* of S */
  int row;            /* first of its rows in y and pivot */
  int touch, n_touch; /* in touch: contacts coupled to it */
  int columns;        /* rows of those contacts */
  size_t at;          /* S, then Y = L^-1 P' R, in dense */
} form_component;

/* What is known of a row before it is judged: the diagonal of C up to which it cannot move [1/kg]; the velocity that it
 * has if it cannot, and the rounding error of that [m/s]. */
typedef struct form_blocked {
  double noise, u, u_noise;
} form_blocked;

/* One row in use of a contact that lost some: sum of c_k times the rows row .. row+n-1 of the set's contact. A tied one moves
 * only with the contact's normal: its row of C is `share` times the normal's, and zero where it cannot move at all. */
typedef struct form_direction {
  int row, n;
  double c[2];
  bool tied;
  double share;
} form_direction;

/* A matrix of groups by blocks: group i meets near[near_start[i] ..], ascending and itself included; its block is
 * rows_i x rows_j, row-major, at block + block_at[]. */
typedef struct form_blocks {
  int *near_start;  /* n_group+1 */
  int *near;        /* n_near */
  size_t *block_at; /* n_near+1 */
  double *block;
} form_blocks;

/* assembly_joint.c: the joints that were eliminated, and C' in their place. */
typedef struct form_joints {
  int n_part;
  form_component *part;
  int *component, *member, *mark, *offset; /* n_group */
  int *touch, *column;                     /* 2 n_group */
  int *pivot;                              /* joint rows, 1-based inside a component */
  double *unit;                            /* joint rows: power of two that brings S_kk near 1 */
  double *before, *speed; /* contact rows: diagonal of C, and |r|, before the elimination */
  double *y, *work, *dense;
  form_blocks left; /* C' */
  int cap_group, cap_row, cap_near;
  size_t cap_dense, cap_block;
  void *mem, *dense_mem, *block_mem; /* owned */
} form_joints;

typedef struct form_assembly {
  const contact_set *set; /* borrowed until the next begin */

  bool own_only;  /* only the diagonal blocks of C are filled */
  int n_contact;  /* active contacts */
  int n_group;    /* active contacts, then the joints */
  int n_row;      /* rows of all groups */
  int *group;     /* n_group: index into the set's groups */
  int *row;       /* n_group+1 */
  double *r;      /* n_row [m/s] */
  double *lambda; /* n_row, scratch for the answer [N s] */
  double *
      repair; /* n_row; of joint rows: the part of r that takes back their error [m/s]; after an elimination, what of it
                  is taken back beside the motion */

  /* Directions that joints or locks block are no rows (assembly_blocked.c): what is left of the rows
   * wanted from contact i, and whether it is less than all of them. */
  contact_rows *rows;        /* n_contact */
  bool *turned;              /* n_contact */
  form_direction *direction; /* n_row; set for turned contacts only */
  form_blocked *known;       /* n_row of `full`; of contacts */
  bool all_rows;             /* of the rule */
  bool reduced;              /* a row was taken out: group and row differ from those of `full` */
  struct {                   /* all rows wanted of the active contacts, then the joints */
    int n_contact;
    int *group, *row;
  } full;
  int *full_of;    /* n_contact: the contact among those of `full` */
  int *home_group; /* where `full` stands once it differs */
  int *home_row;

  /* C, as form_blocks has it: of `home` or of `joints.left` */
  int *near_start, *near;
  size_t *block_at;
  double *block;
  int *self; /* n_group: position of the own block in near */

  int n_joint_group; /* joints that were eliminated: their rows follow the n_row of the contacts */
  form_joints joints;
  form_blocks home; /* as laid out, before an elimination */

  /* per contact of the set, and the answer */
  double *bias;     /* n_contact of the set; HUGE_VAL: not active */
  double *r_normal; /* n_contact of the set: J_n v_free + drift [m/s] */
  double *impulse;  /* n_row of the set */
  double *v_next;   /* n_dof */
  double *shift;    /* n_dof: formulation_answer.shift, where `shifts` */
  bool shifts; /* an error is taken back beside the motion: of eliminated joints, or an overlap */
  bool shift_known;      /* in this step */
  bool beside;           /* errors of joints that contacts touch are */
  double *force, *moved; /* n_dof, scratch: J' lambda [N s], and W of it [m/s] */
  unsigned char *mode;   /* n_contact of the set */

  int *body_start, *body_group; /* groups by body, scratch */
  int *cursor;                  /* n_group, scratch */
  double *jw;                   /* scratch: J_i W of one group, for each of `hands` threads */
  int hands;

  struct form_assembly_size {
    int contact, group, row, dof, body, near, jw;
    size_t block;
  } cap;
  void *mem, *near_mem, *block_mem; /* owned */
} form_assembly;

/* Picks active contacts by the rule, fills r, C, bias; impulse is zeroed. Contacts that were closed one step ago
 * (contact_memory_closed) stay so up to ten times the tolerance, or more where they carried much (MATHEMATICS 2.0.1), and
 * rounding does not make a resting contact flicker. Marks the closed ones of this
 * step in the same way. Allocates only while larger sets than ever before arrive. */
base_status form_assembly_begin(form_assembly *a, const contact_set *c, form_rows rows,
                                const form_rule *rule, contact_memory *memory, base_error *err);
/* The same without the blocks between different groups: C is then known on its diagonal only. */
base_status form_assembly_begin_own(form_assembly *a, const contact_set *c, form_rows rows,
                                    const form_rule *rule, contact_memory *memory, base_error *err);
/* assembly_active.c: the active groups with their rows, r and bias; a step of the two above. */
void form_assembly_choose(form_assembly *a, const contact_set *c, form_rows rows,
                          const form_rule *rule, contact_memory *memory);
/* Does an active contact approach faster than `rest` times what the applied forces add in the step, and by more than the
 * tolerance? */
bool form_has_impact(const form_assembly *a, double rest);
void form_assembly_close(form_assembly *a);

static inline int form_rows_of(const form_assembly *a, int i) {
  return a->row[i + 1] - a->row[i];
}

/* Joints, eliminated or rows. */
static inline int form_joints_of(const form_assembly *a) {
  return a->n_joint_group + a->n_group - a->n_contact;
}

/* The own block of group i: rows_i x rows_i. */
static inline const double *form_own_block(const form_assembly *a, int i) {
  return a->block + a->block_at[a->self[i]];
}

/* Is a stored matrix of n rows worth its factors beside it? It is large, and nothing was eliminated from the assembly. */
static inline bool form_keeps_factors(const form_assembly *a, int n) {
  return n > 128 && a->set->n_group == a->set->n_contact && !a->reduced;
}

/* storage=auto for a solver that reads factors: they alone, where they would stand beside a stored matrix. */
static inline bool form_factors_alone(const contact_set *c, bool by_factors) {
  return by_factors && c->n_row > 128 && c->n_group == c->n_contact;
}

/* The option `storage` in a step whose joints are eliminated: of C' there are no factors, so it is stored as `auto` (0) does. */
static inline int form_storage_without_joints(int storage, int factored, const contact_set *c) {
  return (storage == factored && c->n_group > c->n_contact) ? 0 : storage;
}

/* Largest eigenvalue of the dim x dim block of C (dim 1 or 2) at rows `at` of contact i [1/kg]: the inverse of the effective
 * mass in these directions. */
double form_mobility(const form_assembly *a, int i, int at, int dim);

/* What slides of a step are told by, reckoned once. */
typedef struct form_slip {
  double still; /* what is no slower slides: 1e-8 of the largest velocity without contacts [m/s] */
  double
      share; /* nor than this share of what the bound of its friction changes: a millionth, or what is asked for [1] */
  bool hit;  /* something is met in the step (form_has_impact), or given back */
} form_slip;

form_slip form_slip_of(const form_assembly *a, double rest);
/* Does active contact i slide in the motion that form_assembly_answer wrote? Impulses at their bound [N s], mu lambda_n, do not
 * tell: of two redundant contacts at rest one may stand there. It moves faster than `still`, and than `share` of what the bound changes. */
bool form_slides(const form_assembly *a, int i, double bound, const form_slip *slip);
/* Is `friction`, of its tangents [N s], against the slip of active contact i in that motion? On a round cone it is: else the slip is what the
 * solver leaves. */
bool form_opposes(const form_assembly *a, int i, const double *friction);
/* The speed of that motion along the tangents of active contact i [m/s]. */
double form_slip_speed(const form_assembly *a, int i);
/* Remembers that active contact i slides in that motion (PAST_SLIDES, PAST_WAY). Where kinetic friction is less than static, a slip that loads turn
 * round has been at rest within the step, where static friction is what they have to overcome: that holds until the slip rests,
 * or grows against it. An impact turns a slip without a rest. */
void form_note_slide(const form_assembly *a, int i, const form_slip *slip, contact_memory *m);

/* u = r + C lambda over the rows in use. */
void form_assembly_velocity(const form_assembly *a, const double *lambda, double *u);
/* The same as r + J W J' lambda, where C is known on its diagonal only and joints were not eliminated; writes the answer of
 * lambda on the way. */
void form_assembly_velocity_of(form_assembly *a, const double *lambda, double *u);
/* force += J' l, and u += J x, over the first `rows` rows of group g of the set. */
void form_add_force(form_assembly *a, int g, int rows, const double *l);
void form_add_velocity(const contact_set *c, int g, int rows, const double *x, double *u);

/* Invariant for assert: every group has an ascending list of groups in range, with itself where `self` says. */
static inline bool form_assembly_is_linked(const form_assembly *a) {
  bool good = a->near_start[0] == 0;
  for (int i = 0; i < a->n_group && good; i++) {
    const int first = a->near_start[i], end = a->near_start[i + 1];
    good = a->self[i] >= first && a->self[i] < end && a->near[a->self[i]] == i;
    for (int k = first; k < end && good; k++) {
      const int least = (k > first) ? a->near[k - 1] + 1 : 0;
      good = a->near[k] >= least && a->near[k] < a->n_group;
    }
  }
  return good;
}

/* C as a dense n_row x n_row matrix, column-major. */
void form_assembly_dense(const form_assembly *a, double *out);

/* A block, row-major, into a column-major matrix with leading dimension n. */
static inline void form_put_block(const double *block, int rows, int columns, double *to,
                                  ptrdiff_t n) {
  for (int p = 0; p < rows; p++) {
    for (int q = 0; q < columns; q++) {
      to[q * n + p] = block[p * columns + q];
    }
  }
}

/* Takes the joint rows out: n_group = n_contact, r and C become those of the projected system. */
base_status form_assembly_eliminate(form_assembly *a, base_error *err);
/* Leaves the joints rows, and takes out of the contacts' what they block. */
base_status form_assembly_mix(form_assembly *a, base_error *err);
void form_assembly_joint_impulses(form_assembly *a, double *lambda);
/* S^-1 repair over all rows of `full`: the impulses that would take back the errors of eliminated joints; false: there are none. */
bool form_assembly_repair_impulses(const form_assembly *a, double *lambda);
static inline const double *form_shift_of(const form_assembly *a) {
  return a->shifts ? a->shift : NULL;
}
void form_joints_close(form_joints *j);

/* assembly_blocked.c: takes directions that cannot move out of rows, r and C, and contacts whose normal cannot move out of the
 * active ones (MATHEMATICS 2.1); with all_rows it leaves exact zeros. Called once a step, with `known` filled for the rows of
 * all contacts. */
void form_assembly_unblock(form_assembly *a);
/* Its two halves. The rows that stay, judged by the blocks of C', false: all; and the blocks of C, or of C', in place: what stays
 * moves towards the front. */
bool form_assembly_choose_rows(form_assembly *a);
void form_assembly_compress(form_assembly *a);
/* `known` of what locks, or sides that are not free, leave without motion. */
void form_assembly_know_locks(form_assembly *a);

/* x over the rows of the set's contact into the rows in use of active contact i, and back (adds to x). */
void form_to_rows(const form_assembly *a, int i, const double *x, double *out);
void form_to_set(const form_assembly *a, int i, const double *in, double *x);
/* The second as C has it: a tied row moves bodies as `share` of the normal's does, to its last digit; what is left of it joints
 * hold. true: a tied row of the contact carries. */
bool form_to_motion(const form_assembly *a, int i, const double *in, double *x);
/* Writes lambda (n_row) and the impulses of eliminated joints into impulse (set rows) and v_next = v_free + W J' lambda. */
void form_assembly_answer(form_assembly *a, const double *lambda);
/* The same, and into the shift what the impulses `way` would change in that motion: bodies go that way in this step and keep
 * the velocities of lambda. Once a step. */
void form_assembly_answer_beside(form_assembly *a, const double *lambda, const double *way);
