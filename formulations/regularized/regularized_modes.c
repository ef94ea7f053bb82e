/* regularized_modes.c - from an iterate that breaks the friction law to the modes of the next solve.
 *
 * Three kinds of iteration. Newton's, which takes every slip in its present direction, ends in few
 * solves from a good iterate and turns in circles from a bad one. The secant's always goes on, at a
 * linear rate. So: Newton first; then secants, with Anderson's process; and each time stick and slip
 * have settled, a trial of Newton from there, taken back unless it halves the residual. */
#include "formulations/regularized/regularized.h"

#include <string.h>

enum { FIRST_PATIENCE = 2 }; /* secants without a change before the first trial */
/* iterations in which a residual is to halve: first, and once the loop goes shorter */
enum { LUGRE_PATIENCE = 200, LUGRE_SHORT = 50 };
static const double most_change = 1;     /* of ln r in one extrapolation [1] */
static const double independent = 1e-10; /* of a square, what the newer pairs must leave [1] */

void reg_modes_begin(regularized *s) {
  s->schedule = (reg_schedule){.patience = FIRST_PATIENCE, .way = 1, .mark = HUGE_VAL};
}

/* How far the loop over eta goes: all the way twice, then half of it, and half of that each time the residual has not
 * halved for a while: a contact that friction lifts and that closes without it turns in circles otherwise. */
static double lugre_way(regularized *s, double residual) {
  reg_schedule *c = &s->schedule;
  c->way = (s->iteration < 3) ? 1 : fmin(c->way, 0.5);
  c->waited++;
  if (residual <= 0.5 * c->mark) {
    c->mark = residual;
    c->waited = 0;
  } else if (c->waited >= ((c->way < 0.5) ? LUGRE_SHORT : LUGRE_PATIENCE)) {
    c->way *= 0.5;
    c->waited = 0;
  }
  return c->way;
}

static bool is_secant(const reg_part *p) {
  return p->mode == REG_SECANT && p->r > 0 && p->next_r > 0 && p->next_r < 1;
}

/* The newest pair of steps of every secant part: how ln r moved, and how the law's answer to it did. All
 * are forgotten where the set of parts is not that of the last iteration. */
static void remember_pair(regularized *s) {
  reg_schedule *c = &s->schedule;
  int n = 0, known = 0;
  for (int k = 0; k < s->n_part; k++) {
    n += is_secant(&s->part[k]);
    known += is_secant(&s->part[k]) && s->part[k].followed;
  }
  const bool same = n == known && n == c->n_secant;
  c->n_pair = same ? ((c->n_pair < REG_PAIRS) ? c->n_pair + 1 : REG_PAIRS) : 0;
  c->n_secant = n;
  for (int k = 0; k < s->n_part; k++) {
    reg_part *p = &s->part[k];
    p->followed = is_secant(p);
    if (p->followed) {
      const double log_r = log(p->r);
      const double step = log(p->next_r) - log_r;
      reg_pairs *q = &s->pairs[k];
      for (int j = c->n_pair - 1; j > 0; j--) {
        q->moved[j] = q->moved[j - 1];
        q->answered[j] = q->answered[j - 1];
      }
      q->moved[0] = log_r - p->log_r;
      q->answered[0] = step - p->log_step;
      p->log_r = log_r;
      p->log_step = step;
      p->log_go = step;
    }
  }
}

static double product(const regularized *s, int i, int j) {
  double sum = 0;
  for (int k = 0; k < s->n_part; k++) {
    const double *answered = s->pairs[k].answered;
    sum += s->part[k].followed ? answered[i] * answered[j] : 0;
  }
  return sum;
}

/* Pair j without what the newer ones say already; false where nothing is left. */
static bool orthogonalise(regularized *s, int j) {
  const double whole = product(s, j, j);
  for (int i = 0; i < j; i++) {
    const double share = product(s, i, j) / product(s, i, i);
    for (int k = 0; k < s->n_part; k++) {
      reg_pairs *q = &s->pairs[k];
      if (s->part[k].followed) {
        q->answered[j] -= share * q->answered[i];
        q->moved[j] -= share * q->moved[i];
      }
    }
  }
  return product(s, j, j) > independent * whole;
}

/* ln r goes on by Anderson's process (Walker & Ni 2011): the pairs of the last
 * iterations say what move of ln r makes the law's answer smallest, which also ends where the plain
 * iteration moves slowly away because friction and wedging nearly balance. What they do not know
 * goes as in the plain iteration, as does all where the move is too long to be believed. */
