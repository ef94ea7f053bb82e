#include "harness/control/deviation.h"

#include "problems/vec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

deviation_scale deviation_scale_of(const scene_spec *spec, const world *w, double duration) {
  const double gravity = v3_norm(spec->gravity);
  const double size = world_size(w);
  return (deviation_scale){.size = size,
                           .speed = fmax(sqrt(gravity * size), size / duration),
                           .fall = sqrt(world_most_acceleration(w) / size)};
}

base_status deviation_open(deviation *d, int n, const world_inertia *inertia, base_error *err) {
  *d = (deviation){.n = n, .inertia = inertia};
  d->body = calloc((size_t)n + 1, sizeof *d->body);
  return (d->body != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory for what %d bodies are off by", n);
}

void deviation_close(deviation *d) {
  free(d->body);
  *d = (deviation){0};
}

void deviation_clear(deviation *d) {
  memset(d->body, 0, (size_t)d->n * sizeof *d->body);
  memset(d->sum, 0, sizeof d->sum);
  d->energy = d->place = 0.0;
  d->any = false;
}

void deviation_copy(deviation *to, const deviation *from) {
  deviation_body *own = to->body;
  memcpy(own, from->body, (size_t)from->n * sizeof *own);
  *to = *from;
  to->body = own;
}

/* Root of twice the energy over the mass, of a velocity and a turning, at most. */
static double norm_of(const world_inertia *of, double v, double w) {
  return sqrt(v * v + of->gyration * of->gyration * w * w);
}

/* The velocity by turning that e may be as a whole. */
static double turning_of(const world_inertia *of, double e) {
  return (of->gyration > 0.0) ? e / of->gyration : 0.0;
}

static void note_rate(deviation_body *b, int k, double change, double h) {
  b->rate[k] = fmin(b->last[k], change / h);
  b->last[k] = change / h;
}

/* Does contact make turning of its velocity, and velocity of its turning? */
static bool mixes(const world_growth *g) {
  return g->turned && g->pushed;
}

/* What the step changes in a body, before contact passes it on. place: of what pushes it and its own, in the norm of energy over its mass
 * [m]. Returns in that norm what was left out [m/s]. */
static double enter(const world_inertia *of, const world_growth *g, double place, double h,
                    deviation_body *b) {
  const double pull = g->place * place, turn = g->arm * place;
  const double own = norm_of(of, g->moved, g->spun), whirl = g->speed * b->w + g->whirl * b->a;
  const double more = own + (g->turned ? fmax(pull, turn) : pull) + of->gyration * whirl;
  note_rate(b, 0, mixes(g) ? own : g->moved, h);
  note_rate(b, 1, mixes(g) ? turning_of(of, own) : g->spun, h);
  b->v += g->moved + pull;
  b->w += g->spun + whirl + (g->turned ? turning_of(of, turn) : 0.0);
  b->e = fmin(b->e + more, norm_of(of, b->v, b->w));
  return own;
}

/* The velocity that takes part where bodies push each other. */
static double taking_part(const world_growth *g, const deviation_body *b) {
  return g->turned ? b->e : b->v;
}

/* After contact. energy: of the bodies that push each other, of which this is one; of it alone -1. */
static void pass_on(const world_inertia *of, const world_growth *g, double energy,
                    deviation_body *b) {
  if (energy >= 0.0) {
    b->v = energy / sqrt(of->mass);
    b->e = g->turned ? b->v : norm_of(of, b->v, b->w);
  }
  if (mixes(g)) {
    b->v = b->e;
    b->w = turning_of(of, b->e);
  }
}

static void move(const world_inertia *of, double h, deviation_body *b) {
  b->x += h * b->v;
  b->a += h * b->w;
  b->z = fmin(b->z + h * b->e, norm_of(of, b->x, b->a));
}

/* Does the step change anything? */
static bool changes(const deviation *d, const world_growth *grown) {
  bool some = d->any;
  for (int i = 0; i < d->n && !some; i++) {
    some = grown[i].moved > 0.0 || grown[i].spun > 0.0;
  }
  return some;
}

static double square(double x) {
  return x * x;
}

/* Notes at the first body of each group the places in it. */
static void note_groups(deviation *d, const world_growth *grown) {
  for (int i = 0; i < d->n; i++) {
    d->body[i].group = (deviation_group){0};
  }
  for (int i = 0; i < d->n; i++) {
    deviation_group *at = &d->body[grown[i].group].group;
    at->place += d->inertia[i].mass * square(d->body[i].z);
    at->n++;
  }
}

/* Enters what the step changes in all bodies. */
static void enter_all(deviation *d, const deviation_scale *scale, const world_growth *grown,
                      double h) {
  double own = 0.0, place = 0.0, speed = 0.0, all = 0.0;
  for (int i = 0; i < d->n; i++) {
    const world_inertia *of = &d->inertia[i];
    const world_growth *g = &grown[i];
    deviation_body *b = &d->body[i];
    deviation_group *at = &d->body[g->group].group;
    if (of->mass > 0.0) {
      own +=
          of->mass * square(enter(of, g, fmin(sqrt(at->place), d->place) / sqrt(of->mass), h, b));
      b->grows = (g->arm > 0.0) ? fmin(scale->fall, sqrt(g->arm / h)) : 0.0;
      place = fmax(place, g->whirl + (g->turned ? fmax(g->place, g->arm) : g->place));
      speed = fmax(speed, g->speed);
      all += of->mass * square(b->e);
      at->energy += of->mass * square(taking_part(g, b));
    }
  }
  d->energy = (1.0 + speed) * (d->energy + sqrt(own) + place * d->place);
  d->energy = fmin(d->energy, sqrt(all));
}

void deviation_add(deviation *d, const deviation_scale *scale, const double omitted[EFFECT_COUNT],
                   const world_growth *grown, double h) {
  if (!changes(d, grown)) {
    return;
  }
  d->any = true;
  for (int e = 0; e < EFFECT_COUNT; e++) {
    d->sum[e] += omitted[e];
  }
  double all = 0.0;
  note_groups(d, grown);
  enter_all(d, scale, grown, h);
  for (int i = 0; i < d->n; i++) {
    const deviation_group *at = &d->body[grown[i].group].group;
    if (d->inertia[i].mass > 0.0) {
      const double energy = (at->n > 1) ? fmin(sqrt(at->energy), d->energy) : -1.0;
      pass_on(&d->inertia[i], &grown[i], energy, &d->body[i]);
      move(&d->inertia[i], h, &d->body[i]);
      all += d->inertia[i].mass * square(d->body[i].z);
    }
  }
  d->place = fmin(d->place + h * d->energy, sqrt(all));
}

/* Over the scales, of a body whose bound is `bound`. */
static double over_scales(const deviation_scale *scale, double bound, const double speed[2],
                          const double place[2]) {
  const double centre = fmax(speed[0] / scale->speed, place[0] / scale->size);
  const double turned = fmax(speed[1] * scale->size / scale->speed, place[1]);
  return (bound > 0.0) ? fmax(centre, turned / bound) : centre;
}

deviation_forecast deviation_after(const deviation *d, int i, const deviation_scale *scale,
                                   double time) {
  static const double far = 300.0; /* its exponential is finite, and more than anything asked */
  const deviation_body *b = &d->body[i];
  const double bound = d->inertia[i].bound, r = b->grows;
  double keeps = 1.0, moves = time, falls = 0.5 * time * time;
  if (r > 0.0) {
    const double e = exp(fmin(r * time, far));
    keeps = 0.5 * (e + 1.0 / e);
    moves = 0.5 * (e - 1.0 / e) / r;
    falls = (keeps - 1.0) / (r * r);
  }
  const double v[2] = {b->v, b->w}, x[2] = {b->x, b->a};
  double speed[3][2], place[3][2];
  for (int k = 0; k < 2; k++) {
    speed[0][k] = keeps * v[k] + r * r * moves * x[k];
    place[0][k] = keeps * x[k] + moves * v[k];
    speed[1][k] = speed[0][k] + moves * b->rate[k];
    place[1][k] = place[0][k] + falls * b->rate[k];
    speed[2][k] = speed[0][k] + moves * b->last[k];
    place[2][k] = place[0][k] + falls * b->last[k];
  }
  return (deviation_forecast){.now = over_scales(scale, bound, v, x),
                              .free = over_scales(scale, bound, speed[0], place[0]),
                              .both = over_scales(scale, bound, speed[1], place[1]),
                              .last = over_scales(scale, bound, speed[2], place[2])};
}

void deviation_points(const deviation *d, world_deviation *point) {
  for (int i = 0; i < d->n; i++) {
    const deviation_body *b = &d->body[i];
    point[i] = (world_deviation){b->v + b->w, b->x + b->a};
  }
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
