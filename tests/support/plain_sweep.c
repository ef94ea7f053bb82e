#include "tests/support/plain_sweep.h"

#include "lcp/base/rng.h"

#include <stdlib.h>
#include <string.h>

static void cross(const double *a, const double *b, double *out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- the bed ------------------------------------------------------------------------------- */

/* Views into the two blocks of memory. */
typedef struct arrays {
  double *weight, *jac, *q, *lo, *hi;
  int *dof_start, *weight_start, *row_start, *body, *jac_start;
} arrays;

static void random_frame(base_rng *r, const double *axis, double *frame) {
  double *n = frame, *t1 = frame + 3, *t2 = frame + 6;
  for (int i = 0; i < 3; i++) {
    n[i] = axis[i] + base_rng_between(r, -0.3, 0.3);
  }
  const double size = sqrt(dot(n, n));
  for (int i = 0; i < 3; i++) {
    n[i] /= size;
  }
  const double other[3] = {axis[1], axis[2], axis[0]};
  cross(n, other, t1);
  const double length = sqrt(dot(t1, t1));
  for (int i = 0; i < 3; i++) {
    t1[i] /= length;
  }
  cross(n, t1, t2);
}

static void add_contact(contact_bed *bed, arrays *m, base_rng *r, int a, int b, int axis) {
  const int g = bed->n_contact;
  double direction[3] = {0};
  direction[axis] = 1.0;
  double *frame = bed->frame + 9 * (size_t)g, *arm = bed->arm + 6 * (size_t)g;
  random_frame(r, direction, frame);
  for (int i = 0; i < 6; i++) {
    arm[i] = base_rng_between(r, -0.5, 0.5);
  }
  m->body[2 * (ptrdiff_t)g] = a;
  m->body[2 * g + 1] = b;
  m->row_start[g + 1] = 3 * (g + 1);
  double *jac = m->jac + m->jac_start[g];
  for (int side = 0; side < 2; side++) {
    const double sign = (side == 0) ? 1.0 : -1.0;
    for (int k = 0; k < 3 && ((side == 0) ? a : b) >= 0; k++, jac += 6) {
      double turn[3];
      cross(arm + 3 * side, frame + 3 * k, turn);
      for (int i = 0; i < 3; i++) {
        jac[i] = sign * frame[3 * k + i];
        jac[3 + i] = sign * turn[i];
      }
    }
  }
  m->jac_start[g + 1] = m->jac_start[g] + ((b >= 0) ? 36 : 18);
  for (int k = 0; k < 3; k++) {
    m->q[3 * g + k] = base_rng_between(r, -1.0, (k == 0) ? 0.2 : 1.0);
    m->lo[3 * g + k] = (k == 0) ? 0.0 : -0.4;
    m->hi[3 * g + k] = (k == 0) ? HUGE_VAL : 0.4;
  }
  bed->n_contact++;
}

static void weigh(arrays *m, base_rng *r, int b) {
  double *W = m->weight + 36 * (size_t)b;
  memset(W, 0, 36 * sizeof *W);
  const double mass = base_rng_between(r, 0.5, 2.0);
  double a[9];
  for (int i = 0; i < 9; i++) {
    a[i] = base_rng_between(r, -1.0, 1.0);
  }
  for (int i = 0; i < 3; i++) {
    W[7 * i] = 1.0 / mass;
    for (int j = 0; j <= i; j++) {
      const double v = (((i == j) ? 3.0 : 0.0) + dot(a + 3 * i, a + 3 * j)) / mass;
      W[(3 + i) + 6 * (3 + j)] = W[(3 + j) + 6 * (3 + i)] = v;
    }
  }
  m->dof_start[b + 1] = 6 * (b + 1);
  m->weight_start[b + 1] = 36 * (b + 1);
}

/* An orthant and a box block for each contact, the factored form and the problem. */
typedef struct headers {
  lcp_factored f;
  lcp_block block[];
} headers;

static bool allocate(contact_bed *bed, arrays *m, int bodies, int contacts) {
  const size_t nb = (size_t)bodies, nc = (size_t)contacts;
  bed->memory = malloc((36 * nb + (36 + 9 + 15) * nc) * sizeof(double));
  bed->index = malloc((2 * (nb + 1) + 4 * nc + 2) * sizeof(int));
  headers *h = malloc(sizeof(headers) + 2 * nc * sizeof(lcp_block));
  if (bed->memory == NULL || bed->index == NULL || h == NULL) {
    free(h);
    contact_bed_close(bed);
    return false;
  }
  double *at = bed->memory;
  m->weight = at;
  m->jac = at += 36 * nb;
  m->q = at += 36 * nc;
  m->lo = at += 3 * nc;
  m->hi = at += 3 * nc;
  bed->frame = at += 3 * nc;
  bed->arm = at + 9 * nc;
  m->dof_start = bed->index;
  m->weight_start = m->dof_start + nb + 1;
  m->row_start = m->weight_start + nb + 1;
  m->body = m->row_start + nc + 1;
  m->jac_start = m->body + 2 * nc;
  m->dof_start[0] = m->weight_start[0] = m->row_start[0] = m->jac_start[0] = 0;
  for (int g = 0; g < contacts; g++) {
    h->block[2 * g] = (lcp_block){.start = 3 * g, .size = 1, .set = LCP_ORTHANT};
    h->block[2 * g + 1] = (lcp_block){.start = 3 * g + 1, .size = 2, .set = LCP_BOX};
  }
  h->f = (lcp_factored){.n_body = bodies,
                        .dof_start = m->dof_start,
                        .weight_start = m->weight_start,
                        .weight = m->weight,
                        .n_group = contacts,
                        .row_start = m->row_start,
                        .body = m->body,
                        .jac_start = m->jac_start,
                        .jac = m->jac};
  bed->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = 3 * contacts, .factored = &h->f},
                         .q = m->q,
                         .lo = m->lo,
                         .hi = m->hi,
                         .block = h->block,
                         .n_block = 2 * contacts,
                         .traits = LCP_SYMMETRIC | LCP_PSD};
  return true;
}

