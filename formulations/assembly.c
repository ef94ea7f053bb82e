#include "formulations/assembly.h"

#include "formulations/dof_kernel.h"
#include "lcp/base/crew.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FORM_PAIRS_MAX = 1 << 27 };

static void layout_rows(void *state, base_arena *m) {
  form_assembly *a = state;
  const struct form_assembly_size *s = &a->cap;
  a->group = BASE_ARRAY(m, int, s->group);
  a->row = BASE_ARRAY(m, int, s->group + 1);
  a->r = BASE_ARRAY(m, double, s->row);
  a->lambda = BASE_ARRAY(m, double, s->row);
  a->repair = BASE_ARRAY(m, double, s->row);
  a->home.near_start = BASE_ARRAY(m, int, s->group + 1);
  a->self = BASE_ARRAY(m, int, s->group);
  a->cursor = BASE_ARRAY(m, int, s->group);
  a->bias = BASE_ARRAY(m, double, s->contact);
  a->r_normal = BASE_ARRAY(m, double, s->contact);
  a->mode = BASE_ARRAY(m, unsigned char, s->contact);
  a->impulse = BASE_ARRAY(m, double, s->row);
  a->v_next = BASE_ARRAY(m, double, s->dof);
  a->force = BASE_ARRAY(m, double, s->dof);
  a->moved = BASE_ARRAY(m, double, s->dof);
  a->shift = BASE_ARRAY(m, double, s->dof);
  a->body_start = BASE_ARRAY(m, int, s->body + 2);
  a->body_group = BASE_ARRAY(m, int, 2 * (size_t)s->group);
  a->jw = BASE_ARRAY(m, double, (size_t)s->jw *(size_t)a->hands);
  a->rows = BASE_ARRAY(m, contact_rows, s->contact);
  a->turned = BASE_ARRAY(m, bool, s->contact);
  a->direction = BASE_ARRAY(m, form_direction, s->row);
  a->known = BASE_ARRAY(m, form_blocked, s->row);
  a->full_of = BASE_ARRAY(m, int, s->contact);
  a->home_group = BASE_ARRAY(m, int, s->group);
  a->home_row = BASE_ARRAY(m, int, s->group + 1);
}

static void layout_near(void *state, base_arena *m) {
  form_assembly *a = state;
  a->home.near = BASE_ARRAY(m, int, a->cap.near);
  a->home.block_at = BASE_ARRAY(m, size_t, a->cap.near + 1);
}

static void layout_blocks(void *state, base_arena *m) {
  form_assembly *a = state;
  a->home.block = BASE_ARRAY(m, double, a->cap.block);
}

void form_assembly_close(form_assembly *a) {
  free(a->mem);
  free(a->near_mem);
  free(a->block_mem);
  form_joints_close(&a->joints);
  *a = (form_assembly){0};
}

/* Grows by half so that a slowly growing scene allocates rarely. */
static int larger(int have, int need) {
  return (need <= have) ? have : base_room(need);
}

static base_status grow(form_assembly *a, const contact_set *c, base_error *err) {
  int widest = 1;
  for (int g = 0; g < c->n_group; g++) {
    const int n = c->jac_start[g + 1] - c->jac_start[g];
    widest = (n > widest) ? n : widest;
  }
  struct form_assembly_size *s = &a->cap;
  if (a->mem != NULL && c->n_contact <= s->contact && c->n_group <= s->group &&
      c->n_row <= s->row && c->n_dof <= s->dof && c->n_body <= s->body && widest <= s->jw &&
      base_crew_size() <= a->hands) {
    return BASE_OK;
  }
  s->contact = larger(s->contact, c->n_contact);
  s->group = larger(s->group, c->n_group);
  s->row = larger(s->row, c->n_row);
  s->dof = larger(s->dof, c->n_dof);
  s->body = larger(s->body, c->n_body);
  s->jw = larger(s->jw, widest);
  a->hands = base_crew_size();
  return form_memory(&a->mem, layout_rows, a, err);
}

/* Lists the active groups of every body, ascending. */
static void sort_by_body(form_assembly *a, const contact_set *c) {
  memset(a->body_start, 0, ((size_t)c->n_body + 2) * sizeof *a->body_start);
  for (int i = 0; i < a->n_group; i++) {
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * a->group[i] + side];
      if (b >= 0) {
        a->body_start[b + 2]++;
      }
    }
  }
  for (int b = 0; b < c->n_body; b++) {
    a->body_start[b + 2] += a->body_start[b + 1];
  }
  for (int i = 0; i < a->n_group; i++) {
    for (int side = 0; side < 2; side++) {
      const int b = c->body[2 * a->group[i] + side];
      if (b >= 0) {
        a->body_group[a->body_start[b + 1]++] = i;
      }
    }
  }
}

