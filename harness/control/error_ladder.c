#include "harness/control/error_ladder.h"

#include <math.h>

/* Of each kind of steps: the longest of the first run over its duration, its tolerance over E, and the least ratio of two tolerances,
 * which is the only one of own steps: their error is of no known order. The number of extrapolated steps grows with the root of what is
 * asked, so they begin coarse; their least ratio is no power of 4, for steps halved on the way to the same time would be the same in
 * two runs, and what happens unseen inside one of them as well. */
static const struct {
  double longest, tolerance, least;
} first[] = {{1.0 / 8.0, 256.0, 2.0}, {1.0 / 8.0, 256.0, 2.0}, {1.0 / 2.0, 16.0, 5.0}};
static const double most_ratio = 64.0;
/* Plain steps are of first order: a run that is so much finer than it should do is not followed by another for a trifle. */
static const double plain_spare = 1.2;
/* Parts of the first extrapolated run, which is enough where all is at rest; and what the next one's count from. */
static const double first_parts = 2.0, next_parts = 4.0;
/* What a run may be off by between its states, so that the next one looks at no more parts [E]. */
static const double enough = 0.25;

void error_ladder_begin(error_ladder *l, const sim_request *q, error_steps steps, double length,
                        double bears, bool rests) {
  const bool extrapolate = steps == ERROR_EXTRAPOLATED;
  const double longest = first[steps].longest * q->duration;
  *l = (error_ladder){.steps = steps, .parts = extrapolate ? first_parts : 1.0, .ratio = 1.0};
  l->rule = (step_rule){.least = 1e-9 * q->duration,
                        .most = fmin(longest, bears),
                        .tolerance = first[steps].tolerance * length,
                        .rests = extrapolate && rests && bears >= q->duration,
                        .extrapolate = extrapolate};
  l->rule.first = (steps == ERROR_PLAIN) ? fmin(q->h, l->rule.most) : l->rule.most;
}

void error_ladder_finer(error_ladder *l, double over, double between, double parts) {
  const double least = first[l->steps].least;
  step_rule *rule = &l->rule;
  const double spare = (l->steps == ERROR_PLAIN) ? plain_spare : 1.0;
  l->ratio = (l->steps == ERROR_OWN) ? least : fmin(fmax(spare * over, least), most_ratio);
  rule->tolerance /= l->ratio;
  rule->rests = false;
  if (rule->extrapolate) {
    const double more = sqrt(fmin(fmax(between / enough, 1.0), most_ratio));
    /* one more at least, or two runs would have states at the same times */
    l->parts = fmin(fmax(fmax(l->parts, next_parts) * more, l->parts + 1.0), parts);
  }
  /* or two runs that take the longest steps would be one */
  rule->most /= error_ladder_gain(l, !rule->extrapolate);
  rule->first = fmin(rule->first, rule->most);
}

double error_ladder_gain(const error_ladder *l, bool second) {
  return (l->steps != ERROR_EXTRAPOLATED || second) ? l->ratio : sqrt(l->ratio);
}
