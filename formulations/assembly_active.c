/* assembly_active.c - which contacts are active, with what bias, and their free velocities. */
#include "formulations/assembly.h"
#include "formulations/dof_kernel.h"
#include "lcp/base/crew.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_ROWS = 8 };

/* The tolerance is 1e-9 of the smallest body: a gap below 1e-15 of that, or of the rounding of positions far out, is no overlap to
 * be pushed out: between walls that would have no solution. */
static const double gap_noise = 1e-6;
/* A contact that was closed stays so up to this many tolerances of the set; and one that carried an impulse. */
static const double held = 10, loaded = 30;
/* Of the velocity that an impulse made, what the tolerance of a solver (1e-9) or rounding may leave of it. */
static const double met = 1e-9;

/* Where the rows of one group stand, and the velocities that they act on. */
typedef struct group_rows {
  int first, n[2];
  const double *jac[2], *v[2];
} group_rows;

static group_rows rows_of(const contact_set *c, int g, const double *v) {
  const int first = c->row_start[g];
  const int *b = c->body + 2 * (ptrdiff_t)g;
  group_rows r = {.first = first, .n = {contact_dofs(c, b[0]), contact_dofs(c, b[1])}};
  r.jac[0] = c->jac + c->jac_start[g];
  r.jac[1] = r.jac[0] + (ptrdiff_t)(c->row_start[g + 1] - first) * r.n[0];
  for (int side = 0; side < 2; side++) {
    r.v[side] = (r.n[side] > 0) ? v + c->dof_start[b[side]] : v;
  }
  return r;
}

/* *u += x y, *size += |x y|, term by term. */
static inline void add_terms(const double *x, const double *y, double *u, double *size, int n) {
  double sum = *u;
  double sizes = *size;
  for (int k = 0; k < n; k++) {
    const double term = x[k] * y[k];
    sum += term;
    sizes += fabs(term);
  }
  *u = sum;
  *size = sizes;
}

/* u of one row with its drift; size: sum of what it is made of. */
static double row_velocity(const contact_set *c, const group_rows *r, int row, double *size) {
  double u = c->u_drift[r->first + row];
  *size = fabs(u);
  for (int side = 0; side < 2; side++) {
    const int n = r->n[side];
    FORM_WITH_DOFS(n, add_terms, r->jac[side] + (ptrdiff_t)row * n, r->v[side], &u, size);
  }
  return u;
}

/* Inverse radius of gyration of the bodies of a group, the larger one, about the axes of its spins, rows
 * `metres` .. rows-1 [1/m]. The first dof is a translation; where a body can only turn it is not, and the
 * value is a ratio of moments. */
static double gyration(const contact_set *c, const group_rows *r, int g, int metres, int rows) {
  double most = 0;
  for (int side = 0; side < 2; side++) {
    const int n = r->n[side];
    const int b = c->body[2 * g + side];
    const double *w = (n > 0) ? c->inv_mass + c->mass_start[b] : NULL;
    for (int i = metres; i < rows && n > 0 && w[0] > 0; i++) {
      const double *spin = r->jac[side] + (ptrdiff_t)i * n;
      for (int k = 1; k < n; k++) { /* what a spin does not touch is no rotation about its axis */
        most = (spin[k] != 0) ? fmax(most, sqrt(w[k * n + k] / w[0])) : most;
      }
    }
  }
  return most;
}

/* A value below the rounding error of the sum that it comes from is zero: such noise is no sliding, and a
 * problem whose q has it in some rows is degenerate at two scales at once. */
static inline double without_noise(double u, double size) {
  return (fabs(u) <= 4 * DBL_EPSILON * size) ? 0 : u;
}

/* u of the first `rows` rows of group g. `metres`: rows in
 * m/s, which share one error; it also gives that of spins behind them, which the impulses of the step
 * before have left, through the radius of gyration. */
static void group_velocity(const contact_set *c, const group_rows *r, int g, int rows, int metres,
                           double *u) {
  double size[MOST_ROWS];
  for (int i = 0; i < rows; i++) {
    u[i] = row_velocity(c, r, i, &size[i]);
  }
  double common = 0;
  for (int i = 0; i < metres; i++) {
    common = (size[i] > common) ? size[i] : common;
  }
  const double spin =
      (metres > 0 && metres < rows) ? 8 * common * gyration(c, r, g, metres, rows) : 0;
  for (int i = 0; i < rows; i++) {
    u[i] = without_noise(u[i], (i < metres) ? common : fmax(size[i], spin));
  }
}

/* n' W n of the normal row of contact g [1/kg]. */
static double mobility(const contact_set *c, int g) {
  const group_rows r = rows_of(c, g, c->v);
  double sum = 0;
  for (int side = 0; side < 2; side++) {
    const int n = r.n[side];
    for (int k = 0; k < n * n; k++) {
      const double w = c->inv_mass[c->mass_start[c->body[2 * g + side]] + k];
      sum += r.jac[side][k / n] * w * r.jac[side][k % n];
    }
  }
  return sum;
}

