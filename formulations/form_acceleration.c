/* form_acceleration.c - forces from a complementarity problem between contact forces and contact
 * accelerations (Lotstedt 1981; Baraff 1991; Pfeiffer & Glocker 1996), stepped by semi-implicit
 * Euler. What sets it apart from `velocity` is that the direction of sliding friction is that of
 * the motion at the start of the step and is not an unknown: for large friction the problem may
 * have no solution or several (Painleve), which ends the step as unsolved, not as something else.
 *
 * In impulses lambda = h f and with u- the velocity before the step the rows read
 *   w = u- + h (J a_free + (dJ/dt) v) + C lambda + b
 * i.e. h times the acceleration conditions, plus u-, which keeps closed contacts from drifting and
 * makes approaching ones (b: Newton's law) part of the same problem. A step with an impact is a problem of velocities: its
 * impulses are no forces, the frames do not turn, and friction chooses its direction. Where Newton's law has no solution
 * there, because friction and joints hold a contact that it would have part, Poisson's decides.
 *
 * A contact that would reverse its sliding within the step is posed again as one that sticks or
 * starts anew (faceted cone), once; every such change is counted.
 */
#include "formulations/regularized/slip_problem.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct options {
  int facets, distribution, paradox;
  double stick;
  form_repair repair;
} options;

/* What follows where the forces have no solution. */
enum { PARADOX_STOP, PARADOX_IMPACT };

/* What a problem is for. */
typedef enum stage { FORCES, NEWTON, COMPRESSION, DECOMPRESSION } stage;

static const base_field fields[] = {
    BASE_FIELD(options, facets, BASE_INT, "1", 8, 3, SLIP_FACETS_MAX,
               "directions of friction where a contact sticks"),
    BASE_FIELD(options, stick, BASE_REAL, "1", 1e-9, 0, 1,
               "slower than this share of the step's speeds is rest, not sliding"),
    FORM_DISTRIBUTION_FIELD(options),
    BASE_FIELD_CHOICE(options, paradox, "stop|impact", PARADOX_STOP,
                      "forces without a solution: the end, or a step of impulses with friction "
                      "free to choose its direction"),
    FORM_PUSH_FIELDS(options, 0),
    FORM_JOINT_PUSH_FIELD(options),
};

typedef struct state {
  form_assembly a;
  contact_memory memory;
  slip_problem p;
  lcp_problem posed;
  double *u0;     /* n_row: r + u_curve + bias; owned, lambda lies behind it */
  double *lambda; /* n_row [N s] */
  double *first;  /* n_row: of Poisson's compression [N s] */
  int cap_row;
  stage stage;
  double rest; /* steps of load below which an approach does not bounce */
  bool pending, solved;
  bool may_jump; /* without a solution for its forces the step becomes one of impulses */
  formulation_answer answer;
} state;

static void close(void *st) {
  state *s = st;
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  slip_close(&s->p);
  free(s->u0);
}

static double speed(const double *u, int n) {
  return (n == 2) ? hypot(u[0], u[1]) : (n == 1 ? fabs(u[0]) : 0.0);
}

/* Sliding starts from the velocity before the step; a contact at rest gets the cone, and so does every contact in a step
 * with an impact, in which a direction of sliding does not last, though its friction is that of what slides. What rounding
 * leaves of a rest is no direction: it is measured against the largest free contact velocity. */
static void choose_modes(state *s, const contact_set *c, double stick) {
  double scale = 0.0;
  for (int r = 0; r < s->a.n_row; r++) {
    scale = fmax(scale, fabs(s->a.r[r]));
  }
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i], nt = s->a.rows[i].tangent;
    double before[3];
    form_to_rows(&s->a, i, c->u_before + c->row_start[g], before);
    const double *u = before + 1;
    const double slip = speed(u, nt);
    if (slip <= stick * scale) {
      continue;
    }
    s->p.mu[i] = c->mu_kinetic[g];
    for (int t = 0; t < nt && s->stage == FORCES; t++) {
      s->p.direction[2 * i + t] = u[t] / slip;
    }
  }
}

static base_status grow(state *s, base_error *err) {
  if (s->a.n_row >= s->cap_row) {
    free(s->u0);
    s->cap_row = 2 * s->a.n_row + 8;
    s->u0 = calloc(3 * (size_t)s->cap_row, sizeof *s->u0);
    if (s->u0 == NULL) {
      s->cap_row = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "acceleration: no memory for %d rows", s->a.n_row);
    }
    s->lambda = s->u0 + s->cap_row;
    s->first = s->lambda + s->cap_row;
  }
  return BASE_OK;
}

