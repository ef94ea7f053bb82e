/* Rope of particles round a drum. */
#include "problems/scenes/kit.h"

typedef struct capstan {
  int n;
  double wrap_deg, mu, hold, share, radius;
} capstan;

static const base_field fields[] = {
    BASE_FIELD(capstan, n, BASE_INT, "1", 9, 1, 500, "contacts"),
    BASE_FIELD(capstan, wrap_deg, BASE_REAL, "deg", 180.0, 1.0, 330.0, "angle of wrap"),
    BASE_FIELD(capstan, mu, BASE_REAL, "1", 0.3, 0.0, 5.0, "friction coefficient"),
    BASE_FIELD(capstan, hold, BASE_REAL, "N", 1.0, 1e-6, 1e6, "tension at the held end"),
    BASE_FIELD(capstan, share, BASE_REAL, "1", 0.95, 0.1, 10.0, "pull over the largest that holds"),
    BASE_FIELD(capstan, radius, BASE_REAL, "m", 0.1, 1e-3, 1e2, "radius of the drum"),
};

/* Each contact turns the rope by d = wrap/n and multiplies the tension by at most
 * (1 + mu tan(d/2))/(1 - mu tan(d/2)) -> exp(mu d) (MATHEMATICS B18). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const capstan *p = param;
  const double d = kit_radians(p->wrap_deg) / p->n, k = p->mu * tan(d / 2.0);
  const double pull = p->share * p->hold * pow((1.0 + k) / (1.0 - k), p->n), pos[2] = {0.0, 0.0};
  spec_body *b;
  if (k >= 0.95) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "n = %d: mu tan(d/2) = %g, need less than 0.95 (more contacts)", p->n, k);
  }
  kit_world(s, 2, 0.0, 0.05, 0.001);
  BASE_TRY(kit_ball(s, "drum", 1.0, p->radius, pos, &b, err));
  b->kinematic = true;
  for (int i = 0; i < p->n; i++) {
    char name[SPEC_NAME];
    const double at = (i + 0.5) * d;
    kit_name(name, "r", i);
    BASE_TRY(spec_add_body(s, name, &b, err));
    b->mass = 0.01;
    b->lock = SPEC_RZ;
    b->pos[0] = p->radius * cos(at);
    b->pos[1] = p->radius * sin(at);
    if (i > 0) {
      spec_joint *j;
      kit_name(name, "j", i);
      BASE_TRY(spec_add_joint(s, name, &j, err));
      j->kind = SPEC_DISTANCE;
      j->body = i + 1;
      j->other = i;
      for (int c = 0; c < 2; c++) {
        j->anchor[c] = s->body[i + 1].pos[c];
        j->other_anchor[c] = s->body[i].pos[c];
      }
    }
  }
  for (int end = 0; end < 2; end++) { /* along the continued polygon */
    spec_load *l;
    BASE_TRY(spec_add_load(s, &l, err));
    const double along = (end == 0) ? 0.0 : p->n * d;
    const double T = (end == 0) ? p->hold : pull, side = (end == 0) ? 1.0 : -1.0;
    l->kind = SPEC_FORCE;
    l->body = (end == 0) ? 1 : p->n;
    l->force[0] = side * T * sin(along);
    l->force[1] = -side * T * cos(along);
  }
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, "r0.pos", err));
  if (p->share < 0.999) {
    return kit_rests(s, "r0.pos", 1e-6 * p->radius, "T2/T1 within the product", err);
  }
  return (p->share > 1.02 && p->share < 3.0)
             ? kit_moves(s, "r0.x", 1e-9, "T2/T1 beyond the product", err)
             : kit_finite(s, err);
}

KIT_SCENE(capstan, "rope round a drum", "eytelwein1808",
          "Particles joined by rigid links lie on a drum and are pulled at both ends. The ratio of "
          "tensions that holds is the product over contacts of (1 + mu tan(d/2))/(1 - mu "
          "tan(d/2)), which tends to exp(mu wrap): friction through joints, with every contact at "
          "its limit at once (MATHEMATICS B18).",
          .situation = SITUATION_GRASP);
