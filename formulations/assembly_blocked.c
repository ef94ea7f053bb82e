/* assembly_blocked.c - directions of a contact in which nothing can move.
 *
 * A direction that joints or locks block has a zero row and column in C. Computed, the zero is rounding error, which no
 * solver can tell from a very light direction. It is judged here, once, against what is known of where it comes from
 * (form_blocked), and taken out of the contact's rows: no unknown, no impulse. Where two tangents, or two rolling
 * directions, can move along one line only, the rows are turned so that one of them is that line.
 *
 * Where normal and tangent move together along one line (a pendulum's end on a wall), both stay rows, and C of the two is
 * singular. Computed, it is singular to rounding, and an impulse of any size solves what has no solution. The tangent's
 * row and column of C are therefore written as a multiple of the normal's.
 *
 * Two things stay as exact zero rows, since their velocity says something: a tangent that cannot move and is moved
 * all the same (a belt under a locked body), which rubs, and a normal that cannot move and approaches, for which no impulse
 * exists: the problem has no solution, and says so. Any other contact whose normal cannot move carries nothing. */
#include "formulations/assembly.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_ROWS = 6 };

/* Rows of J that are rounding errors of a direction of length one: their squares. */
static const double lock_noise = 256 * DBL_EPSILON * DBL_EPSILON;
/* The smaller of two eigenvalues that rounding leaves of a zero, over the larger. */
static const double turn_noise = 16 * DBL_EPSILON;

/* What becomes of the rows of one contact. */
typedef struct remains {
  contact_rows rows;
  int n;
  form_direction direction[MOST_ROWS];
  double u[MOST_ROWS]; /* of a tied row, beside its share of the normal's [m/s] */
} remains;

void form_assembly_know_locks(form_assembly *a) {
  const contact_set *c = a->set;
  for (int i = 0; i < a->n_contact; i++) {
    const int rows = form_rows_of(a, i);
    const int metres = 1 + a->rows[i].tangent; /* before the rows of spins, in other units */
    const double *own = form_own_block(a, i);
    const double *drift = c->u_drift + c->row_start[a->group[i]];
    double most[2] = {0};
    double fastest = 0;
    for (int p = 0; p < rows; p++) {
      most[p >= metres] = fmax(most[p >= metres], own[(ptrdiff_t)p * (rows + 1)]);
      fastest = fmax(fastest, fabs(drift[p]));
    }
    for (int p = 0; p < rows; p++) {
      a->known[a->row[i] + p] = (form_blocked){.noise = lock_noise * most[p >= metres],
                                               .u = drift[p],
                                               .u_noise = 16 * DBL_EPSILON * fastest};
    }
  }
}

static void keep(remains *out, int row, int n, double c0, double c1) {
  out->direction[out->n++] = (form_direction){.row = row, .n = n, .c = {c0, c1}};
}

static void tie(remains *out, int p, double share, double u, double noise) {
  out->direction[p].tied = true;
  out->direction[p].share = share;
  out->u[p] = (fabs(u) > noise) ? u : 0;
}

/* A row that cannot move stays where it has a velocity. */
static void keep_still(remains *out, int row, int n, double c0, double c1, double u, double noise) {
  if (fabs(u) > noise) {
    keep(out, row, n, c0, c1);
    tie(out, out->n - 1, 0, u, noise);
  }
}

/* The direction of the larger eigenvalue of [p q; q r]. */
static void main_axis(double p, double q, double r, double axis[2]) {
  const double half = 0.5 * (p - r);
  const double root = hypot(half, q);
  axis[0] = (half >= 0) ? half + root : q;
  axis[1] = (half >= 0) ? q : root - half;
  const double length = hypot(axis[0], axis[1]);
  axis[0] = (length > 0) ? axis[0] / length : 1;
  axis[1] = (length > 0) ? axis[1] / length : 0;
}

/* Keeps what can move of the n rows from `first` on (of one kind, n <= 2); returns how many stay. */
static int keep_part(const form_assembly *a, int i, int first, int n, remains *out) {
  const int rows = a->full.row[i + 1] - a->full.row[i];
  const int before = out->n;
  const double *own = form_own_block(a, i) + (ptrdiff_t)first * (rows + 1);
  const form_blocked *known = a->known + a->full.row[i] + first;
  if (n == 1) {
    if (own[0] <= known->noise) {
      keep_still(out, first, 1, 1, 0, known->u, known->u_noise);
    } else {
      keep(out, first, 1, 1, 0);
    }
  } else if (n == 2) {
    const double p = own[0], q = own[1], r = own[rows + 1];
    const double noise = fmax(known[0].noise, known[1].noise);
    const double u_noise = known[0].u_noise + known[1].u_noise;
    const double largest = 0.5 * (p + r) + hypot(0.5 * (p - r), q);
    if (largest <= noise) {
      const bool moved = hypot(known[0].u, known[1].u) > u_noise;
      for (int k = 0; moved && k < 2; k++) {
        keep_still(out, first + k, 1, 1, 0, known[k].u, -1);
      }
    } else if (p + r - largest <= fmax(2 * noise, turn_noise * largest)) {
      double axis[2];
      main_axis(p, q, r, axis);
      keep(out, first, 2, axis[0], axis[1]);
      keep_still(out, first, 2, -axis[1], axis[0], axis[0] * known[1].u - axis[1] * known[0].u,
                 u_noise);
    } else {
      keep(out, first, 1, 1, 0);
      keep(out, first + 1, 1, 1, 0);
    }
  }
  return out->n - before;
}

