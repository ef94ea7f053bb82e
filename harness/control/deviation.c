#include "harness/control/deviation.h"

#include "problems/vec.h"

#include <math.h>

deviation_scale deviation_scale_of(const scene_spec *spec, const world *w, double duration) {
  const double gravity = v3_norm(spec->gravity);
  const double size = world_size(w);
  double sum = 0.0, least = HUGE_VAL;
  for (int i = 0; i < spec->n_body; i++) {
    const spec_body *b = &spec->body[i];
    sum += b->kinematic ? 0.0 : b->mass;
    least = b->kinematic ? least : fmin(least, b->mass);
  }
  return (deviation_scale){.size = size,
                           .speed = fmax(sqrt(gravity * size), size / duration),
                           .fall = sqrt(gravity / size),
                           .masses = (sum > 0.0) ? sqrt(sum / least) : 1.0,
                           .swing = world_swing(w)};
}

bool deviation_add(deviation *d, const deviation_scale *scale, const double omitted[EFFECT_COUNT],
                   double least, const world_growth *g, double h) {
  double change = 0.0;
  for (int e = 0; e < EFFECT_COUNT; e++) {
    if (omitted[e] > least) {
      d->sum[e] += omitted[e];
      change += omitted[e];
    }
  }
  if (change == 0.0 && d->speed == 0.0) {
    return false;
  }
  d->rate = fmin(d->change, change / h);
  d->change = change / h;
  const double more = ((g->shared && !d->shared) ? scale->masses : 1.0) *
                      ((g->turned && !d->turned) ? scale->swing : 1.0);
  d->shared = d->shared || g->shared;
  d->turned = d->turned || g->turned;
  /* what acts on bodies that turn counts at their points already */
  change *= (d->shared ? scale->masses : 1.0) * ((d->turned && !g->turned) ? scale->swing : 1.0);
  d->place *= more;
  d->speed = (more * d->speed + change + g->place * d->place) * (1.0 + g->speed);
  d->place += h * d->speed;
  return true;
}

double deviation_growth(const deviation_scale *scale, const world_growth *g, double h) {
  return (g->place > 0.0) ? fmin(scale->fall, sqrt(g->place / h)) : 0.0;
}

double deviation_after(const deviation *d, const deviation_scale *scale, double growth, double rate,
                       double time) {
  static const double far = 300.0; /* its exponential is finite, and more than anything asked */
  const double r = growth, angle = fmin(r * time, far);
  const double keeps = cosh(angle), moves = (r > 0.0) ? sinh(angle) / r : time;
  const double falls = (r > 0.0) ? (keeps - 1.0) / (r * r) : 0.5 * time * time;
  const double speed = keeps * d->speed + r * r * moves * d->place + rate * moves;
  const double place = keeps * d->place + moves * d->speed + rate * falls;
  return fmax(speed / scale->speed, place / scale->size);
}

unsigned deviation_by(const deviation *d, double share) {
  double most = 0.0;
  unsigned effects = 0;
  for (int e = 0; e < EFFECT_COUNT; e++) {
    most = fmax(most, d->sum[e]);
  }
  for (int e = 0; e < EFFECT_COUNT; e++) {
    effects |= (d->sum[e] > share * most) ? 1u << e : 0u;
  }
  return effects;
}
