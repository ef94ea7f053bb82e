#include "lcp/solvers/cone_batches.h"

#include "lcp/solvers/batch_waves.h"
#include "lcp/solvers/cone_batches_kernel.h"
#include "lcp/solvers/cone_block.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

static const double regular = 1e-9; /* least value of S over its largest */

void lcp_cone_batches_layout(lcp_cone_batches *s, const lcp_capacity *cap, base_arena *a) {
  const size_t bodies = (size_t)cap->n_body;
  const size_t contacts = (cap->n_body > 0) ? (size_t)cap->n / 3 : 0;
  s->batch = BASE_ARRAY(a, lcp_cone_batch, contacts);
  s->body = BASE_ARRAY(a, double, 16 * lcp_batches_bodies(contacts, bodies));
  s->axis = BASE_ARRAY(a, double, 3 * contacts);
  lcp_batches_layout(&s->in, contacts, bodies, a);
}

/* The local problem of a contact in the axes of S. */
typedef struct local {
  double inverse, slope[2], stiff[2], turn[2];
} local;

/* Cosine (>= 0) and sine of half the angle of (x, y), of length r. */
static void half_turn(double x, double y, double r, double *c, double *s) {
  *c = 1.0;
  *s = 0.0;
  if (r > 0.0 && x >= 0.0) {
    *c = sqrt(0.5 * (1.0 + x / r));
    *s = y / (2.0 * r * *c);
  } else if (r > 0.0) {
    *s = copysign(sqrt(0.5 * (1.0 - x / r)), y);
    *c = y / (2.0 * r * *s);
  }
}

/* False where A_nn or S is not safely positive. */
static bool local_of(const double *A, local *out) {
  const double coupling[2] = {A[1] / A[0], A[2] / A[0]};
  const double S00 = A[4] - A[1] * coupling[0], S11 = A[8] - A[2] * coupling[1];
  const double off = 0.5 * (A[5] + A[7]) - A[1] * coupling[1];
  const double mean = 0.5 * (S00 + S11), half = 0.5 * (S00 - S11);
  const double radius = sqrt(half * half + off * off);
  double c, s;
  half_turn(half, off, radius, &c, &s);
  *out = (local){.inverse = 1.0 / A[0],
                 .slope = {c * coupling[0] + s * coupling[1], c * coupling[1] - s * coupling[0]},
                 .stiff = {mean + radius, mean - radius},
                 .turn = {c, s}};
  return A[0] > 0.0 && out->stiff[1] > regular * fmax(A[4], A[8]);
}

static bool admits_group(const lcp_problem *p, int g) {
  const lcp_factored *f = p->M.factored;
  const lcp_block *b = &p->block[g];
  return b->set == LCP_CONE && b->start == f->row_start[g] && b->size == 3 && b->n_part == 1 &&
         b->part_mu[0] > 0.0 && f->row_start[g + 1] - f->row_start[g] == 3 &&
         f->body[2 * g] != f->body[2 * g + 1];
}

/* All but what `record` finds. */
static bool admits(const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  bool good = p->M.storage == LCP_FACTORED && f->shift == NULL && f->n_group > 0 &&
              p->block != NULL && p->n_block == f->n_group && lcp_contact_rigid(f);
  for (int g = 0; good && g < f->n_group; g++) {
    good = admits_group(p, g);
  }
  return good;
}

/* In the axes of S, t_2 = t_0 x t_1: x = (c z_1 + s z_2, hand (c z_2 - s z_1)). */
static void to_axes(const double *axis, const double *z, double *x) {
  x[0] = z[0];
  x[1] = axis[0] * z[1] + axis[1] * z[2];
  x[2] = axis[2] * (axis[0] * z[2] - axis[1] * z[1]);
}

static void from_axes(const double *axis, const double *x, double *z) {
  z[0] = x[0];
  z[1] = axis[0] * x[1] - axis[1] * (axis[2] * x[2]);
  z[2] = axis[1] * x[1] + axis[0] * (axis[2] * x[2]);
}

