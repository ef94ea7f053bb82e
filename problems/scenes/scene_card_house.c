/* Card house. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct card_house {
  int levels;
  double theta_deg, mu, length, thickness, gravity, duration;
} card_house;

static const base_field fields[] = {
    BASE_FIELD(card_house, levels, BASE_INT, "1", 1, 1, 20, "storeys of one pair each, on a lid"),
    BASE_FIELD(card_house, theta_deg, BASE_REAL, "deg", 65.0, 30.0, 85.0, "inclination of a card"),
    BASE_FIELD(card_house, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(card_house, length, BASE_REAL, "m", 0.09, 1e-3, 1e2, "length of a card"),
    BASE_FIELD(card_house, thickness, BASE_REAL, "m", 0.002, 1e-4, 1e1, "thickness of a card"),
    BASE_FIELD(card_house, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(card_house, duration, BASE_REAL, "s", 0.2, 1e-3, 1e2, "time simulated"),
};

/* A card whose foot is cut level and whose head is cut upright, so that both touch with faces: the
 * corner-on-corner contact of two square-cut cards has no normal. side: -1 left, 1 right. */
static base_status add_card(scene_spec *s, const card_house *p, int storey, double side, double y,
                            base_error *err) {
  const double th = kit_radians(p->theta_deg), l = p->length, w = p->thickness;
  const double foot = w / sin(th), head = w / cos(th);
  const double reach = l * cos(th), rise = l * sin(th);
  /* right card leans left: head face on x = 0 */
  const double right[4][2] = {
      {reach, y}, {reach + foot, y}, {0.0, y + rise + head}, {0.0, y + rise}};
  const double left[4][2] = {
      {-reach - foot, y}, {-reach, y}, {0.0, y + rise}, {0.0, y + rise + head}};
  char name[SPEC_NAME];
  kit_name(name, (side > 0.0) ? "right" : "left", storey);
  return kit_polygon(s, name, 1.0 / (l * w), 4, (side > 0.0) ? right : left, NULL, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const card_house *p = param;
  const double th = kit_radians(p->theta_deg);
  const double storey = p->length * sin(th) + p->thickness / cos(th);
  const double lid[2] = {p->length * cos(th) + 3.0 * p->thickness / sin(th), p->thickness / 2.0};
  char name[SPEC_NAME] = "left0", var[2 * SPEC_NAME];
  double y = 0.0;
  kit_world(s, 2, p->gravity, p->duration, 0.0025);
  for (int i = 0; i < p->levels; i++) {
    if (i > 0) {
      const double pos[2] = {0.0, y + lid[1]};
      kit_name(name, "lid", i);
      BASE_TRY(kit_box(s, name, 1.0, lid, pos, NULL, err));
      y += p->thickness;
    }
    BASE_TRY(add_card(s, p, i, -1.0, y, err));
    BASE_TRY(add_card(s, p, i, 1.0, y, err));
    kit_name(name, "left", i);
    y += storey;
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  (void)snprintf(var, sizeof var, "%s.angle", name);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  if (p->levels > 1) {
    return BASE_OK;
  }
  const double need = 0.5 / tan(th); /* thin cards: mu >= cot(theta)/2 */
  if (p->mu >= 1.3 * need) {
    return kit_rests(s, var, 1e-6, "stands: mu >= cot(theta)/2", err);
  }
  if (p->mu <= 0.7 * need) {
    BASE_TRY(kit_moves(s, var, 0.01, "slides apart: mu < cot(theta)/2", err));
    return kit_rigid_only(kit_last(s), err);
  }
  return BASE_OK;
}

KIT_SCENE(
    card_house, "card house", "baraff1994",
    "Pairs of cards lean on each other, storeys on lids. One pair of thin cards stands for mu "
    ">= cot(theta)/2. Feet and heads are cut so that they touch with faces. The classic "
    "picture of friction solvers that creep.",
    .situation = SITUATION_STACK);
