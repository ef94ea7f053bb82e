#include "formulations/regularized/slip_problem.h"

#include <stdlib.h>
#include <string.h>

static void layout(void *state, base_arena *m) {
  slip_problem *s = state;
  const size_t n = (size_t)s->cap_n, rows = (size_t)s->cap_row;
  s->first = BASE_ARRAY(m, int, s->cap_contact + 1);
  s->direction = BASE_ARRAY(m, double, 2 * (size_t)s->cap_contact);
  s->mu = BASE_ARRAY(m, double, s->cap_contact);
  s->turn = BASE_ARRAY(m, double, s->cap_contact);
  s->given = BASE_ARRAY(m, double, s->cap_contact);
  s->unit = BASE_ARRAY(m, double, s->cap_contact);
  s->block = BASE_ARRAY(m, lcp_block, s->cap_contact);
  s->C = BASE_ARRAY(m, double, rows *rows);
  s->column = BASE_ARRAY(m, double, rows);
  s->M = BASE_ARRAY(m, double, n *n);
  s->q = BASE_ARRAY(m, double, n);
  s->z0 = BASE_ARRAY(m, double, n);
}

void slip_close(slip_problem *s) {
  free(s->mem);
  *s = (slip_problem){0};
}

static int tangents(const form_assembly *a, int i) {
  return form_rows_of(a, i) - 1;
}

static bool slips(const slip_problem *s, int i) {
  return s->direction[2 * i] != 0.0 || s->direction[2 * i + 1] != 0.0;
}

bool slip_at_rest(const slip_problem *s, const form_assembly *a, int i) {
  return tangents(a, i) > 0 && !slips(s, i);
}

static int facets_of(const slip_problem *s, const form_assembly *a, int i) {
  return (tangents(a, i) == 1) ? 2 : s->facets;
}

static int width(const slip_problem *s, const form_assembly *a, int i) {
  return slip_at_rest(s, a, i) ? facets_of(s, a, i) + 2 : 1;
}

/* Unit vector of facet k in the tangent rows of contact i. */
static void facet(const slip_problem *s, const form_assembly *a, int i, int k, double d[2]) {
  const double angle = s->turn[i] + 6.283185307179586476925 * k / facets_of(s, a, i);
  d[0] = (tangents(a, i) == 1) ? 1.0 - 2.0 * k : cos(angle);
  d[1] = (tangents(a, i) == 1) ? 0.0 : sin(angle);
}

base_status slip_begin(slip_problem *s, const form_assembly *a, int facets, int distribution,
                       base_error *err) {
  s->facets = facets;
  s->distribution = distribution;
  const int n = a->n_contact * (facets + 2);
  if (s->mem == NULL || a->n_contact > s->cap_contact || a->n_row > s->cap_row || n > s->cap_n) {
    s->cap_contact = base_room(a->n_contact) + 4;
    s->cap_row = 3 * s->cap_contact;
    s->cap_n = s->cap_contact * (facets + 2);
    BASE_TRY(form_memory(&s->mem, layout, s, err));
  }
  form_assembly_dense(a, s->C);
  memset(s->direction, 0, 2 * (size_t)a->n_contact * sizeof *s->direction);
  memset(s->turn, 0, (size_t)a->n_contact * sizeof *s->turn);
  memset(s->given, 0, (size_t)a->n_contact * sizeof *s->given);
  for (int i = 0; i < a->n_contact; i++) {
    const size_t r = (size_t)a->row[i];
    const double own = s->C[r * (size_t)a->n_row + r];
    s->unit[i] = (own > 0.0) ? own : 1.0;
    s->mu[i] = a->set->mu_static[a->group[i]];
  }
  return BASE_OK;
}

/* Adds the row impulses of contact i (own[rows]) that unknown k at value z stands for. */
static void spread(const slip_problem *s, const form_assembly *a, int i, int k, double z,
                   double *own) {
  double d[2];
  const int nt = tangents(a, i);
  if (k == 0) {
    own[0] += z;
    for (int t = 0; t < nt && slips(s, i); t++) {
      own[1 + t] -= s->mu[i] * s->direction[2 * i + t] * z;
    }
  } else if (k <= facets_of(s, a, i)) {
    facet(s, a, i, k - 1, d);
    for (int t = 0; t < nt; t++) {
      own[1 + t] += d[t] * z;
    }
  } /* sigma carries no impulse */
}

/* What the rows of contact i read from the velocities u: the normal, then along each facet. */
static void gather(const slip_problem *s, const form_assembly *a, int i, const double *u,
                   double *w) {
  const double *own = u + a->row[i];
  double d[2];
  w[0] = own[0];
  for (int k = 1; k <= width(s, a, i) - 2; k++) {
    facet(s, a, i, k - 1, d);
    w[k] = d[0] * own[1] + ((tangents(a, i) == 2) ? d[1] * own[2] : 0.0);
  }
}

