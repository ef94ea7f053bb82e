/* formulations/formulation.h - turns a contact set into complementarity problems and back.
 *
 * A step may need several solves (stick/slip modes, Poisson's second phase, frozen bounds):
 *
 *   begin(set)
 *   while (assemble(&problem, z0) gave a problem) { solve -> z;  recover(z, claim) }
 *   answer(&answer)
 *
 * State across steps (bristles, modes, last impulses) belongs to the formulation, keyed by contact
 * id. The formulation never sees a solver. */
#pragma once

#include "formulations/contact_memory.h"
#include "lcp/base/fields.h"
#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"
#include "problems/world/contact_set.h"
#include "problems/world/world.h"

/* What of Coulomb's law the model keeps; reported next to every result, so that a
 * fast solver of an easier model is not mistaken for a fast solver. */
typedef enum formulation_model {
  FORM_UNILATERAL = 1u << 0,      /* no interpenetration */
  FORM_FRICTION = 1u << 1,        /* some friction */
  FORM_CONE_EXACT = 1u << 2,      /* circular friction cone */
  FORM_CONE_POLYHEDRAL = 1u << 3, /* faceted cone */
  FORM_REGULARISED = 1u << 4,     /* friction through a compliant or viscous law */
  FORM_BOUNDS_LAGGED = 1u << 5,   /* bounds from an earlier normal impulse */
  FORM_PENALTY = 1u << 6,         /* compliant normal contact */
  FORM_POSITION = 1u << 7,        /* normal rows at position level */
  FORM_ACCELERATION = 1u << 8,    /* forces, not impulses */
  FORM_NO_LCP = 1u << 9,          /* implements step itself */
  FORM_NORMAL_ONLY = 1u << 10,    /* the unknowns are the normal impulses, one a contact */
  FORM_CURVED = 1u << 11,         /* begin wants u_curve (world_contacts_curved); not told */
} formulation_model;

/* Beside the EFFECT_ bits in `lacks`: scenes with generalised coordinates instead of bodies. */
enum { FORM_COORDINATES = 1u << EFFECT_COUNT };

/* The words of `model` in rows and lists: "unilateral friction ...". formulation_model_word returns
 * NULL for a bit that has none. */
const char *formulation_model_word(int bit);
void formulation_model_print(unsigned model, char *buf, size_t cap);

typedef enum formulation_start { FORM_COLD, FORM_PREVIOUS } formulation_start;

/* Work of one step (the harness adds the solver's own). */
typedef struct formulation_work {
  long solves, mode_changes, factorizations, fallbacks, rays, evaluations;
  long analyses; /* symbolic ones, before a factorization with a new pattern */
} formulation_work;

/* Result of one step; arrays are views into the formulation's state, valid until begin. */
typedef struct formulation_answer {
  const double *impulse; /* n_row of the set: contact-frame impulses and joint impulses [N s] */
  const double *v_next;  /* n_dof */
  const double *
      shift; /* n_dof: by these velocities besides v_next the bodies move in this step and then no more: what
                                takes back the errors of joints, which neither contacts nor the next step feel; NULL: none */
  const double *bias;        /* n_contact: normal bias used [m/s]; HUGE_VAL: contact not active */
  bool solved;               /* the formulation's own residual met its tolerance in this step */
  double residual;           /* its own model's residual (mode loop, bound loop) [1] */
  int circle;                /* solves after which that loop was back, bit for bit, in a state that
                                it had been in, which proves that it has no end; 0: none is known */
  int lcp_dim;               /* unknowns of the largest problem posed */
  int n_active;              /* active contacts */
  double stiffness_ratio;    /* min over contacts of G/m_t; HUGE_VAL if not regularised */
  double v_slip;             /* max regularisation velocity mu f_n / c [m/s], 0 if none */
  double deflection;         /* max bristle saturation deflection mu f_n / k [m], 0 if none */
  double spring_energy;      /* stored in bristles after the step [J] */
  bool gave_way;             /* bristles of two shapes gave way that all together could have held */
  const unsigned char *mode; /* n_contact: 0 open, 1 stick, 2 slip; NULL: unknown */
  const contact_set *set; /* FORM_NO_LCP: the set at the end of the step that impulse, bias and mode
                             refer to; NULL: the set given to begin */
  formulation_work work;
} formulation_answer;

/* Whose the rows of a problem are, group by group: group k has the rows first[k] .. first[k + 1] - 1 (first NULL: row k alone),
 * and is group[k] of the set, a contact or a joint. Views, valid as long as the problem. */
typedef struct formulation_rows {
  const contact_set *set;
  int n_group;
  const int *first; /* n_group+1, or NULL */
  const int *group; /* n_group, ascending */
} formulation_rows;

/* How a formulation that advances the world itself has a problem solved: the caller's solver, its
 * judge and its counters stay behind this call. z[p->M.n]: start point in, answer out. */
typedef struct formulation_solver {
  base_status (*solve)(void *ctx, const lcp_problem *p, double *z, lcp_outcome *claimed,
                       base_error *err);
  bool (*due)(
      void *ctx); /* has the caller no more time, so that the step is to fail; NULL: never */
  void *ctx;
} formulation_solver;

/* What the solver of a run reads, by which an option that is `auto` chooses how a large problem is posed. */
typedef struct formulation_reader {
  unsigned sets;   /* lcp_solver.sets; 0: those of the formulation alone are known of */
  bool by_factors; /* lcp_solver.by_factors: with storage=auto no matrix is stored beside them */
  bool newton;     /* lcp_solver.newton */
} formulation_reader;

/* How far its law of friction goes beyond mu times the normal force. */
typedef struct formulation_friction {
  double most; /* its largest force over mu times the normal one, per contact [1] */
  bool aslant; /* its facets lie aslant of the axes, and push out of a plane of motion */
} formulation_friction;