/* A row of C, or of any block with the contact's rows, along d; x: the contact's first row, its rows `stride` apart. */
static double along(const form_direction *d, const double *x, ptrdiff_t stride) {
  const double *at = x + d->row * stride;
  return d->tied ? d->share * x[0] : d->c[0] * at[0] + ((d->n == 2) ? d->c[1] * at[stride] : 0);
}

/* to = D_i from D_j', row-major; `columns` of `from`. */
static void turn_block(const double *from, int columns, const form_direction *di, int ni,
                       const form_direction *dj, int nj, double *to) {
  double half[MOST_ROWS * MOST_ROWS];
  double whole[MOST_ROWS * MOST_ROWS];
  for (int p = 0; p < ni; p++) {
    for (int q = 0; q < columns; q++) {
      half[p * columns + q] = along(&di[p], from + q, columns);
    }
  }
  for (int p = 0; p < ni; p++) {
    for (int q = 0; q < nj; q++) {
      whole[p * nj + q] = along(&dj[q], half + (ptrdiff_t)p * columns, 1);
    }
  }
  memcpy(to, whole, (size_t)ni * (size_t)nj * sizeof *to); /* `to` may begin inside `from` */
}

/* Of tangent p, whose row of C is `row`: the share of the normal's motion that it has, and what it moves beside that where
 * joints alone move it; *noise, *u_noise: of its diagonal without that share, and of u. */
static double share_of_normal(const form_direction *d, const form_blocked *known, double c_nn,
                              double c_tn, double *u, double *noise, double *u_noise) {
  const double share = c_tn / c_nn;
  double t_noise = 0;
  *u = -share * known[0].u;
  *u_noise = fabs(share) * known[0].u_noise;
  for (int k = 0; k < d->n; k++) {
    t_noise = fmax(t_noise, known[d->row + k].noise);
    *u += d->c[k] * known[d->row + k].u;
    *u_noise += known[d->row + k].u_noise;
  }
  *noise = t_noise + share * share * known[0].noise;
  return share;
}

/* Ties the tangents that move only with the normal. Of two, one combination may: they are turned so that it is a row. */
static void tie_tangents(const form_assembly *a, int i, remains *out) {
  const form_blocked *known = a->known + a->full.row[i];
  int m = out->rows.tangent;
  while (m > 0 && out->direction[m].tied) {
    m--;
  }
  const double *c = form_own_block(a, i);
  double turned[9] = {0}, share[2], u[2], noise[2], u_noise[2];
  const int rows = a->full.row[i + 1] - a->full.row[i];
  if (rows > 1 + m) {
    turn_block(c, rows, out->direction, 1 + m, out->direction, 1 + m, turned);
    c = turned;
  }
  for (int p = 0; p < m; p++) {
    share[p] = share_of_normal(&out->direction[1 + p], known, c[0], c[(1 + p) * (1 + m)], &u[p],
                               &noise[p], &u_noise[p]);
    noise[p] = fmax(noise[p], turn_noise * c[(1 + p) * (2 + m)]);
  }
  if (m == 1) {
    if (c[3] - share[0] * c[1] <= noise[0]) {
      tie(out, 1, share[0], u[0], u_noise[0]);
    }
  } else if (m == 2) {
    const double p = c[4] - share[0] * c[1], q = c[5] - share[0] * c[2];
    const double r = c[8] - share[1] * c[2];
    const double largest = 0.5 * (p + r) + hypot(0.5 * (p - r), q);
    const double most = noise[0] + noise[1];
    if (largest <= most) {
      tie(out, 1, share[0], u[0], u_noise[0]);
      tie(out, 2, share[1], u[1], u_noise[1]);
    } else if (p + r - largest <= most) {
      double axis[2];
      main_axis(p, q, r, axis);
      out->direction[1] = (form_direction){.row = 1, .n = 2, .c = {axis[0], axis[1]}};
      out->direction[2] = (form_direction){.row = 1, .n = 2, .c = {-axis[1], axis[0]}};
      tie(out, 2, axis[0] * share[1] - axis[1] * share[0], axis[0] * u[1] - axis[1] * u[0],
          u_noise[0] + u_noise[1]);
    }
  }
}

