/* assembly_use.c - what is read from an assembly: u = r + C lambda, C as one matrix, and the answer of a
 * step in the rows of the set. */
#include "formulations/assembly.h"
#include "formulations/dof_kernel.h"

#include <string.h>

/* u += block l. */
static void add_product(const double *block, int ri, int rj, const double *l, double *u) {
  for (int p = 0; p < ri; p++) {
    for (int q = 0; q < rj; q++) {
      u[p] += block[p * rj + q] * l[q];
    }
  }
}

void form_assembly_velocity(const form_assembly *a, const double *lambda, double *u) {
  memcpy(u, a->r, (size_t)a->n_row * sizeof *u);
  for (int i = 0; i < a->n_group; i++) {
    const int ri = form_rows_of(a, i);
    double *ui = u + a->row[i];
    for (int k = a->near_start[i]; k < a->near_start[i + 1]; k++) {
      const int j = a->near[k];
      add_product(a->block + a->block_at[k], ri, form_rows_of(a, j), lambda + a->row[j], ui);
    }
  }
}

double form_mobility(const form_assembly *a, int i, int at, int dim) {
  const int n = form_rows_of(a, i);
  const double *block = form_own_block(a, i);
  const double p = block[at * n + at];
  if (dim == 1) {
    return p;
  }
  const double q = block[at * n + at + 1];
  const double r = block[(at + 1) * n + at + 1];
  return 0.5 * (p + r) + sqrt(0.25 * (p - r) * (p - r) + q * q);
}

void form_assembly_dense(const form_assembly *a, double *out) {
  const ptrdiff_t n = a->n_row;
  memset(out, 0, (size_t)(n * n) * sizeof *out);
  for (int i = 0; i < a->n_group; i++) {
    const int ri = form_rows_of(a, i);
    for (int k = a->near_start[i]; k < a->near_start[i + 1]; k++) {
      const int j = a->near[k];
      const int rj = form_rows_of(a, j);
      const double *block = a->block + a->block_at[k];
      double *to = out + a->row[j] * n + a->row[i];
      form_put_block(block, ri, rj, to, n);
    }
  }
}

void form_add_force(form_assembly *a, int g, int rows, const double *l) {
  const contact_set *c = a->set;
  const int all = c->row_start[g + 1] - c->row_start[g];
  const double *jac = c->jac + c->jac_start[g];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = contact_dofs(c, b);
    double *f = a->force + ((n > 0) ? c->dof_start[b] : 0);
    for (int p = 0; p < rows; p++) {
      FORM_WITH_DOFS(n, form_add_scaled, l[p], jac + (ptrdiff_t)p * n, f);
    }
    jac += (ptrdiff_t)all * n;
  }
}

/* out = from + W force. */
static void add_motion(const form_assembly *a, const double *from, double *out) {
  const contact_set *c = a->set;
  for (int b = 0; b < c->n_body; b++) {
    const int n = contact_dofs(c, b);
    const int at = c->dof_start[b];
    memmove(out + at, from + at, (size_t)n * sizeof *out);
    FORM_WITH_DOFS(n, form_add_product, c->inv_mass + c->mass_start[b], a->force + at, out + at);
  }
}

/* shift = -W J_b' S^-1 repair, once a step. */
static void find_shift(form_assembly *a) {
  const contact_set *c = a->set;
  a->shifts = form_assembly_repair_impulses(a, a->lambda);
  a->shift_known = true;
  if (!a->shifts) {
    return;
  }
  memset(a->force, 0, (size_t)c->n_dof * sizeof *a->force);
  memset(a->shift, 0, (size_t)c->n_dof * sizeof *a->shift);
  for (int i = a->full.n_contact; i < a->full.n_contact + form_joints_of(a); i++) {
    form_add_force(a, a->full.group[i], a->full.row[i + 1] - a->full.row[i],
                   a->lambda + a->full.row[i]);
  }
  add_motion(a, a->shift, a->shift);
  for (int d = 0; d < c->n_dof; d++) {
    a->shift[d] = -a->shift[d];
  }
}