/* The contact in place k; false: it has not the form. */
static bool record(lcp_cone_batches *s, const lcp_problem *p, int k) {
  lcp_cone_batch *c = &s->batch[k / LCP_LANES];
  const int l = k % LCP_LANES, g = s->in.order[k];
  lcp_contact_frame frame;
  local at = {.inverse = 1.0, .stiff = {1.0, 1.0}};
  double q[3] = {1.0, 0.0, 0.0};
  if (g >= 0) {
    const lcp_factored *f = p->M.factored;
    double *axis = s->axis + 3 * (ptrdiff_t)g;
    double first[3], A[9];
    lcp_contact_block(f, g, s->body, A);
    if (!lcp_contact_frame_of_group(f, g, &frame) || !local_of(A, &at)) {
      return false;
    }
    memcpy(axis, (const double[3]){at.turn[0], at.turn[1], frame.hand}, 3 * sizeof *axis);
    to_axes(axis, p->q + p->block[g].start, q);
    for (int i = 0; i < 3; i++) {
      first[i] = axis[0] * frame.d[1][i] + axis[1] * frame.d[2][i];
    }
    memcpy(frame.d[1], first, sizeof first);
    frame.hand = 1.0;
    at.slope[1] *= axis[2];
  }
  lcp_contact_place(&c->at, k, p->M.factored, g, (g >= 0) ? &frame : NULL, NULL);
  c->mu[l] = (g >= 0) ? p->block[g].part_mu[0] : 1.0;
  c->inverse[l] = at.inverse;
  for (int i = 0; i < 3; i++) {
    c->q[i][l] = q[i];
    c->r[i][l] = 0.0;
  }
  for (int i = 0; i < 2; i++) {
    c->slope[i][l] = at.slope[i];
    c->stiff[i][l] = at.stiff[i];
    c->soft[i][l] = 1.0 / at.stiff[i];
  }
  return true;
}

typedef struct recording {
  lcp_cone_batches *s;
  const lcp_problem *p;
  atomic_bool failed;
} recording;

static void record_stretch(void *of, int first, int count) {
  recording *r = of;
  for (int k = LCP_LANES * first; k < LCP_LANES * (first + count); k++) {
    if (!record(r->s, r->p, k)) {
      atomic_store(&r->failed, true);
      return;
    }
  }
}

bool lcp_cone_batches_prepare(lcp_cone_batches *s, const lcp_problem *p) {
  s->in.n_contact = 0;
  if (!admits(p)) {
    return false;
  }
  lcp_contact_bodies(p->M.factored, s->body);
  lcp_batches_order(&s->in, p->M.factored);
  recording r = {.s = s, .p = p};
  lcp_batch_shares(&s->in, record_stretch, &r);
  return !atomic_load(&r.failed);
}

static void import(lcp_cone_batches *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  assert(lcp_batches_are_partitioned(&s->in, f));
  lcp_contact_stop_bodies(f, s->body);
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    const int l = k % LCP_LANES, g = s->in.order[k];
    lcp_cone_batch *c = &s->batch[k / LCP_LANES];
    double x[3];
    c->slip[l] = 0.0;
    if (g < 0) {
      continue;
    }
    to_axes(s->axis + 3 * (ptrdiff_t)g, z + p->block[g].start, x);
    for (int i = 0; i < 3; i++) {
      c->r[i][l] = x[i];
    }
  }
  lcp_cone_kernel_push(s->batch, s->in.n_batch, s->body);
}

static void export(const lcp_cone_batches *s, const lcp_problem *p, double *z) {
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    const int l = k % LCP_LANES, g = s->in.order[k];
    const lcp_cone_batch *c = &s->batch[k / LCP_LANES];
    if (g < 0) {
      continue;
    }
    double *to = z + p->block[g].start;
    from_axes(s->axis + 3 * (ptrdiff_t)g, (const double[3]){c->r[0][l], c->r[1][l], c->r[2][l]},
              to);
    const double size = sqrt(to[1] * to[1] + to[2] * to[2]), bound = c->mu[l] * to[0];
    for (int i = 1; i < 3 && size > bound; i++) {
      to[i] *= bound / size;
    }
  }
}

typedef struct sweeping {
  lcp_cone_batches *s;
  double omega;
} sweeping;

static void sweep_stretch(void *of, int first, int count) {
  const sweeping *w = of;
  lcp_cone_kernel_sweep(w->s->batch + first, count, w->s->body, w->omega);
}

void lcp_cone_batches_run(lcp_cone_batches *s, const lcp_problem *p, double omega, long sweeps,
                          double *z) {
  sweeping w = {s, omega};
  import(s, p, z);
  lcp_batch_waves(&s->in, sweeps, sweep_stretch, &w);
  export(s, p, z);
}
