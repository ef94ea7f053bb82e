/* regularized_modes.c - from an iterate that breaks the friction law to the modes of the next solve.
 *
 * Three kinds of iteration. Newton's, which takes every slip in its present direction, ends in few
 * solves from a good iterate and turns in circles from a bad one. The secant's always goes on, at a
 * linear rate. So: Newton first; then secants, with Aitken's process; and each time stick and slip
 * have settled, a trial of Newton from there, taken back unless it halves the residual. */
#include "formulations/regularized/regularized.h"

#include <string.h>

enum { FIRST_PATIENCE = 2 };                 /* secants without a change before the first trial */
static const double least_relaxation = 0.05; /* below, the steps turn back and forth [1] */
static const double most_change = 1;         /* of ln r in one extrapolation [1] */

void reg_modes_begin(regularized *s) {
  s->schedule = (reg_schedule){.relaxation = 1, .patience = FIRST_PATIENCE};
}

static bool is_secant(const reg_part *p) {
  return p->mode == REG_SECANT && p->r > 0 && p->next_r > 0 && p->next_r < 1;
}

/* ln r goes on by omega times its step, omega from the last two steps (Irons & Tuck 1969, Aitken's
 * process for vectors): beyond 1 where friction and wedging nearly balance, negative where they
 * balance too well and the plain iteration moves slowly away. 1 where the set of parts has changed
 * or the extrapolation says nothing. */
static void relax(regularized *s) {
  reg_schedule *c = &s->schedule;
  double product = 0;
  double square = 0;
  double longest = 0;
  int n = 0;
  for (int k = 0; k < s->n_part; k++) {
    reg_part *p = &s->part[k];
    if (is_secant(p)) {
      const double step = log(p->next_r / p->r);
      const double change = step - p->log_step;
      product += p->log_step * change;
      square += change * change;
      longest = fmax(longest, fabs(step));
      p->log_step = step;
      n++;
    }
  }
  const double omega = -c->relaxation * product / square;
  const bool useful = fabs(omega) > least_relaxation && fabs(omega) * longest < most_change;
  c->relaxation = (n > 0 && n == c->n_secant && useful) ? omega : 1;
  c->n_secant = n;
}

/* Friction factor of the next secant: the law's, further along the way it is going. */
static double next_factor(const regularized *s, const reg_part *p) {
  return is_secant(p) ? fmin(1, p->r * exp(s->schedule.relaxation * p->log_step)) : p->next_r;
}

static void begin_trial(regularized *s) {
  s->schedule.trial = true;
  memcpy(s->base, s->lambda, (size_t)s->a.n_row * sizeof *s->base);
  memcpy(s->base_part, s->part, (size_t)s->n_part * sizeof *s->part);
}

/* Back to where a trial began that led nowhere; the next one comes later. */
static void end_trial(regularized *s) {
  s->schedule.trial = false;
  s->schedule.calm = 0;
  s->schedule.patience *= 2;
  s->schedule.n_secant = 0;
  memcpy(s->lambda, s->base, (size_t)s->a.n_row * sizeof *s->base);
  memcpy(s->part, s->base_part, (size_t)s->n_part * sizeof *s->part);
  for (int i = 0; i < s->a.n_contact; i++) {
    s->anchor[i] = s->z0[i] = s->base[s->a.row[i]];
  }
}

static bool takes_secants(regularized *s, double residual) {
  reg_schedule *c = &s->schedule;
  if (s->opt.modes != REG_NEWTON) {
    return s->opt.modes == REG_SECANT_ONLY;
  }
  if (s->iteration < s->opt.newton_iter) {
    return false;
  }
  if (c->trial && !(residual < 0.5 * c->residual)) {
    end_trial(s);
    return true;
  }
  if (!c->trial && c->calm >= c->patience) {
    begin_trial(s);
  }
  c->residual = residual;
  return !c->trial;
}

/* The law's mode at the present iterate. */
static void choose_mode(regularized *s, reg_part *p, bool secant) {
  const unsigned char was = p->mode;
  const double tau = p->size;
  p->r = next_factor(s, p);
  p->mode = REG_STICK;
  if (p->next_r < 1 && tau > 0) {
    const double d[2] = {p->tau[0] / tau, p->tau[1] / tau};
    const bool turned = was != REG_STICK && d[0] * p->d[0] + d[1] * p->d[1] < 0;
    const bool hold = s->opt.modes == REG_NEWTON && turned;
    p->mode = (secant || hold) ? REG_SECANT : REG_SLIP;
    p->d[0] = d[0];
    p->d[1] = d[1];
  }
  s->answer.work.mode_changes += p->mode != was;
  s->schedule.calm = ((was == REG_STICK) == (p->mode == REG_STICK)) ? s->schedule.calm : 0;
}

void reg_modes_next(regularized *s, double residual) {
  const bool secant = takes_secants(s, residual);
  relax(s);
  s->schedule.calm++;
  for (int k = 0; k < s->n_part; k++) {
    reg_part *p = &s->part[k];
    if (reg_is_lugre(s, p)) {
      reg_lugre_next(&s->opt, s->a.set->h, s->iteration, p);
    } else if (!reg_is_idle(s, p)) {
      choose_mode(s, p, secant);
    }
  }
}

void reg_modes_without_solution(regularized *s) {
  s->answer.work.fallbacks++;
  if (s->schedule.trial) {
    end_trial(s);
    reg_modes_next(s, HUGE_VAL);
    return;
  }
  for (int k = 0; k < s->n_part; k++) {
    if (s->part[k].mode == REG_SLIP) {
      s->part[k].mode = REG_SECANT;
    }
  }
}
