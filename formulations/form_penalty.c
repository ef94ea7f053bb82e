/* form_penalty.c - compliant contact integrated as an ordinary differential equation: the
 * alternative that hard-contact formulations avoid, and therefore their yardstick of cost.
 *
 *   q' = N v,   v' = P (f + J_n' F(d, d') + J_t' F_t(F, u_t)) + joints
 *
 * where P projects onto what joints leave: they are rigid, J_b v' + (dJ_b/dt) v + 2 s C' + s^2 C = 0 (Baumgarte,
 * s: `joint_rate`), eliminated as everywhere (event_space.h), and start closed.
 *
 * with the force laws of penalty_law.h, advanced by GSL's explicit or stiff methods under error
 * control. No complementarity problem is posed; the cost is counted in evaluations of the right-
 * hand side. Impulses are the trapezoidal time integral of the forces over the accepted substeps.
 *
 * The closing speed v_i of Hunt-Crossley and Lankarani-Nikravesh is taken when a contact is first
 * seen penetrating at an accepted state, and not below `impact_floor`: at rest both laws would
 * otherwise divide by zero.
 */
#include "formulations/event/event_space.h"
#include "formulations/gsl_library.h"
#include "formulations/impulse_log.h"
#include "formulations/penalty_law.h"

#include <stdlib.h>
#include <string.h>

typedef struct options {
  int law, integrator, max_evaluations;
  double stiffness, damping, slip_speed, impact_floor, joint_rate, rtol, atol;
} options;

static const base_field fields[] = {
    BASE_FIELD_CHOICE(options, law, PENALTY_MODELS, PENALTY_GONTHIER, "normal force law"),
    BASE_FIELD_CHOICE(options, integrator, "rkf45|rk8pd|msbdf|bsimp", 2, "GSL stepping method"),
    BASE_FIELD(options, stiffness, BASE_REAL, "N/m^1.5", 0, 0, 1e24,
               "K of the force law (N/m for kelvin_voigt); 0: from the loads of the scene"),
    BASE_FIELD(options, damping, BASE_REAL, "N s/m", 1e3, 0, 1e12, "c of kelvin_voigt"),
    BASE_FIELD(options, slip_speed, BASE_REAL, "m/s", 1e-3, 1e-9, 1e3,
               "regularisation velocity of friction"),
    BASE_FIELD(options, impact_floor, BASE_REAL, "m/s", 1e-2, 1e-9, 1e3,
               "least closing speed the damping factor is scaled with"),
    BASE_FIELD(options, joint_rate, BASE_REAL, "1/s", 100, 0, 1e6,
               "of Baumgarte's terms at joints"),
    BASE_FIELD(options, rtol, BASE_REAL, "1", 1e-10, 1e-13, 1, "relative error per substep"),
    BASE_FIELD(options, atol, BASE_REAL, "m, m/s", 1e-12, 1e-15, 1, "absolute error per substep"),
    BASE_FIELD(options, max_evaluations, BASE_INT, "1", 20000000, 1, 2e9,
               "right-hand sides in one step before it is given up"),
};

typedef struct state {
  const options *opt;
  world *w; /* borrowed, during step only */
  int n_config, n_dof;
  double *y, *acc, *probe; /* n_config + n_dof; n_dof; 3 (n_config + n_dof) */
  gsl_library gsl;
  gsl_odeiv2_system system;
  gsl_odeiv2_driver *driver; /* the multistep method asks its driver for the error level */
  double substep;            /* proposal carried from step to step [s] */
  impulse_log log;           /* `memory` is the closing speed at the start of the contact */
  event_space space;         /* of the joints */
  joint_log joints;
  bool jointed;
  double K;               /* stiffness in use [N/m^1.5], or [N/m] */
  double e, x;            /* the last coefficient of restitution, and its damping factor */
  double *impulse, *bias; /* of the set after the step */
  int cap_row, cap_contact;
  contact_set set;
  long evaluations;
  base_error *err; /* where a right-hand side reports */
  formulation_answer answer;
} state;

/* Step handed to the detection inside a substep: only geometry and u_before are used of that set. */
static const double instant = 1e-9; /* [s] */

static const double first_substep = 1e-6; /* [s]; error control finds the right one */

/* Where K comes from the loads, they would press in a body by this share of the smallest one's size, all of them
 * through one contact; and by no less than this acceleration gives its mass [m/s^2]. */
