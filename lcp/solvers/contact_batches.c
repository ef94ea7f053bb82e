#include "lcp/solvers/contact_batches.h"

#include "lcp/base/crew.h"
#include "lcp/lcp_mixture.h"

#include <assert.h>
#include <string.h>

enum { NEAR = 256, FAR = 1024 }; /* contacts that a batch may skip; where it would not be full */
enum { TAKEN = -1 };

/* At most, for no batch is empty. */
static size_t stretches(size_t contacts) {
  return contacts / LCP_STRETCH + 1;
}

void lcp_batches_layout(lcp_batches *s, size_t contacts, size_t bodies, base_arena *a) {
  s->order = BASE_ARRAY(a, int, LCP_LANES *contacts);
  s->last = BASE_ARRAY(a, int, bodies);
  s->before = BASE_ARRAY(a, int, 2 * contacts);
  s->after = BASE_ARRAY(a, int, 2 * contacts);
  s->waits = BASE_ARRAY(a, int, contacts);
  s->ready = BASE_ARRAY(a, int, contacts + 1);
  s->until = BASE_ARRAY(a, int, stretches(contacts));
}

size_t lcp_batches_bodies(size_t contacts, size_t bodies) {
  return (bodies > 0) ? bodies + stretches(contacts) : 0;
}

/* ---- frames --------------------------------------------------------------------------------- */

/* Of unit vectors and of arms recovered from rows. A tangent that was projected from an axis near the normal is at right
 * angles to it up to 1e-13; what is allowed stays below the drift that batch_test.c counts with. */
static const double rounding = 1e-12;

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

bool lcp_contact_rigid(const lcp_factored *f) {
  for (int b = 0; b < f->n_body; b++) {
    if (f->dof_start[b + 1] - f->dof_start[b] != 6 || !rigid(f->weight + f->weight_start[b])) {
      return false;
    }
  }
  return true;
}

void lcp_contact_rows(const lcp_factored *f, int g, int rows, double room[LCP_MIXED_MAX],
                      const double *side[2]) {
  const double *jac = lcp_factored_rows(f, g, room);
  for (int s = 0; s < 2; s++) {
    side[s] = (f->body[2 * g + s] >= 0) ? jac : NULL;
    jac += (side[s] != NULL) ? 6 * (ptrdiff_t)rows : 0;
  }
}

bool lcp_contact_frame_of(const double *const rows[2], lcp_contact_frame *out) {
  double third[3];
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
  cross(out->d[0], out->d[1], third);
  out->hand = (dot(third, out->d[2]) > 0.0) ? 1.0 : -1.0;
  return true;
}

bool lcp_contact_frame_of_group(const lcp_factored *f, int g, lcp_contact_frame *out) {
  double room[LCP_MIXED_MAX];
  const double *rows[2];
  lcp_contact_rows(f, g, 3, room, rows);
  return lcp_contact_frame_of(rows, out);
}

void lcp_contact_block(const lcp_factored *f, int g, const double *body, double A[9]) {
  double room[LCP_MIXED_MAX];
  const double *side[2];
  lcp_contact_rows(f, g, 3, room, side);
  memset(A, 0, 9 * sizeof *A);
  for (int s = 0; s < 2; s++) {
    const double *b = body + 16 * (ptrdiff_t)((side[s] != NULL) ? f->body[2 * g + s] : f->n_body);
    for (int j = 0; j < 3 && side[s] != NULL; j++) {
      const double *row = side[s] + 6 * (ptrdiff_t)j;
      const double turn[3] = {LCP_TURN(b + 8, row + 3, 0), LCP_TURN(b + 8, row + 3, 1),
                              LCP_TURN(b + 8, row + 3, 2)};
      for (int i = 0; i <= j; i++) {
        const double *other = side[s] + 6 * (ptrdiff_t)i;
        A[i + 3 * j] += b[3] * dot(other, row) + dot(other + 3, turn);
      }
    }
  }
  for (int j = 0; j < 3; j++) {
    for (int i = j + 1; i < 3; i++) {
      A[i + 3 * j] = A[j + 3 * i];
    }
  }
}

void lcp_contact_place(lcp_lane_frame *at, int k, const lcp_factored *f, int g,
                       const lcp_contact_frame *frame, const double *root) {
  const int l = k % LCP_LANES, fixed = f->n_body + k / (LCP_LANES * LCP_STRETCH);
  for (int s = 0; s < 2; s++) {
    const int b = (frame != NULL) ? f->body[2 * g + s] : -1;
    at->body[s][l] = (b >= 0) ? b : fixed;
    for (int i = 0; i < 3; i++) {
      at->t[s][i][l] = (frame == NULL) ? 0.0 : frame->d[s][i] / ((root != NULL) ? root[s] : 1.0);
      at->arm[s][i][l] = (frame == NULL) ? 0.0 : frame->arm[s][i];
    }
  }
  at->third[l] = (frame == NULL) ? 0.0 : frame->hand;
}

void lcp_contact_bodies(const lcp_factored *f, double *body) {
  const size_t all = lcp_batches_bodies((size_t)f->n_group, (size_t)f->n_body);
  memset(body, 0, 16 * all * sizeof *body);
  for (int b = 0; b < f->n_body; b++) {
    const double *W = f->weight + f->weight_start[b];
    double *to = body + 16 * (size_t)b;
    const double m[6] = {W[21], W[22], W[23], W[28], W[29], W[35]};
    to[3] = W[0];
    memcpy(to + 8, m, sizeof m);
  }
}

