#include "lcp/solvers/contact_sweep_kernel.h"

#include <assert.h>
#include <string.h>

enum { WINDOW = 64, PASSES = 16 };

void lcp_contact_sweep_layout(lcp_contact_sweep *s, const lcp_capacity *cap, base_arena *a) {
  const size_t bodies = (cap->n_body > 0) ? (size_t)cap->n_body + 1 : 0;
  const size_t rows = (cap->n_body > 0) ? (size_t)cap->n : 0, contacts = rows / 3;
  s->batch = BASE_ARRAY(a, lcp_contact_batch, contacts / LCP_LANES + 1);
  s->body = BASE_ARRAY(a, double, 16 * bodies);
  s->open = BASE_ARRAY(a, unsigned long long, bodies);
  s->order = BASE_ARRAY(a, int, contacts);
  s->left = BASE_ARRAY(a, int, contacts);
  s->next_left = BASE_ARRAY(a, int, contacts);
  s->root = BASE_ARRAY(a, double, rows);
}

/* ---- does the problem have the form? ------------------------------------------------------- */

static const double rounding = 1e-14; /* of unit vectors and of arms recovered from rows */

/* W = diag(I/m, inertia^-1), 6 x 6, symmetric. */
static bool rigid(const double *W) {
  for (int j = 0; j < 6; j++) {
    for (int i = 0; i < 6; i++) {
      const bool linear = i < 3 || j < 3;
      if (linear ? W[i + 6 * j] != ((i == j) ? W[0] : 0.0) : W[i + 6 * j] != W[j + 6 * i]) {
        return false;
      }
    }
  }
  return W[0] > 0.0;
}

static void cross(const double *a, const double *b, double *out) {
  for (int i = 0; i < 3; i++) {
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
  }
}

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Frame and arms of a group. */
typedef struct geometry {
  double d[3][3], arm[2][3];
} geometry;

/* The arm r of rows (sign d_k, sign r x d_k): sum_k d_k x (r x d_k) = 2 r. False: they are not such. */
static bool arm_of(const double *rows, double sign, double d[3][3], double *r) {
  for (int i = 0; i < 3; i++) {
    r[i] = 0.0;
  }
  for (int k = 0; k < 3; k++) {
    double part[3];
    cross(d[k], &rows[6 * k + 3], part);
    for (int i = 0; i < 3; i++) {
      r[i] += 0.5 * sign * part[i];
    }
  }
  const double size = fabs(r[0]) + fabs(r[1]) + fabs(r[2]);
  for (int k = 0; k < 3; k++) {
    double back[3];
    cross(r, d[k], back);
    for (int i = 0; i < 3; i++) {
      if (!(fabs(sign * rows[6 * k + i] - d[k][i]) <= rounding &&
            fabs(sign * rows[6 * k + 3 + i] - back[i]) <= rounding * size)) {
        return false;
      }
    }
  }
  return true;
}

static bool geometry_of(const lcp_factored *f, int g, geometry *out) {
  const double *rows[2], *jac = f->jac + f->jac_start[g];
  for (int s = 0; s < 2; s++) {
    rows[s] = (f->body[2 * g + s] >= 0) ? jac : NULL;
    jac += (rows[s] != NULL) ? 18 : 0;
  }
  if (rows[0] == NULL && rows[1] == NULL) {
    return false;
  }
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 3; i++) {
      out->d[k][i] = (rows[0] != NULL) ? rows[0][6 * k + i] : -rows[1][6 * k + i];
    }
  }
  for (int k = 0; k < 3; k++) { /* orthonormal */
    for (int l = 0; l <= k; l++) {
      if (!(fabs(dot(out->d[k], out->d[l]) - (k == l)) <= rounding)) {
        return false;
      }
    }
  }
  for (int s = 0; s < 2; s++) {
    memset(out->arm[s], 0, sizeof out->arm[s]);
    if (rows[s] != NULL && !arm_of(rows[s], (s == 0) ? 1.0 : -1.0, out->d, out->arm[s])) {
      return false;
    }
  }
  return true;
}

