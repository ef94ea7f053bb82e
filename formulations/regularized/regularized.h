/* formulations/regularized/regularized.h - normal impulses as the only unknowns; friction through a compliant
 * law in the static phase and through lambda_n in the kinetic one (Gholami, Nasri, Kovecses &
 * Teichmann 2016; the equations are MATHEMATICS 2.3).
 *
 * Law of one part (friction, torsion or rolling of one contact): a Coulomb slider in series with
 * spring k and damper c, state s [m], implicit Euler over the step,
 *
 *   h tau = h k s + G v_t,   G = h^2 k + h c [kg]
 *   stick |h tau| <= mu lambda_n:  lambda_t = -h tau,                s+ = s + h v_t
 *   slip  otherwise, d = tau/|tau|: lambda_t = -mu lambda_n d,       s+ = (mu lambda_n d + c s)/(h k + c)
 *
 * For given modes lambda_t is affine in lambda_n, which leaves an LCP of size p. Each part is
 *   S  stick            lambda_t = -h tau
 *   L  slip, linearised lambda_t = -mu lambda_n d - r (I - d d') h tau
 *   R  secant           lambda_t = -r h tau,   r = min(1, mu lambda_n / |h tau|) of the last iterate
 *   G  given            lambda_t known before the solve (regularized_once.c)
 * and the modes are found by solving again: L is a Newton step, R always converges. With an ellipse
 * of friction coefficients the second tangent is scaled so that the law is a circle again; k and c
 * then differ along the axes like mu^2, for which the radial return is exact (MATHEMATICS 2.3.11). */
#pragma once

#include "formulations/bristle.h"
#include "formulations/row_matrix.h"

enum { REG_KINDS = 3 };    /* friction, torsion, rolling */
enum { REG_ROWS_MAX = 8 }; /* of a group */
enum { REG_PAIRS = 8 };    /* steps that the secant iteration remembers */
typedef enum reg_mode { REG_STICK, REG_SLIP, REG_SECANT, REG_GIVEN } reg_mode;
typedef enum reg_model { REG_BRISTLE, REG_VISCOUS, REG_LUGRE } reg_model;
typedef enum reg_modes { REG_NEWTON, REG_PLAIN, REG_SECANT_ONLY, REG_ONCE } reg_modes;
typedef enum reg_pose { REG_BY_SIZE, REG_REDUCED, REG_CONE } reg_pose;
/* Readings of what the paper leaves open, with modes decided once a step (MATHEMATICS 2.3.13). */
enum { REG_BOUND_CURRENT, REG_BOUND_PREVIOUS };
enum { REG_IMPLICIT, REG_EXPLICIT };
enum { REG_SATURATED, REG_RESET };
enum { REG_TURNED_STICKS, REG_TURNED_SLIPS }; /* of REG_PLAIN */

/* What a memory entry has of its own: whether there is more of an active contact, then for each kind of part the numbers below, which
 * count only where a step starts from the previous one. */
enum { REG_PAST_MODE, REG_PAST_R, REG_PAST_D, REG_PAST_PART = REG_PAST_D + 3 };
enum { REG_PAST_OWN, REG_PAST_PARTS };

/* Of the mode loop, unless they are given. */
#define REG_PROX        1e-4
#define REG_NEWTON_ITER 10

