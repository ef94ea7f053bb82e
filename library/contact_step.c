/* contact_step.c - one time step of rigid bodies in contact, from plain arrays.
 *
 * The problem is posed in the factored form M = J W J', W the inverse masses and inertias, one exact Coulomb cone a contact:
 * w = J (v + W J' r) + bias e_n = M r + (J v + bias e_n). A row of J is (d, (x - c) x d) on the first body, its opposite on the
 * second. */
#include "library/library.h"

#include <stdlib.h>
#include <string.h>

typedef struct step {
  const lcp_contacts *c;
  int n; /* 3 n_contact */
  lcp_factored factored;
  lcp_problem p;
  void *mem;
  int *dof_start, *weight_start, *row_start, *jac_start, *body;
  double *weight; /* 36 n_body */
  double *jac;    /* at most 36 n_contact */
  double *frame;  /* 9 n_contact: rows n, t1, t2 */
  double *q, *z;  /* n */
  lcp_block *block;
} step;

static void lay_out(step *s, base_arena *a) {
  const int bodies = s->c->n_body, contacts = s->c->n_contact;
  s->dof_start = BASE_ARRAY(a, int, bodies + 1);
  s->weight_start = BASE_ARRAY(a, int, bodies + 1);
  s->row_start = BASE_ARRAY(a, int, contacts + 1);
  s->jac_start = BASE_ARRAY(a, int, contacts + 1);
  s->body = BASE_ARRAY(a, int, 2 * (size_t)contacts);
  s->weight = BASE_ARRAY(a, double, 36 * (size_t)bodies);
  s->jac = BASE_ARRAY(a, double, 36 * (size_t)contacts);
  s->frame = BASE_ARRAY(a, double, 9 * (size_t)contacts);
  s->q = BASE_ARRAY(a, double, s->n);
  s->z = BASE_ARRAY(a, double, s->n);
  s->block = BASE_ARRAY(a, lcp_block, contacts);
}

static base_status allocate(step *s, base_error *err) {
  base_arena measure = base_arena_measuring();
  lay_out(s, &measure);
  s->mem = measure.overflow ? NULL : base_alloc(measure.used);
  if (s->mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d contacts", s->c->n_contact);
  }
  base_arena real = base_arena_over(s->mem, measure.used);
  lay_out(s, &real);
  return BASE_OK;
}

static void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Two directions across n, of length one, a function of n alone: the axis that n is least along, made perpendicular. */
static void tangents(const double n[3], double t1[3], double t2[3]) {
  int least = 0;
  for (int k = 1; k < 3; k++) {
    least = (fabs(n[k]) < fabs(n[least])) ? k : least;
  }
  double axis[3] = {0};
  axis[least] = 1.0;
  cross(n, axis, t1);
  const double length = sqrt(dot(t1, t1));
  for (int k = 0; k < 3; k++) {
    t1[k] /= length;
  }
  cross(n, t1, t2);
}

/* ---- checks ------------------------------------------------------------------------------- */

static base_status check_numbers(const char *what, const double *x, size_t n, base_error *err) {
  if (x == NULL && n > 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: missing", what);
  }
  for (size_t i = 0; i < n; i++) {
    if (!isfinite(x[i])) {
      return BASE_FAIL(err, BASE_EINVAL, "%s[%zu] is %g: need finite numbers", what, i, x[i]);
    }
  }
  return BASE_OK;
}

static bool moves(const lcp_contacts *c, int b) {
  return b >= 0 && c->inverse_mass[b] > 0.0;
}

static base_status check_contact(const lcp_contacts *c, int k, base_error *err) {
  const int a = c->body[2 * k], b = c->body[2 * k + 1];
  if (a < -1 || b < -1 || a >= c->n_body || b >= c->n_body || a == b) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d is of bodies %d and %d: need two of -1..%d", k,
                     a, b, c->n_body - 1);
  }
  if (!moves(c, a) && !moves(c, b)) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: neither body %d nor %d can move", k, a, b);
  }
  if (fabs(dot(c->normal + 3 * (size_t)k, c->normal + 3 * (size_t)k) - 1.0) > 1e-6) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d: need a normal of length one", k);
  }
  if (!(c->mu[k] >= 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "contact %d has mu %g: need mu >= 0", k, c->mu[k]);
  }
  return BASE_OK;
}

