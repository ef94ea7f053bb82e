#include "formulations/event/event_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distance from the circle's law over the largest friction. */
static const double circle_tol = 1e-9;
/* A box that pivots about a corner settles in ten or so (test form_event); what has not by now does not. */
static const int max_turns = 100;

static base_status grow_scratch(event_run *s, const contact_set *c, base_error *err) {
  BASE_TRY(space_reserve(&s->space, c, err));
  if (c->n_row >= s->cap_row || c->n_contact >= s->cap_contact) {
    s->cap_row = 2 * c->n_row + 8;
    s->cap_contact = 2 * c->n_contact + 8;
    const size_t unknowns = (size_t)s->cap_contact * (size_t)(s->opt->facets + 2);
    free(s->row);
    free(s->z);
    s->row = calloc((size_t)s->cap_row * 3, sizeof *s->row);
    s->z = calloc(unknowns, sizeof *s->z);
    if (s->row == NULL || s->z == NULL) {
      s->cap_row = s->cap_contact = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", c->n_contact);
    }
  }
  return BASE_OK;
}

base_status event_log_joints(event_run *s, double dt, bool jump, base_error *err) {
  return joint_log_add(&s->joints, &s->space.view, s->space.a.impulse, dt, jump, err);
}

static bool touches(const contact_set *c, int g) {
  return c->gap[g] <= event_touching * c->tol;
}

/* Velocities that are rounding errors of the others are zero: a contact at rest beside an impact
 * would otherwise pose a problem of its own, of noise. */
static void drop_noise(int n, double *u) {
  double largest = 0.0;
  for (int r = 0; r < n; r++) {
    largest = fmax(largest, fabs(u[r]));
  }
  for (int r = 0; r < n; r++) {
    u[r] = (fabs(u[r]) > 1e-12 * largest) ? u[r] : 0.0;
  }
}

/* Poses, solves, and leaves lambda (n_row of the assembly) in a.lambda; s->solved says how. */
static base_status solve(event_run *s, const double *u0, double *lambda, base_error *err) {
  lcp_problem p;
  lcp_outcome claimed = LCP_NUMERICAL;
  slip_pose(&s->p, &s->space.a, u0, &p);
  memset(s->z, 0, (size_t)p.M.n * sizeof *s->z);
  BASE_TRY(s->solver->solve(s->solver->ctx, &p, s->z, &claimed, err));
  s->answer.work.solves++;
  s->answer.lcp_dim = (p.M.n > s->answer.lcp_dim) ? p.M.n : s->answer.lcp_dim;
  s->solved = claimed == LCP_SOLVED;
  s->without_solution = claimed == LCP_RAY || claimed == LCP_INFEASIBLE;
  s->answer.work.rays += s->without_solution;
  s->answer.residual = s->solved ? 0.0 : 1.0; /* without a solution nothing of the model is met */
  slip_impulses(&s->p, &s->space.a, s->z, lambda);
  return BASE_OK;
}

/* Solves the problem posed by s->p with its facets turned until friction is that of the circle; where
 * it never is, the answer is unsolved and carries how far it is off. */
static base_status solve_turning(event_run *s, const double *u0, double *lambda, base_error *err) {
  BASE_TRY(turns_begin(&s->turns, s->space.a.n_contact, err));
  BASE_TRY(solve(s, u0, lambda, err));
  double off = s->solved ? turns_residual(&s->p, &s->space.a, u0, lambda) : 0.0;
  while (s->solved && off > circle_tol && s->turns.mixing.mixing.taken < max_turns) {
    BASE_TRY(turns_next(&s->turns, &s->p, &s->space.a, u0, lambda, err));
    BASE_TRY(solve(s, u0, lambda, err));
    off = s->solved ? turns_residual(&s->p, &s->space.a, u0, lambda) : 0.0;
  }
  if (off > circle_tol) {
    s->solved = false;
    s->answer.residual = off;
  }
  return BASE_OK;
}

