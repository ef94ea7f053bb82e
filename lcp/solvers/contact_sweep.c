#include "lcp/solvers/contact_sweep_kernel.h"

#include <string.h>

enum { WINDOW = 64, PASSES = 16 };

void lcp_contact_sweep_layout(lcp_contact_sweep *s, const lcp_capacity *cap, base_arena *a) {
  const size_t bodies = (cap->n_body > 0) ? (size_t)cap->n_body + 1 : 0;
  const size_t rows = (cap->n_body > 0) ? (size_t)cap->n : 0, contacts = rows / 3;
  s->batch = BASE_ARRAY(a, lcp_contact_batch, contacts / LCP_LANES + 1);
  s->body = BASE_ARRAY(a, double, 8 * bodies);
  s->open = BASE_ARRAY(a, unsigned long long, bodies);
  s->order = BASE_ARRAY(a, int, contacts);
  s->left = BASE_ARRAY(a, int, contacts);
  s->next_left = BASE_ARRAY(a, int, contacts);
  s->root = BASE_ARRAY(a, double, rows);
}

/* ---- does the problem have the form? ------------------------------------------------------- */

/* W = diag(I/m, inertia^-1), 6 x 6. */
static bool rigid(const double *W) {
  for (int j = 0; j < 6; j++) {
    for (int i = 0; i < 3; i++) {
      if (W[i + 6 * j] != ((i == j) ? W[0] : 0.0)) {
        return false;
      }
    }
  }
  return W[0] > 0.0;
}

/* Opposite directions on the two sides, to rounding: s_b G_a = - s_a G_b. */
static bool opposite(const double *ga, const double *gb, double sa, double sb) {
  double gap = 0.0, size = 0.0;
  for (int i = 0; i < 3; i++) {
    gap = fmax(gap, fabs(sb * ga[i] + sa * gb[i]));
    size = fmax(size, fabs(sb * ga[i]));
  }
  return gap <= 8e-16 * size;
}

static bool admits_group(const lcp_gs *gs, const lcp_factored *f, int g) {
  const int i = f->row_start[g], *body = &f->body[2 * g];
  if (f->row_start[g + 1] - i != 3 || (body[0] < 0 && body[1] < 0) || body[0] == body[1]) {
    return false;
  }
  const double *G = gs->sweep.G + f->jac_start[g];
  for (int r = 0; r < 3; r++) {
    const bool bounds =
        (r == 0) ? gs->lo[i] == 0.0 && gs->hi[i] == HUGE_VAL : gs->lo[i + r] == -gs->hi[i + r];
    if (!bounds || !(gs->sweep.d[i + r] > 0.0)) {
      return false;
    }
    if (body[0] >= 0 && body[1] >= 0 &&
        !opposite(G + 6 * r, G + 18 + 6 * r, gs->sweep.L[f->weight_start[body[0]]],
                  gs->sweep.L[f->weight_start[body[1]]])) {
      return false;
    }
  }
  return true;
}

static bool admits(const lcp_gs *gs, const lcp_problem *p) {
  const lcp_factored *f = p->M.factored;
  if (p->M.storage != LCP_FACTORED || f->shift != NULL || gs->by_block || f->n_group == 0) {
    return false;
  }
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] != 6 || !rigid(f->weight + f->weight_start[b])) {
      return false;
    }
  }
  for (int g = 0; g < f->n_group; g++) {
    if (!admits_group(gs, f, g)) {
      return false;
    }
  }
  return true;
}

/* ---- colouring ----------------------------------------------------------------------------- */

typedef struct window {
  int contact[WINDOW][LCP_LANES], count[WINDOW];
  unsigned long long used, room; /* slots with contacts; of these, slots with a free lane */
  int oldest;                    /* slot that gives way next */
} window;

static void touch(const lcp_contact_sweep *s, const lcp_factored *f, int contact,
                  unsigned long long bit, bool on) {
  for (int k = 0; k < 2; k++) {
    const int b = f->body[2 * contact + k];
    if (b >= 0) {
      s->open[b] = on ? (s->open[b] | bit) : (s->open[b] & ~bit);
    }
  }
}

/* Empties a slot into `to`. */
static void empty(const lcp_contact_sweep *s, const lcp_factored *f, window *w, int slot, int *to,
                  int *n) {
  const unsigned long long bit = 1ull << slot;
  for (int l = 0; l < w->count[slot]; l++) {
    touch(s, f, w->contact[slot][l], bit, false);
    to[(*n)++] = w->contact[slot][l];
  }
  w->count[slot] = 0;
  w->used &= ~bit;
  w->room &= ~bit;
}

/* One pass over left[n]: full batches to order from `done` on; returns the new `done`, what did not
 * fill a batch in next_left. */
static int pass(const lcp_contact_sweep *s, const lcp_factored *f, int n, int done, int *n_left) {
  window w = {.used = 0};
  *n_left = 0;
  for (int k = 0; k < n; k++) {
    const int c = s->left[k], *body = &f->body[2 * c];
    const unsigned long long taken =
        ((body[0] >= 0) ? s->open[body[0]] : 0) | ((body[1] >= 0) ? s->open[body[1]] : 0);
    int slot;
    if ((w.room & ~taken) != 0) {
      slot = __builtin_ctzll(w.room & ~taken);
    } else {
      if (~w.used == 0) {
        empty(s, f, &w, w.oldest, s->next_left, n_left);
        w.oldest = (w.oldest + 1) % WINDOW;
      }
      slot = __builtin_ctzll(~w.used);
    }
    const unsigned long long bit = 1ull << slot;
    w.used |= bit;
    w.room |= bit;
    w.contact[slot][w.count[slot]++] = c;
    touch(s, f, c, bit, true);
    if (w.count[slot] == LCP_LANES) {
      empty(s, f, &w, slot, s->order, &done);
    }
  }
  for (int slot = 0; slot < WINDOW; slot++) {
    empty(s, f, &w, slot, s->next_left, n_left);
  }
  return done;
}

