/* contact_sweep_kernel.h - the record of four contacts and the two loops over it. */
#pragma once

#include "lcp/solvers/contact_sweep.h"

typedef double lcp_v4 __attribute__((vector_size(32)));
typedef long long lcp_m4 __attribute__((vector_size(32)));

/* Structure of arrays inside: [row][component][lane]. */
struct lcp_contact_batch {
  lcp_v4 t[2][3];   /* directions / sqrt(M_ii) of the first two rows */
  lcp_v4 third;     /* t_2 = third (t_0 x t_1) */
  lcp_v4 arm[2][3]; /* from the bodies to the point [m] */
  lcp_v4 A[3];      /* scaled M_10, M_20, M_21 [1] */
  lcp_v4 q[3];      /* q / sqrt(M_ii) */
  lcp_v4 x[3];      /* z sqrt(M_ii) */
  lcp_v4 bound[2];  /* friction bound sqrt(M_ii) */
  int body[2][4];   /* n_body where fixed */
};

/* Batches without a shared body, four contacts at once. */
void lcp_contact_kernel_full(lcp_contact_batch *batch, int count, double *body, double omega);

/* `count` contacts from batch[0] on, one by one. */
void lcp_contact_kernel_serial(lcp_contact_batch *batch, int count, double *body, double omega);

/* Adds the velocities that the impulses x of the first `count` contacts cause. */
void lcp_contact_kernel_push(const lcp_contact_batch *batch, int count, double *body);