/* Merges the ascending lists of group i's two bodies; writes them to out unless NULL. */
static int neighbours(const form_assembly *a, const contact_set *c, int i, int *out) {
  if (a->own_only) {
    if (out != NULL) {
      out[0] = i;
    }
    return 1;
  }
  const int b0 = c->body[2 * a->group[i]];
  const int b1 = c->body[2 * a->group[i] + 1];
  int p = (b0 >= 0) ? a->body_start[b0] : 0;
  int q = (b1 >= 0) ? a->body_start[b1] : 0;
  const int p_end = (b0 >= 0) ? a->body_start[b0 + 1] : 0;
  const int q_end = (b1 >= 0) ? a->body_start[b1 + 1] : 0;
  int n = 0;
  int last = -1;
  bool seen = false; /* a group between fixed sides still meets itself */
  while (p < p_end || q < q_end) {
    const int gp = (p < p_end) ? a->body_group[p] : a->n_group;
    const int gq = (q < q_end) ? a->body_group[q] : a->n_group;
    const int g = (gp < gq) ? gp : gq;
    p += (gp == g);
    q += (gq == g);
    if (g != last) {
      if (out != NULL) {
        out[n] = g;
      }
      n++;
    }
    seen = seen || g == i;
    last = g;
  }
  if (!seen) {
    if (out != NULL) {
      out[0] = i;
    }
    n = 1;
  }
  return n;
}

/* Fills near_start, near, self, block_at. */
static base_status link_groups(form_assembly *a, const contact_set *c, base_error *err) {
  size_t n = 0;
  for (int i = 0; i < a->n_group; i++) {
    n += (size_t)neighbours(a, c, i, NULL);
  }
  if (n > FORM_PAIRS_MAX) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "contact space: %zu pairs of coupled contacts, more than %d", n,
                     FORM_PAIRS_MAX);
  }
  if (a->near_mem == NULL || (int)n > a->cap.near) {
    a->cap.near = larger(a->cap.near, (int)n);
    BASE_TRY(form_memory(&a->near_mem, layout_near, a, err));
  }
  a->near_start = a->home.near_start;
  a->near = a->home.near;
  a->block_at = a->home.block_at;
  a->near_start[0] = 0;
  a->block_at[0] = 0;
  for (int i = 0; i < a->n_group; i++) {
    const int at = a->near_start[i];
    a->near_start[i + 1] = at + neighbours(a, c, i, a->near + at);
    for (int k = at; k < a->near_start[i + 1]; k++) {
      const size_t size = (size_t)form_rows_of(a, i) * (size_t)form_rows_of(a, a->near[k]);
      a->block_at[k + 1] = a->block_at[k] + size;
      if (a->near[k] == i) {
        a->self[i] = k;
      }
    }
  }
  const size_t doubles = a->block_at[n];
  if (a->block_mem == NULL || doubles > a->cap.block) {
    a->cap.block = base_room_of(doubles);
    BASE_TRY(form_memory(&a->block_mem, layout_blocks, a, err));
  }
  a->block = a->home.block;
  return BASE_OK;
}

/* out = J W: rows x n, W symmetric. */
static inline void weigh_side(const double *jac, const double *w, int rows, double *out, int n) {
  memset(out, 0, (size_t)rows * (size_t)n * sizeof *out);
  for (int r = 0; r < rows; r++) {
    form_add_product(w, jac + (ptrdiff_t)r * n, out + (ptrdiff_t)r * n, n);
  }
}

/* out += (J_i W) J_j' for one shared body. */
static inline void couple_side(const double *jw, const double *jac, int ri, int rj, double *out,
                               int n) {
  for (int p = 0; p < ri; p++) {
    for (int q = 0; q < rj; q++) {
      out[p * rj + q] += form_dot(jw + (ptrdiff_t)p * n, jac + (ptrdiff_t)q * n, n);
    }
  }
}

/* jw = J_i W for both sides of group i: rows x dofs of side 0, then of side 1. */
static void weigh(const form_assembly *a, const contact_set *c, int i, double *jw) {
  const int g = a->group[i];
  const int rows = form_rows_of(a, i);
  const int all = c->row_start[g + 1] - c->row_start[g];
  const double *jac = c->jac + c->jac_start[g];
  double *out = jw;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = contact_dofs(c, b);
    const double *w = c->inv_mass + ((n > 0) ? c->mass_start[b] : 0);
    FORM_WITH_DOFS(n, weigh_side, jac, w, rows, out);
    jac += (ptrdiff_t)all * n;
    out += (ptrdiff_t)rows * n;
  }
}