contact_bed contact_bed_open(int n_contact, unsigned long seed) {
  contact_bed bed = {0};
  arrays m;
  base_rng r = base_rng_seeded(seed);
  int edge = 1; /* a lattice of edge^3 bodies has about 3 edge^3 contacts */
  while (3 * edge * edge * edge - 2 * edge * edge < n_contact) {
    edge++;
  }
  const int bodies = edge * edge * edge;
  if (!allocate(&bed, &m, bodies, n_contact)) {
    return bed;
  }
  bed.n_body = bodies;
  for (int b = 0; b < bodies; b++) {
    weigh(&m, &r, b);
  }
  for (int b = 0; b < bodies; b++) {
    const int at[3] = {b % edge, b / edge % edge, b / edge / edge};
    const int stride[3] = {1, edge, edge * edge};
    for (int axis = 0; axis < 3; axis++) {
      const bool floor = axis == 2 && at[2] == 0;
      if ((at[axis] > 0 || floor) && bed.n_contact < n_contact) {
        add_contact(&bed, &m, &r, b, floor ? -1 : b - stride[axis], axis);
      }
    }
  }
  return bed;
}

void contact_bed_close(contact_bed *bed) {
  free((void *)(uintptr_t)bed->p.M.factored); /* heads the block that holds the lcp_blocks too */
  free(bed->memory);
  free(bed->index);
  *bed = (contact_bed){0};
}

/* ---- J and W J' stored ---------------------------------------------------------------------- */

void plain_rows_fill(const contact_bed *bed, const int *order, plain_contact_rows *c) {
  const lcp_factored *f = bed->p.M.factored;
  for (int k = 0; k < bed->n_contact; k++, c++) {
    const int g = (order != NULL) ? order[k] : k;
    const double *jac = f->jac + f->jac_start[g];
    memset(c, 0, sizeof *c);
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      c->body[side] = (b >= 0) ? b : bed->n_body;
      for (int r = 0; r < 3 && b >= 0; r++, jac += 6) {
        const double *W = f->weight + f->weight_start[b];
        for (int i = 0; i < 6; i++) {
          c->J[r][6 * side + i] = jac[i];
          for (int j = 0; j < 6; j++) {
            c->B[r][6 * side + i] += W[i + 6 * j] * jac[j];
          }
        }
      }
    }
    for (int r = 0; r < 3; r++) {
      double d = 0.0;
      for (int i = 0; i < 12; i++) {
        d += c->J[r][i] * c->B[r][i];
      }
      c->inverse[r] = 1.0 / d;
      c->q[r] = bed->p.q[3 * g + r];
      c->bound[r] = bed->p.hi[3 * g + r];
    }
  }
}

