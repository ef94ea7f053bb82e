/* problems/world/contact_merit.h - the physical yardstick: how far is a step from Signorini contact with
 * an isotropic Coulomb cone? Independent of every formulation, so that formulations can be
 * compared (RESIDUALS 5: De Saxce's natural map; Acary, Bremond & Huber 2018).
 *
 * For each contact with impulse (l_n, l_t), velocity u = J v+ + drift and normal bias b
 * (restitution, gap/h) the common model is
 *   K* in  u + (b + mu |u_t|) e_n   _|_   l in K,   K = { |l_t| <= mu l_n }.
 */
#pragma once

#include "problems/world/contact_set.h"

typedef struct contact_merit {
  double ncp;         /* max_i || a_i l - P_K(a_i l - u~) ||, a_i = (J_n W J_n')_ii  [m/s] */
  double ncp_rel;     /* ncp / max(speed scale of the step, tiny) [1] */
  double normal;      /* max_i |min(a_i l_n, u_n + b)|  [m/s] */
  double cone;        /* max_i max(0, |l_t| - mu l_n)  [N s] */
  double cone_rel;    /* over max_i mu l_n; mu = 1 with torsion or rolling only [1] */
  double dissipation; /* sum_i (mu l_n |u_t| + l_t . u_t)  [J], >= 0; 0 for exact Coulomb */
  double momentum;    /* || M (v+ - v_free) - J' l || / || M v || + ... [1] */
  double joint;       /* max |J_b v+ + drift| over joint rows [m/s] */
  double joint_rel;   /* the same beyond what a row may move, over the speeds of bodies [1] */
} contact_merit;

/* A joint row may move by h (dJ/dt) v, and by its error, taken back within the step. What it moves beyond that is measured
 * against the largest ||J_b|| of a row times the largest ||v+|| + ||v_free|| of a body, plus |drift|.
 * impulse, u of n_row entries; bias of n_contact entries, b_i = HUGE_VAL for a contact that the
 * formulation left out (judged only if its impulse is not zero). */
base_status contact_merit_at(const contact_set *c, const double *impulse, const double *v_next,
                             const double *bias, contact_merit *out, base_error *err);