/* Beside joints that stay rows nothing is tied: it is these rows that tie it. */
static void loosen(remains *out) {
  for (int p = 0; p < out->n; p++) {
    out->direction[p].tied = false;
  }
}

/* What is left of contact i of `full`; n = 0: it is not active. */
static void judge(const form_assembly *a, int i, remains *out) {
  const contact_rows rows = a->rows[i];
  const form_blocked *normal = a->known + a->full.row[i];
  *out = (remains){.n = 0};
  if (form_own_block(a, i)[0] <= normal->noise) {
    const double apart = normal->u + fmax(a->bias[a->full.group[i]], 0);
    if (apart < -normal->u_noise) {
      keep_still(out, 0, 1, 1, 0, normal->u, -1);
    }
    return;
  }
  keep(out, 0, 1, 1, 0);
  out->rows.tangent = (unsigned char)keep_part(a, i, 1, rows.tangent, out);
  tie_tangents(a, i, out);
  out->rows.torsion = (unsigned char)keep_part(a, i, 1 + rows.tangent, rows.torsion, out);
  out->rows.rolling =
      (unsigned char)keep_part(a, i, 1 + rows.tangent + rows.torsion, rows.rolling, out);
}

static void judge_row(const form_assembly *a, int i, remains *out) {
  judge(a, i, out);
  if (a->n_group > a->n_contact) {
    loosen(out);
  }
}

static bool changes(const form_assembly *a, int i, const remains *now) {
  bool differs = now->n != a->full.row[i + 1] - a->full.row[i];
  for (int p = 0; p < now->n; p++) {
    differs = differs || now->direction[p].n == 2 || now->direction[p].tied;
  }
  return differs;
}

static bool any_changes(const form_assembly *a) {
  bool any = false;
  for (int i = 0; i < a->n_contact && !any; i++) {
    remains now;
    judge_row(a, i, &now);
    any = changes(a, i, &now);
  }
  return any;
}

/* Contact i of `full` becomes the next active one, with what is left of its rows. */
static void take_over(form_assembly *a, int i, int n_contact, const remains *now) {
  const int g = a->full.group[i];
  const int first = a->full.row[i];
  const int to = a->row[n_contact];
  double r[MOST_ROWS] = {0};
  memcpy(r, a->r + first, (size_t)(a->full.row[i + 1] - first) * sizeof *r);
  a->group[n_contact] = g;
  a->full_of[n_contact] = i;
  a->rows[n_contact] = now->rows;
  a->turned[n_contact] = now->n != a->full.row[i + 1] - first;
  a->row[n_contact + 1] = to + now->n;
  for (int p = 0; p < now->n; p++) {
    const form_direction *d = &now->direction[p];
    a->direction[to + p] = *d;
    a->r[to + p] = along(d, r, 1) + (d->tied ? now->u[p] : 0);
    a->turned[n_contact] = a->turned[n_contact] || d->n == 2 || d->tied;
  }
}

/* The joints that stay rows follow the contacts. */
static void follow(form_assembly *a, int n_contact, int n_joint, int *to_new) {
  for (int m = 0; m < n_joint; m++) {
    const int from = a->full.n_contact + m, to = n_contact + m;
    const int rows = a->full.row[from + 1] - a->full.row[from];
    to_new[from] = to;
    a->group[to] = a->full.group[from];
    a->row[to + 1] = a->row[to] + rows;
    memmove(a->r + a->row[to], a->r + a->full.row[from], (size_t)rows * sizeof *a->r);
    for (int p = 0; p < rows; p++) {
      a->direction[a->row[to] + p] = (form_direction){.row = p, .n = 1, .c = {1, 0}};
    }
  }
}

bool form_assembly_choose_rows(form_assembly *a) {
  if (!any_changes(a)) {
    return false;
  }
  const size_t n_group = (size_t)a->n_group + (size_t)a->n_joint_group;
  const int n_joint = a->n_group - a->n_contact;
  memcpy(a->home_group, a->group, n_group * sizeof *a->group);
  memcpy(a->home_row, a->row, (n_group + 1) * sizeof *a->row);
  a->full.n_contact = a->n_contact;
  a->full.group = a->home_group;
  a->full.row = a->home_row;
  int *to_new = a->cursor;
  int n_contact = 0;
  remains ahead;
  for (int i = 0; i < a->full.n_contact; i++) {
    judge_row(a, i, &ahead);
    if (ahead.n == 0) {
      to_new[i] = -1;
      a->bias[a->full.group[i]] = HUGE_VAL;
      continue;
    }
    to_new[i] = n_contact;
    take_over(a, i, n_contact++, &ahead);
  }
  follow(a, n_contact, n_joint, to_new);
  a->reduced = true;
  a->n_contact = n_contact;
  a->n_group = n_contact + n_joint;
  a->n_row = a->row[a->n_group];
  return true;
}