/* Writes lambda and what follows from it into the assembly's answer arrays. */
static void finish(state *s) {
  form_assembly_answer(&s->a, s->lambda);
  for (int i = 0; i < s->a.n_contact; i++) {
    const bool slips = s->p.direction[2 * i] != 0.0 || s->p.direction[2 * i + 1] != 0.0;
    double *now = contact_memory_now(&s->memory, s->a.group[i]);
    s->a.mode[s->a.group[i]] = (s->lambda[s->a.row[i]] > 0.0) ? (slips ? 2 : 1) : 0;
    now[PAST_SLIDES] = slips;
    memset(now + PAST_IMPULSE, 0, (size_t)s->memory.layout.impulse * sizeof *now);
    form_to_set(&s->a, i, s->lambda + s->a.row[i], now + PAST_IMPULSE);
  }
}

/* u0: what is free of a step of forces, whose contact frames turn, or of one with an impact. Nothing parts in a compression. */
static void set_free(state *s) {
  const contact_set *c = s->a.set;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i], first = s->a.row[i];
    if (s->stage != FORCES) {
      memset(s->u0 + first, 0, (size_t)form_rows_of(&s->a, i) * sizeof *s->u0);
    } else {
      form_to_rows(&s->a, i, c->u_curve + c->row_start[g], s->u0 + first);
    }
    for (int r = 0; r < form_rows_of(&s->a, i); r++) {
      s->u0[first + r] += s->a.r[first + r];
    }
    s->u0[first] += (s->stage == COMPRESSION) ? fmax(s->a.bias[g], 0.0) : s->a.bias[g];
  }
}

static base_status begin(void *st, const contact_set *c, const void *opt, formulation_start start,
                         base_error *err) {
  (void)start; /* no unknown of the last step is a guess for the next one */
  state *s = st;
  const options *o = opt;
  const form_rule rule = {.level = FORM_LEVEL_VELOCITY,
                          .activation = FORM_CLOSED,
                          .newton = true,
                          .gives = true,
                          .repair = o->repair};
  if (c->n_contact > 0 && c->u_curve == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "acceleration: needs u_curve of the contacts");
  }
  BASE_TRY(contact_memory_begin(&s->memory, contact_memory_need(contact_memory_kinds(c), false, 0),
                                c, err));
  BASE_TRY(form_assembly_begin(&s->a, c, FORM_ROWS_TANGENT, &rule, &s->memory, err));
  BASE_TRY(form_assembly_eliminate(&s->a, err));
  BASE_TRY(slip_begin(&s->p, &s->a, o->facets, o->distribution, err));
  BASE_TRY(grow(s, err));
  s->stage = form_has_impact(&s->a, o->repair.rest) ? NEWTON : FORCES;
  choose_modes(s, c, o->stick);
  set_free(s);
  s->rest = o->repair.rest;
  s->may_jump = o->paradox == PARADOX_IMPACT;
  s->pending = s->a.n_contact > 0;
  s->solved = true;
  s->answer = (formulation_answer){.stiffness_ratio = HUGE_VAL, .n_active = s->a.n_contact};
  memset(s->lambda, 0, (size_t)s->a.n_row * sizeof *s->lambda);
  finish(s);
  return BASE_OK;
}

static base_status assemble(void *st, lcp_problem *out, const double **z0, bool *pending,
                            base_error *err) {
  (void)err;
  state *s = st;
  *pending = s->pending;
  *z0 = s->p.z0;
  if (s->pending) {
    slip_pose(&s->p, &s->a, s->u0, &s->posed);
    *out = s->posed;
    s->answer.work.solves++;
    s->answer.lcp_dim = (s->p.n > s->answer.lcp_dim) ? s->p.n : s->answer.lcp_dim;
  }
  return BASE_OK;
}

static void rows(const void *st, formulation_rows *out) {
  const state *s = st;
  *out = (formulation_rows){s->a.set, s->a.n_contact, s->p.first, s->a.group};
}

/* Row r of u0 + C lambda. */
static double row_velocity(const state *s, int r) {
  const size_t n = (size_t)s->a.n_row;
  double u = s->u0[r];
  for (size_t j = 0; j < n; j++) {
    u += s->p.C[j * n + (size_t)r] * s->lambda[j];
  }
  return u;
}

/* u at the end of the step along the old sliding direction; below zero: reversed. */
static bool reverses(const state *s, int i) {
  const double *d = s->p.direction + 2 * i;
  double along = 0.0;
  for (int t = 0; t < form_rows_of(&s->a, i) - 1; t++) {
    along += d[t] * row_velocity(s, s->a.row[i] + 1 + t);
  }
  return along < 0.0;
}