void lcp_contact_stop_bodies(const lcp_factored *f, double *body) {
  for (size_t b = 0; b < (size_t)f->n_body; b++) {
    for (size_t i = 0; i < 8; i++) {
      body[16 * b + i] = (i == 3) ? body[16 * b + i] : 0.0;
    }
  }
}

/* ---- order ---------------------------------------------------------------------------------- */

/* The contacts of a body follow one another in the order given: a contact waits for the one before it of either body. */
static void link_contacts(lcp_batches *s, const lcp_factored *f) {
  for (int b = 0; b < f->n_body; b++) {
    s->last[b] = -1;
  }
  for (int c = 0; c < s->n_contact; c++) {
    s->waits[c] = 0;
    for (int k = 0; k < 2; k++) {
      const int b = f->body[2 * (ptrdiff_t)c + k], before = (b >= 0) ? s->last[b] : -1;
      s->before[2 * (ptrdiff_t)c + k] = before;
      s->after[2 * (ptrdiff_t)c + k] = -1;
      if (before >= 0) {
        s->after[2 * (ptrdiff_t)before + (f->body[2 * (ptrdiff_t)before] != b)] = c;
        s->waits[c]++;
      }
      if (b >= 0) {
        s->last[b] = c;
      }
    }
  }
}

/* Contact c is in a batch. Those that waited for it wait for what it waited for; those that wait for none any more, of the
 * first `seen`, are ready. */
static void take(lcp_batches *s, const lcp_factored *f, int c, int seen, int *ready) {
  for (int k = 0; k < 2; k++) {
    const int b = f->body[2 * (ptrdiff_t)c + k];
    const int before = s->before[2 * (ptrdiff_t)c + k], next = s->after[2 * (ptrdiff_t)c + k];
    if (before >= 0) {
      s->after[2 * (ptrdiff_t)before + (f->body[2 * (ptrdiff_t)before] != b)] = next;
    }
    if (next >= 0) {
      s->before[2 * (ptrdiff_t)next + (f->body[2 * (ptrdiff_t)next] != b)] = before;
      if (before < 0 && --s->waits[next] == 0 && next < seen) {
        s->ready[(*ready)++] = next;
      }
    }
  }
  s->waits[c] = TAKEN;
}

static bool shares(const lcp_factored *f, int c, int d) {
  const int *a = f->body + 2 * (ptrdiff_t)c, *b = f->body + 2 * (ptrdiff_t)d;
  return (a[0] >= 0 && (a[0] == b[0] || a[0] == b[1])) ||
         (a[1] >= 0 && (a[1] == b[0] || a[1] == b[1]));
}

/* Fills a batch of `count` with contacts out of turn, of the next ones from `first` on. Returns how many it then has. */
static int fill(const lcp_batches *s, const lcp_factored *f, int first, int count, int *to) {
  for (int c = first; c < s->n_contact && c < first + NEAR && count < LCP_LANES; c++) {
    bool joins = s->waits[c] > 0;
    for (int l = 0; l < count && joins; l++) {
      joins = !shares(f, c, to[l]);
    }
    if (joins) {
      to[count++] = c;
    }
  }
  return count;
}

/* Where each stretch is awaited. */
static void find_until(lcp_batches *s, const lcp_factored *f) {
  const int places = LCP_LANES * LCP_STRETCH;
  for (int pass = 0; pass < 2; pass++) {
    for (int k = 0; k < LCP_LANES * s->n_batch; k++) {
      const int c = s->order[k], here = k / places;
      if (k % places == 0 && pass == 1) {
        s->until[here] = here;
      }
      for (int e = 0; e < 2 && c >= 0; e++) {
        const int b = f->body[2 * (ptrdiff_t)c + e];
        if (b >= 0 && pass == 0) {
          s->last[b] = here;
        } else if (b >= 0 && s->last[b] > s->until[here]) {
          s->until[here] = s->last[b];
        }
      }
    }
  }
}

void lcp_batches_order(lcp_batches *s, const lcp_factored *f) {
  const int n = f->n_group;
  int taken = 0, used = 0, ready = 0, seen = 0, first = 0;
  s->n_contact = n;
  s->n_batch = 0;
  link_contacts(s, f);
  while (taken < n) {
    for (; seen < n && seen < taken + ((ready < used + LCP_LANES) ? FAR : NEAR); seen++) {
      s->ready[ready] = seen;
      ready += s->waits[seen] == 0;
    }
    int *to = s->order + (ptrdiff_t)LCP_LANES * s->n_batch++, count = 0;
    for (; count < LCP_LANES && used < ready; used++) {
      to[count++] = s->ready[used];
    }
    for (; first < n && s->waits[first] == TAKEN; first++) {
    }
    count = fill(s, f, first, count, to);
    assert(count > 0); /* the first that is not taken waits for none */
    for (int l = 0; l < LCP_LANES; l++) {
      if (l < count) {
        take(s, f, to[l], seen, &ready);
      } else {
        to[l] = -1;
      }
    }
    taken += count;
  }
  s->shared = base_crew_size() > 1;
  if (s->shared) {
    find_until(s, f);
  }
}

bool lcp_batches_are_partitioned(lcp_batches *s, const lcp_factored *f) {
  bool good = true;
  int met = 0;
  memset(s->waits, 0, (size_t)s->n_contact * sizeof *s->waits);
  for (int k = 0; k < LCP_LANES * s->n_batch && good; k++) {
    const int c = s->order[k], lane = k % LCP_LANES;
    met += c >= 0;
    good = c == -1 || (c >= 0 && c < s->n_contact && s->waits[c]++ == 0);
    for (int l = 1; l <= lane && good && c >= 0; l++) {
      good = s->order[k - l] < 0 || !shares(f, c, s->order[k - l]);
    }
  }
  return good && met == s->n_contact;
}
