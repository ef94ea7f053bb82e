/* regularized_once.c - stick and slip decided once a step, from the state in which it begins (MATHEMATICS 2.3.13): one
 * solve, whose answer is not tested against the law again.
 *
 *   h tau = h k s + G v_t,  v_t before the step;   slip where ||h tau|| > mu lambda_n',  d = tau/||tau||
 *
 * lambda_n' is the normal impulse of the last step, or for a new contact what would stop its approach if nothing else did.
 * A sticking part then is a spring of the law, or with integration=explicit the impulse -h (k s + c v_t); a
 * slipping one has -mu lambda_n d, or with bound=previous -mu lambda_n' d. The impulses that are known so are added to the
 * free velocities. */
#include "formulations/regularized/regularized.h"

#include <string.h>

static double normal_before(const regularized *s, int i) {
  const form_assembly *a = &s->a;
  const int g = a->group[i];
  const double *past = contact_memory_old(&s->memory, g);
  if (past != NULL && s->memory.h_old > 0) {
    return fmax(past[PAST_IMPULSE], 0.0) * a->set->h / s->memory.h_old;
  }
  const double own = form_own_block(a, i)[0];
  return (own > 0) ? fmax(0.0, -(a->r[a->row[i]] + a->bias[g])) / own : 0;
}

static void give(regularized *s, reg_part *p, const double *impulse) {
  p->mode = REG_GIVEN;
  for (int m = 0; m < p->dim; m++) {
    s->given[p->row + m] = impulse[m] * ((m == 1) ? p->axis2 : 1);
  }
}

static void decide(regularized *s, reg_part *p) {
  const form_assembly *a = &s->a;
  const int i = p->contact, g = a->group[i];
  const double h = a->set->h;
  const double normal = normal_before(s, i);
  const double bound = (p->sliding ? p->mu_kinetic : p->mu_static) * normal;
  const bool is_explicit = s->opt.integration == REG_EXPLICIT;
  double before[REG_ROWS_MAX], tau[2] = {0, 0};
  form_to_rows(a, i, a->set->u_before + a->set->row_start[g], before);
  for (int m = 0; m < p->dim; m++) {
    const double v = ((m == 1) ? p->axis2 : 1) * before[p->row - a->row[i] + m];
    tau[m] = p->pull * p->s[m] + (is_explicit ? h * p->c : p->G) * v;
  }
  const double size = hypot(tau[0], tau[1]);
  const bool slips = size > bound;
  p->mode = slips ? REG_SLIP : REG_STICK;
  p->sliding = slips;
  p->r = slips ? 0 : 1;
  for (int m = 0; m < 2 && slips; m++) {
    p->d[m] = tau[m] / size;
  }
  if (slips && s->opt.bound == REG_BOUND_PREVIOUS) {
    const double kinetic = p->mu_kinetic * normal;
    give(s, p, (double[2]){-kinetic * p->d[0], -kinetic * p->d[1]});
  } else if (!slips && is_explicit) {
    give(s, p, (double[2]){-tau[0], -tau[1]});
  }
}

void reg_once_begin(regularized *s) {
  memset(s->given, 0, (size_t)s->a.n_row * sizeof *s->given);
  for (int k = 0; k < s->n_part; k++) {
    decide(s, &s->part[k]);
  }
  form_assembly_velocity(&s->a, s->given, s->u);
  memcpy(s->a.r, s->u, (size_t)s->a.n_row * sizeof *s->u);
}

void reg_once_settle(const regularized *s, const reg_part *p, const double *lambda, double *next) {
  const double h = s->a.set->h, creep = h * p->k + p->c;
  for (int m = 0; m < p->dim; m++) {
    const double unit = (m == 1) ? p->axis2 : 1;
    const double saturated =
        (creep > 0) ? (-lambda[p->row + m] / unit + p->c * p->s[m]) / creep : 0;
    const double moved = p->s[m] + h * unit * s->u[p->row + m];
    const double sliding = (s->opt.bristle == REG_RESET) ? 0 : saturated;
    next[m] = (p->r < 1) ? sliding : moved;
  }
}
