/* problems/import/friction_problem.h - one frictional contact problem as other codes store it.
 *
 * Rows of a contact: normal, tangents (1 in the plane, 2 in space), and with rolling two more.
 *   local    u = W r + q
 *   global   M v = H r + f,  u = H' v + w      (W = H' M^-1 H, q = H' M^-1 f + w)
 * and with joints (FCLIB only), multipliers l free:
 *   local    u = W r + V l + q,  0 = V' r + R l + s
 *   global   M v = H r + G l + f,  u = H' v + w,  0 = G' v + b
 * with u + (mu |u_T| [+ mu_r |u_R|]) e_n in K*, r in K, u _|_ r (Acary, Bremond & Huber 2018). */
#pragma once

#include "lcp/lcp_problem.h"
#include "problems/families/known_lcp.h"

typedef struct friction_problem {
  int rows; /* of a contact: 2, 3, or 5 with rolling */
  int n_contact;
  bool global;
  lcp_csc W; /* local; owned, as all below */
  double *q; /* local, rows * n_contact */
  lcp_csc M, H;
  double *f;    /* global, dofs */
  double *w;    /* global, rows * n_contact */
  int n_joint;  /* rows; 0: none */
  lcp_csc V, R; /* local, rows * n_contact x n_joint and n_joint x n_joint */
  double *s;    /* local, n_joint */
  lcp_csc G;    /* global, dofs x n_joint */
  double *b;    /* global, n_joint */
  double *mu;   /* n_contact */
  double *mu_r; /* n_contact with rows = 5, else NULL [m] */
  char title[160];
} friction_problem;

void friction_free(friction_problem *p);

/* Shapes, finiteness, mu >= 0. */
base_status friction_check(const friction_problem *p, base_error *err);

/* ---- readers: refuse sizes that the file cannot hold before allocating -------------------- */

/* A file is tried in a child process first, because libhdf5 itself fails on some (survives.h);
 * `_here` is the reader without that, for scripts/fuzz. */
base_status friction_read_fclib(const char *path, friction_problem *out, base_error *err);
base_status friction_read_fclib_here(const char *path, friction_problem *out, base_error *err);
base_status friction_read_siconos(const char *path, friction_problem *out, base_error *err);

/* ---- writers: read back to the same bits -------------------------------------------------- */

base_status friction_write_fclib(const char *path, const friction_problem *p, base_error *err);
base_status friction_write_siconos(const char *path, const friction_problem *p, base_error *err);

/* ---- problems to solve -------------------------------------------------------------------- */

/* Replaces a global problem by its local one, without joints, W exactly symmetric: sparse Cholesky of M's symmetric
 * part. An inertia matrix must be symmetric to 1e-5 of its largest entry (some files of other codes
 * are to 1.5e-6) and positive definite. Joints are eliminated, also of local problems; they must be independent. */
base_status friction_condense(friction_problem *p, base_error *err);

/* Parts of friction_condense. [H G] and [w b] in place of H and w; the joint rows and columns of what
 * that condenses to, cut out again; joints of a local problem eliminated. */
base_status friction_join_joints(friction_problem *p, base_error *err);
base_status friction_split_joints(friction_problem *p, base_error *err);
base_status friction_eliminate_joints(friction_problem *p, base_error *err);

/* The exact problem: one LCP_CONE block a contact. p must be local; *out owns copies. */
base_status friction_pose_cone(const friction_problem *p, known_lcp *out, base_error *err);

/* The polyhedral LCP with nd facets (2 in the plane), inscribed, unknowns contact by contact
 * (r_n, beta_1 .. beta_nd, sigma), and with rolling gamma_1 .. gamma_nd [N m s] and a sigma of their
 * own. p must be local. */
base_status friction_pose_facets(const friction_problem *p, int nd, known_lcp *out,
                                 base_error *err);
/* Impulses r (rows * n_contact) of a solution z of that LCP. */
void friction_facet_impulse(int rows, int n_contact, int nd, const double *z, double *r);
