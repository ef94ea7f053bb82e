/* Spheres in a hopper. */
#include "problems/scenes/kit.h"
#include "problems/vec.h"

#include <stdio.h>

typedef struct hopper {
  int layers, outlet, dim;
  double radius, mu, mass, gravity, duration;
} hopper;

static const base_field fields[] = {
    BASE_FIELD(hopper, layers, BASE_INT, "1", 8, 1, 2000, "layers of spheres, one in the lowest"),
    BASE_FIELD(hopper, outlet, BASE_INT, "1", 0, 0, 2000,
               "layers left out at the tip, which is open then; 0: closed"),
    BASE_FIELD(hopper, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(hopper, radius, BASE_REAL, "m", 0.05, 1e-4, 1e2, "radius"),
    BASE_FIELD(hopper, mu, BASE_REAL, "1", 0.2, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(hopper, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of a sphere"),
    BASE_FIELD(hopper, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(hopper, duration, BASE_REAL, "s", 0.1, 1e-3, 1e3, "time simulated"),
};

/* Layer k, counted from the tip, has k + 1 discs in the plane; in space a triangle of (k + 1)(k + 2)/2. */
static double spheres_above(const hopper *p) {
  double n = 0.0;
  for (int k = p->outlet; k < p->outlet + p->layers; k++) {
    n += (p->dim == 2) ? k + 1.0 : (k + 1.0) * (k + 2.0) / 2.0;
  }
  return n;
}

/* The two or three edges of the densest packing that go up from a sphere: unit vectors. */
static int edges_of(int dim, double edge[3][3]) {
  const double up = (dim == 2) ? sqrt(0.75) : sqrt(2.0 / 3.0), out = sqrt(1.0 - up * up);
  for (int i = 0; i < dim; i++) {
    const double turn = 2.0 * KIT_PI * i / 3.0;
    edge[i][0] = (dim == 2) ? (i == 0 ? -out : out) : out * cos(turn);
    edge[i][1] = (dim == 2) ? up : out * sin(turn);
    edge[i][2] = (dim == 2) ? 0.0 : up;
  }
  return dim;
}

/* Walls through all edges but one, a radius below the spheres. Returns the upward part of their normals. */
static base_status add_walls(const hopper *p, scene_spec *s, double *rise, base_error *err) {
  double edge[3][3];
  const int n = edges_of(p->dim, edge);
  for (int i = 0; i < n; i++) {
    const double *along = edge[(i + 1) % n], *inside = edge[i];
    double normal[3];
    char name[SPEC_NAME];
    if (n == 2) {
      normal[0] = -along[1];
      normal[1] = along[0];
      normal[2] = 0.0;
    } else {
      v3_cross(along, edge[(i + 2) % n], normal);
    }
    const double size = v3_norm(normal), side = (v3_dot(normal, inside) > 0.0) ? 1.0 : -1.0;
    for (int k = 0; k < 3; k++) {
      normal[k] *= side / size;
    }
    *rise = normal[kit_up(s)];
    kit_name(name, "wall", i);
    BASE_TRY(spec_add_static(s, name, normal, -p->radius, NULL, err));
  }
  return BASE_OK;
}

/* So many steps of a diameter along each edge from the tip. */
static base_status add_sphere(const hopper *p, const int *steps, scene_spec *s, base_error *err) {
  double edge[3][3], pos[3] = {0.0, 0.0, 0.0};
  char name[SPEC_NAME];
  const int n = edges_of(p->dim, edge);
  for (int e = 0; e < n; e++) {
    for (int c = 0; c < 3; c++) {
      pos[c] += 2.0 * p->radius * steps[e] * edge[e][c];
    }
  }
  kit_name(name, "s", s->n_body);
  return kit_ball(s, name, p->mass, p->radius, pos, NULL, err);
}

/* Layer k: all ways to go up k steps. */
static base_status add_layer(const hopper *p, int k, scene_spec *s, base_error *err) {
  for (int i = 0; i <= k; i++) {
    for (int j = (p->dim == 2) ? k - i : 0; j <= k - i; j++) {
      BASE_TRY(add_sphere(p, (const int[]){i, j, k - i - j}, s, err));
    }
  }
  return BASE_OK;
}

/* W is in balance with N c + T sin of all walls, |T| <= mu N, c the upward part of their normals. */
static base_status expect_load(const hopper *p, scene_spec *s, double weight, double rise,
                               base_error *err) {
  const double sine = sqrt(1.0 - rise * rise);
  const double least = weight / (rise + p->mu * sine), most = weight / (rise - p->mu * sine);
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_CONTACT_FORCE_SUM, NULL, &c, err));
  c->t0 = 0.5 * p->duration;
  c->t1 = p->duration;
  c->value = 0.5 * (least + most);
  c->tol.abs = 0.5 * (most - least) + 1e-6 * weight;
  for (int i = 0; i < p->dim; i++) {
    kit_name(c->pair[i].a, "wall", i);
    (void)snprintf(c->pair[i].b, SPEC_NAME, SPEC_ANY);
  }
  c->n_pair = p->dim;
  kit_source(c, "sum N (c + mu s) >= W >= sum N (c - mu s)");
  return BASE_OK;
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const hopper *p = param;
  const double n = spheres_above(p), fall = p->gravity * p->duration;
  double rise = 1.0;
  if (n > 2e6) {
    return BASE_FAIL(err, BASE_EINVAL, "layers = %d: %g spheres, need at most 2e6", p->layers, n);
  }
  kit_world(s, p->dim, p->gravity, p->duration, 0.005);
  for (int k = p->outlet; k < p->outlet + p->layers; k++) {
    BASE_TRY(add_layer(p, k, s, err));
  }
  BASE_TRY(add_walls(p, s, &rise, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  char top[SPEC_NAME], var[2 * SPEC_NAME];
  kit_name(top, "s", (int)n - 1);
  (void)snprintf(var, sizeof var, "%s.pos", top);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  if (p->outlet > 0) {
    BASE_TRY(kit_penetration(s, 1e-6, 2.0 * fall, err));
    return kit_energy(s, 1e-9 * n * p->mass * fall * fall, n * p->mass * p->gravity * fall, err);
  }
  BASE_TRY(kit_penetration(s, 1e-7, 0.02 * p->layers * fall, err));
  BASE_TRY(kit_drift(s, var, 1e-6, 2.0 * p->gravity * p->layers, NULL, err));
  kit_source(kit_last(s), "every sphere lies in a pocket: nothing moves");
  return (p->mu * sqrt(1.0 - rise * rise) < rise)
             ? expect_load(p, s, n * p->mass * p->gravity, rise, err)
             : BASE_OK;
}

KIT_SCENE(hopper, "spheres in a hopper", "beverloo1961",
          "Densest packing in a hopper that is made for it, of two walls in the plane and three in "
          "space. Closed, nothing moves and the walls carry the weight: their normal forces sum "
          "to W/c without friction and lie between W/(c + mu s) and W/(c - mu s) with it. Open at "
          "the tip it runs out. Up to 2e6 spheres.",
          .situation = SITUATION_STACK);
