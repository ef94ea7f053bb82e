/* contact_sweep_kernel.h - the record of four contacts and the two loops over it. */
#pragma once

#include "lcp/solvers/contact_sweep.h"

typedef double lcp_v4 __attribute__((vector_size(32)));
typedef long long lcp_m4 __attribute__((vector_size(32)));

/* Structure of arrays inside: [row][component][lane]. */
struct lcp_contact_batch {
  lcp_v4 t[3][3];  /* direction / sqrt(M_ii) [1] */
  lcp_v4 ga[3][3]; /* angular row of body a, mass-weighted */
  lcp_v4 gb[3][3]; /* of body b */
  lcp_v4 q[3];     /* q / sqrt(M_ii) */
  lcp_v4 z[3];     /* z sqrt(M_ii) */
  lcp_v4 bound[2]; /* friction bound sqrt(M_ii) */
  int a[4], b[4];  /* bodies; n_body where fixed */
};

/* Batches without a shared body, four contacts at once. */
void lcp_contact_kernel_full(lcp_contact_batch *batch, int count, double *body, double omega);

/* `count` contacts from batch[0] on, one by one. */
void lcp_contact_kernel_serial(lcp_contact_batch *batch, int count, double *body, double omega);