/* The block of the cone row and of sigma: D'u + E sigma, mu lambda_n - sum beta, in units of u. */
static void fill_cone(slip_problem *s, const form_assembly *a, int i) {
  const size_t n = (size_t)s->n, first = (size_t)s->first[i];
  const size_t cone = first + (size_t)width(s, a, i) - 1;
  s->M[first * n + cone] = s->unit[i] * s->mu[i];
  for (size_t k = first + 1; k < cone; k++) {
    s->M[cone * n + k] = s->unit[i];
    s->M[k * n + cone] = -s->unit[i];
  }
}

/* column <- column + C e z of unknown k of contact j. */
static void add_motion(slip_problem *s, const form_assembly *a, int j, int k, double z) {
  const size_t rows = (size_t)a->n_row;
  double impulse[3] = {0};
  spread(s, a, j, k, z, impulse);
  for (int r = 0; r < form_rows_of(a, j); r++) {
    const double *c = s->C + ((size_t)a->row[j] + (size_t)r) * rows;
    for (size_t i = 0; i < rows && impulse[r] != 0.0; i++) {
      s->column[i] += impulse[r] * c[i];
    }
  }
}

/* What every contact reads of C e of unknown k of contact j: one column of M. */
static void fill_column(slip_problem *s, const form_assembly *a, int j, int k) {
  const size_t n = (size_t)s->n;
  memset(s->column, 0, (size_t)a->n_row * sizeof *s->column);
  add_motion(s, a, j, k, 1.0);
  for (int i = 0; i < a->n_contact; i++) {
    gather(s, a, i, s->column, s->M + (size_t)(s->first[j] + k) * n + (size_t)s->first[i]);
  }
}

void slip_pose(slip_problem *s, const form_assembly *a, const double *u0, lcp_problem *out) {
  s->first[0] = 0;
  for (int i = 0; i < a->n_contact; i++) {
    s->first[i + 1] = s->first[i] + width(s, a, i);
    const int cones = (width(s, a, i) > 1) ? 1 : 0;
    s->block[i] = (lcp_block){.start = s->first[i],
                              .size = width(s, a, i),
                              .set = LCP_ORTHANT,
                              .n_part = cones,
                              .part_dim = {cones * facets_of(s, a, i)},
                              .soft = form_soft(a->set, a->group[i], s->distribution)};
  }
  s->n = s->first[a->n_contact];
  const size_t n = (size_t)s->n;
  memset(s->M, 0, n * n * sizeof *s->M);
  memset(s->q, 0, n * sizeof *s->q);
  memset(s->z0, 0, n * sizeof *s->z0);
  for (int j = 0; j < a->n_contact; j++) {
    for (int k = 0; k < width(s, a, j); k++) {
      fill_column(s, a, j, k);
    }
  }
  memcpy(s->column, u0, (size_t)a->n_row * sizeof *s->column);
  for (int j = 0; j < a->n_contact; j++) {
    if (s->given[j] != 0.0) {
      add_motion(s, a, j, 0, s->given[j]);
    }
  }
  bool cones = false;
  for (int i = 0; i < a->n_contact; i++) {
    gather(s, a, i, s->column, s->q + s->first[i]);
    if (width(s, a, i) > 1) {
      fill_cone(s, a, i);
      s->q[s->first[i + 1] - 1] = s->unit[i] * s->mu[i] * s->given[i];
      cones = true;
    }
  }
  *out = (lcp_problem){.M = {.storage = LCP_DENSE, .n = s->n, .val = s->M},
                       .q = s->q,
                       .block = s->block,
                       .n_block = a->n_contact,
                       .traits = cones ? LCP_ZERO_DIAGONAL : 0u};
}

void slip_impulses(const slip_problem *s, const form_assembly *a, const double *z, double *lambda) {
  memset(lambda, 0, (size_t)a->n_row * sizeof *lambda);
  for (int i = 0; i < a->n_contact; i++) {
    spread(s, a, i, 0, s->given[i], lambda + a->row[i]);
    for (int k = 0; k < s->first[i + 1] - s->first[i]; k++) {
      spread(s, a, i, k, z[s->first[i] + k], lambda + a->row[i]);
    }
  }
}

void slip_departure(const slip_problem *s, const form_assembly *a, int i, const double *u0,
                    const double *lambda, double along[2]) {
  const size_t n = (size_t)a->n_row;
  along[0] = along[1] = 0.0;
  for (int t = 0; t < tangents(a, i); t++) {
    const size_t r = (size_t)a->row[i] + 1 + (size_t)t;
    along[t] = u0[r];
    for (size_t j = 0; j < n; j++) {
      along[t] += s->C[j * n + r] * lambda[j];
    }
  }
}
