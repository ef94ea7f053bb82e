#include "formulations/event/event_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static bool touches(const contact_set *c, int g) {
  return c->gap[g] <= event_touching * c->tol;
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
  const double size = event_departs(s, i, u0, lambda, along), friction = hypot(f[1], f[2]);
  if (k->stick && saturated(s, i, f)) {
    k->stick = false;
    k->edge = c->mu_static[s->space.a.group[i]] > c->mu_kinetic[s->space.a.group[i]];
    k->direction[0] = -f[1] / friction;
    k->direction[1] = -f[2] / friction;
  } else if (k->stick && size > 0.0) {
    k->stick = false;
    k->direction[0] = along[0] / size;
    k->direction[1] = along[1] / size;
  }
  return BASE_OK;
}

/* The terms of the arc that keep contacts from drifting: a force that ran out on the arc has run out
 * here. A contact whose normal joints or locks hold needs none, and what its acceleration has is the error of its curvature; if
 * it closes all the same that is an impact, for which there is no impulse. */
static base_status stabilise(const event_run *s, const contact_set *c, double *u0, double *term,
                             base_error *err) {
  const form_assembly *a = &s->space.a;
  const double rate = s->opt->rate;
  memset(term, 0, (size_t)a->n_row * sizeof *term);
  for (int i = 0; i < a->n_contact; i++) {
    const int g = a->group[i], first = a->row[i];
    const double *u = c->u_before + c->row_start[g];
    if (!(form_own_block(a, i)[0] > 0.0)) {
      u0[first] =
          fmax(u0[first], 0.0); /* no force answers what joints or locks hold, and none is needed */
      continue;
    }
    term[first] = 2.0 * rate * u[0] + rate * rate * c->gap[g];
    for (int t = 1; t < form_rows_of(a, i) && slip_at_rest(&s->p, a, i); t++) {
      term[first + t] = rate * u[t];
    }
  }
  BASE_TRY(event_make_consistent(s, term, err));
  for (int r = 0; r < a->n_row; r++) {
    u0[r] += term[r];
  }
  return BASE_OK;
}

void event_set_slow(event_run *s) {
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
  s->pull = event_scale(s, u0);
  BASE_TRY(stabilise(s, c, u0, lambda, err));
  event_drop_noise(s->space.a.n_row, u0);
  BASE_TRY(event_solve(s, u0, lambda, err));
  double largest = 0.0;
  for (int i = 0; i < s->space.a.n_contact; i++) {
    largest = fmax(largest, lambda[s->space.a.row[i]]);
  }
  s->arc.n = 0;
  if (s->solved) {
    BASE_TRY(event_inside(s, u0, 1e-9 * largest, lambda, err));
  }
  for (int i = 0; s->solved && i < s->space.a.n_contact; i++) {
    if (lambda[s->space.a.row[i]] > 1e-9 * largest) {
      BASE_TRY(keep_contact(s, c, i, u0, lambda, err));
    }
  }
  return BASE_OK;
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

static bool turns_back(const event_run *s, const arc_contact *k) {
  return k->starts && !k->stick && k->mu > 0.0 && along_of(k) < -1e-9 * s->pull;
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
      if (turns_back(s, k)) {
        k->stick = turned = true;
      }
    }
  }
  return BASE_OK;
}

/* A contact that sticks only with a force beyond its cone slides, against that force: its acceleration may be too small to tell, which
 * for a contact that moves as one with its joints is no small force. Returns whether the contacts carry this and none turns back. */
static base_status release(event_run *s, bool *carries, base_error *err) {
  for (int i = 0; i < s->arc.n; i++) {
    arc_contact *k = &s->arc.contact[i];
    const double friction = hypot(k->force[1], k->force[2]);
    if (k->starts && k->stick && arc_slips(&s->arc, k)) {
      k->stick = false;
      k->direction[0] = -k->force[1] / friction;
      k->direction[1] = -k->force[2] / friction;
    }
  }
  BASE_TRY(arc_forces(&s->arc, s->acc, err));
  *carries = arc_carries(&s->arc);
  for (int i = 0; i < s->arc.n; i++) {
    *carries = *carries && !turns_back(s, &s->arc.contact[i]);
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
  bool carries = arc_carries(&s->arc);
  if (!carries) {
    BASE_TRY(release(s, &carries, err));
  }
  if (carries) {
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
  BASE_TRY(world_contacts_curved(s->w, s->arc.probe, s->arc.margin, c, err));
  return grow_scratch(s, c, err);
}

base_status event_resolve(event_run *s, double t, base_error *err) {
  contact_set c;
  BASE_TRY(look(s, t, &c, err));
  event_set_slow(s);
  if (mark_closing(s, &c)) {
    BASE_TRY(event_impact(s, &c, err));
    if (!s->solved) {
      return BASE_OK;
    }
    BASE_TRY(look(s, t, &c, err));
  }
  BASE_TRY(choose_modes(s, &c, err));
  if (!s->solved && s->without_solution && s->opt->paradox == PARADOX_IMPACT && s->pull > 0.0) {
    BASE_TRY(event_impact_without_collision(s, &c, err));
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
  for (int i = 0; i < s->arc.n; i++) {
    arc_contact *k = &s->arc.contact[i];
    k->follows = k->starts && !k->stick && arc_begins_slowly(&s->arc, k);
  }
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
