/* Card house. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct card_house {
  int levels, pairs;
  double theta_deg, mu, length, thickness, gravity, duration;
} card_house;

static const base_field fields[] = {
    BASE_FIELD(card_house, levels, BASE_INT, "1", 1, 1, 20, "storeys, each on a lid"),
    BASE_FIELD(card_house, pairs, BASE_INT, "1", 1, 1, 20,
               "pairs of cards below; each storey has one less, and at least one"),
    BASE_FIELD(card_house, theta_deg, BASE_REAL, "deg", 65.0, 30.0, 85.0, "inclination of a card"),
    BASE_FIELD(card_house, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(card_house, length, BASE_REAL, "m", 0.09, 1e-3, 1e2, "length of a card"),
    BASE_FIELD(card_house, thickness, BASE_REAL, "m", 0.002, 1e-4, 1e1, "thickness of a card"),
    BASE_FIELD(card_house, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(card_house, duration, BASE_REAL, "s", 0.2, 1e-3, 1e2, "time simulated"),
};

/* A card whose foot is cut level and whose head is cut upright, so that both touch with faces: the
 * corner-on-corner contact of two square-cut cards has no normal. Heads meet at x. side: -1 left, 1 right. */
static base_status add_card(scene_spec *s, const card_house *p, int pair, double side, double x,
                            double y, base_error *err) {
  const double th = kit_radians(p->theta_deg), l = p->length, w = p->thickness;
  const double foot = w / sin(th), head = w / cos(th);
  const double reach = l * cos(th), rise = l * sin(th);
  /* right card leans left: head face on x */
  const double right[4][2] = {
      {x + reach, y}, {x + reach + foot, y}, {x, y + rise + head}, {x, y + rise}};
  const double left[4][2] = {
      {x - reach - foot, y}, {x - reach, y}, {x, y + rise}, {x, y + rise + head}};
  char name[SPEC_NAME];
  kit_name(name, (side > 0.0) ? "right" : "left", pair);
  return kit_polygon(s, name, 1.0 / (l * w), 4, (side > 0.0) ? right : left, NULL, err);
}

static int pairs_of(const card_house *p, int storey) {
  return (storey < p->pairs) ? p->pairs - storey : 1;
}

/* Between the heads of neighbours: their feet stay a card's thickness apart. */
static double spacing(const card_house *p) {
  const double th = kit_radians(p->theta_deg);
  return 2.0 * (p->length * cos(th) + p->thickness / sin(th)) + p->thickness;
}

/* Over all heads of the storey below, and as wide as the feet of a pair where there is one head only: such a lid balances. */
static base_status add_lid(scene_spec *s, const card_house *p, int storey, double y,
                           base_error *err) {
  const double th = kit_radians(p->theta_deg);
  const int below = pairs_of(p, storey - 1);
  const double reach = (below > 1) ? (below - 1) * spacing(p) / 2.0 : p->length * cos(th);
  const double half[2] = {reach + 3.0 * p->thickness / sin(th), p->thickness / 2.0};
  const double pos[2] = {0.0, y + half[1]};
  char name[SPEC_NAME];
  kit_name(name, "lid", storey);
  return kit_box(s, name, 1.0, half, pos, NULL, err);
}

static base_status add_storey(scene_spec *s, const card_house *p, int storey, int *pair, double y,
                              base_error *err) {
  const int n = pairs_of(p, storey);
  for (int j = 0; j < n; j++) {
    const double x = (j - (n - 1) / 2.0) * spacing(p);
    BASE_TRY(add_card(s, p, *pair, -1.0, x, y, err));
    BASE_TRY(add_card(s, p, *pair, 1.0, x, y, err));
    *pair += 1;
  }
  return BASE_OK;
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const card_house *p = param;
  const double th = kit_radians(p->theta_deg);
  const double storey = p->length * sin(th) + p->thickness / cos(th);
  char name[SPEC_NAME], var[2 * SPEC_NAME];
  double y = 0.0;
  int pair = 0;
  kit_world(s, 2, p->gravity, p->duration, 0.0025);
  for (int i = 0; i < p->levels; i++) {
    if (i > 0) {
      BASE_TRY(add_lid(s, p, i, y, err));
      y += p->thickness;
    }
    BASE_TRY(add_storey(s, p, i, &pair, y, err));
    y += storey;
  }
  kit_name(name, "left", pair - 1);
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  (void)snprintf(var, sizeof var, "%s.angle", name);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  /* A foot carries V + w under V on its head: it needs cot(theta) (V + w/2)/(V + w). */
  if (p->levels > 1) {
    return (p->pairs >= p->levels && p->mu >= 1.05 / tan(th))
               ? kit_rests(s, var, 1e-6, "stands: mu >= cot(theta), no lid on one head", err)
               : BASE_OK;
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
    ">= cot(theta)/2. Feet and heads are cut so that they touch with faces. Where every storey "
    "has a pair less than the one below (pairs = levels) the house stands; where a lid "
    "rests on the heads of one pair it balances, and what rounding begins grows by e in a "
    "twenty-fifth of a second. The classic picture of friction solvers that creep.",
    .situation = SITUATION_STACK);