static void accelerate(regularized *s) {
  reg_schedule *c = &s->schedule;
  remember_pair(s);
  for (int j = 0; j < c->n_pair; j++) {
    if (!orthogonalise(s, j)) {
      c->n_pair = j;
      break;
    }
    double along = 0;
    for (int k = 0; k < s->n_part; k++) {
      along += s->part[k].followed ? s->pairs[k].answered[j] * s->part[k].log_step : 0;
    }
    along /= product(s, j, j);
    for (int k = 0; k < s->n_part; k++) {
      reg_part *p = &s->part[k];
      p->log_go -= p->followed ? along * (s->pairs[k].moved[j] + s->pairs[k].answered[j]) : 0;
    }
  }
  double longest = 0;
  for (int k = 0; k < s->n_part; k++) {
    longest = fmax(longest, s->part[k].followed ? fabs(s->part[k].log_go) : 0);
  }
  for (int k = 0; k < s->n_part && !(longest < most_change); k++) {
    s->part[k].log_go = s->part[k].log_step;
  }
}

/* Friction factor of the next secant: the law's, further along the way it is going. A contact may close
 * without friction and open with what the law then gives it, for ever: each time it has opened,
 * it closes with half of that. */
static double next_factor(reg_part *p) {
  if (p->mode == REG_SECANT && p->r > 0 && p->next_r == 0) {
    p->openings++;
  }
  const bool closes = p->mode == REG_SECANT && p->r == 0 && p->next_r > 0;
  if (closes) {
    return ldexp(p->next_r, -p->openings);
  }
  return p->followed ? fmin(1, p->r * exp(p->log_go)) : p->next_r;
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

/* The law's mode at the present iterate. What slipped, or was a secant, and has turned round would rather hold: it sticks in the next solve. */
static void choose_mode(regularized *s, reg_part *p, bool secant) {
  const unsigned char was = p->mode;
  const double tau = p->size;
  p->r = next_factor(p);
  p->mode = REG_STICK;
  if (p->next_r < 1 && tau > 0) {
    const double d[2] = {p->tau[0] / tau, p->tau[1] / tau};
    const bool turned = was != REG_STICK && d[0] * p->d[0] + d[1] * p->d[1] < 0;
    const bool stays = turned && s->opt.turned == REG_TURNED_STICKS;
    p->mode = secant ? REG_SECANT : stays ? REG_STICK : REG_SLIP;
    p->d[0] = d[0];
    p->d[1] = d[1];
  }
  s->answer.work.mode_changes += p->mode != was;
  s->schedule.calm = ((was == REG_STICK) == (p->mode == REG_STICK)) ? s->schedule.calm : 0;
}

void reg_modes_next(regularized *s, double residual) {
  const bool secant = takes_secants(s, residual);
  const double way = (s->opt.model == REG_LUGRE) ? lugre_way(s, residual) : 1;
  accelerate(s);
  s->schedule.calm++;
  for (int k = 0; k < s->n_part; k++) {
    reg_part *p = &s->part[k];
    if (reg_is_lugre(s, p)) {
      reg_lugre_next(&s->opt, s->a.set->h, way, p);
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

/* The next solve follows from these alone: what a plain iteration does with an iterate depends on no other. */
static bool is_kept(const regularized *s) {
  bool same = memcmp(s->base, s->lambda, (size_t)s->a.n_row * sizeof *s->base) == 0;
  for (int k = 0; k < s->n_part && same; k++) {
    const reg_part *p = &s->part[k], *b = &s->base_part[k];
    same = p->mode == b->mode && p->sliding == b->sliding && p->flips == b->flips &&
           p->d[0] == b->d[0] && p->d[1] == b->d[1];
  }
  return same;
}

/* One state is kept, anew at iterations 2, 4, 8, ...: a circle is found within three times what leads into it and its
 * length (Brent 1980). The first does not count, before which there is no proximal term yet. */
int reg_modes_circle(regularized *s) {
  const int i = s->iteration;
  if (s->opt.modes != REG_PLAIN) {
    return 0;
  }
  if (i > 2 && is_kept(s)) {
    return i - s->schedule.kept;
  }
  if ((i & (i - 1)) == 0) {
    s->schedule.kept = i;
    memcpy(s->base, s->lambda, (size_t)s->a.n_row * sizeof *s->base);
    memcpy(s->base_part, s->part, (size_t)s->n_part * sizeof *s->part);
  }
  return 0;
}
