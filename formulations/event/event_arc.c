#include "formulations/event/event_arc.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Step handed to the detection: gaps, u and the curvature term are used of that set, and the
 * curvature is differenced over 1e-3 of it. */
static const double probe = 1e-3;     /* [s] */
static const double rank_tol = 1e-11; /* singular directions of redundant contacts */

void arc_close(arc *a) {
  free(a->contact);
  free(a->mem);
  *a = (arc){0};
}

base_status arc_reserve(arc *a, int n_contact, base_error *err) {
  if (n_contact > a->cap) {
    arc_contact *more = realloc(a->contact, (size_t)n_contact * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", n_contact);
    }
    a->contact = more;
    a->cap = n_contact;
  }
  return BASE_OK;
}

/* Work arrays of one evaluation: m unknowns over n dofs. */
typedef struct work {
  double *A, *b, *free_acc, *push; /* m*m, m, n, n*m: W J' of each unknown */
  int *row;                        /* m: row in the set; */
  int *of;                         /* m: contact in the list */
  lapack_int *pivot;               /* m */
} work;

static base_status reserve_work(arc *a, size_t m, size_t n, work *w, base_error *err) {
  const size_t doubles = m * m + m + n + n * m, ints = 3 * m;
  const size_t need = doubles + (ints * sizeof(lapack_int)) / sizeof(double) + 4;
  if (need > a->cap_mem) {
    free(a->mem);
    a->mem = malloc(2 * need * sizeof *a->mem);
    a->cap_mem = (a->mem != NULL) ? 2 * need : 0;
    if (a->mem == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %zu contact rows", m);
    }
  }
  double *d = a->mem;
  *w = (work){.A = d, .b = d + m * m, .free_acc = d + m * m + m, .push = d + m * m + m + n};
  lapack_int *i = (lapack_int *)(void *)(d + doubles);
  *w = (work){w->A, w->b, w->free_acc, w->push, i, i + m, i + 2 * m};
  return BASE_OK;
}

/* J_r . x over both sides of contact g, for its row r (of `rows`). */
static double row_dot(const contact_set *c, int g, int r, const double *x) {
  const int rows = c->row_start[g + 1] - c->row_start[g];
  const double *jac = c->jac + c->jac_start[g];
  double sum = 0.0;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
    for (int k = 0; k < n; k++) {
      sum += jac[r * n + k] * x[c->dof_start[b] + k];
    }
    jac += rows * n;
  }
  return sum;
}

/* out += W J_r' f. */
static void push_row(const contact_set *c, int g, int r, double f, double *out) {
  const int rows = c->row_start[g + 1] - c->row_start[g];
  const double *jac = c->jac + c->jac_start[g];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
    const double *W = (b < 0) ? NULL : c->inv_mass + c->mass_start[b];
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < n; k++) {
        out[c->dof_start[b] + i] += W[k * n + i] * jac[r * n + k] * f;
      }
    }
    jac += rows * n;
  }
}

static int find(const arc *a, uint64_t id) {
  for (int i = 0; i < a->n; i++) {
    if (a->contact[i].id == id) {
      return i;
    }
  }
  return -1;
}

/* Gaps and velocities of the listed contacts; the nearest closing one of the others. */
static void read_set(arc *a, int *group) {
  const contact_set *c = &a->set;
  a->open_gap = HUGE_VAL;
  for (int i = 0; i < a->n; i++) {
    a->contact[i].present = false;
  }
  for (int g = 0; g < c->n_contact; g++) {
    const int i = find(a, c->id[g]);
    const double *u = c->u_before + c->row_start[g];
    if (i < 0) {
      a->open_gap = (u[0] < 0.0) ? fmin(a->open_gap, c->gap[g]) : a->open_gap;
      continue;
    }
    arc_contact *k = &a->contact[i];
    group[i] = g;
    k->present = true;
    k->gap = c->gap[g];
    k->mu = (c->rows[g].tangent > 0) ? (k->stick ? c->mu_static[g] : c->mu_kinetic[g]) : 0.0;
    for (int r = 0; r < 3; r++) {
      k->u[r] = (r <= c->rows[g].tangent) ? u[r] : 0.0;
    }
    const double slip = hypot(k->u[1], k->u[2]);
    if (!k->stick && slip > 1e-9) {
      k->direction[0] = k->u[1] / slip;
      k->direction[1] = k->u[2] / slip;
    }
  }
}