/* BASE_EEXTERNAL where the caller's time is up, with the formulation's name and the time t that it came to [s]; solver NULL: never. */
base_status formulation_in_time(const formulation_solver *solver, const char *name, double t,
                                base_error *err);

typedef struct formulation formulation;

/* One formulation with its options and state over a run; opaque, owns its arrays, grows them when
 * a larger contact set arrives. */
typedef struct formulation_run formulation_run;

struct formulation {
  const char *name, *title, *cite; /* cite: keys of docs/references.bib */
  const char *words;      /* one sentence for a reader who meets the name for the first time */
  const char *when;       /* one sentence: when to take it */
  const char *apart;      /* options, blanks between, of which every value is a curve of its own in
                        figures; NULL: all settings are one curve */
  unsigned model;         /* formulation_model bits */
  unsigned sets;          /* 1u << lcp_set of its contacts' blocks; 0: poses no problem */
  unsigned lacks;         /* what it cannot simulate: EFFECT_ bits, FORM_COORDINATES */
  const char *stands_for; /* which "forms" word of the case format its checks go by: "velocity",
                             "position" or "regularized"; NULL: only checks without forms */
  const base_field *fields;
  int n_fields;
  size_t options_size, state_size;
  size_t
      memory; /* where in the state its contact_memory lies: all that survives a step. 0: it has none, or keeps more
                    than that, and no run of it can come back to an earlier step */
  size_t
      reader; /* where in the state a formulation_reader lies that formulation_read_by sets; 0: it has none */

  /* LCP dimension in closed form: p active contacts, of which all have friction. */
  long (*dimension)(int dim, int p, const void *opt);
  /* Of a space of `dim`. NULL: what the bits of its model tell (formulation_friction_of). */
  formulation_friction (*friction)(int dim, const void *opt);

  /* state lifetime */
  base_status (*open)(void *state, const void *opt, base_error *err); /* may be NULL */
  void (*close)(void *state);                                         /* frees what state owns */

  /* one step */
  base_status (*begin)(void *state, const contact_set *c, const void *opt, formulation_start start,
                       base_error *err);
  /* *pending = false: nothing (more) to solve in this step. Otherwise *out is a view valid until
   * recover, and z0[n] (capacity given by out->M.n) the start point (cold: zeros in
   * the first solve of a step). */
  base_status (*assemble)(void *state, lcp_problem *out, const double **z0, bool *pending,
                          base_error *err);
  /* Of the problem last assembled. NULL for FORM_NO_LCP. */
  void (*rows)(const void *state, formulation_rows *out);
  /* Takes any z, exact or not, with what the solver claimed. */
  base_status (*recover)(void *state, const double *z, lcp_outcome claimed, base_error *err);
  void (*answer)(const void *state, formulation_answer *out);

  /* FORM_NO_LCP only: advances the world by h itself (integrator, event location), its clock
   * included. `solver` solves the problems met at events. */
  base_status (*step)(void *state, world *w, double h, const formulation_solver *solver,
                      formulation_answer *out, base_error *err);
};

const formulation *const *formulations(int *count);
const formulation *formulation_find(const char *name);

/* The law of friction of f with these options. Round cones and bristles give mu times the normal force at most, a box the
 * root of 2 times that at its corners, and each as much again where that normal force is one of before. */
formulation_friction formulation_friction_of(const formulation *f, int dim, const void *opt);

base_status formulation_open(formulation_run **out, const formulation *f, const void *opt,
                             base_error *err);
/* Before the first step: who solves what the run poses. Where nobody is named, as where a problem is exported, it is a solver of no
 * more than the formulation's own sets that reads no factors. */
void formulation_read_by(formulation_run *r, formulation_reader reader);
void formulation_close(formulation_run *r);
/* Refuses a world in which something occurs that f lacks, so that no motion without it is reported as the scene's:
 * BASE_EUNSUPPORTED names what. To be asked before the first step; begin and step refuse what they see of it in
 * their contact set or world. */
base_status formulation_admits(const formulation *f, const world *w, base_error *err);
/* What the run remembers from step to step, to come back to (contact_memory.h). BASE_EUNSUPPORTED where f->memory is 0. */
base_status formulation_keep(const formulation_run *r, contact_past *past, base_error *err);
base_status formulation_recall(formulation_run *r, const contact_past *past, base_error *err);
/* contact_memory_changes of the step just taken. BASE_EUNSUPPORTED as above. */
base_status formulation_changes(const formulation_run *r,
                                void (*tell)(void *of, uint64_t id, double by), void *of,
                                base_error *err);
/* Before its first step the run goes on where one of formulation f was (NULL: there was none with a memory). *past is of formulation_keep
 * and loses what r does not understand; r has no use for it where it has no memory. */
base_status formulation_take_over(formulation_run *r, const formulation *f, contact_past *past,
                                  base_error *err);
base_status formulation_begin(formulation_run *r, const contact_set *c, formulation_start start,
                              base_error *err);
base_status formulation_assemble(formulation_run *r, lcp_problem *out, const double **z0,
                                 bool *pending, base_error *err);
/* Of the problem last assembled. BASE_EUNSUPPORTED: a formulation that steps by itself does not tell. */
base_status formulation_rows_of(const formulation_run *r, formulation_rows *out, base_error *err);
base_status formulation_recover(formulation_run *r, const double *z, lcp_outcome claimed,
                                base_error *err);
void formulation_answer_of(const formulation_run *r, formulation_answer *out);
base_status formulation_step(formulation_run *r, world *w, double h,
                             const formulation_solver *solver, formulation_answer *out,
                             base_error *err);
