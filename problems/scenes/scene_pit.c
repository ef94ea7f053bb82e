/* Ball in a groove or pit. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct pit {
  double beta_deg, radius, mass, gravity;
  int walls, dim;
} pit;

static const base_field fields[] = {
    BASE_FIELD(pit, beta_deg, BASE_REAL, "deg", 40.0, 1e-4, 89.99, "slope of the walls"),
    BASE_FIELD(pit, walls, BASE_INT, "1", 3, 2, 8, "walls in 3D (2 in the plane)"),
    BASE_FIELD(pit, dim, BASE_INT, "1", 3, 2, 3, "dimension"),
    BASE_FIELD(pit, radius, BASE_REAL, "m", 0.2, 1e-3, 1e2, "radius"),
    BASE_FIELD(pit, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass"),
    BASE_FIELD(pit, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Each normal force m g/(n cos beta) while n <= dim; their sum m g/cos beta always. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const pit *p = param;
  const int n = (p->dim == 2) ? 2 : p->walls;
  const double beta = kit_radians(p->beta_deg), total = p->mass * p->gravity / cos(beta);
  double pos[3] = {0.0};
  spec_check *sum;
  if (p->dim == 3 && n == 2) {
    return BASE_FAIL(err, BASE_EINVAL, "walls = 2: need at least 3 in space");
  }
  kit_world(s, p->dim, p->gravity, 0.2, 0.01);
  pos[kit_up(s)] = p->radius / cos(beta);
  BASE_TRY(kit_ball(s, "ball", p->mass, p->radius, pos, NULL, err));
  s->effects = EFFECT_CONTACT;
  for (int i = 0; i < n; i++) {
    char name[SPEC_NAME];
    const double turn = 2.0 * KIT_PI * i / n + 0.3;
    double normal[3] = {sin(beta) * cos(turn), sin(beta) * sin(turn), cos(beta)};
    if (p->dim == 2) {
      normal[0] = (i == 0) ? sin(beta) : -sin(beta);
      normal[1] = cos(beta);
    }
    kit_name(name, "p", i);
    BASE_TRY(spec_add_static(s, name, normal, 0.0, NULL, err));
    if (n <= p->dim) {
      BASE_TRY(kit_force(s, "ball", name, false, 0.1, 0.2, total / n,
                         1e-6 * total / fmax(sin(beta) * sin(beta), 1e-6), NULL, err));
      kit_source(kit_last(s), "m g/(n cos beta)");
    }
  }
  BASE_TRY(spec_add_check(s, CHECK_CONTACT_FORCE_SUM, NULL, &sum, err));
  sum->n_pair = n;
  sum->t0 = 0.1;
  sum->t1 = 0.2;
  sum->value = total;
  sum->tol.abs = 1e-6 * total;
  kit_source(sum, "m g/cos beta");
  for (int i = 0; i < n; i++) {
    (void)snprintf(sum->pair[i].a, SPEC_NAME, "ball");
    kit_name(sum->pair[i].b, "p", i);
  }
  BASE_TRY(spec_add_observe(s, "ball.pos", err));
  return kit_drift(s, "ball.pos", 1e-7, 0.0, NULL, err);
}

KIT_SCENE(pit, "ball in a groove or pit", "",
          "A ball rests on several planes. Three walls carry m g/(3 cos beta) each, more are "
          "hyperstatic and only the sum is determined; nearly flat or nearly closed walls (beta "
          "towards 0 or 90 degrees) make the split as ill-conditioned as wanted (MATHEMATICS S4).",
          .situation = SITUATION_OTHER);