static base_status check(const lcp_contacts *c, const double *velocity, const double *impulse,
                         base_error *err) {
  if (c->n_body < 0 || c->n_contact < 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%d bodies, %d contacts: need counts >= 0", c->n_body,
                     c->n_contact);
  }
  const size_t bodies = (size_t)c->n_body, contacts = (size_t)c->n_contact;
  BASE_TRY(check_numbers("inverse_mass", c->inverse_mass, bodies, err));
  BASE_TRY(check_numbers("inverse_inertia", c->inverse_inertia, 9 * bodies, err));
  BASE_TRY(check_numbers("position", c->position, 3 * bodies, err));
  BASE_TRY(check_numbers("velocity", velocity, 6 * bodies, err));
  BASE_TRY(check_numbers("point", c->point, 3 * contacts, err));
  BASE_TRY(check_numbers("normal", c->normal, 3 * contacts, err));
  BASE_TRY(check_numbers("mu", c->mu, contacts, err));
  BASE_TRY(check_numbers("impulse", impulse, 3 * contacts, err));
  BASE_TRY((c->bias != NULL) ? check_numbers("bias", c->bias, contacts, err) : BASE_OK);
  if (c->body == NULL && contacts > 0) {
    return BASE_FAIL(err, BASE_EINVAL, "body: missing");
  }
  for (int b = 0; b < c->n_body; b++) {
    if (c->inverse_mass[b] < 0.0) {
      return BASE_FAIL(err, BASE_EINVAL, "body %d has inverse mass %g: need >= 0", b,
                       c->inverse_mass[b]);
    }
  }
  for (int k = 0; k < c->n_contact; k++) {
    BASE_TRY(check_contact(c, k, err));
  }
  return BASE_OK;
}

/* ---- the problem -------------------------------------------------------------------------- */

static void pose_bodies(step *s) {
  const lcp_contacts *c = s->c;
  memset(s->weight, 0, 36 * (size_t)c->n_body * sizeof *s->weight);
  for (int b = 0; b < c->n_body; b++) {
    s->dof_start[b] = 6 * b;
    s->weight_start[b] = 36 * b;
    double *W = s->weight + 36 * (size_t)b;
    const double *inertia = c->inverse_inertia + 9 * (size_t)b;
    for (int i = 0; i < 3; i++) {
      W[6 * i + i] = c->inverse_mass[b];
      for (int j = 0; j < 3; j++) {
        W[6 * (3 + i) + 3 + j] = inertia[3 * i + j];
      }
    }
  }
  s->dof_start[c->n_body] = 6 * c->n_body;
  s->weight_start[c->n_body] = 36 * c->n_body;
}

/* The three rows of contact k on one of its bodies, 3 x 6 row-major: sign (d, (x - c) x d). */
static void pose_side(const step *s, int k, int b, double sign, double *rows) {
  const lcp_contacts *c = s->c;
  double arm[3];
  for (int i = 0; i < 3; i++) {
    arm[i] = c->point[3 * k + i] - c->position[3 * b + i];
  }
  for (int r = 0; r < 3; r++) {
    const double *d = s->frame + 9 * (size_t)k + 3 * r;
    double turn[3];
    cross(arm, d, turn);
    for (int i = 0; i < 3; i++) {
      rows[6 * r + i] = sign * d[i];
      rows[6 * r + 3 + i] = sign * turn[i];
    }
  }
}

/* rows[3 x 6] times the velocity of body b, added to q. */
static void add_velocity(const double *rows, const double *v, double *q) {
  for (int r = 0; r < 3; r++) {
    for (int i = 0; i < 6; i++) {
      q[r] += rows[6 * r + i] * v[i];
    }
  }
}