/* The step is posed once more, for impulses with friction free to choose its direction. */
static void pose_impact(state *s, stage next) {
  s->stage = next;
  s->pending = true;
  s->answer.work.fallbacks++;
  memset(s->p.direction, 0, 2 * (size_t)s->a.n_contact * sizeof *s->p.direction);
  set_free(s);
}

/* Where no forces answer, impulses do: the step becomes one with an impact (Genot & Brogliato 1999; MATHEMATICS 2.6.6 for the
 * limit of short steps), and where these cannot part what they should, Poisson's law decides. True if there is another problem
 * to solve. */
static bool goes_on(state *s) {
  if (s->stage == NEWTON) {
    pose_impact(s, COMPRESSION);
    return true;
  }
  if (s->stage == FORCES && s->may_jump) {
    pose_impact(s, NEWTON);
    return true;
  }
  return false;
}

/* The share e of what ended the approaches is given back, or as much beyond it as keeps bodies apart; what carried the loads
 * of the step is not. */
static void decompress(state *s) {
  const contact_set *c = s->a.set;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i], normal = s->a.row[i];
    const double u = c->u_before[c->row_start[g]];
    const double gained = fmax(0.0, u - s->a.r_normal[g]);
    const bool bounces = c->restitution != NULL && u < 0.0 && -u > s->rest * gained;
    s->p.given[i] = bounces ? c->restitution[g] * s->lambda[normal] * u / (u - gained) : 0.0;
  }
  for (int r = 0; r < s->a.n_row; r++) {
    s->first[r] = row_velocity(s, r);
  }
  memcpy(s->u0, s->first, (size_t)s->a.n_row * sizeof *s->u0);
  memcpy(s->first, s->lambda, (size_t)s->a.n_row * sizeof *s->first);
  s->stage = DECOMPRESSION;
  s->pending = true;
}

static base_status recover(void *st, const double *z, lcp_outcome claimed, base_error *err) {
  (void)err;
  state *s = st;
  const contact_set *c = s->a.set;
  const bool without = claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  s->pending = false;
  s->answer.work.rays += without;
  if (without && goes_on(s)) {
    return BASE_OK;
  }
  if (claimed != LCP_SOLVED) {
    s->solved = false;
    s->answer.residual = 1.0;
  }
  slip_impulses(&s->p, &s->a, z, s->lambda);
  for (int r = 0; s->stage == DECOMPRESSION && r < s->a.n_row; r++) {
    s->lambda[r] += s->first[r];
  }
  if (s->stage == COMPRESSION && s->solved) {
    decompress(s);
  }
  for (int i = 0; s->solved && i < s->a.n_contact; i++) {
    double *d = s->p.direction + 2 * i;
    const bool slips = d[0] != 0.0 || d[1] != 0.0;
    if (slips && s->lambda[s->a.row[i]] > 0.0 && reverses(s, i)) {
      d[0] = d[1] = 0.0;
      s->p.mu[i] = c->mu_static[s->a.group[i]];
      s->answer.work.mode_changes++;
      s->pending = true; /* each contact at most once: it stays a cone from now on */
    }
  }
  finish(s);
  return BASE_OK;
}

static void answer(const void *st, formulation_answer *out) {
  const state *s = st;
  *out = s->answer;
  out->impulse = s->a.impulse;
  out->v_next = s->a.v_next;
  out->shift = form_shift_of(&s->a);
  out->bias = s->a.bias;
  out->mode = s->a.mode;
  out->solved = s->solved;
}

static long dimension(int dim, int p, const void *opt) {
  const options *o = opt;
  return (long)p * ((dim == 2) ? 4 : o->facets + 2);
}

static formulation_friction friction(int dim, const void *opt) {
  const options *o = opt;
  (void)dim;
  return (formulation_friction){.most = 1.0, .aslant = o->facets % 4 != 0};
}

const formulation form_acceleration = {
    .name = "acceleration",
    .title = "Force-acceleration LCP",
    .cite = "pfeiffer1996; baraff1991",
    .words = "Solves for contact forces and accelerations, and for impulses at impacts.",
    .when = "Motion is smooth and the forces of an instant are asked for.",
    .apart = "facets",
    .model =
        FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_POLYHEDRAL | FORM_ACCELERATION | FORM_CURVED,
    .sets = 1u << LCP_ORTHANT,
    .lacks = EFFECT_ROLLING | EFFECT_TORSION | FORM_COORDINATES,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(state),
    .memory = offsetof(state, memory),
    .dimension = dimension,
    .friction = friction,
    .close = close,
    .begin = begin,
    .assemble = assemble,
    .rows = rows,
    .recover = recover,
    .answer = answer,
};
