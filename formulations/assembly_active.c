/* assembly_active.c - which contacts are active, with what bias, and their free velocities. */
#include "formulations/assembly.h"

#include <float.h>
#include <math.h>

enum { MOST_ROWS = 8 };

/* The tolerance is 1e-9 of the smallest body: a gap below 1e-15 of that is a rounding error of
 * positions, and no overlap to be pushed out. */
static const double gap_noise = 1e-6;

/* Inverse radius of gyration of the bodies of group g, the larger one [1/m]. */
static double gyration(const contact_set *c, int g) {
  double most = 0;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = contact_dofs(c, b);
    const double *w = (n > 0) ? c->inv_mass + c->mass_start[b] : NULL;
    for (int k = 1; k < n && w[0] > 0; k++) {
      most = fmax(most, sqrt(w[k * n + k] / w[0]));
    }
  }
  return most;
}

/* u of the first `rows` rows of group g at velocity v, plus drift. A value below the rounding error
 * of the sums it comes from is zero: such noise is no sliding, and a problem whose q has it in some
 * rows is degenerate at two scales at once. `metres`: rows in m/s, which share one error; it also gives
 * that of spins behind them, which the impulses of the step before have left, through the radius of
 * gyration. */
static void group_velocity(const contact_set *c, int g, int rows, int metres, const double *v,
                           double *u) {
  const int first = c->row_start[g];
  const int all = c->row_start[g + 1] - first;
  double size[MOST_ROWS];
  for (int i = 0; i < rows; i++) {
    u[i] = c->u_drift[first + i];
    size[i] = fabs(u[i]);
  }
  const double *jac = c->jac + c->jac_start[g];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = contact_dofs(c, b);
    const double *vb = v + ((n > 0) ? c->dof_start[b] : 0);
    for (int i = 0; i < rows; i++) {
      for (int k = 0; k < n; k++) {
        const double term = jac[i * n + k] * vb[k];
        u[i] += term;
        size[i] += fabs(term);
      }
    }
    jac += (ptrdiff_t)all * n;
  }
  double common = 0;
  for (int i = 0; i < metres; i++) {
    common = fmax(common, size[i]);
  }
  const double spin = (metres > 0 && metres < rows) ? 8 * common * gyration(c, g) : 0;
  for (int i = 0; i < rows; i++) {
    const double error = 4 * DBL_EPSILON * ((i < metres) ? common : fmax(size[i], spin));
    u[i] = (fabs(u[i]) <= error) ? 0 : u[i];
  }
}

/* Bias of contact i; HUGE_VAL where it is not active. u_free = J_n v_free + drift. */
static double normal_bias(const contact_set *c, int i, const form_rule *rule, double u_free,
                          bool was_closed) {
  const double gap = (fabs(c->gap[i]) <= gap_noise * c->tol) ? 0 : c->gap[i];
  const double u = c->u_before[c->row_start[i]];
  const double tol = was_closed ? 10 * c->tol : c->tol;
  const double test = (rule->activation == FORM_MOREAU) ? gap + 0.5 * c->h * u : gap;
  const bool closed = test <= tol;
  if (!closed && rule->level == FORM_LEVEL_VELOCITY) {
    return HUGE_VAL;
  }
  double b = 0;
  if (gap < 0 || rule->level == FORM_LEVEL_POSITION) {
    b = ((gap < 0) ? rule->push : 1.0) * gap / c->h;
    b = fmax(b, -rule->push_speed);
  }
  const double gain = fmax(0.0, u - u_free); /* approach speed won in this step */
  if (closed && rule->newton && c->restitution != NULL && -u > rule->rest * gain) {
    b = fmin(b, c->restitution[i] * fmin(u, 0.0));
  }
  return b;
}

static int rows_wanted(const contact_set *c, int i, form_rows rows) {
  switch (rows) {
  case FORM_ROWS_NORMAL:
    return 1;
  case FORM_ROWS_TANGENT:
    return 1 + c->rows[i].tangent;
  case FORM_ROWS_ALL:
    break;
  }
  return c->row_start[i + 1] - c->row_start[i];
}

void form_assembly_choose(form_assembly *a, const contact_set *c, form_rows rows,
                          const form_rule *rule, contact_memory *memory) {
  a->n_contact = 0;
  a->row[0] = 0;
  for (int i = 0; i < c->n_contact; i++) {
    group_velocity(c, i, 1, 1, c->v_free, &a->r_normal[i]);
    const double *past = contact_memory_old(memory, i);
    a->bias[i] = normal_bias(c, i, rule, a->r_normal[i], past != NULL && past[0] > 0);
    a->mode[i] = 0;
    if (a->bias[i] < HUGE_VAL) {
      const int k = a->n_contact++;
      contact_memory_now(memory, i)[0] = 1;
      a->group[k] = i;
      a->row[k + 1] = a->row[k] + rows_wanted(c, i, rows);
      const int n = form_rows_of(a, k);
      const int metres = (n > 1 + c->rows[i].tangent) ? 1 + c->rows[i].tangent : n;
      group_velocity(c, i, n, metres, c->v_free, a->r + a->row[k]);
    }
  }
  a->n_joint_group = 0;
  a->n_group = a->n_contact;
  for (int g = c->n_contact; g < c->n_group; g++) {
    const int k = a->n_group++;
    const int n = c->row_start[g + 1] - c->row_start[g];
    a->group[k] = g;
    a->row[k + 1] = a->row[k] + n;
    group_velocity(c, g, n, 0, c->v_free, a->r + a->row[k]);
    for (int i = 0; i < n; i++) {
      const int at = c->row_start[g] - c->row_start[c->n_contact] + i;
      a->r[a->row[k] + i] += rule->joint_push / c->h * c->joint_error[at];
    }
  }
  a->n_row = a->row[a->n_group];
}