/* Unknowns: the normal of every contact, the tangents of sticking ones. */
static size_t number(const arc *a, const int *group, work *w) {
  size_t m = 0;
  for (int i = 0; i < a->n; i++) {
    const arc_contact *k = &a->contact[i];
    const int rows = !k->present ? 0 : (k->stick ? 1 + a->set.rows[group[i]].tangent : 1);
    for (int r = 0; r < rows; r++, m++) {
      if (w != NULL) {
        w->row[m] = r;
        w->of[m] = i;
      }
    }
  }
  return m;
}

/* The equations for what is added to the forces at the start of the arc. */
static void fill(arc *a, const int *group, size_t m, const work *w) {
  const contact_set *c = &a->set;
  const size_t n = (size_t)c->n_dof;
  memset(w->push, 0, n * m * sizeof *w->push);
  for (size_t j = 0; j < m; j++) {
    const arc_contact *k = &a->contact[w->of[j]];
    const int g = group[w->of[j]];
    push_row(c, g, w->row[j], 1.0, w->push + j * n);
    for (int t = 0; !k->stick && t < c->rows[g].tangent; t++) {
      push_row(c, g, 1 + t, -k->mu * k->direction[t], w->push + j * n);
    }
  }
  for (size_t i = 0; i < m; i++) {
    const arc_contact *k = &a->contact[w->of[i]];
    const int g = group[w->of[i]], r = w->row[i];
    const double target =
        (r == 0) ? 2.0 * a->rate * k->u[0] + a->rate * a->rate * k->gap : a->rate * k->u[r];
    const double curve = c->u_curve[c->row_start[g] + r] / c->h;
    const double drift = (c->u_drift[c->row_start[g] + r] + row_dot(c, g, r, c->v) -
                          c->u_before[c->row_start[g] + r]) /
                         c->h;
    w->b[i] = -(row_dot(c, g, r, w->free_acc) + curve + drift + target);
    for (size_t j = 0; j < m; j++) {
      w->A[j * m + i] = row_dot(c, g, r, w->push + j * n);
      w->b[i] -= w->A[j * m + i] * a->contact[w->of[j]].start[w->row[j]];
    }
  }
}

base_status arc_forces(arc *a, double *acc, base_error *err) {
  const size_t n = (size_t)world_n_dof(a->w);
  int group[64];
  if (a->n > 64) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "event: %d touching contacts, at most 64", a->n);
  }
  BASE_TRY(world_contacts_curved(a->w, probe, -1.0, &a->set, err));
  BASE_TRY(world_acceleration(a->w, acc, err));
  read_set(a, group);
  a->evaluations++;
  work w = {0};
  const size_t m = number(a, group, NULL);
  BASE_TRY(reserve_work(a, m, n, &w, err));
  (void)number(a, group, &w);
  memcpy(w.free_acc, acc, n * sizeof *acc);
  fill(a, group, m, &w);
  if (m > 0) {
    lapack_int rank = 0;
    memset(w.pivot, 0, m * sizeof *w.pivot);
    const lapack_int im = (lapack_int)m;
    if (LAPACKE_dgelsy(LAPACK_COL_MAJOR, im, im, 1, w.A, im, w.b, im, w.pivot, rank_tol, &rank) !=
        0) {
      return BASE_FAIL(err, BASE_EEXTERNAL, "event: contact equations could not be solved");
    }
  }
  for (int i = 0; i < a->n; i++) {
    memset(a->contact[i].force, 0, sizeof a->contact[i].force);
  }
  for (size_t j = 0; j < m; j++) {
    arc_contact *k = &a->contact[w.of[j]];
    const double f = k->start[w.row[j]] + w.b[j];
    k->force[w.row[j]] = f;
    for (int t = 0; !k->stick && t < 2; t++) {
      k->force[1 + t] = -k->mu * k->direction[t] * f;
    }
    for (size_t d = 0; d < n; d++) {
      acc[d] += w.push[j * n + d] * f;
    }
  }
  return BASE_OK;
}