void plain_rows_sweep(plain_contact_rows *c, int n, double *v) {
  for (int k = 0; k < n; k++, c++) {
    double *va = v + 6 * (size_t)c->body[0], *vb = v + 6 * (size_t)c->body[1];
    for (int r = 0; r < 3; r++) {
      double w = c->q[r];
      for (int i = 0; i < 6; i++) {
        w += c->J[r][i] * va[i] + c->J[r][6 + i] * vb[i];
      }
      double x = c->z[r] - w * c->inverse[r];
      const double lo = (r == 0) ? 0.0 : -c->bound[r];
      x = (x < lo) ? lo : ((x > c->bound[r]) ? c->bound[r] : x);
      const double dz = x - c->z[r];
      c->z[r] = x;
      for (int i = 0; i < 6; i++) {
        va[i] += c->B[r][i] * dz;
        vb[i] += c->B[r][6 + i] * dz;
      }
    }
  }
}

/* ---- frames and arms ------------------------------------------------------------------------ */

void plain_frames_fill(const contact_bed *bed, const int *order, plain_contact_frames *c,
                       plain_body *body) {
  const lcp_factored *f = bed->p.M.factored;
  memset(&body[bed->n_body], 0, sizeof *body); /* the floor does not move */
  for (int b = 0; b < bed->n_body; b++) {
    const double *W = f->weight + f->weight_start[b];
    body[b].inverse_mass = W[0];
    for (int i = 0; i < 9; i++) {
      body[b].inverse_inertia[i] = W[(3 + i % 3) + 6 * (3 + i / 3)];
    }
  }
  for (int k = 0; k < bed->n_contact; k++, c++) {
    const int g = (order != NULL) ? order[k] : k;
    const double *frame = bed->frame + 9 * (size_t)g;
    memcpy(c->n, frame, sizeof c->n);
    memcpy(c->t, frame + 3, sizeof c->t);
    memcpy(c->arm, bed->arm + 6 * (size_t)g, sizeof c->arm);
    for (int side = 0; side < 2; side++) {
      c->body[side] = (f->body[2 * g + side] >= 0) ? f->body[2 * g + side] : bed->n_body;
    }
    for (int r = 0; r < 3; r++) {
      double d = 0.0;
      for (int side = 0; side < 2; side++) {
        const plain_body *m = &body[c->body[side]];
        double turn[3], spin[3];
        cross(c->arm[side], frame + 3 * r, turn);
        for (int i = 0; i < 3; i++) {
          spin[i] = dot(m->inverse_inertia + 3 * i, turn);
        }
        d += m->inverse_mass + dot(turn, spin);
      }
      c->inverse[r] = 1.0 / d;
      c->q[r] = bed->p.q[3 * g + r];
      c->z[r] = 0.0;
    }
    c->bound[0] = bed->p.hi[3 * g + 1];
    c->bound[1] = bed->p.hi[3 * g + 2];
  }
}

void plain_frames_sweep(plain_contact_frames *c, int n, const plain_body *body, double *v) {
  for (int k = 0; k < n; k++, c++) {
    double *va = v + 6 * (size_t)c->body[0], *vb = v + 6 * (size_t)c->body[1];
    const plain_body *ma = &body[c->body[0]], *mb = &body[c->body[1]];
    double third[3];
    cross(c->n, c->t, third);
    const double *direction[3] = {c->n, c->t, third};
    for (int r = 0; r < 3; r++) {
      const double *d = direction[r];
      double ra[3], rb[3];
      cross(c->arm[0], d, ra);
      cross(c->arm[1], d, rb);
      const double w = c->q[r] + dot(d, va) + dot(ra, va + 3) - dot(d, vb) - dot(rb, vb + 3);
      double x = c->z[r] - w * c->inverse[r];
      const double lo = (r == 0) ? 0.0 : -c->bound[r - 1], hi = (r == 0) ? HUGE_VAL : -lo;
      x = (x < lo) ? lo : ((x > hi) ? hi : x);
      const double dz = x - c->z[r], pa = ma->inverse_mass * dz, pb = mb->inverse_mass * dz;
      c->z[r] = x;
      for (int i = 0; i < 3; i++) {
        va[i] += d[i] * pa;
        vb[i] -= d[i] * pb;
        va[3 + i] += dot(ma->inverse_inertia + 3 * i, ra) * dz;
        vb[3 + i] -= dot(mb->inverse_inertia + 3 * i, rb) * dz;
      }
    }
  }
}