void form_assembly_compress(form_assembly *a) {
  const int *to_new = a->cursor;
  const int n_full = a->full.n_contact + a->n_group - a->n_contact;
  size_t at = 0;
  int listed = 0;
  int from = a->near_start[0];
  for (int i = 0; i < n_full; i++) {
    const int end = a->near_start[i + 1];
    const int ni = to_new[i];
    for (int k = from; k < end && ni >= 0; k++) {
      const int j = a->near[k];
      const int nj = to_new[j];
      if (nj < 0) {
        continue;
      }
      turn_block(a->block + a->block_at[k], a->full.row[j + 1] - a->full.row[j],
                 a->direction + a->row[ni], form_rows_of(a, ni), a->direction + a->row[nj],
                 form_rows_of(a, nj), a->block + at);
      a->near[listed] = nj;
      a->block_at[listed] = at;
      if (nj == ni) {
        a->self[ni] = listed;
      }
      at += (size_t)form_rows_of(a, ni) * (size_t)form_rows_of(a, nj);
      listed++;
    }
    from = end;
    if (ni >= 0) {
      a->near_start[ni + 1] = listed;
    }
  }
  a->block_at[listed] = at;
}

/* Accelerations of drifts hold differences of frames (world_contacts_curved), and these an error of this share of the
 * largest one. */
static const double difference = 1e-6;

/* Marks the rows that cannot move; their velocity is what they have without rounding. */
static bool mark_still(form_assembly *a) {
  bool any = false;
  double largest = 0;
  for (int r = 0; r < a->n_row; r++) {
    largest = fmax(largest, fabs(a->r[r]));
  }
  for (int i = 0; i < a->n_contact; i++) {
    const int rows = form_rows_of(a, i);
    for (int p = 0; p < rows; p++) {
      const int at = a->row[i] + p;
      const form_blocked *known = &a->known[at];
      form_direction *d = &a->direction[at];
      d->tied = form_own_block(a, i)[(ptrdiff_t)p * (rows + 1)] <= known->noise;
      if (d->tied) {
        const double noise = fmax(known->u_noise, difference * largest);
        a->r[at] = (fabs(known->u) > noise) ? known->u : 0;
        any = true;
      }
    }
  }
  return any;
}

/* Exact zeros in rows and columns that cannot move. */
static void zero_still(form_assembly *a) {
  for (int i = 0; i < a->n_contact; i++) {
    const int rows = form_rows_of(a, i);
    for (int k = a->near_start[i]; k < a->near_start[i + 1]; k++) {
      const int columns = form_rows_of(a, a->near[k]);
      const form_direction *other = a->direction + a->row[a->near[k]];
      double *block = a->block + a->block_at[k];
      for (int e = 0; e < rows * columns; e++) {
        const bool still = a->direction[a->row[i] + e / columns].tied || other[e % columns].tied;
        block[e] = still ? 0 : block[e];
      }
    }
  }
}

void form_assembly_unblock(form_assembly *a) {
  if (a->all_rows) {
    if (mark_still(a)) {
      zero_still(a);
    }
    return;
  }
  if (form_assembly_choose_rows(a)) {
    form_assembly_compress(a);
  }
}

void form_to_rows(const form_assembly *a, int i, const double *x, double *out) {
  for (int p = 0; p < form_rows_of(a, i); p++) {
    const form_direction *d = &a->direction[a->row[i] + p];
    out[p] =
        !a->turned[i] ? x[p] : d->c[0] * x[d->row] + ((d->n == 2) ? d->c[1] * x[d->row + 1] : 0);
  }
}

/* x += value times row p of contact i. */
static void add_row(const form_assembly *a, int i, int p, double value, double *x) {
  const form_direction whole = {.row = p, .n = 1, .c = {1, 0}};
  const form_direction *d = a->turned[i] ? &a->direction[a->row[i] + p] : &whole;
  for (int k = 0; k < d->n; k++) {
    x[d->row + k] += d->c[k] * value;
  }
}

void form_to_set(const form_assembly *a, int i, const double *in, double *x) {
  for (int p = 0; p < form_rows_of(a, i); p++) {
    add_row(a, i, p, in[p], x);
  }
}

bool form_to_motion(const form_assembly *a, int i, const double *in, double *x) {
  bool ties = false;
  for (int p = 0; p < form_rows_of(a, i); p++) {
    const form_direction *d = &a->direction[a->row[i] + p];
    if (a->turned[i] && d->tied) {
      x[0] += d->share * in[p];
      ties = ties || in[p] != 0;
    } else {
      add_row(a, i, p, in[p], x);
    }
  }
  return ties;
}