/* The impulses of all contacts in the rows of `full` into a->lambda, with those of the joints that they ask for: as they are, or
 * as they move the bodies. Returns whether these differ, which they do where a tied row carries. */
static bool take_impulses(form_assembly *a, const double *lambda, bool as_they_move) {
  bool ties = false;
  if (a->reduced) {
    memset(a->lambda, 0, (size_t)a->full.row[a->full.n_contact] * sizeof *lambda);
    for (int i = 0; i < a->n_contact; i++) {
      double *to = a->lambda + a->full.row[a->full_of[i]];
      if (as_they_move) {
        ties |= form_to_motion(a, i, lambda + a->row[i], to);
      } else {
        form_to_set(a, i, lambda + a->row[i], to);
      }
    }
    const int first = a->row[a->n_contact]; /* of joints that are rows */
    memcpy(a->lambda + a->full.row[a->full.n_contact], lambda + first,
           (size_t)(a->n_row - first) * sizeof *lambda);
  } else {
    memcpy(a->lambda, lambda, (size_t)a->n_row * sizeof *lambda);
  }
  if (a->n_joint_group > 0) {
    form_assembly_joint_impulses(a, a->lambda);
  }
  return ties;
}

void form_assembly_answer(form_assembly *a, const double *lambda) {
  const contact_set *c = a->set;
  const int n_contact = a->reduced ? a->full.n_contact : a->n_contact;
  const int n_group = n_contact + form_joints_of(a);
  const bool own = a->reduced || a->n_joint_group > 0;
  if (a->beside && !a->shift_known) {
    find_shift(a);
  }
  const bool ties = own && take_impulses(a, lambda, true);
  const double *l = own ? a->lambda : lambda;
  memset(a->force, 0, (size_t)c->n_dof * sizeof *a->force);
  for (int i = 0; i < n_group; i++) {
    form_add_force(a, a->full.group[i], a->full.row[i + 1] - a->full.row[i], l + a->full.row[i]);
  }
  if (ties) {
    (void)take_impulses(a, lambda, false);
  }
  for (int i = 0; i < n_group; i++) {
    memcpy(a->impulse + c->row_start[a->full.group[i]], l + a->full.row[i],
           (size_t)(a->full.row[i + 1] - a->full.row[i]) * sizeof *l);
  }
  add_motion(a, c->v_free, a->v_next);
}

void form_assembly_answer_beside(form_assembly *a, const double *lambda, const double *way) {
  const int n = a->set->n_dof;
  form_assembly_answer(a, way);
  for (int d = 0; d < n; d++) {
    a->shift[d] = (a->shifts ? a->shift[d] : 0) + a->v_next[d];
  }
  a->shifts = true;
  form_assembly_answer(a, lambda);
  for (int d = 0; d < n; d++) {
    a->shift[d] -= a->v_next[d];
  }
}

void form_add_velocity(const contact_set *c, int g, int rows, const double *x, double *u) {
  const int all = c->row_start[g + 1] - c->row_start[g];
  const double *jac = c->jac + c->jac_start[g];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = contact_dofs(c, b);
    for (int p = 0; p < rows && n > 0; p++) {
      u[p] += FORM_WITH_DOFS(n, form_dot, jac + (ptrdiff_t)p * n, x + c->dof_start[b]);
    }
    jac += (ptrdiff_t)all * n;
  }
}

void form_assembly_velocity_of(form_assembly *a, const double *lambda, double *u) {
  const contact_set *c = a->set;
  form_assembly_answer(a, lambda);
  for (int d = 0; d < c->n_dof; d++) {
    a->force[d] = a->v_next[d] - c->v_free[d];
  }
  memcpy(u, a->r, (size_t)a->n_row * sizeof *u);
  for (int i = 0; i < a->n_group; i++) {
    form_add_velocity(c, a->group[i], form_rows_of(a, i), a->force, u + a->row[i]);
  }
}

/* Shares of a speed that is no sliding: of what friction can change in a step, and of the largest velocity without contacts,
 * which solvers answer to about 1e-9. */
static const double of_friction = 1e-6, of_largest = 1e-8;