static void colour(lcp_contact_sweep *s, const lcp_factored *f) {
  int n = f->n_group, done = 0;
  memset(s->open, 0, (size_t)f->n_body * sizeof *s->open);
  for (int k = 0; k < n; k++) {
    s->left[k] = k;
  }
  for (int k = 0; k < PASSES && n >= LCP_LANES; k++) {
    int n_left = 0;
    const int now = pass(s, f, n, done, &n_left);
    int *swap = s->left;
    s->left = s->next_left;
    s->next_left = swap;
    n = n_left;
    if (now == done) {
      break;
    }
    done = now;
  }
  memcpy(s->order + done, s->left, (size_t)n * sizeof *s->order);
  s->n_full = done / LCP_LANES;
}

/* ---- records ------------------------------------------------------------------------------- */

static void record(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p, int k) {
  const lcp_factored *f = p->M.factored;
  lcp_contact_batch *c = &s->batch[k / LCP_LANES];
  const int l = k % LCP_LANES, g = s->order[k], first = f->row_start[g];
  const int a = f->body[2 * g], b = f->body[2 * g + 1];
  const double *Ga = gs->sweep.G + f->jac_start[g], *Gb = Ga + ((a >= 0) ? 18 : 0);
  c->a[l] = (a >= 0) ? a : f->n_body;
  c->b[l] = (b >= 0) ? b : f->n_body;
  for (int r = 0; r < 3; r++) {
    const double root = sqrt(gs->sweep.d[first + r]);
    s->root[first + r] = root;
    c->q[r][l] = p->q[first + r] / root;
    c->z[r][l] = 0.0;
    for (int i = 0; i < 3; i++) {
      const double sa = s->body[8 * c->a[l] + 3], sb = s->body[8 * c->b[l] + 3];
      c->t[r][i][l] = ((a >= 0) ? Ga[6 * r + i] / sa : -Gb[6 * r + i] / sb) / root;
      c->ga[r][i][l] = (a >= 0) ? Ga[6 * r + 3 + i] / root : 0.0;
      c->gb[r][i][l] = (b >= 0) ? Gb[6 * r + 3 + i] / root : 0.0;
    }
  }
  for (int r = 0; r < 2; r++) {
    c->bound[r][l] = gs->hi[first + 1 + r] * s->root[first + 1 + r];
  }
}

bool lcp_contact_sweep_prepare(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p) {
  s->n_contact = 0;
  if (!admits(gs, p)) {
    return false;
  }
  const lcp_factored *f = p->M.factored;
  s->n_contact = f->n_group;
  memset(s->body, 0, 8 * ((size_t)f->n_body + 1) * sizeof *s->body);
  for (int b = 0; b < f->n_body; b++) {
    s->body[8 * b + 3] = gs->sweep.L[f->weight_start[b]];
  }
  memset(s->batch, 0, ((size_t)s->n_contact / LCP_LANES + 1) * sizeof *s->batch);
  colour(s, f);
  for (int k = 0; k < s->n_contact; k++) {
    record(s, gs, p, k);
  }
  return true;
}

void lcp_contact_sweep_import(lcp_contact_sweep *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  for (int b = 0; b <= f->n_body; b++) {
    for (int i = 0; i < 8; i++) {
      s->body[8 * b + i] = (i == 3) ? s->body[8 * b + i] : 0.0;
    }
  }
  for (int k = 0; k < s->n_contact; k++) {
    lcp_contact_batch *c = &s->batch[k / LCP_LANES];
    const int l = k % LCP_LANES, first = f->row_start[s->order[k]];
    double *ua = s->body + 8 * c->a[l], *ub = s->body + 8 * c->b[l];
    for (int r = 0; r < 3; r++) {
      const double x = z[first + r] * s->root[first + r];
      c->z[r][l] = x;
      for (int i = 0; i < 3; i++) {
        ua[i] += ua[3] * c->t[r][i][l] * x;
        ub[i] -= ub[3] * c->t[r][i][l] * x;
        ua[4 + i] += c->ga[r][i][l] * x;
        ub[4 + i] += c->gb[r][i][l] * x;
      }
    }
  }
}

void lcp_contact_sweep_run(lcp_contact_sweep *s, double omega, int sweeps) {
  for (int k = 0; k < sweeps; k++) {
    lcp_contact_kernel_full(s->batch, s->n_full, s->body, omega);
    lcp_contact_kernel_serial(s->batch + s->n_full, s->n_contact - s->n_full * LCP_LANES, s->body,
                              omega);
  }
}

void lcp_contact_sweep_export(const lcp_contact_sweep *s, const lcp_problem *p, double *z) {
  const lcp_factored *f = p->M.factored;
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_contact_batch *c = &s->batch[k / LCP_LANES];
    const int first = f->row_start[s->order[k]];
    for (int r = 0; r < 3; r++) {
      z[first + r] = c->z[r][k % LCP_LANES] / s->root[first + r];
    }
  }
}