static const double pressed = 1e-3;
static const double least_acceleration = 10.0;
static const double sizes =
    1e9; /* smallest body in the contact tolerances of a set (contact_set.h) */

/* K from what may have to be carried, sum |M a| of all bodies at the start, and from the mass that moves. */
static base_status find_stiffness(state *s, base_error *err) {
  contact_set c;
  double *a = s->probe, load = 0.0, mass = 0.0;
  s->K = s->opt->stiffness;
  if (s->K > 0.0) {
    return BASE_OK;
  }
  BASE_TRY(world_contacts(s->w, instant, 0.0, &c, err));
  BASE_TRY(world_acceleration(s->w, a, err));
  for (int b = 0; b < c.n_body; b++) {
    const int n = contact_dofs(&c, b);
    const double *M = c.mass + c.mass_start[b], *own = a + c.dof_start[b];
    double square = 0.0;
    for (int k = 0; k < n; k++) {
      for (int l = 0; l < n; l++) {
        square += own[k] * M[l * n + k] * own[l];
      }
    }
    load += (n > 0) ? sqrt(M[0] * fmax(square, 0.0)) : 0.0;
    mass += (n > 0) ? M[0] : 0.0;
  }
  const double depth = pressed * sizes * c.tol;
  const double force = fmax(fmax(load, least_acceleration * mass), least_acceleration * 1e-12);
  s->K = force / ((s->opt->law == PENALTY_KELVIN_VOIGT) ? depth : depth * sqrt(depth));
  return BASE_OK;
}

/* The damping factor at e, remembered: most scenes have one. */
static double damping_factor(state *s, double e) {
  if (e != s->e) {
    s->e = e;
    s->x = penalty_damping((penalty_model)s->opt->law, e);
  }
  return s->x;
}

/* Contact-frame force of contact i of the set (normal, tangents); rows beyond friction get none. */
static void contact_force(state *s, const contact_set *c, int i, const impulse_entry *known,
                          double f[3]) {
  const options *o = s->opt;
  const double *u = c->u_before + c->row_start[i];
  const double closing = -u[0];
  const double e = (c->restitution != NULL) ? c->restitution[i] : 0.0;
  const double v_i = (known != NULL) ? known->memory : fmax(closing, o->impact_floor);
  f[1] = f[2] = 0.0;
  f[0] = penalty_normal_force((penalty_model)o->law, s->K, o->damping, damping_factor(s, e), v_i,
                              -c->gap[i], closing);
  if (c->rows[i].tangent > 0) {
    penalty_friction(c->mu_kinetic[i], f[0], o->slip_speed, c->rows[i].tangent, u + 1, f + 1);
  }
}

/* a += W J' f for one contact. */
static void add_acceleration(const contact_set *c, int i, const double f[3], double *a) {
  const int n_row = 1 + c->rows[i].tangent;
  const double *jac = c->jac + c->jac_start[i];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * i + side];
    if (b < 0) {
      continue;
    }
    const int first = c->dof_start[b], n = c->dof_start[b + 1] - first;
    const double *W = c->inv_mass + c->mass_start[b];
    double g[6] = {0};
    for (int r = 0; r < n_row; r++) {
      for (int k = 0; k < n; k++) {
        g[k] += jac[r * n + k] * f[r];
      }
    }
    for (int k = 0; k < n; k++) {
      for (int l = 0; l < n; l++) {
        a[first + k] += W[l * n + k] * g[l];
      }
    }
    jac += (c->row_start[i + 1] - c->row_start[i]) * n;
  }
}

/* v' of the world's state, contacts in *c; of the joints, their forces stay in s->space. */
static base_status accelerate(state *s, contact_set *c, double *a, base_error *err) {
  BASE_TRY(world_acceleration(s->w, a, err));
  BASE_TRY(s->jointed ? world_contacts_curved(s->w, instant, 0.0, c, err)
                      : world_contacts(s->w, instant, 0.0, c, err));
  for (int i = 0; i < c->n_contact; i++) {
    double f[3];
    if (c->gap[i] < 0.0) {
      contact_force(s, c, i, impulse_log_find(&s->log, c->id[i]), f);
      add_acceleration(c, i, f, a);
    }
  }
  return s->jointed ? space_constrain(&s->space, c, s->opt->joint_rate, a, err) : BASE_OK;
}