static bool admits_group(const lcp_gs *gs, const lcp_factored *f, int g) {
  const int i = f->row_start[g], *body = &f->body[2 * (ptrdiff_t)g];
  geometry unused;
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
  return geometry_of(f, g, &unused);
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
    const int c = s->left[k], *body = &f->body[2 * (ptrdiff_t)c];
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

#ifndef NDEBUG
/* Every contact has one place, and the contacts of a full batch share no body: its lanes are written at once. */
static bool partitioned(const lcp_contact_sweep *s, const lcp_factored *f) {
  bool good = true;
  memset(s->left, 0, (size_t)s->n_contact * sizeof *s->left);
  for (int k = 0; k < s->n_contact && good; k++) {
    const int c = s->order[k], lane = k % LCP_LANES;
    good = c >= 0 && c < s->n_contact && s->left[c]++ == 0;
    for (int l = 1; l <= lane && good && k / LCP_LANES < s->n_full; l++) {
      const int *own = &f->body[2 * (ptrdiff_t)c],
                *other = &f->body[2 * (ptrdiff_t)s->order[k - l]];
      for (int side = 0; side < 2; side++) {
        good = good && (own[side] < 0 || (own[side] != other[0] && own[side] != other[1]));
      }
    }
  }
  return good;
}
#endif

/* ---- records ------------------------------------------------------------------------------- */

static void record(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p, int k) {
  const lcp_factored *f = p->M.factored;
  lcp_contact_batch *c = &s->batch[k / LCP_LANES];
  const int l = k % LCP_LANES, g = s->order[k], first = f->row_start[g];
  double *root = s->root + first, A[9] = {0}, third[3];
  geometry at;
  (void)geometry_of(f, g, &at); /* admitted */
  lcp_sweep_block(&gs->sweep, p, first, 3, A);
  for (int r = 0; r < 3; r++) {
    root[r] = sqrt(gs->sweep.d[first + r]);
    c->q[r][l] = p->q[first + r] / root[r];
    c->x[r][l] = 0.0;
  }
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    c->body[side][l] = (b >= 0) ? b : f->n_body;
    c->bound[side][l] = gs->hi[first + 1 + side] * root[1 + side];
    for (int i = 0; i < 3; i++) {
      c->t[side][i][l] = at.d[side][i] / root[side];
      c->arm[side][i][l] = at.arm[side][i];
    }
  }
  cross(at.d[0], at.d[1], third);
  c->third[l] = ((dot(third, at.d[2]) > 0.0) ? 1.0 : -1.0) * root[0] * root[1] / root[2];
  c->A[0][l] = A[1] / (root[0] * root[1]);
  c->A[1][l] = A[2] / (root[0] * root[2]);
  c->A[2][l] = A[5] / (root[1] * root[2]);
}

static void place_bodies(lcp_contact_sweep *s, const lcp_factored *f) {
  memset(s->body, 0, 16 * ((size_t)f->n_body + 1) * sizeof *s->body);
  for (int b = 0; b < f->n_body; b++) {
    const double *W = f->weight + f->weight_start[b];
    double *to = s->body + 16 * (size_t)b;
    const double m[6] = {W[21], W[22], W[23], W[28], W[29], W[35]};
    to[3] = W[0];
    memcpy(to + 8, m, sizeof m);
  }
}

bool lcp_contact_sweep_prepare(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p) {
  s->n_contact = 0;
  if (!admits(gs, p)) {
    return false;
  }
  const lcp_factored *f = p->M.factored;
  s->n_contact = f->n_group;
  place_bodies(s, f);
  memset(s->batch, 0, ((size_t)s->n_contact / LCP_LANES + 1) * sizeof *s->batch);
  colour(s, f);
  for (int k = 0; k < s->n_contact; k++) {
    record(s, gs, p, k);
  }
  return true;
}

void lcp_contact_sweep_import(lcp_contact_sweep *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  assert(partitioned(s, f));
  for (size_t b = 0; b <= (size_t)f->n_body; b++) {
    for (size_t i = 0; i < 8; i++) {
      s->body[16 * b + i] = (i == 3) ? s->body[16 * b + i] : 0.0;
    }
  }
  for (int k = 0; k < s->n_contact; k++) {
    lcp_contact_batch *c = &s->batch[k / LCP_LANES];
    for (int r = 0; r < 3; r++) {
      const int row = f->row_start[s->order[k]] + r;
      c->x[r][k % LCP_LANES] = z[row] * s->root[row];
    }
  }
  lcp_contact_kernel_push(s->batch, s->n_contact, s->body);
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
      z[first + r] = c->x[r][k % LCP_LANES] / s->root[first + r];
    }
  }
}