typedef struct reg_options {
  int variant;   /* names a choice of the others */
  int model;     /* reg_model */
  int bias;      /* form_level */
  int stiffness; /* 0: G/m_t fixed, 1: k and c fixed */
  double ratio;  /* G/m_t [1] */
  double zeta;   /* damping of the bristle, c = 2 zeta sqrt(k m_t) [1] */
  double k, c;   /* [N/m], [N s/m] */
  int impact;    /* 0: keep k and c, 1: raise G to ratio m_t in steps with an impact */
  int modes;     /* reg_modes */
  int turned;    /* of REG_PLAIN: what a slip becomes that its own friction has turned round */
  int bound, integration,
      bristle;      /* of REG_ONCE: the normal impulse behind the friction, the bristle's force, and
                                      what is left of it while it slides */
  int distribution; /* form_distribution */
  int pose;         /* reg_pose; of a step never REG_BY_SIZE */
  int storage;      /* row_storage, of pose=cone */
  int form;         /* 0 by size, 1 contact space, 2 mass matrix */
  int factor;       /* of the mass matrix: 0 by width, 1 envelope, 2 CHOLMOD */
  double sigma0, sigma1, sigma2, v_stribeck; /* LuGre [N/m], [N s/m], [N s/m], [m/s] */
  double ellipse;                            /* mu along t2 over mu along t1 [1] */
  int activation, restitution;
  double tol;      /* of the mode loop, on the friction impulses over the largest impulse [1] */
  int mode_iter;   /* most solves in a step */
  double prox;     /* weight of the proximal term [1] */
  int newton_iter; /* solves after which all slip is treated by the secant */
  form_repair repair;
} reg_options;

typedef struct reg_part {
  int contact;  /* active contact */
  int kind;     /* 0 friction, 1 torsion, 2 rolling */
  int row, dim; /* rows row .. row+dim-1 of the assembly, dim 1 or 2 */
  double mu_static, mu_kinetic;
  double k, c, G, m; /* m: effective mass m_t [kg] */
  double share;      /* of a stiffness that several contacts have together */
  double pull;       /* h k: impulse per deflection [N s/m]; LuGre: kappa */
  double axis2;      /* ellipse: t2 is measured in units of it, where the law is a circle [1] */
  double eta, next_eta, v[2]; /* LuGre */
  double s[2];                /* at the start of the step [m] */
  double d[2], r;             /* slip direction, secant factor of the current mode */
  double tau[2], size;        /* h tau of the last iterate and its length [N s] */
  double next_r;              /* min(1, mu lambda_n / |h tau|) there */
  double log_r, log_step;     /* ln r and ln(next_r / r) of the last secant iteration */
  double log_go;              /* the move of ln r from there */
  double load;                /* mu lambda_n there, an impulse [N s] */
  int openings;               /* solves of this step that took its secant's load away */
  unsigned char mode;         /* reg_mode */
  unsigned char sliding;      /* mu is the kinetic one */
  unsigned char slid;         /* it was at the start of the step */
  unsigned char holds;        /* it is the static one throughout the step: the slide turned round */
  unsigned char followed;     /* log_r and log_step are of the last iteration */
  unsigned char flips;        /* changes of `sliding` in this step */
} reg_part;

/* What the secants of a part remember: changes of log_r and log_step, newest first. */
typedef struct reg_pairs {
  double moved[REG_PAIRS], answered[REG_PAIRS];
} reg_pairs;

/* One compliant row: sum c_m e_(row+m), lambda = -(u + offset) / compliance. */
typedef struct reg_row {
  int group, row, n;
  double c[2];
  double compliance, stiffness; /* 1/(r G) [1/kg], r G [kg] */
  double offset;                /* [m/s] */
} reg_row;

/* The direction's part of x, of which q->row is the first entry. */
static inline double reg_along(const reg_row *q, const double *x) {
  return q->c[0] * x[0] + ((q->n == 2) ? q->c[1] * x[1] : 0);
}