static int right_hand_side(double t, const double y[], double dy[], void *params) {
  state *s = params;
  contact_set c;
  world_set_state(s->w, t, y, y + s->n_config);
  world_config_rate(s->w, y, y + s->n_config, dy);
  if (accelerate(s, &c, dy + s->n_config, s->err) != BASE_OK) {
    return GSL_EBADFUNC;
  }
  s->evaluations++;
  return GSL_SUCCESS;
}

/* Forward differences with the step sqrt(eps) max(|y|, 1e-3); GSL wants dfdy row-major. */
static int jacobian(double t, const double y[], double *dfdy, double dfdt[], void *params) {
  state *s = params;
  const int n = s->n_config + s->n_dof;
  double *moved = s->probe, *base = s->probe + n, *at = s->probe + 2 * n;
  memcpy(moved, y, (size_t)n * sizeof *moved);
  int status = right_hand_side(t, y, base, s);
  for (int j = 0; j < n && status == GSL_SUCCESS; j++) {
    const double size = (y[j] < 0.0 ? -y[j] : y[j]);
    const double d = 1.5e-8 * (size > 1e-3 ? size : 1e-3);
    moved[j] = y[j] + d;
    status = right_hand_side(t, moved, at, s);
    moved[j] = y[j];
    for (int i = 0; i < n; i++) {
      dfdy[i * n + j] = (at[i] - base[i]) / d;
    }
  }
  memset(dfdt, 0, (size_t)n * sizeof *dfdt); /* loads vary slowly against a substep */
  return status;
}

/* Updates the memory at an accepted state and adds the trapezoid of the substep dt. */
static base_status accept(state *s, double t, double dt, base_error *err) {
  contact_set c;
  world_set_state(s->w, t, s->y, s->y + s->n_config);
  BASE_TRY(world_contacts(s->w, instant, 0.0, &c, err));
  impulse_log_begin(&s->log);
  for (int i = 0; i < c.n_contact; i++) {
    if (c.gap[i] >= 0.0) {
      continue;
    }
    const double closing = -c.u_before[c.row_start[i]];
    impulse_entry *e;
    double f[3];
    BASE_TRY(impulse_log_at(&s->log, c.id[i], fmax(closing, s->opt->impact_floor), &e, err));
    contact_force(s, &c, i, e, f);
    impulse_log_add(e, dt, f);
  }
  impulse_log_end(&s->log, dt);
  if (s->jointed) {
    BASE_TRY(accelerate(s, &c, s->acc, err));
    BASE_TRY(joint_log_add(&s->joints, &c, s->space.a.impulse, dt, false, err));
  }
  return BASE_OK;
}

static const gsl_odeiv2_step_type *method(const state *s, int integrator) {
  const gsl_odeiv2_step_type *types[] = {
      *s->gsl.gsl_odeiv2_step_rkf45, *s->gsl.gsl_odeiv2_step_rk8pd, *s->gsl.gsl_odeiv2_step_msbdf,
      *s->gsl.gsl_odeiv2_step_bsimp};
  return types[integrator];
}

static void close(void *st) {
  state *s = st;
  if (s->driver != NULL) {
    s->gsl.gsl_odeiv2_driver_free(s->driver);
  }
  free(s->y);
  impulse_log_close(&s->log);
  joint_log_close(&s->joints);
  space_close(&s->space);
  free(s->impulse);
  free(s->bias);
}

static base_status open(void *st, const void *opt, base_error *err) {
  state *s = st;
  s->opt = opt;
  s->e = -1.0;
  return gsl_integrators(&s->gsl, err);
}

/* Everything whose size the world fixes; done at the first step. */
static base_status bind(state *s, world *w, base_error *err) {
  s->w = w;
  if (s->y != NULL) {
    return BASE_OK;
  }
  s->n_config = world_n_config(w);
  s->n_dof = world_n_dof(w);
  const size_t n = (size_t)s->n_config + (size_t)s->n_dof;
  if (s->n_dof < 1) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "penalty: nothing moves in this scene");
  }
  s->y = calloc(5 * n + 1, sizeof *s->y);
  s->system = (gsl_odeiv2_system){right_hand_side, jacobian, n, s};
  s->driver = s->gsl.gsl_odeiv2_driver_alloc_y_new(&s->system, method(s, s->opt->integrator),
                                                   first_substep, s->opt->atol, s->opt->rtol);
  if (s->y == NULL || s->driver == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "penalty: no memory for %zu state variables", n);
  }
  s->probe = s->y + n;
  s->acc = s->y + 4 * n;
  s->jointed = (world_occurring(w) & EFFECT_JOINTS) != 0;
  world_get_state(w, s->y, s->y + s->n_config);
  if (s->jointed) { /* closed, and without velocities that they forbid */
    double left;
    BASE_TRY(space_onto_joints(&s->space, w, world_time(w), s->y, s->y + s->n_config, s->probe,
                               &left, err));
  }
  return find_stiffness(s, err);
}