form_slip form_slip_of(const form_assembly *a, double rest) {
  double largest = 0;
  for (int r = 0; r < a->row[a->n_contact]; r++) {
    largest = fmax(largest, fabs(a->r[r]));
  }
  const double still = of_largest * largest;
  bool owed = false; /* an impact of a step before is given back */
  for (int i = 0; i < a->n_contact && !owed; i++) {
    owed = a->bias[a->group[i]] < -still;
  }
  return (form_slip){.still = still, .share = of_friction, .hit = owed || form_has_impact(a, rest)};
}

/* u, over the rows of the set of active contact i, along its tangents in use: t[0] and t[1], 0 where there is only one. */
static void tangents_of(const form_assembly *a, int i, const double *u, double t[2]) {
  double used[6];
  form_to_rows(a, i, u, used);
  t[0] = used[1];
  t[1] = (a->rows[i].tangent > 1) ? used[2] : 0;
}

/* Of active contact i over the rows of the set, in the motion that form_assembly_answer wrote. */
static void end_velocity(const form_assembly *a, int i, double u[6]) {
  const contact_set *c = a->set;
  const int g = a->group[i], rows = c->row_start[g + 1] - c->row_start[g];
  memcpy(u, c->u_drift + c->row_start[g], (size_t)rows * sizeof *u);
  form_add_velocity(c, g, rows, a->v_next, u);
}

double form_slip_speed(const form_assembly *a, int i) {
  double u[6], t[2];
  end_velocity(a, i, u);
  tangents_of(a, i, u, t);
  return hypot(t[0], t[1]);
}

bool form_opposes(const form_assembly *a, int i, const double *friction) {
  static const double aside = 0.1; /* of the slip */
  double u[6], t[2];
  end_velocity(a, i, u);
  tangents_of(a, i, u, t);
  const double across = (a->rows[i].tangent > 1) ? friction[1] : 0;
  const double much = hypot(friction[0], across) * hypot(t[0], t[1]);
  const bool against = friction[0] * t[0] + across * t[1] < 0;
  return against && fabs(friction[0] * t[1] - across * t[0]) <= aside * much;
}

bool form_slides(const form_assembly *a, int i, double bound, const form_slip *slip) {
  const int tangent = a->rows[i].tangent;
  if (tangent == 0) {
    return false;
  }
  const double speed = form_slip_speed(a, i);
  return speed > slip->still && speed > slip->share * form_mobility(a, i, 1, tangent) * bound;
}

/* Do the applied forces alone give active contact i the slip u within a step? */
static bool is_by_loads(const form_assembly *a, int i, const double before[2], const double u[2]) {
  const double *free = a->r + a->row[i] + 1;
  const double across = (a->rows[i].tangent > 1) ? free[1] - before[1] : 0;
  return hypot(u[0], u[1]) <= hypot(free[0] - before[0], across);
}

/* Did the slip of contact i, which slid before the step, end as that of one that has been at rest in it? */
static bool has_rested(const form_assembly *a, int i, const double *end, int slid,
                       const form_slip *slip) {
  const contact_set *c = a->set;
  double before[2], u[2];
  tangents_of(a, i, c->u_before + c->row_start[a->group[i]], before);
  tangents_of(a, i, end, u);
  const bool turned = before[0] * u[0] + before[1] * u[1] <= 0;
  if (turned && (!slip->hit || is_by_loads(a, i, before, u))) {
    return true;
  }
  return slid < 0 && hypot(u[0], u[1]) < hypot(before[0], before[1]);
}

void form_note_slide(const form_assembly *a, int i, const form_slip *slip, contact_memory *m) {
  const contact_set *c = a->set;
  const int g = a->group[i];
  double *now = contact_memory_now(m, g);
  double end[6];
  now[PAST_SLIDES] = 1;
  if (!(c->mu_kinetic[g] < c->mu_static[g])) {
    return;
  }
  const int slid = contact_memory_slides(m, c, g);
  end_velocity(a, i, end);
  contact_memory_way(c, g, end, now + PAST_WAY);
  now[PAST_SLIDES] = (slid != 0 && has_rested(a, i, end, slid, slip)) ? -1 : 1;
}