/* regularized_mass.c: M_hat and its factor, in an envelope or with CHOLMOD. */
typedef struct reg_sparse reg_sparse;
typedef struct reg_joint {
  int n, rank;   /* joint rows, independent ones */
  double *S, *W; /* n x n, factored; n x width */
  double *own;   /* width: squares of the columns before they are projected */
  double *x, *y; /* S^-1 r_b; scratch */
  double *work;  /* 2n, LAPACK's */
  int *pivot;    /* 1-based */
  int cap_n, cap_width;
  void *mem; /* owned */
} reg_joint;
typedef struct reg_mass {
  bool by_sparse;
  reg_sparse *sparse; /* owned */
  reg_joint joint;
  long analyses;          /* symbolic ones since open */
  int *place, *order;     /* n_body: first dof in the order of elimination; bodies in that order */
  int *first;             /* n_dof: first column of each row of L */
  size_t *at;             /* n_dof+1: where the row starts */
  int *link_start, *link; /* bodies sharing a friction contact */
  double *L, *Y, *delta;
  double *c;      /* n_dof: first column of Y while it is summed */
  double *e;      /* directions of one contact */
  int *from, *to; /* n_body: columns of Y that begin at a body lie in from .. to-1 */
  int cap_body, cap_dof, cap_contact;
  size_t cap_L, cap_Y;
  void *mem, *val_mem; /* owned */
} reg_mass;

/* regularized_modes.c: which kind of iteration is next. */
typedef struct reg_schedule {
  int n_secant;    /* parts by the secant in the last iteration */
  int n_pair;      /* pairs of steps they remember */
  int calm;        /* iterations since a part began or ceased to stick */
  int patience;    /* of those before a trial of Newton's */
  bool trial;      /* one is running */
  double residual; /* where its last iteration began */
  double way;      /* LuGre: how much of the way to the law's answer an iteration goes */
  double mark;     /* the residual to be halved */
  int waited;      /* iterations since the last one that halved it */
  int kept;        /* REG_PLAIN: the iteration whose state is in base */
} reg_schedule;

/* regularized_cone.c: the step as one cone problem. */
typedef struct reg_cone {
  row_matrix matrix;                   /* C, with 1/G on its diagonal or in S */
  int storage;                         /* row_storage of this step */
  double *q, *z0, *w, *give, *scratch; /* n_row: give = 1/G [1/kg]; a product's own */
  lcp_block *block;                    /* n_group */
  int cap_row, cap_group;
  size_t cap_scratch;
  void *mem; /* owned */
} reg_cone;

typedef struct regularized {
  form_assembly a;
  contact_memory memory;
  reg_options opt;
  formulation_start start;
  formulation_reader reader;

  reg_part *part, *best_part,
      *base_part;   /* n_part; base: where a trial of Newton's began; REG_PLAIN:
                                             a state that the loop has been in */
  reg_pairs *pairs; /* n_part; touched by secants alone. None of pose=cone, like base_part */
  int n_part;
  int *part_start; /* n_contact+1: parts of each active contact */
  int *sharers;    /* n_contact: active contacts that share its stiffness, itself included */
  form_bristle_key *bodies; /* n_contact: scratch of that */
  int *row_of;              /* n_group+1: compliant rows of each group */
  reg_row *rows;            /* n_rows */
  int n_rows;
  bool any_slip; /* some part has a slip column */

  double *anchor;     /* p: lambda_n of the last iterate, centre of the proximal term [N s] */
  double *A, *b, *z0; /* p*p, p, p */
  double *sigma;      /* n_rows^2: Q C Q' + compliance, then its Cholesky factor */
  double *xyc;        /* n_rows x (2p+1): L^-1 [Q C N' | Q C B | Q r + offset] */
  double *lambda, *u, *best, *base; /* assembly rows */
  double *given; /* assembly rows: friction that is known before the solve, REG_ONCE [N s] */
  double *t;     /* n_rows */
  lcp_block *block;

  bool by_mass; /* which of the two forms this step takes */
  reg_mass mass;
  reg_cone cone;

  int iteration;
  bool done;
  bool proximal; /* the term is in A and b of this solve */
  double best_residual;
  reg_schedule schedule;
  double largest; /* impulse of the last iterate [N s] */
  double fastest; /* free velocity of a row of a contact [m/s] */
  formulation_answer answer;

  int cap_contact, cap_group, cap_row, cap_part, cap_iterated;
  size_t cap_sigma, cap_xyc, cap_A;
  void *mem, *dense_mem; /* owned */
} regularized;

/* regularized_law.c: parts of the step with their stiffness and transported state; the law at an
 * iterate; the memory of the next step. */