/* Gap up to which contact i is closed whatever it does [m]. Closed before, it may have moved away by the rounding of positions, and by
 * what was left of the velocity that its impulse made: much where a large impulse passes through a light body (1e8 kg on 1 kg). */
static double closed_up_to(const contact_set *c, int i, const contact_memory *memory) {
  const double *past = contact_memory_old(memory, i);
  if (!contact_memory_closed(memory, i)) {
    return c->tol;
  }
  if (past == NULL || !(past[PAST_IMPULSE] > 0) || !(c->gap[i] > held * c->tol)) {
    return held * c->tol;
  }
  return fmax(loaded * c->tol, met * c->h * mobility(c, i) * past[PAST_IMPULSE]);
}

/* Is another contact of the two shapes of contact i closed? Contacts of two shapes follow each other. */
static bool pair_touches(const contact_set *c, int i, const contact_memory *memory) {
  const uint64_t shapes = contact_shapes_of(c->id[i]);
  bool touches = false;
  for (int way = -1; way <= 1; way += 2) {
    for (int k = i + way;
         !touches && k >= 0 && k < c->n_contact && contact_shapes_of(c->id[k]) == shapes;
         k += way) {
      touches = c->gap[k] <= closed_up_to(c, k, memory);
    }
  }
  return touches;
}

/* Did contact i carry, and would it close again within the step? The turning of its bodies lifted it, or it bounced. If it were open the
 * step would end in an overlap, and the next begin with an impact. Where its shapes touch at another point they turn about that one. */
static bool hovers(const contact_set *c, int i, const form_rule *rule, const contact_memory *memory,
                   double u_free) {
  const double *past = contact_memory_old(memory, i);
  return rule->activation == FORM_CLOSED && past != NULL && past[PAST_IMPULSE] > 0 &&
         c->gap[i] > held * c->tol && c->gap[i] <= -c->h * u_free &&
         contact_memory_closed(memory, i) && !pair_touches(c, i, memory);
}

/* Gap of contact i without what says nothing [m]: rounding, and of a contact that carried an impulse what the solver's
 * tolerance left of its velocity. At position level gaps of 1e-14 m would else decide which of redundant contacts carry. */
static double gap_without_noise(const contact_set *c, int i, const contact_memory *memory) {
  const double *past = contact_memory_old(memory, i);
  const bool carried = past != NULL && past[PAST_IMPULSE] > 0 && contact_memory_closed(memory, i);
  const double noise = fmax((carried ? 1 : gap_noise) * c->tol, c->noise);
  return (fabs(c->gap[i]) <= noise) ? 0 : c->gap[i];
}

/* Bias of contact i, which has that gap and is closed up to the gap tol; HUGE_VAL where it is not active. What has moved
 * apart by more than is usual may come back. */
static double normal_bias(const contact_set *c, int i, const form_rule *rule, double u_free,
                          double gap, double tol) {
  const double u = c->u_before[c->row_start[i]];
  const double test = (rule->activation == FORM_MOREAU) ? gap + 0.5 * c->h * u : gap;
  const bool closed = test <= tol;
  if (!closed && rule->level == FORM_LEVEL_VELOCITY) {
    return HUGE_VAL;
  }
  const bool off = closed && gap > held * c->tol && rule->activation == FORM_CLOSED;
  double b = 0;
  if (gap < 0 || off || rule->level == FORM_LEVEL_POSITION) {
    b = ((gap < 0) ? rule->repair.push : 1.0) * gap / c->h;
    b = fmax(b, -rule->repair.push_speed);
  }
  const double gain = fmax(0.0, u - u_free); /* approach speed won in this step */
  if (closed && rule->newton && c->restitution != NULL && -u > rule->repair.rest * gain) {
    b = fmin(b, c->restitution[i] * fmin(u, 0.0));
  }
  return b;
}

static contact_rows rows_wanted(const contact_set *c, int i, form_rows rows) {
  switch (rows) {
  case FORM_ROWS_NORMAL:
    return (contact_rows){0};
  case FORM_ROWS_TANGENT:
    return (contact_rows){.tangent = c->rows[i].tangent};
  case FORM_ROWS_ALL:
    break;
  }
  return c->rows[i];
}

/* Contact i becomes the next active one. */
static void activate(form_assembly *a, const contact_set *c, int i, form_rows rows) {
  const int k = a->n_contact++;
  const contact_rows wanted = rows_wanted(c, i, rows);
  a->group[k] = i;
  a->rows[k] = wanted;
  a->turned[k] = false;
  a->full_of[k] = k;
  a->row[k + 1] = a->row[k] + 1 + wanted.tangent + wanted.torsion + wanted.rolling;
}

