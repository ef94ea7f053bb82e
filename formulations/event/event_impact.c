/* Impacts: by Newton's law or Poisson's where something closes, and without collision where no force answers. */
#include "formulations/event/event_run.h"

#include <math.h>
#include <string.h>

/* The impulses of the impact that s->space poses become the state's, with the velocities after it. */
static base_status take_impulses(event_run *s, const contact_set *c, const double *lambda,
                                 base_error *err) {
  for (int i = 0; i < s->space.a.n_contact; i++) {
    impulse_entry *e;
    BASE_TRY(impulse_log_at(&s->log, c->id[s->space.a.group[i]], 0.0, &e, err));
    for (int r = 0; r < form_rows_of(&s->space.a, i); r++) {
      e->impulse[r] += lambda[s->space.a.row[i] + r];
    }
  }
  form_assembly_answer(&s->space.a, lambda);
  memcpy(s->y + s->n_config, s->space.a.v_next, (size_t)s->n_dof * sizeof *s->y);
  return event_log_joints(s, 0.0, true, err);
}

/* e of contact i, 0 where it is too slow to bounce. */
static double restitution_of(const event_run *s, const contact_set *c, int i) {
  const int g = s->space.a.group[i];
  const bool bounces = c->restitution != NULL && c->u_before[c->row_start[g]] < -s->rest;
  return bounces ? c->restitution[g] : 0.0;
}

/* Contacts that would bounce if they were faster. */
static int count_slow(const event_run *s, const contact_set *c) {
  int count = 0;
  for (int i = 0; i < s->space.a.n_contact; i++) {
    const int g = s->space.a.group[i];
    const double u = c->u_before[c->row_start[g]];
    count +=
        c->restitution != NULL && c->restitution[g] > 0.0 && u >= -s->rest && u < -0.1 * s->slow;
  }
  return count;
}

/* Newton's law: 0 <= lambda_n _|_ u_n + e u_n- >= 0. */
static base_status impact_by_newton(event_run *s, const contact_set *c, double *lambda,
                                    base_error *err) {
  const form_assembly *a = &s->space.a;
  double *u0 = s->row;
  memcpy(u0, a->r, (size_t)a->n_row * sizeof *u0);
  for (int i = 0; i < a->n_contact; i++) {
    u0[a->row[i]] += restitution_of(s, c, i) * c->u_before[c->row_start[a->group[i]]];
  }
  event_drop_noise(a->n_row, u0);
  return event_solve(s, u0, lambda, err);
}

/* Poisson's law: impulses that end the approach, and of the normal ones the share e once more, or as much beyond it as keeps
 * bodies apart, with friction of its own (MATHEMATICS 2.1). A solution always exists. */
static base_status impact_by_poisson(event_run *s, const contact_set *c, double *lambda,
                                     base_error *err) {
  const form_assembly *a = &s->space.a;
  double *u0 = s->row, *first = s->row + 2 * (ptrdiff_t)s->cap_row;
  memcpy(u0, a->r, (size_t)a->n_row * sizeof *u0);
  event_drop_noise(a->n_row, u0);
  BASE_TRY(event_solve(s, u0, first, err));
  if (!s->solved) {
    return BASE_OK;
  }
  form_assembly_velocity(a, first, u0);
  for (int i = 0; i < a->n_contact; i++) {
    s->p.given[i] = restitution_of(s, c, i) * first[a->row[i]];
  }
  event_drop_noise(a->n_row, u0);
  BASE_TRY(event_solve(s, u0, lambda, err));
  for (int r = 0; r < a->n_row; r++) {
    lambda[r] += first[r];
  }
  return BASE_OK;
}

/* What slips as it is hit has kinetic friction. */
static void set_friction(event_run *s, const contact_set *c) {
  for (int i = 0; i < s->space.a.n_contact; i++) {
    const int g = s->space.a.group[i];
    const double *u = c->u_before + c->row_start[g];
    double slip = 0.0;
    for (int k = 1; k <= c->rows[g].tangent; k++) {
      slip = hypot(slip, u[k]);
    }
    s->p.mu[i] = (slip > s->slow) ? c->mu_kinetic[g] : c->mu_static[g];
  }
}

base_status event_impact(event_run *s, const contact_set *c, base_error *err) {
  double *lambda = s->row + s->cap_row;
  bool poisson = s->opt->restitution == EVENT_POISSON;
  BASE_TRY(space_impact(&s->space, c, err));
  BASE_TRY(slip_begin(&s->p, &s->space.a, s->opt->facets, s->opt->distribution, err));
  set_friction(s, c);
  s->answer.work.fallbacks += count_slow(s, c);
  if (!poisson) {
    BASE_TRY(impact_by_newton(s, c, lambda, err));
    poisson = !s->solved && s->without_solution && s->opt->paradox == PARADOX_IMPACT;
    s->answer.work.fallbacks += poisson;
  }
  if (poisson) {
    BASE_TRY(impact_by_poisson(s, c, lambda, err));
  }
  return s->solved ? take_impulses(s, c, lambda, err) : BASE_OK;
}

base_status event_impact_without_collision(event_run *s, const contact_set *c, base_error *err) {
  double *u0 = s->row, *pull = s->row + 2 * (ptrdiff_t)s->cap_row;
  const form_assembly *a = &s->space.a;
  const double h = s->slow / s->pull;
  memset(pull, 0, (size_t)c->n_row * sizeof *pull);
  for (int i = 0; i < a->n_contact; i++) {
    double *to = pull + c->row_start[a->group[i]];
    memcpy(to, a->r + a->row[i], (size_t)form_rows_of(a, i) * sizeof *pull);
    to[0] = (form_own_block(a, i)[0] > 0.0) ? to[0] : fmax(to[0], 0.0);
  }
  s->answer.work.fallbacks++;
  BASE_TRY(space_impact(&s->space, c, err));
  BASE_TRY(slip_begin(&s->p, a, s->opt->facets, s->opt->distribution, err));
  double *lambda = s->row + s->cap_row, *term = lambda;
  memset(term, 0, (size_t)a->n_row * sizeof *term);
  for (int i = 0; i < a->n_contact; i++) { /* it persists: so slow an opening is none */
    term[a->row[i]] = -fmax(a->r[a->row[i]], 0.0);
  }
  BASE_TRY(event_make_consistent(s, term, err));
  for (int i = 0; i < a->n_contact; i++) {
    for (int r = a->row[i]; r < a->row[i + 1]; r++) {
      u0[r] = a->r[r] + h * pull[c->row_start[a->group[i]] + r - a->row[i]] + term[r];
    }
  }
  event_drop_noise(a->n_row, u0);
  BASE_TRY(event_solve(s, u0, lambda, err));
  return s->solved ? take_impulses(s, c, lambda, err) : BASE_OK;
}
