/* regularized_mass.c - the reduced LCP through the mass matrix (MATHEMATICS 2.3.2).
 *
 *   M_hat = M + J' Q' g^-1 Q J,   A = J_n M_hat^-1 J' B,   b = N r + b_n - J_n M_hat^-1 c,
 *   c = J' Q' g^-1 (Q r + o)
 *
 * with the compliant directions Q, compliances g, offsets o and columns B of regularized_contact.c;
 * the two forms give the same numbers. M_hat couples only bodies that share a contact with
 * friction. It is factored inside its envelope (regularized_envelope.c) or, where that would be
 * wide, by CHOLMOD (regularized_sparse.c). All right sides pass the forward substitution together;
 * nothing of contact space is formed. */
#include "formulations/dof_kernel.h"
#include "formulations/regularized/regularized_factor.h"

#include <cblas.h>
#include <stdlib.h>
#include <string.h>

/* Mean entries in a row of the envelope beyond which CHOLMOD is taken. The p right sides cost more than
 * the factor: up to a width of 500 (3840 dofs, 2080 contacts) the envelope was 1.4 to 2 times faster. */
static const size_t wide_envelope = 1024;

static void layout(void *state, base_arena *m) {
  reg_mass *s = state;
  const size_t n = (size_t)s->cap_dof;
  s->place = BASE_ARRAY(m, int, s->cap_body + 1);
  s->order = BASE_ARRAY(m, int, s->cap_body + 1);
  s->first = BASE_ARRAY(m, int, n);
  s->at = BASE_ARRAY(m, size_t, n + 1);
  s->link_start = BASE_ARRAY(m, int, s->cap_body + 2);
  s->link = BASE_ARRAY(m, int, 2 * (size_t)s->cap_contact);
  s->delta = BASE_ARRAY(m, double, n);
  s->c = BASE_ARRAY(m, double, n);
  s->e = BASE_ARRAY(m, double, REG_ROWS_MAX *n);
  s->from = BASE_ARRAY(m, int, s->cap_body);
  s->to = BASE_ARRAY(m, int, s->cap_body);
}

static void layout_values(void *state, base_arena *m) {
  reg_mass *s = state;
  s->L = BASE_ARRAY(m, double, s->cap_L);
  s->Y = BASE_ARRAY(m, double, s->cap_Y);
}

void reg_mass_close(reg_mass *m) {
  reg_sparse_close(m);
  free(m->joint.mem);
  free(m->mem);
  free(m->val_mem);
}

/* Bodies a and b of active contact i are coupled by friction. */
static bool is_link(const regularized *s, int i) {
  const int *b = s->a.set->body + 2 * (ptrdiff_t)s->a.group[i];
  return b[0] >= 0 && b[1] >= 0 && b[0] != b[1] && s->part_start[i] < s->part_start[i + 1];
}

/* Lists, for every body, the bodies it shares a friction contact with. */
static void find_links(const regularized *s, reg_mass *m) {
  const contact_set *c = s->a.set;
  memset(m->link_start, 0, ((size_t)c->n_body + 2) * sizeof *m->link_start);
  for (int i = 0; i < s->a.n_contact; i++) {
    const int *b = c->body + 2 * (ptrdiff_t)s->a.group[i];
    if (is_link(s, i)) {
      m->link_start[b[0] + 2]++;
      m->link_start[b[1] + 2]++;
    }
  }
  for (int k = 0; k < c->n_body; k++) {
    m->link_start[k + 2] += m->link_start[k + 1];
  }
  for (int i = 0; i < s->a.n_contact; i++) {
    const int *b = c->body + 2 * (ptrdiff_t)s->a.group[i];
    if (is_link(s, i)) {
      m->link[m->link_start[b[0] + 1]++] = b[1];
      m->link[m->link_start[b[1] + 1]++] = b[0];
    }
  }
}

/* Appends the neighbours of body b that have no place in the order yet. */
static int append_links(reg_mass *m, int b, int n) {
  for (int k = m->link_start[b]; k < m->link_start[b + 1]; k++) {
    if (m->place[m->link[k]] < 0) {
      m->place[m->link[k]] = 0;
      m->order[n++] = m->link[k];
    }
  }
  return n;
}

/* Breadth-first from the first body of each component, reversed; place[b]: its first dof. */
static void order_bodies(const contact_set *c, reg_mass *m) {
  int n = 0;
  for (int b = 0; b < c->n_body; b++) {
    m->place[b] = -1;
  }
  for (int seed = 0; seed < c->n_body; seed++) {
    if (m->place[seed] >= 0) {
      continue;
    }
    m->place[seed] = 0;
    m->order[n++] = seed;
    for (int head = n - 1; head < n; head++) {
      n = append_links(m, m->order[head], n);
    }
  }
  int at = 0;
  for (int k = n - 1; k >= 0; k--) {
    m->place[m->order[k]] = at;
    at += contact_dofs(c, m->order[k]);
  }
}

