/* polyhedral_push.c - what moves contacts apart beside the law of contact: the rebound of two_steps, and at position level
 * overlaps. One that grew along a curved way is taken back by the velocity that the way lacks, and costs less than the impulses
 * of the step take. One that the impulses of a jam push out gives them energy from nothing, or has no solution: it is moved
 * beside the motion, after it, by the least motion of normal impulses, and leaves no velocity. */
#include "formulations/polyhedral_matrix.h"

#include <math.h>
#include <string.h>

/* Speed at which active contact i was met in the step before and that it has not given back, <= 0. */
double poly_owed(const polyhedral *s, int i) {
  const double *past = contact_memory_old(&s->memory, s->a.group[i]);
  const bool waits = s->opt.restitution == POLY_TWO_STEPS && s->a.set->restitution != NULL;
  return (waits && past != NULL) ? past[PAST_APPROACH] : 0;
}

/* Rebound of the contacts that the step before brought to rest: u_n+ >= -e u_n-. */
static void rebound(polyhedral *s) {
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const double speed = poly_owed(s, i);
    if (speed < 0) {
      s->a.bias[g] = fmin(s->a.bias[g], s->a.set->restitution[g] * speed);
    }
  }
}

void poly_pushes_begin(polyhedral *s) {
  s->pushes = false;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const bool inside = s->opt.level == FORM_LEVEL_POSITION && s->a.set->gap[g] < 0;
    s->push[i] = inside ? s->a.bias[g] : 0;
    s->pushes = s->pushes || s->push[i] < 0;
  }
  rebound(s);
}

void poly_pushes_drop(polyhedral *s) {
  for (int i = 0; i < s->a.n_contact; i++) {
    if (s->push[i] < 0) {
      s->a.bias[s->a.group[i]] = 0;
    }
  }
  rebound(s);
}

static void find_velocities(polyhedral *s) {
  if (s->a.own_only) {
    form_assembly_velocity_of(&s->a, s->base, s->u);
  } else {
    form_assembly_velocity(&s->a, s->base, s->u);
  }
}

/* u of the impulses that are already there: none before the first solve. */
void poly_velocities(polyhedral *s) {
  if (s->phase == POLY_MOTION || s->phase == POLY_STILL) {
    memcpy(s->u, s->a.r, (size_t)s->a.n_row * sizeof *s->u);
  } else {
    find_velocities(s);
  }
}

/* lambda' (u+ + u_free) / 2 is the energy that the step gives. */
bool poly_makes_energy(polyhedral *s) {
  static const double rounding = 1e-9;
  double given = 0, size = 0;
  find_velocities(s);
  for (int r = 0; r < s->a.n_row; r++) {
    given += 0.5 * s->base[r] * (s->u[r] + s->a.r[r]);
    size += fabs(s->base[r]) * (fabs(s->u[r]) + fabs(s->a.r[r]));
  }
  return given > rounding * size;
}

void poly_push_out(polyhedral *s, const double *z, bool solved) {
  s->phase = POLY_DONE;
  s->answer.work.fallbacks += !solved;
  memcpy(s->u, s->base, (size_t)s->a.n_row * sizeof *s->u);
  for (int i = 0; i < s->a.n_group && solved; i++) {
    poly_expand(s, i, z + s->first[i], s->u + s->a.row[i]);
  }
  if (solved) {
    form_assembly_answer_beside(&s->a, s->base, s->u);
  }
}