/* C_ij = sum over shared bodies of (J_i W) J_j', with J_i W in jw. */
static void couple(const form_assembly *a, const contact_set *c, int i, int j, const double *jw,
                   double *out) {
  const int ri = form_rows_of(a, i);
  const int rj = form_rows_of(a, j);
  const int gi = a->group[i];
  const int gj = a->group[j];
  const int all = c->row_start[gj + 1] - c->row_start[gj];
  memset(out, 0, (size_t)ri * (size_t)rj * sizeof *out);
  for (int s = 0; s < 2; s++) {
    const int b = c->body[2 * gi + s];
    const int n = contact_dofs(c, b);
    const double *jac = c->jac + c->jac_start[gj];
    for (int t = 0; t < 2 && n > 0; t++) {
      if (c->body[2 * gj + t] == b) {
        FORM_WITH_DOFS(n, couple_side, jw, jac, ri, rj, out);
      }
      jac += (ptrdiff_t)all * contact_dofs(c, c->body[2 * gj + t]);
    }
    jw += (ptrdiff_t)ri * n;
  }
}

/* low = up', both row-major; the own block onto itself. */
static void mirror(const double *up, int ri, int rj, double *low) {
  for (int p = 0; p < ri; p++) {
    for (int q = (low == up) ? p + 1 : 0; q < rj; q++) {
      low[q * ri + p] = up[p * rj + q];
    }
  }
}

/* out += upper triangle of (J_i W) J_i'. */
static inline void couple_upper(const double *jw, const double *jac, int rows, double *out, int n) {
  for (int p = 0; p < rows; p++) {
    for (int q = p; q < rows; q++) {
      out[p * rows + q] += form_dot(jw + (ptrdiff_t)p * n, jac + (ptrdiff_t)q * n, n);
    }
  }
}

/* C_ii, with J_i W in jw. */
static void couple_own(const form_assembly *a, const contact_set *c, int i, const double *jw,
                       double *out) {
  const int g = a->group[i];
  const int *b = c->body + 2 * (ptrdiff_t)g;
  const int rows = form_rows_of(a, i);
  if (b[0] == b[1]) { /* the sides of one body couple */
    couple(a, c, i, i, jw, out);
  } else {
    memset(out, 0, (size_t)rows * (size_t)rows * sizeof *out);
    const double *jac = c->jac + c->jac_start[g];
    for (int side = 0; side < 2; side++) {
      const int n = contact_dofs(c, b[side]);
      FORM_WITH_DOFS(n, couple_upper, jw, jac, rows, out);
      jw += (ptrdiff_t)rows * n;
      jac += (ptrdiff_t)(c->row_start[g + 1] - c->row_start[g]) * n;
    }
  }
  mirror(out, rows, rows, out);
}

/* Upper blocks are computed, lower ones copied: C is symmetric to the last bit. The own block is
 * symmetrised the same way. */
static void fill_all(form_assembly *a, const contact_set *c) {
  memcpy(a->cursor, a->near_start, (size_t)a->n_group * sizeof *a->cursor);
  for (int i = 0; i < a->n_group; i++) {
    weigh(a, c, i, a->jw);
    couple_own(a, c, i, a->jw, a->block + a->block_at[a->self[i]]);
    for (int k = a->self[i] + 1; k < a->near_start[i + 1]; k++) {
      const int j = a->near[k];
      double *up = a->block + a->block_at[k];
      couple(a, c, i, j, a->jw, up);
      mirror(up, form_rows_of(a, i), form_rows_of(a, j), a->block + a->block_at[a->cursor[j]++]);
    }
  }
}

/* Does contact i resist torsion or rolling here? */
static bool resists(const form_assembly *a, int i) {
  return i < a->n_contact && form_rows_of(a, i) > 1 + a->set->rows[a->group[i]].tangent;
}

/* C_rr of row p of group i. */
static double diagonal_of(const form_assembly *a, int i, int p) {
  return form_own_block(a, i)[p * form_rows_of(a, i) + p];
}