void reg_parts_build(regularized *s);
/* Evaluates the law at (lambda, u), both over the assembly's rows (pose=cone: u is w of regularized_cone.c): fills tau, r;
 * returns the largest deviation of lambda from the law over the largest impulse. */
double reg_law_residual(regularized *s, const double *lambda, const double *u);
/* Puts the law's friction impulses into lambda and stores states and modes. */
void reg_commit(regularized *s, double *lambda);
/* Remembers what slides in the motion that form_assembly_answer wrote from them. */
void reg_note_slides(regularized *s);
bool reg_is_lugre(const regularized *s, const reg_part *p);
/* Carries and asks for nothing that the tolerance can see. */
bool reg_is_idle(const regularized *s, const reg_part *p);

/* regularized_modes.c: the modes of the next solve, from the last iterate with that residual, or
 * after modes whose problem has no solution. */
void reg_modes_begin(regularized *s);
void reg_modes_next(regularized *s, double residual);
void reg_modes_without_solution(regularized *s);
/* After reg_modes_next with REG_PLAIN: the number of solves after which the loop is, bit for bit, in a state that it has been
 * in, so that it has no end; 0: it is not known to be. */
int reg_modes_circle(regularized *s);

/* regularized_once.c: modes from the state alone; friction known before the solve goes into `given` and into the free
 * velocities. Then what a part leaves behind: the impulse of the solve, and the next deflections. */
void reg_once_begin(regularized *s);
void reg_once_settle(const regularized *s, const reg_part *p, const double *lambda, double *next);

/* regularized_lugre.c */
void reg_lugre_begin(const reg_options *o, double h, reg_part *p);
/* eta at p->v under lambda_n. */
double reg_lugre_steady(const reg_options *o, double h, const reg_part *p, double lambda_n);
void reg_lugre_trial(const reg_options *o, double h, reg_part *p, double lambda_n, const double *u);
void reg_lugre_next(const reg_options *o, double h, double way, reg_part *p);
double reg_lugre_state(const reg_part *p, double h, int m);

/* Doubles remembered per contact: parts that no contact of the set has are not. */
contact_layout reg_layout(const contact_set *c);
/* form_regularized.c: the normal impulse that active contact i starts from [N s]: that of the last step, as a force of this one, or zero. */
double reg_start_impulse(const regularized *s, int i);

/* regularized_contact.c: compliant directions and slip columns of the current modes. */
void reg_rows_collect(regularized *s);
void reg_slip_column(const regularized *s, int j, double *f);

/* regularized_mass.c: MATHEMATICS 2.3.2. Ordering and memory for the contacts of this step; then as below,
 * expand giving u as well. */
base_status reg_mass_begin(regularized *s, base_error *err);
bool reg_mass_reduce(regularized *s);
void reg_mass_expand(regularized *s, const double *lambda_n, double *lambda, double *u);
void reg_mass_close(reg_mass *m);

/* regularized_cone.c. BASE_EINVAL: options that the cone does not have. */
base_status reg_cone_admits(const reg_options *o, base_error *err);
/* The problem of this step, from assembly, parts and the normal impulses in z0; s->cone.storage says how it is held. */
base_status reg_cone_begin(regularized *s, base_error *err);
/* Sets the coefficients of friction that the parts have now; false where they had them already. */
bool reg_cone_bounds(regularized *s);
lcp_problem reg_cone_problem(const regularized *s);
/* w of z over the assembly's rows, a view. */
const double *reg_cone_slips(regularized *s, const double *z);
void reg_cone_close(reg_cone *c);

/* regularized_contact.c: MATHEMATICS 2.3.3. Builds A and b for the current modes; false if the compliance
 * matrix is not positive definite (rigid and redundant friction). */
bool reg_contact_reduce(regularized *s);
/* lambda over the assembly's rows from the normal impulses. */
void reg_contact_expand(regularized *s, const double *lambda_n, double *lambda);
