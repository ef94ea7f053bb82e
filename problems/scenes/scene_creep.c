/* Oscillating load below the friction limit. */
#include "problems/scenes/kit.h"

typedef struct creep {
  double mean, amplitude, frequency, limit, mass, gravity, duration;
} creep;

static const base_field fields[] = {
    BASE_FIELD(creep, mean, BASE_REAL, "N", 0.4, 0.0, 1e6, "mean load"),
    BASE_FIELD(creep, amplitude, BASE_REAL, "N", 0.4, 0.0, 1e6, "amplitude of the load"),
    BASE_FIELD(creep, frequency, BASE_REAL, "Hz", 1.0, 1e-3, 1e3, "frequency of the load"),
    BASE_FIELD(creep, limit, BASE_REAL, "N", 1.0, 1e-6, 1e9, "friction limit mu m g"),
    BASE_FIELD(creep, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass"),
    BASE_FIELD(creep, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(creep, duration, BASE_REAL, "s", 3.0, 1e-3, 1e4, "time simulated"),
};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const creep *p = param;
  const double half[2] = {0.1, 0.05}, pos[2] = {0.0, 0.05};
  spec_load *l;
  spec_check *c;
  if (p->mean + p->amplitude > 0.98 * p->limit) {
    return BASE_FAIL(err, BASE_EINVAL, "mean + amplitude = %g: need less than 0.98 of limit = %g",
                     p->mean + p->amplitude, p->limit);
  }
  kit_world(s, 2, p->gravity, p->duration, 0.01 / p->frequency);
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE;
  l->force[0] = p->mean;
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE_SINE;
  l->dir[0] = 1.0;
  l->rate = p->amplitude;
  l->omega = 2.0 * KIT_PI * p->frequency;
  s->friction.dflt = p->limit / (p->mass * p->gravity);
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, "block.x", err));
  BASE_TRY(kit_rests(s, "block.x", 1e-8, "the load never reaches the limit", err));
  /* a bristle deflects by the load's share of its saturation and comes back; a viscous law creeps
   * with that share of v_s, LuGre a little for ever (MATHEMATICS 2.3.4) */
  BASE_TRY(kit_drift(s, "block.x", 1e-9, 10.0, &c, err));
  c->tol.reg_d = 1.2;
  c->tol.reg_v = 1.2 * p->duration * (p->mean + p->amplitude) / p->limit;
  kit_source(c, "bristle: returns");
  return spec_check_only(c, "regularized", err);
}

KIT_SCENE(creep, "oscillating load below the limit", "dupont2002",
          "A load oscillates between zero and 80 percent of the friction limit. A rigid model does "
          "not move, a bristle moves elastically and returns, LuGre drifts 5 micrometres a second "
          "for ever, a viscous law creeps (MATHEMATICS B22).",
          .situation = SITUATION_OTHER);