/* Zeros for the entries of C_ij that are no more than rounding. */
static void drop_noise(const form_assembly *a, int i, int j, double *block) {
  static const double noise = 8.0 * DBL_EPSILON;
  const int ri = form_rows_of(a, i), rj = form_rows_of(a, j);
  for (int e = 0; e < ri * rj; e++) {
    const double scale = diagonal_of(a, i, e / rj) * diagonal_of(a, j, e % rj);
    block[e] = (block[e] * block[e] <= noise * noise * scale) ? 0.0 : block[e];
  }
}

/* What resists torsion and rolling of a ball has nothing to do with its slip. By an entry of 1e-17 it would, where nothing else moves it:
 * such entries are zero in the blocks of groups that resist. */
static void clean(form_assembly *a) {
  if (a->set->mu_torsion == NULL && a->set->mu_rolling == NULL) {
    return;
  }
  for (int i = 0; i < a->n_group; i++) {
    for (int k = a->near_start[i]; k < a->near_start[i + 1]; k++) {
      if (resists(a, i) || resists(a, a->near[k])) {
        drop_noise(a, i, a->near[k], a->block + a->block_at[k]);
      }
    }
  }
}

/* The diagonal alone: groups do not meet. */
static void fill_own(void *of, int part, int hand) {
  form_assembly *a = of;
  double *jw = a->jw + (ptrdiff_t)hand * a->cap.jw;
  for (int i = part * CONTACT_SHARE; i < base_part_end(part, a->n_group, CONTACT_SHARE); i++) {
    weigh(a, a->set, i, jw);
    couple_own(a, a->set, i, jw, a->block + a->block_at[a->self[i]]);
  }
}

/* At position level the gap closes in one step and the approach is gone in the next: Newton's law, which goes by it, would
 * take some bounces and leave out others (MATHEMATICS 2.2). */
static base_status check_rule(const contact_set *c, const form_rule *rule, base_error *err) {
  const bool asks = rule->newton && rule->level == FORM_LEVEL_POSITION && c->restitution != NULL;
  for (int i = 0; asks && i < c->n_contact; i++) {
    if (c->restitution[i] > 0) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "restitution %g at position level: need restitution=none, or velocity level",
                       c->restitution[i]);
    }
  }
  return BASE_OK;
}

/* The tolerance is 1e-9 of the smallest body; half of one, in tolerances. */
static const double half_a_body = 0.5e9;

/* Position level closes gaps to first order in the step. A body that is inside another after a step of it all the same turned too
 * far in that step: to push it out in one more would throw it. An overlap to begin with is pushed out. */
static base_status check_depth(const contact_set *c, const form_rule *rule,
                               const contact_memory *memory, base_error *err) {
  const bool begun = rule->level == FORM_LEVEL_POSITION && memory->h_old > 0;
  for (int i = 0; begun && i < c->n_contact; i++) {
    if (c->gap[i] < -half_a_body * c->tol) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "position level: an overlap of %.3g m, more than half of the smallest body, "
                       "came in a step of "
                       "%g s, which is too long to close gaps",
                       -c->gap[i], memory->h_old);
    }
  }
  return BASE_OK;
}

static base_status begin(form_assembly *a, const contact_set *c, form_rows rows,
                         const form_rule *rule, contact_memory *memory, base_error *err) {
  a->set = c;
  BASE_TRY(check_rule(c, rule, err));
  BASE_TRY(check_depth(c, rule, memory, err));
  BASE_TRY(grow(a, c, err));
  form_assembly_choose(a, c, rows, rule, memory);
  if (!a->own_only) {
    sort_by_body(a, c);
  }
  BASE_TRY(link_groups(a, c, err));
  assert(form_assembly_is_linked(a));
  if (a->own_only) {
    base_share(base_parts(a->n_group, CONTACT_SHARE), fill_own, a);
  } else {
    fill_all(a, c);
  }
  clean(a);
  if (a->n_group == a->n_contact && !a->own_only) { /* with joints: where they are eliminated */
    form_assembly_know_locks(a);
    form_assembly_unblock(a);
  }
  memset(a->impulse, 0, (size_t)c->n_row * sizeof *a->impulse);
  return BASE_OK;
}

base_status form_assembly_begin(form_assembly *a, const contact_set *c, form_rows rows,
                                const form_rule *rule, contact_memory *memory, base_error *err) {
  a->own_only = false;
  return begin(a, c, rows, rule, memory, err);
}

base_status form_assembly_begin_own(form_assembly *a, const contact_set *c, form_rows rows,
                                    const form_rule *rule, contact_memory *memory,
                                    base_error *err) {
  a->own_only = true;
  return begin(a, c, rows, rule, memory, err);
}