static base_status grow_rows(state *s, const contact_set *c, base_error *err) {
  if (c->n_row >= s->cap_row || c->n_contact >= s->cap_contact) {
    free(s->impulse);
    free(s->bias);
    s->cap_row = 2 * c->n_row + 16;
    s->cap_contact = 2 * c->n_contact + 16;
    s->impulse = calloc((size_t)s->cap_row, sizeof *s->impulse);
    s->bias = calloc((size_t)s->cap_contact, sizeof *s->bias);
    if (s->impulse == NULL || s->bias == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "penalty: no memory for %d contact rows", c->n_row);
    }
  }
  return BASE_OK;
}

/* The answer in terms of the contacts within reach at the end of the step. */
static base_status report(state *s, double h, formulation_answer *out, base_error *err) {
  contact_set *c = &s->set;
  BASE_TRY(world_contacts(s->w, h, -1.0, c, err));
  BASE_TRY(grow_rows(s, c, err));
  const int active = impulse_log_write(&s->log, c, s->impulse);
  joint_log_write(&s->joints, c, s->impulse);
  double energy = 0.0;
  for (int i = 0; i < c->n_contact; i++) {
    s->bias[i] = HUGE_VAL; /* no complementarity is claimed */
    energy += penalty_energy((penalty_model)s->opt->law, s->K, -c->gap[i]);
  }
  *out = (formulation_answer){.impulse = s->impulse,
                              .v_next = s->y + s->n_config,
                              .bias = s->bias,
                              .set = c,
                              .solved = true,
                              .n_active = active,
                              .stiffness_ratio = HUGE_VAL,
                              .v_slip = s->opt->slip_speed,
                              .spring_energy = energy,
                              .work = {.evaluations = s->evaluations}};
  return BASE_OK;
}

static base_status step(void *st, world *w, double h, const formulation_solver *solver,
                        formulation_answer *out, base_error *err) {
  state *s = st;
  BASE_TRY(bind(s, w, err));
  s->err = err;
  s->evaluations = 0;
  double t = world_time(w);
  const double end = t + h;
  world_get_state(w, s->y, s->y + s->n_config);
  gsl_odeiv2_driver *g = s->driver;
  double sub = (s->substep > 0.0) ? s->substep : first_substep;
  while (t < end) {
    const double from = t;
    const int status =
        s->gsl.gsl_odeiv2_evolve_apply(g->e, g->c, g->s, &s->system, &t, end, &sub, s->y);
    if (status == GSL_EBADFUNC) {
      return err != NULL ? err->code : BASE_EEXTERNAL;
    }
    if (status != GSL_SUCCESS || s->evaluations > s->opt->max_evaluations || !(t > from)) {
      return BASE_FAIL(err, BASE_EEXTERNAL,
                       "penalty: integrator gave up at t=%g s after %ld evaluations (%s)", t,
                       s->evaluations, s->gsl.gsl_strerror(status));
    }
    BASE_TRY(accept(s, t, t - from, err));
    if (t < end) {
      s->substep = sub;
      BASE_TRY(formulation_in_time(solver, "penalty", t, err));
    }
  }
  BASE_TRY(report(s, h, out, err));
  impulse_log_next_step(&s->log);
  joint_log_next_step(&s->joints);
  return BASE_OK;
}

static long dimension(int dim, int p, const void *opt) {
  (void)dim, (void)p, (void)opt;
  return 0;
}

const formulation form_penalty = {
    .name = "penalty",
    .title = "Compliant contact (ODE)",
    .cite = "gonthier2004; hunt1975; lankarani1990",
    .words = "Compliant contact: a stiff differential equation, integrated without a "
             "complementarity problem.",
    .when = "The stiffness of the contact is known and its compliance is asked for.",
    .model = FORM_FRICTION | FORM_REGULARISED | FORM_PENALTY | FORM_NO_LCP,
    .lacks = EFFECT_ROLLING | EFFECT_TORSION | FORM_COORDINATES,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(state),
    .dimension = dimension,
    .open = open,
    .close = close,
    .step = step,
};
