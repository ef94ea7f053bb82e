#include "problems/world/contact_law.h"

#include <math.h>

/* Slower than this share of what its friction could do in the step a contact does not slide, and an impulse that is off by no more than this
 * share of it is off by the solve. */
static const double directed = 1e-6;
/* No formulation calls it a slide to be slower than this share of that. */
static const double held = 1e-5;

enum { HOLDS = 1, SLIDES = 2 }; /* modes */

/* Contact i, which slides at u: adds what its friction l is beyond mu_k l_n against the slip. What that does is no faster than the slip:
 * as soon as it were, it would turn round. */
static bool bends(const contact_set *c, int i, const double *l, const double *u, double *v) {
  const int tangent = c->rows[i].tangent;
  const double limit = c->mu_kinetic[i] * l[0];
  double slip = 0.0, power = 0.0, much = 0.0, beyond[3] = {0};
  for (int k = 1; k <= tangent; k++) {
    slip = hypot(slip, u[k]);
    power += l[k] * u[k];
  }
  for (int k = 1; k <= tangent; k++) {
    beyond[k] = l[k] + limit * u[k] / slip;
    much = hypot(much, beyond[k]);
  }
  if (power > 0.0 || !(much > directed * limit)) {
    return false;
  }
  const double share = fmin(1.0, slip / (much * contact_mobility(c, i, 1)));
  for (int k = 1; k <= tangent; k++) {
    contact_push(c, i, k, share * beyond[k], v);
  }
  return true;
}

/* Does contact i, which opens at u behind the step, come back from an impact? */
static bool bounces(const contact_set *c, int i, double u) {
  const double e = (c->restitution != NULL) ? c->restitution[i] : 0.0;
  const double before = c->u_before[c->row_start[i]];
  return e > 0.0 && before < 0.0 && u > -0.5 * e * before;
}

static const double beyond = 4.0; /* times what loads give within the step */

/* Does contact i come to rest in an impact, and stay? */
static bool is_struck(const contact_set *c, int i, double u_free) {
  const double before = c->u_before[c->row_start[i]];
  return -before > beyond * fabs(u_free - before);
}

/* The speed that the friction l of contact i, which holds, has not taken off a slip in an impact: what is left to slide goes on with it. */
static double not_taken(const contact_set *c, int i, const double *l) {
  double given = 0.0;
  for (int k = 1; k <= c->rows[i].tangent; k++) {
    given = hypot(given, l[k]);
  }
  return fmax(c->mu_kinetic[i] * l[0] - given, 0.0) * contact_mobility(c, i, 1);
}

/* The slip of contact i, which holds, beyond what loads give it within the step. */
static double left_to(const contact_set *c, int i, double slip, const double *u_free) {
  const double *before = c->u_before + c->row_start[i];
  double loads = 0.0;
  for (int k = 1; k <= c->rows[i].tangent; k++) {
    loads = hypot(loads, u_free[k] - before[k]);
  }
  return (slip > beyond * loads) ? slip : 0.0;
}

/* Contacts [first, end) of two bodies, of which none slides: adds what they hold together beyond mu_s l_n, as corners of a box do. A round cone
 * would let it slip. */
static bool holds_beyond(const contact_set *c, int first, int end, const double *impulse,
                         double *v) {
  const contact_friction f = contact_friction_of(c, first, end, impulse);
  if (!(f.together > (1.0 + directed) * f.could)) {
    return false;
  }
  for (int i = first; i < end; i++) {
    const double *l = impulse + c->row_start[i];
    for (int k = 1; k <= c->rows[i].tangent; k++) {
      contact_push(c, i, k, (1.0 - f.could / f.together) * l[k], v);
    }
  }
  return true;
}

/* That of all pairs of bodies. */
static bool any_holds_beyond(const contact_set *c, const double *impulse, const unsigned char *mode,
                             double *v) {
  bool some = false;
  for (int i = 0, end; i < c->n_contact; i = end) {
    bool slides = false;
    end = contact_pair_end(c, i);
    for (int k = i; k < end; k++) {
      slides = slides || mode[k] == SLIDES;
    }
    some = (!slides && holds_beyond(c, i, end, impulse, v)) || some;
  }
  return some;
}

contact_law contact_law_at(const contact_set *c, const double *impulse, const unsigned char *mode,
                           const double *u, const double *u_free, double *v) {
  contact_law law = {.bent = any_holds_beyond(c, impulse, mode, v)};
  for (int i = 0; i < c->n_contact; i++) {
    const int k = c->row_start[i];
    const int tangent = c->rows[i].tangent;
    if (tangent == 0 || !(c->mu_kinetic[i] * impulse[k] > 0.0)) {
      continue;
    }
    double slip = 0.0;
    for (int m = 1; m <= tangent; m++) {
      slip = hypot(slip, u[k + m]);
    }
    if (!(slip > directed * c->mu_kinetic[i] * impulse[k] * contact_mobility(c, i, 1))) {
      continue;
    }
    if (mode[i] == SLIDES) {
      law.bent = bends(c, i, impulse + k, u + k, v) || law.bent;
    } else if (mode[i] == HOLDS &&
               slip > held * c->mu_kinetic[i] * impulse[k] * contact_mobility(c, i, 1)) {
      const double left = left_to(c, i, slip, u_free + k);
      if (bounces(c, i, u[k])) {
        law.left = fmax(law.left, left);
      } else if (is_struck(c, i, u_free[k])) {
        law.left = fmax(law.left, fmin(left, not_taken(c, i, impulse + k)));
      }
    }
  }
  return law;
}