/* Marks the touching contacts and says whether one of them closes. */
static bool mark_closing(event_run *s, const contact_set *c) {
  bool closing = false;
  for (int g = 0; g < c->n_contact; g++) {
    s->space.gap[g] = touches(c, g) ? 0.0 : 1.0;
    closing = closing || (touches(c, g) && c->u_before[c->row_start[g]] < -0.1 * s->slow);
  }
  return closing;
}

/* Solves the impact that s->p poses from the velocities u0; its impulses and the velocities after it become the state's. */
static base_status jump(event_run *s, const contact_set *c, double *u0, base_error *err) {
  double *lambda = s->row + s->cap_row;
  drop_noise(s->space.a.n_row, u0);
  BASE_TRY(solve_turning(s, u0, lambda, err));
  for (int i = 0; s->solved && i < s->space.a.n_contact; i++) {
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

static base_status impact(event_run *s, const contact_set *c, base_error *err) {
  double *u0 = s->row;
  BASE_TRY(space_impact(&s->space, c, err));
  BASE_TRY(slip_begin(&s->p, &s->space.a, s->opt->facets, s->opt->distribution, err));
  for (int i = 0; i < s->space.a.n_contact; i++) {
    const int g = s->space.a.group[i], first = s->space.a.row[i];
    const double u = c->u_before[c->row_start[g]];
    memcpy(u0 + first, s->space.a.r + first, (size_t)form_rows_of(&s->space.a, i) * sizeof *u0);
    const double e = (c->restitution != NULL) ? c->restitution[g] : 0.0;
    if (u < -s->opt->rest_speed) {
      u0[first] += e * u;
    } else if (e > 0.0 && u < -0.1 * s->slow) {
      s->answer.work.fallbacks++;
    }
  }
  return jump(s, c, u0, err);
}

/* Sliding contacts keep their direction; the others get the cone. */
static void set_directions(event_run *s, const contact_set *c) {
  for (int i = 0; i < s->space.a.n_contact; i++) {
    const int g = s->space.a.group[i], nt = c->rows[g].tangent;
    const double *u = c->u_before + c->row_start[g] + 1;
    const double slip = (nt == 2) ? hypot(u[0], u[1]) : (nt == 1 ? fabs(u[0]) : 0.0);
    for (int t = 0; t < nt && slip > s->slow; t++) {
      s->p.direction[2 * i + t] = u[t] / slip;
      s->p.mu[i] = c->mu_kinetic[g];
    }
  }
}

/* The force of contact i lies on the circle itself, not only on a facet. */
static bool saturated(const event_run *s, int i, const double *f) {
  const double friction = hypot(f[1], f[2]);
  return friction > 0.0 && friction >= s->p.mu[i] * f[0] * (1.0 - 1e-9);
}

/* Largest free acceleration: what is smaller than 1e-9 of it is none. */
static double scale_of(const event_run *s, const double *u0) {
  double scale = 0.0;
  for (int r = 0; r < s->space.a.n_row; r++) {
    scale = fmax(scale, fabs(u0[r]));
  }
  return scale;
}

/* A contact at rest sticks if the forces leave it at rest inside its cone. On the edge of its cone it
 * slides against its force: where it starts to move its acceleration may be too small to point
 * anywhere, and where redundant neighbours hold it, sharing among sticking contacts could not give
 * it that force. */
static base_status keep_contact(event_run *s, const contact_set *c, int i, const double *u0,
                                const double *lambda, base_error *err) {
  const double *d = s->p.direction + 2 * i;
  double f[3] = {0.0}, along[2];
  memcpy(f, lambda + s->space.a.row[i], (size_t)form_rows_of(&s->space.a, i) * sizeof *f);
  BASE_TRY(arc_reserve(&s->arc, s->arc.n + 1, err));
  arc_contact *k = &s->arc.contact[s->arc.n++];
  *k = (arc_contact){
      .id = c->id[s->space.a.group[i]], .direction = {d[0], d[1]}, .start = {f[0], f[1], f[2]}};
  k->stick = k->starts = slip_at_rest(&s->p, &s->space.a, i);
  slip_departure(&s->p, &s->space.a, i, u0, lambda, along);
  const double size = hypot(along[0], along[1]), friction = hypot(f[1], f[2]);
  if (k->stick && saturated(s, i, f)) {
    k->stick = false;
    k->edge = c->mu_static[s->space.a.group[i]] > c->mu_kinetic[s->space.a.group[i]];
    k->direction[0] = -f[1] / friction;
    k->direction[1] = -f[2] / friction;
  } else if (k->stick && size > 1e-9 * scale_of(s, u0)) {
    k->stick = false;
    k->direction[0] = along[0] / size;
    k->direction[1] = along[1] / size;
  }
  return BASE_OK;
}

/* Rows of a contact move together where less than this share of a row's own mobility is left without the others. */
static const double together = 1e-9;

/* The row of the largest diagonal that is left, the normal before all others. */
static int next_row(const double *left, const bool *done, int n) {
  int k = -1;
  for (int r = 0; r < n && (done[0] || r == 0); r++) {
    k = (!done[r] && (k < 0 || left[r * (n + 1)] > left[k * (n + 1)])) ? r : k;
  }
  return k;
}

/* term (n rows, the normal first) of a contact with the own block B (n x n). Joints may leave it fewer ways to move than rows:
 * a row that moves only with others takes what their terms make of it, because no force of the contact could make it
 * do anything else, and friction would seem to miss its law. */
static void make_consistent(const double *B, int n, double *term) {
  double left[9], asked[3];
  bool done[3] = {false};
  memcpy(left, B, (size_t)(n * n) * sizeof *left);
  memcpy(asked, term, (size_t)n * sizeof *asked);
  for (int k = 0; k >= 0 && left[k * (n + 1)] > together * B[k * (n + 1)];
       k = next_row(left, done, n)) {
    done[k] = true;
    for (int r = 0; r < n; r++) {
      const double share = done[r] ? 0.0 : left[k * n + r] / left[k * (n + 1)];
      asked[r] -= share * asked[k];
      for (int c = 0; c < n; c++) {
        left[c * n + r] -= share * (done[c] ? 0.0 : left[c * n + k]);
      }
    }
  }
  for (int r = 0; r < n; r++) {
    term[r] -= done[r] ? 0.0 : asked[r];
  }
}

/* The terms of the arc that keep contacts from drifting: a force that ran out on the arc has run out
 * here. */
static void stabilise(const event_run *s, const contact_set *c, double *u0) {
  const double rate = s->opt->rate;
  for (int i = 0; i < s->space.a.n_contact; i++) {
    const int g = s->space.a.group[i], n = form_rows_of(&s->space.a, i);
    const double *u = c->u_before + c->row_start[g], *own = form_own_block(&s->space.a, i);
    double *row = u0 + s->space.a.row[i];
    if (!(own[0] > 0.0)) {
      continue; /* joints or locks hold it */
    }
    double term[3] = {2.0 * rate * u[0] + rate * rate * c->gap[g]};
    if (slip_at_rest(&s->p, &s->space.a, i)) {
      for (int t = 1; t < n; t++) {
        term[t] = rate * u[t];
      }
      make_consistent(own, n, term);
    }
    for (int r = 0; r < n; r++) {
      row[r] += term[r];
    }
  }
}

/* What the integrator cannot tell from rest: so many of its errors, at the largest speed so far. */
static void set_slow(event_run *s) {
  s->speed = fmax(s->speed, world_surface_speed(s->w));
  s->slow = s->arc.slow = s->opt->resolve * (s->atol + s->opt->rtol * s->speed);
}

/* Marks the touching contacts that do not part. One that opens at u against the acceleration a would
 * rise by u^2/(2 a); below tol, the distance that tells closed from open, that is no flight. a is the largest
 * free acceleration of a contact at the event before. */
static void mark_resting(event_run *s, const contact_set *c) {
  const double hop = sqrt(2.0 * s->pull * c->tol), most = fmax(s->slow, hop);
  for (int g = 0; g < c->n_contact; g++) {
    const double u = c->u_before[c->row_start[g]];
    s->space.gap[g] = (touches(c, g) && u <= most) ? 0.0 : 1.0;
    s->answer.work.fallbacks += touches(c, g) && u > s->slow && u <= hop;
  }
}

/* Which touching contacts persist, and how: the acceleration-level problem. */
static base_status choose_modes(event_run *s, const contact_set *c, base_error *err) {
  double *u0 = s->row, *lambda = s->row + s->cap_row;
  BASE_TRY(world_acceleration(s->w, s->acc, err));
  mark_resting(s, c);
  BASE_TRY(space_forces(&s->space, c, s->acc, err));
  BASE_TRY(slip_begin(&s->p, &s->space.a, s->opt->facets, s->opt->distribution, err));
  set_directions(s, c);
  memcpy(u0, s->space.a.r, (size_t)s->space.a.n_row * sizeof *u0);
  s->pull = scale_of(s, u0);
  stabilise(s, c, u0);
  drop_noise(s->space.a.n_row, u0);
  BASE_TRY(solve_turning(s, u0, lambda, err));
  double largest = 0.0;
  for (int i = 0; i < s->space.a.n_contact; i++) {
    largest = fmax(largest, lambda[s->space.a.row[i]]);
  }
  s->arc.n = 0;
  for (int i = 0; s->solved && i < s->space.a.n_contact; i++) {
    if (lambda[s->space.a.row[i]] > 1e-9 * largest) {
      BASE_TRY(keep_contact(s, c, i, u0, lambda, err));
    }
  }
  return BASE_OK;
}

/* Where no force answers the accelerations, impulses do: the jump is that of a step of length h from here as h goes to 0
 * (Genot & Brogliato 1999), with h so short that free acceleration adds no more than what cannot be told
 * from rest. s->space holds the accelerations of the contacts that persist. */
static base_status impact_without_collision(event_run *s, const contact_set *c, base_error *err) {
  double *u0 = s->row, *pull = s->row + 2 * (ptrdiff_t)s->cap_row;
  const form_assembly *a = &s->space.a;
  const double h = s->slow / s->pull;
  memset(pull, 0, (size_t)c->n_row * sizeof *pull);
  for (int i = 0; i < a->n_contact; i++) {
    memcpy(pull + c->row_start[a->group[i]], a->r + a->row[i],
           (size_t)form_rows_of(a, i) * sizeof *pull);
  }
  s->answer.work.fallbacks++;
  BASE_TRY(space_impact(&s->space, c, err));
  BASE_TRY(slip_begin(&s->p, a, s->opt->facets, s->opt->distribution, err));
  for (int i = 0; i < a->n_contact; i++) {
    for (int r = 0; r < form_rows_of(a, i); r++) {
      u0[a->row[i] + r] = a->r[a->row[i] + r] + h * pull[c->row_start[a->group[i]] + r];
    }
  }
  return jump(s, c, u0, err);
}

static double along_of(const arc_contact *k) {
  return k->rate[0] * k->direction[0] + k->rate[1] * k->direction[1];
}

/* Contacts on the edges of their cones slide together or not at all: with kinetic friction on all of them, one that is not
 * accelerated is held by its neighbours and keeps its static coefficient. */
static base_status hold_on_edge(event_run *s, base_error *err) {
  bool found = true;
  for (int round = 0; found && round <= s->arc.n; round++) {
    bool asked = false;
    found = false;
    for (int i = 0; i < s->arc.n; i++) {
      asked = asked || (s->arc.contact[i].edge && !s->arc.contact[i].held);
    }
    if (!asked) {
      return BASE_OK;
    }
    BASE_TRY(arc_forces(&s->arc, s->acc, err));
    for (int i = 0; i < s->arc.n; i++) {
      arc_contact *k = &s->arc.contact[i];
      const bool stays = k->edge && !k->held && along_of(k) <= 1e-9 * s->pull;
      k->held = k->held || stays;
      found = found || stays;
    }
  }
  return BASE_OK;
}

/* A contact on the edge of its cone that starts to slide and is accelerated against that direction at once
 * does not slide: redundant neighbours hold it. It sticks, with the force that it has. */
static base_status hold_what_turns_back(event_run *s, base_error *err) {
  bool turned = true;
  for (int round = 0; turned && round <= s->arc.n; round++) {
    turned = false;
    BASE_TRY(arc_forces(&s->arc, s->acc, err));
    for (int i = 0; i < s->arc.n; i++) {
      arc_contact *k = &s->arc.contact[i];
      if (k->starts && !k->stick && k->mu > 0.0 && along_of(k) < -1e-9 * s->pull) {
        k->stick = turned = true;
      }
    }
  }
  return BASE_OK;
}

/* The forces that the arc begins with. Where the contacts cannot carry what springs would share, because friction holds from
 * before, they are those nearest to the forces that the modes were chosen with. Where they cannot carry these either, a
 * contact on the edge of its cone was let slide that its neighbours hold: all such stick. Both count. */
static base_status begin_forces(event_run *s, base_error *err) {
  s->arc.distribution = s->opt->distribution;
  BASE_TRY(hold_on_edge(s, err));
  BASE_TRY(hold_what_turns_back(s, err));
  if (s->arc.distribution != FORM_EXTREME && !arc_carries(&s->arc)) {
    s->arc.distribution = FORM_EXTREME;
    s->arc.unshared++;
    BASE_TRY(hold_what_turns_back(s, err));
  }
  if (arc_carries(&s->arc)) {
    return BASE_OK;
  }
  s->answer.work.fallbacks++;
  for (int i = 0; i < s->arc.n; i++) {
    s->arc.contact[i].stick = s->arc.contact[i].stick || s->arc.contact[i].starts;
  }
  return arc_forces(&s->arc, s->acc, err);
}

/* Forces after a jump start the next trapezoid. */
static base_status restart_forces(event_run *s, base_error *err) {
  BASE_TRY(begin_forces(s, err));
  impulse_log_begin(&s->log);
  for (int i = 0; i < s->arc.n; i++) {
    impulse_entry *e;
    BASE_TRY(impulse_log_at(&s->log, s->arc.contact[i].id, 0.0, &e, err));
    memcpy(e->force, s->arc.contact[i].force, sizeof e->force);
    e->seen = true;
  }
  for (int i = 0; i < s->log.n; i++) {
    if (!s->log.entry[i].seen) {
      memset(s->log.entry[i].force, 0, sizeof s->log.entry[i].force);
    }
  }
  return event_log_joints(s, 0.0, false, err);
}

static base_status look(event_run *s, double t, contact_set *c, base_error *err) {
  world_set_state(s->w, t, s->y, s->y + s->n_config);
  BASE_TRY(world_contacts_curved(s->w, 1e-3, s->arc.margin, c, err));
  return grow_scratch(s, c, err);
}

base_status event_resolve(event_run *s, double t, base_error *err) {
  contact_set c;
  BASE_TRY(look(s, t, &c, err));
  set_slow(s);
  if (mark_closing(s, &c)) {
    BASE_TRY(impact(s, &c, err));
    if (!s->solved) {
      return BASE_OK;
    }
    BASE_TRY(look(s, t, &c, err));
  }
  BASE_TRY(choose_modes(s, &c, err));
  if (!s->solved && s->without_solution && s->opt->paradox == PARADOX_IMPACT && s->pull > 0.0) {
    BASE_TRY(impact_without_collision(s, &c, err));
    if (!s->solved) {
      return BASE_OK;
    }
    BASE_TRY(look(s, t, &c, err));
    BASE_TRY(choose_modes(s, &c, err));
  }
  if (!s->solved) {
    return BASE_OK;
  }
  BASE_TRY(arc_settle(&s->arc, s->y + s->n_config, err));
  world_set_state(s->w, t, s->y, s->y + s->n_config);
  BASE_TRY(restart_forces(s, err));
  return watch_take(&s->watch, &s->arc, true, event_touching * s->arc.set.tol, err);
}

void event_resolve_close(event_run *s) {
  space_close(&s->space);
  turns_close(&s->turns);
  slip_close(&s->p);
  free(s->row);
  free(s->z);
  joint_log_close(&s->joints);
}
