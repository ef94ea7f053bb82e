#include "lcp/solvers/batch_waves.h"
#include "lcp/solvers/contact_sweep_kernel.h"

#include <assert.h>
#include <string.h>

void lcp_contact_sweep_layout(lcp_contact_sweep *s, const lcp_capacity *cap, base_arena *a) {
  const size_t bodies = (size_t)cap->n_body;
  const size_t rows = (cap->n_body > 0) ? (size_t)cap->n : 0, contacts = rows / 3;
  s->batch = BASE_ARRAY(a, lcp_contact_batch, contacts);
  s->body = BASE_ARRAY(a, double, 16 * lcp_batches_bodies(contacts, bodies));
  lcp_batches_layout(&s->in, contacts, bodies, a);
  s->root = BASE_ARRAY(a, double, rows);
}

/* ---- does the problem have the form? ------------------------------------------------------- */

static bool admits_group(const lcp_gs *gs, const lcp_factored *f, int g) {
  const int i = f->row_start[g], *body = &f->body[2 * (ptrdiff_t)g];
  lcp_contact_frame unused;
  if (f->row_start[g + 1] - i != 3 || body[0] == body[1]) {
    return false;
  }
  for (int r = 0; r < 3; r++) {
    const bool bounds =
        (r == 0) ? gs->lo[i] == 0.0 && gs->hi[i] == HUGE_VAL : gs->lo[i + r] == -gs->hi[i + r];
    if (!bounds || !(gs->sweep.d[i + r] > 0.0)) {
      return false;
    }
  }
  return lcp_contact_frame_of_group(f, g, &unused);
}

static bool admits(const lcp_gs *gs, const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  if (p->M.storage != LCP_FACTORED || f->shift != NULL || gs->by_block || f->n_group == 0) {
    return false;
  }
  if (!lcp_contact_rigid(f)) {
    return false;
  }
  for (int g = 0; g < f->n_group; g++) {
    if (!admits_group(gs, f, g)) {
      return false;
    }
  }
  return true;
}

/* ---- records ------------------------------------------------------------------------------- */

static void record(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p, int k) {
  const lcp_factored *f = p->M.factored;
  lcp_contact_batch *c = &s->batch[k / LCP_LANES];
  const int l = k % LCP_LANES, g = s->in.order[k], first = (g >= 0) ? f->row_start[g] : 0;
  double unit[3] = {1.0, 1.0, 1.0}, *root = (g >= 0) ? s->root + first : unit, A[9] = {0};
  lcp_contact_frame frame;
  if (g >= 0) {
    (void)lcp_contact_frame_of_group(f, g, &frame); /* admitted */
    lcp_sweep_block(&gs->sweep, p, first, 3, A);
  }
  for (int r = 0; r < 3; r++) {
    root[r] = (g >= 0) ? sqrt(gs->sweep.d[first + r]) : 1.0;
    c->q[r][l] = (g >= 0) ? p->q[first + r] / root[r] : 0.0;
    c->x[r][l] = 0.0;
  }
  lcp_contact_place(&c->at, k, f, g, (g >= 0) ? &frame : NULL, root);
  for (int side = 0; side < 2; side++) {
    c->bound[side][l] = (g >= 0) ? gs->hi[first + 1 + side] * root[1 + side] : 0.0;
  }
  c->at.third[l] *= root[0] * root[1] / root[2];
  c->A[0][l] = A[1] / (root[0] * root[1]);
  c->A[1][l] = A[2] / (root[0] * root[2]);
  c->A[2][l] = A[5] / (root[1] * root[2]);
}

typedef struct recording {
  lcp_contact_sweep *s;
  const lcp_gs *gs;
  const lcp_problem *p;
} recording;

static void record_stretch(void *of, int first, int count) {
  const recording *r = of;
  for (int k = LCP_LANES * first; k < LCP_LANES * (first + count); k++) {
    record(r->s, r->gs, r->p, k);
  }
}

bool lcp_contact_sweep_prepare(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p) {
  s->in.n_contact = 0;
  if (!admits(gs, p)) {
    return false;
  }
  const lcp_factored *f = p->M.factored;
  lcp_contact_bodies(f, s->body);
  lcp_batches_order(&s->in, f);
  recording r = {s, gs, p};
  lcp_batch_shares(&s->in, record_stretch, &r);
  return true;
}

void lcp_contact_sweep_import(lcp_contact_sweep *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  assert(lcp_batches_are_partitioned(&s->in, f));
  lcp_contact_stop_bodies(f, s->body);
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    lcp_contact_batch *c = &s->batch[k / LCP_LANES];
    const int g = s->in.order[k], first = (g >= 0) ? f->row_start[g] : 0;
    for (int r = 0; r < 3; r++) {
      c->x[r][k % LCP_LANES] = (g >= 0) ? z[first + r] * s->root[first + r] : 0.0;
    }
  }
  lcp_contact_kernel_push(s->batch, s->in.n_batch, s->body);
}

typedef struct sweeping {
  lcp_contact_sweep *s;
  double omega;
} sweeping;

static void sweep_stretch(void *of, int first, int count) {
  const sweeping *w = of;
  lcp_contact_kernel_sweep(w->s->batch + first, count, w->s->body, w->omega);
}

void lcp_contact_sweep_run(lcp_contact_sweep *s, double omega, int sweeps) {
  sweeping w = {s, omega};
  lcp_batch_waves(&s->in, sweeps, sweep_stretch, &w);
}

void lcp_contact_sweep_export(const lcp_contact_sweep *s, const lcp_problem *p, double *z) {
  const lcp_factored *f = p->M.factored;
  for (int k = 0; k < LCP_LANES * s->in.n_batch; k++) {
    const lcp_contact_batch *c = &s->batch[k / LCP_LANES];
    const int g = s->in.order[k], first = (g >= 0) ? f->row_start[g] : 0;
    for (int r = 0; r < 3 && g >= 0; r++) {
      z[first + r] = c->x[r][k % LCP_LANES] / s->root[first + r];
    }
  }
}
