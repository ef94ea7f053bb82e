#include "formulations/row_matrix.h"

#include "lcp/base/crew.h"

#include <stdlib.h>
#include <string.h>

/* Factors pay where the rows at a body are more than four times its velocities, as between boxes, whose contacts
 * are many for two bodies: J W J' has then about four times the entries of J. Joints are eliminated from the product
 * only, so with joints, and in small problems, row_matrix_build decides. */
static bool factors_pay(const contact_set *c) {
  long at_bodies = 0;
  if (c->n_group > c->n_contact || c->n_row <= 64) {
    return false;
  }
  for (int g = 0; g < c->n_group; g++) {
    const int sides = (c->body[2 * g] >= 0) + (c->body[2 * g + 1] >= 0);
    at_bodies += (long)sides * (c->row_start[g + 1] - c->row_start[g]);
  }
  return at_bodies > 4 * (long)c->n_dof;
}

row_storage row_storage_of(row_storage storage, const contact_set *c) {
  return (storage == ROW_AUTO && factors_pay(c)) ? ROW_FACTORED : storage;
}

base_status row_assembly_begin(form_assembly *a, const contact_set *c, row_storage storage,
                               bool eliminate, const form_rule *rule, contact_memory *memory,
                               base_error *err) {
  if (storage == ROW_FACTORED) { /* C is not needed but for its factors */
    return form_assembly_begin_own(a, c, FORM_ROWS_ALL, rule, memory, err);
  }
  BASE_TRY(form_assembly_begin(a, c, FORM_ROWS_ALL, rule, memory, err));
  return eliminate ? form_assembly_eliminate(a, err) : form_assembly_mix(a, err);
}

static void layout_rows(void *state, base_arena *a) {
  row_matrix *m = state;
  m->colptr = BASE_ARRAY(a, int, m->cap_n + 1);
  m->body = BASE_ARRAY(a, int, 2 * (size_t)m->cap_group);
  m->jac_start = BASE_ARRAY(a, int, m->cap_group + 1);
}

static void layout_values(void *state, base_arena *a) {
  row_matrix *m = state;
  m->val = BASE_ARRAY(a, double, m->cap_val);
  m->rowind = BASE_ARRAY(a, int, m->cap_val);
  m->jac = BASE_ARRAY(a, double, m->cap_jac);
}

void row_matrix_close(row_matrix *m) {
  free(m->mem);
  free(m->val_mem);
}

static base_status reserve(row_matrix *m, const form_assembly *a, size_t val, size_t jac,
                           base_error *err) {
  if (val > (size_t)INT32_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "Delassus matrix: %zu stored entries, more than 2^31 (storage=factored)", val);
  }
  if (m->mem == NULL || a->n_row > m->cap_n || a->n_group > m->cap_group) {
    m->cap_n = base_room(a->n_row);
    m->cap_group = base_room(a->n_group);
    BASE_TRY(form_memory(&m->mem, layout_rows, m, err));
  }
  if (m->val_mem == NULL || val > m->cap_val || jac > m->cap_jac) {
    m->cap_val = (val > m->cap_val) ? base_room_of(val) : m->cap_val;
    m->cap_jac = (jac > m->cap_jac) ? base_room_of(jac) : m->cap_jac;
    BASE_TRY(form_memory(&m->val_mem, layout_values, m, err));
  }
  return BASE_OK;
}

/* C is symmetric: column q of group j read along row q of its blocks. */
static int put_column(row_matrix *m, const form_assembly *a, int j, int q, int at) {
  for (int k = a->near_start[j]; k < a->near_start[j + 1]; k++) {
    const int i = a->near[k];
    const int ri = form_rows_of(a, i);
    const double *block = a->block + a->block_at[k] + (ptrdiff_t)q * ri;
    for (int p = 0; p < ri; p++) {
      m->rowind[at] = a->row[i] + p;
      m->val[at++] = block[p];
    }
  }
  return at;
}

static void fill_csc(row_matrix *m, const form_assembly *a) {
  int at = 0;
  for (int j = 0; j < a->n_group; j++) {
    for (int q = 0; q < form_rows_of(a, j); q++) {
      m->colptr[a->row[j] + q] = at;
      at = put_column(m, a, j, q, at);
    }
  }
  m->colptr[a->n_row] = at;
  m->M.csc = (lcp_csc){a->n_row, a->n_row, m->colptr, m->rowind, m->val};
}

static size_t jacobian_size(const form_assembly *a, int i) {
  const contact_set *c = a->set;
  int width = 0;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * a->group[i] + side];
    width += (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
  }
  return (size_t)form_rows_of(a, i) * (size_t)width;
}