static void append_joint(form_assembly *a, const contact_set *c, int g, const form_rule *rule) {
  const int k = a->n_group++;
  const int n = c->row_start[g + 1] - c->row_start[g];
  const group_rows r = rows_of(c, g, c->v_free);
  double *to = a->r + a->row[k];
  a->group[k] = g;
  a->row[k + 1] = a->row[k] + n;
  group_velocity(c, &r, g, n, 0, to);
  for (int i = 0; i < n; i++) {
    const int at = c->row_start[g] - c->row_start[c->n_contact] + i;
    a->repair[a->row[k] + i] = rule->repair.joint_push / c->h * c->joint_error[at];
    to[i] += a->repair[a->row[k] + i];
  }
}

bool form_has_impact(const form_assembly *a, double rest) {
  const contact_set *c = a->set;
  bool any = false;
  for (int i = 0; i < a->n_contact && !any; i++) {
    const int g = a->group[i];
    const double u = c->u_before[c->row_start[g]];
    const double gain = fmax(0.0, u - a->r_normal[g]);
    any = -u > rest * gain && -u * c->h > c->tol;
  }
  return any;
}

/* Springs stay as they are under a law that has none. */
static void note_active(contact_memory *memory, int i, const double *past) {
  double *now = contact_memory_now(memory, i);
  now[PAST_CLOSED] = 1;
  if (past != NULL && past[PAST_SPRUNG] > 0) {
    const int pulls = contact_memory_pulls(memory);
    now[PAST_SPRUNG] = past[PAST_SPRUNG];
    memcpy(now + pulls, past + pulls, (size_t)memory->layout.pull * sizeof *now);
  }
}

/* What the choice goes by. */
typedef struct choice {
  form_assembly *a;
  const contact_set *c;
  const form_rule *rule;
  contact_memory *memory;
} choice;

/* Bias of the contacts of one part, HUGE_VAL where they are not active. */
static void judge_contacts(void *of, int part, int hand) {
  const choice *h = of;
  const contact_set *c = h->c;
  form_assembly *a = h->a;
  (void)hand;
  for (int i = part * CONTACT_SHARE; i < base_part_end(part, c->n_contact, CONTACT_SHARE); i++) {
    const group_rows r = rows_of(c, i, c->v_free);
    double size;
    const double u = row_velocity(c, &r, 0, &size);
    a->r_normal[i] = without_noise(u, size);
    const double *past = contact_memory_old(h->memory, i);
    a->bias[i] = normal_bias(c, i, h->rule, a->r_normal[i], gap_without_noise(c, i, h->memory),
                             hovers(c, i, h->rule, h->memory, a->r_normal[i])
                                 ? c->gap[i]
                                 : closed_up_to(c, i, h->memory));
    a->mode[i] = 0;
    if (a->bias[i] < HUGE_VAL && h->rule->gives && past != NULL && past[PAST_APPROACH] < 0 &&
        c->restitution != NULL) {
      a->bias[i] = fmin(a->bias[i], c->restitution[i] * past[PAST_APPROACH]);
    }
    if (a->bias[i] < HUGE_VAL) {
      note_active(h->memory, i, past);
    }
  }
}

/* r of the active contacts of one part. */
static void fill_velocities(void *of, int part, int hand) {
  const choice *h = of;
  const contact_set *c = h->c;
  form_assembly *a = h->a;
  (void)hand;
  for (int k = part * CONTACT_SHARE; k < base_part_end(part, a->n_contact, CONTACT_SHARE); k++) {
    const int i = a->group[k], n = a->row[k + 1] - a->row[k];
    const int metres = (n > 1 + c->rows[i].tangent) ? 1 + c->rows[i].tangent : n;
    const group_rows r = rows_of(c, i, c->v_free);
    group_velocity(c, &r, i, n, metres, a->r + a->row[k]);
  }
}

void form_assembly_choose(form_assembly *a, const contact_set *c, form_rows rows,
                          const form_rule *rule, contact_memory *memory) {
  choice h = {a, c, rule, memory};
  a->n_contact = 0;
  a->row[0] = 0;
  base_share(base_parts(c->n_contact, CONTACT_SHARE), judge_contacts, &h);
  for (int i = 0; i < c->n_contact; i++) {
    if (a->bias[i] < HUGE_VAL) {
      activate(a, c, i, rows);
    }
  }
  base_share(base_parts(a->n_contact, CONTACT_SHARE), fill_velocities, &h);
  a->n_joint_group = 0;
  a->n_group = a->n_contact;
  for (int g = c->n_contact; g < c->n_group; g++) {
    append_joint(a, c, g, rule);
  }
  a->n_row = a->row[a->n_group];
  a->all_rows = rule->all_rows;
  a->shifts = false;
  a->shift_known = false;
  a->beside = false;
  a->reduced = false;
  a->full.n_contact = a->n_contact;
  a->full.group = a->group;
  a->full.row = a->row;
}