static base_status reserve(regularized *s, base_error *err) {
  reg_mass *m = &s->mass;
  const contact_set *c = s->a.set;
  if (m->mem == NULL || c->n_body > m->cap_body || c->n_dof > m->cap_dof ||
      c->n_contact > m->cap_contact) {
    m->cap_body = base_room(c->n_body);
    m->cap_dof = base_room(c->n_dof);
    m->cap_contact = base_room(c->n_contact);
    BASE_TRY(form_memory(&m->mem, layout, m, err));
  }
  find_links(s, m);
  order_bodies(c, m);
  reg_envelope_plan(c, m);
  const size_t wide = m->at[c->n_dof] / ((size_t)c->n_dof + 1);
  m->by_sparse = s->opt.factor == 2 || (s->opt.factor == 0 && wide > wide_envelope);
  BASE_TRY(reg_joint_begin(s, 2 * s->a.n_contact + 1, err));
  const size_t sides = (size_t)c->n_dof * (2 * (size_t)s->a.n_contact + 1 + (size_t)m->joint.n);
  const size_t entries = m->by_sparse ? 0 : m->at[c->n_dof];
  if (m->val_mem == NULL || entries > m->cap_L || sides > m->cap_Y) {
    m->cap_L = base_room_of(entries);
    m->cap_Y = base_room_of(sides);
    BASE_TRY(form_memory(&m->val_mem, layout_values, m, err));
  }
  return m->by_sparse ? reg_sparse_plan(c, m, err) : BASE_OK;
}

base_status reg_mass_begin(regularized *s, base_error *err) {
  const long before = s->mass.analyses;
  const base_status done = reserve(s, err);
  s->answer.work.analyses += s->mass.analyses - before;
  return done;
}

static int columns(const regularized *s) {
  return 1 + (s->any_slip ? 2 : 1) * s->a.n_contact;
}

/* Factors M_hat and leaves L^-1 of the right sides in Y. */
static bool substitute(regularized *s, int all) {
  reg_mass *m = &s->mass;
  const int n = s->a.set->n_dof;
  (m->by_sparse ? reg_sparse_mass : reg_envelope_mass)(s->a.set, m);
  reg_sides_fill(s, all);
  s->answer.work.factorizations++;
  if (!(m->by_sparse ? reg_sparse_factor(m) : reg_envelope_factor(s->a.set, m))) {
    return false;
  }
  if (m->by_sparse) {
    return reg_sparse_forward(m, n, all);
  }
  reg_envelope_forward(s->a.set, m, s->a.n_contact, s->any_slip ? 2 : 1, all);
  return true;
}

/* Products p p n up to which A is summed body by body; beyond, BLAS gains more by its blocks. */
static const double few = 2e7;

/* A = N B' of the columns `all` apart, without slip B = N. */
static void multiply(regularized *s, int all) {
  const int p = s->a.n_contact;
  const int n = s->a.set->n_dof;
  const double *N = s->mass.Y + 1;
  if (!s->mass.by_sparse && s->mass.joint.n == 0 && (double)p * p * n <= few) {
    reg_envelope_multiply(s->a.set, &s->mass, p, s->any_slip, all, s->A);
  } else if (s->any_slip) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, p, p, n, 1, N, all, N + p, all, 0, s->A,
                p);
  } else if (p > 0) { /* joints alone pose no problem */
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, p, n, 1, N, all, 0, s->A, p);
  }
  for (int j = 0; j < p && !s->any_slip; j++) {
    for (int i = j + 1; i < p; i++) {
      s->A[(ptrdiff_t)i * p + j] = s->A[(ptrdiff_t)j * p + i];
    }
  }
}

bool reg_mass_reduce(regularized *s) {
  reg_mass *m = &s->mass;
  const int n = s->a.set->n_dof;
  const int p = s->a.n_contact;
  const int width = columns(s);
  const int all = width + m->joint.n;
  if (!substitute(s, all) || (m->joint.n > 0 && !reg_joint_factor(s, width))) {
    return false;
  }
  for (int i = 0; i < p; i++) {
    s->b[i] = s->a.r[s->a.row[i]] + s->a.bias[s->a.group[i]];
  }
  /* Y row-major with `all` columns is a column-major all x n matrix */
  const double *N = m->Y + 1;
  for (ptrdiff_t k = 0; k < n; k++) {
    form_add_scaled(-m->Y[k * all], N + k * all, s->b, p);
  }
  if (m->joint.n > 0) {
    reg_joint_project(s, width);
  }
  multiply(s, all);
  return true;
}

/* delta = v - v_free = M_hat^-1 (J' B lambda_n - c); the compliant impulses follow from u. */
void reg_mass_expand(regularized *s, const double *lambda_n, double *lambda, double *u) {
  reg_mass *m = &s->mass;
  const int n = s->a.set->n_dof;
  const int p = s->a.n_contact;
  const int all = columns(s) + m->joint.n;
  const int first = 1 + (s->any_slip ? p : 0);
  for (ptrdiff_t k = 0; k < n; k++) {
    const double *row = m->Y + k * all;
    m->delta[k] = form_long_dot(row + first, lambda_n, p) - row[0];
  }
  (m->by_sparse ? reg_sparse_backward : reg_envelope_backward)(m, n, m->delta);
  reg_sides_motion(s, m->delta, u);
  memset(lambda, 0, (size_t)s->a.n_row * sizeof *lambda);
  if (m->joint.n > 0) {
    reg_joint_impulses(s, first, lambda_n, lambda);
  }
  for (int i = 0; i < p; i++) {
    double f[REG_ROWS_MAX];
    reg_slip_column(s, i, f);
    for (int k = 0; k < form_rows_of(&s->a, i); k++) {
      lambda[s->a.row[i] + k] = f[k] * lambda_n[i];
    }
  }
  for (int k = 0; k < s->n_rows; k++) {
    const reg_row *q = &s->rows[k];
    const double force = (reg_along(q, u + q->row) + q->offset) * q->stiffness;
    for (int x = 0; x < q->n; x++) {
      lambda[q->row + x] -= q->c[x] * force;
    }
  }
}