static void pose_contacts(step *s, const double *velocity, const double *impulse) {
  const lcp_contacts *c = s->c;
  int at = 0;
  for (int k = 0; k < c->n_contact; k++) {
    double *frame = s->frame + 9 * (size_t)k, *q = s->q + 3 * (size_t)k;
    memcpy(frame, c->normal + 3 * (size_t)k, 3 * sizeof *frame);
    tangents(frame, frame + 3, frame + 6);
    s->row_start[k] = 3 * k;
    s->jac_start[k] = at;
    q[0] = (c->bias != NULL) ? c->bias[k] : 0.0;
    q[1] = q[2] = 0.0;
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * k + side];
      s->body[2 * k + side] = b;
      if (b >= 0) {
        pose_side(s, k, b, side == 0 ? 1.0 : -1.0, s->jac + at);
        add_velocity(s->jac + at, velocity + 6 * (size_t)b, q);
        at += 18;
      }
    }
    for (int r = 0; r < 3; r++) {
      s->z[3 * k + r] = dot(frame + 3 * r, impulse + 3 * (size_t)k);
    }
    s->block[k] = (lcp_block){.start = 3 * k,
                              .size = 3,
                              .set = LCP_CONE,
                              .n_part = 1,
                              .part_dim = {2},
                              .part_mu = {c->mu[k]}};
  }
  s->row_start[c->n_contact] = s->n;
  s->jac_start[c->n_contact] = at;
}

static base_status pose(step *s, const double *velocity, const double *impulse, base_error *err) {
  BASE_TRY(check(s->c, velocity, impulse, err));
  if (s->c->n_contact > (1 << 25) || s->c->n_body > (1 << 25)) {
    return BASE_FAIL(err, BASE_EINVAL, "%d bodies, %d contacts: too many", s->c->n_body,
                     s->c->n_contact);
  }
  s->n = 3 * s->c->n_contact;
  BASE_TRY(allocate(s, err));
  pose_bodies(s);
  pose_contacts(s, velocity, impulse);
  s->factored = (lcp_factored){.n_body = s->c->n_body,
                               .dof_start = s->dof_start,
                               .weight_start = s->weight_start,
                               .weight = s->weight,
                               .n_group = s->c->n_contact,
                               .row_start = s->row_start,
                               .body = s->body,
                               .jac_start = s->jac_start,
                               .jac = s->jac};
  s->p = (lcp_problem){
      .M = {.storage = LCP_FACTORED, .n = s->n, .factored = &s->factored},
      .q = s->q,
      .block = s->block,
      .n_block = s->c->n_contact,
      .traits = LCP_SYMMETRIC | LCP_PSD,
  };
  return lcp_problem_check(&s->p, err);
}

/* velocity += W J' z, impulse = z in world axes. */
static void recover(const step *s, double *velocity, double *impulse) {
  const lcp_contacts *c = s->c;
  for (int k = 0; k < c->n_contact; k++) {
    const double *rows = s->jac + s->jac_start[k], *z = s->z + 3 * (size_t)k;
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * k + side];
      if (b < 0) {
        continue;
      }
      double push[6] = {0};
      for (int i = 0; i < 6; i++) {
        push[i] = rows[i] * z[0] + rows[6 + i] * z[1] + rows[12 + i] * z[2];
      }
      for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
          velocity[6 * b + i] += s->weight[36 * (size_t)b + (size_t)(6 * j + i)] * push[j];
        }
      }
      rows += 18;
    }
    const double *frame = s->frame + 9 * (size_t)k;
    for (int i = 0; i < 3; i++) {
      impulse[3 * k + i] = frame[i] * z[0] + frame[3 + i] * z[1] + frame[6 + i] * z[2];
    }
  }
}

int lcp_contact_step(const lcp_contacts *contacts, const char *solver, double *velocity,
                     double *impulse, lcp_report *report) {
  base_error err = {0};
  step s = {.c = contacts};
  if (pose(&s, velocity, impulse, &err) != BASE_OK) {
    free(s.mem);
    return library_failed(&err);
  }
  const int code = lcp_solve(&s.p, solver != NULL ? solver : "cone_newton", s.z, report);
  if (code == LCP_OK || code == LCP_UNSOLVED) {
    recover(&s, velocity, impulse);
  }
  free(s.mem);
  return code;
}