/* Are the rows in use all rows of the set, in its order? */
static bool is_whole(const form_assembly *a) {
  const contact_set *c = a->set;
  bool whole = !a->reduced && a->n_group == c->n_group;
  for (int i = 0; i < a->n_group && whole; i++) {
    whole = a->group[i] == i && form_rows_of(a, i) == c->row_start[i + 1] - c->row_start[i];
  }
  return whole;
}

typedef struct copying {
  row_matrix *m;
  const form_assembly *a;
} copying;

/* The rows in use of the active groups of one part, to where m->jac_start says. */
static void copy_jacobians(void *of, int part, int hand) {
  const copying *h = of;
  const form_assembly *a = h->a;
  const contact_set *c = a->set;
  row_matrix *m = h->m;
  (void)hand;
  for (int i = part * CONTACT_SHARE; i < base_part_end(part, a->n_group, CONTACT_SHARE); i++) {
    const int g = a->group[i];
    const int rows = form_rows_of(a, i);
    const int all = c->row_start[g + 1] - c->row_start[g];
    const double *jac = c->jac + c->jac_start[g];
    double *out = m->jac + m->jac_start[i];
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * g + side];
      const int n = (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
      m->body[2 * i + side] = b;
      memcpy(out, jac, (size_t)rows * (size_t)n * sizeof *out);
      out += (ptrdiff_t)rows * n;
      jac += (ptrdiff_t)all * n;
    }
  }
}

static void fill_factored(row_matrix *m, const form_assembly *a, bool whole) {
  const contact_set *c = a->set;
  if (!whole) {
    copying h = {m, a};
    m->jac_start[0] = 0;
    for (int i = 0; i < a->n_group; i++) {
      m->jac_start[i + 1] = m->jac_start[i] + (int)jacobian_size(a, i);
    }
    base_share(base_parts(a->n_group, CONTACT_SHARE), copy_jacobians, &h);
  }
  m->factored = (lcp_factored){.n_body = c->n_body,
                               .dof_start = c->dof_start,
                               .weight_start = c->mass_start,
                               .weight = c->inv_mass,
                               .n_group = a->n_group,
                               .row_start = a->row,
                               .body = whole ? c->body : m->body,
                               .jac_start = whole ? c->jac_start : m->jac_start,
                               .jac = whole ? c->jac : m->jac};
  m->M.factored = &m->factored;
}

base_status row_matrix_build(row_matrix *m, const form_assembly *a, row_storage storage,
                             base_error *err) {
  const size_t n = (size_t)a->n_row;
  const size_t nnz = (a->n_group > 0) ? a->block_at[a->near_start[a->n_group]] : 0;
  if (storage == ROW_AUTO) {
    storage = (n <= 64 || nnz > n * n / 4) ? ROW_DENSE : ROW_CSC;
  }
  const bool beside = form_keeps_factors(a, a->n_row) && storage != ROW_FACTORED;
  const bool factored = beside || storage == ROW_FACTORED, whole = factored && is_whole(a);
  size_t jac = 0;
  for (int i = 0; factored && !whole && i < a->n_group; i++) {
    jac += jacobian_size(a, i);
  }
  const size_t val = (storage == ROW_DENSE) ? n * n : ((storage == ROW_CSC) ? nnz : n);
  BASE_TRY(reserve(m, a, val, jac, err));
  m->M = (lcp_matrix){.n = a->n_row};
  switch (storage) {
  case ROW_AUTO:
  case ROW_DENSE:
    m->M.storage = LCP_DENSE;
    form_assembly_dense(a, m->val);
    m->M.val = m->val;
    break;
  case ROW_CSC:
    m->M.storage = LCP_CSC;
    fill_csc(m, a);
    break;
  case ROW_FACTORED:
    m->M.storage = LCP_FACTORED;
    break;
  }
  if (factored) {
    fill_factored(m, a, whole);
  }
  return BASE_OK;
}

void row_matrix_soften(row_matrix *m, const double *add) {
  const int n = m->M.n;
  if (m->M.storage == LCP_FACTORED) {
    int at = 0;
    for (int i = 0; i < n; i++) {
      m->colptr[i] = at;
      m->rowind[at] = i;
      m->val[at] = add[i];
      at += add[i] > 0;
    }
    m->colptr[n] = at;
    m->shift = (lcp_csc){n, n, m->colptr, m->rowind, m->val};
    m->factored.shift = (at > 0) ? &m->shift : NULL;
    return;
  }
  m->M.factored = NULL; /* which would need an S of its own */
  for (int j = 0; j < n; j++) {
    ptrdiff_t at = (ptrdiff_t)j * n + j;
    for (int k = 0; m->M.storage == LCP_CSC && k < m->colptr[j + 1] - m->colptr[j]; k++) {
      at = (m->rowind[m->colptr[j] + k] == j) ? m->colptr[j] + k : at;
    }
    m->val[at] += add[j];
  }
}
