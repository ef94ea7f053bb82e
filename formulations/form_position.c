/* form_position.c - position-level LCP with a faceted friction cone: the linearised gap at the end
 * of the step stays non-negative, gap + h (J_n v+ + drift) >= 0, over all contacts within the
 * margin (Stewart & Trinkle 1996). A fall ends on the surface. An impact takes two steps: the first
 * closes the gap; the second comes to rest, or with restitution=two_steps rebounds with e times the
 * speed of the approach (Newton's law, one step late; MATHEMATICS 2.2). Energy then falls in the first and is
 * given back in the second, which an observer of single steps sees as a gain. An overlap is pushed
 * out in one step, by the velocity, or where that would give energy or has no solution beside the motion
 * (polyhedral/polyhedral_push.c); `push` and `push_speed` bound it. */
#include "formulations/polyhedral.h"

typedef poly_options options;

static const base_field fields[] = {
    BASE_FIELD(options, facets, BASE_INT, "1", 4, 3, POLY_FACETS_MAX, "directions of friction"),
    BASE_FIELD_CHOICE(options, cone, "inscribed|circumscribed", 0, "facets inside the circle"),
    BASE_FIELD_CHOICE(options, restitution, "none|two_steps", 0,
                      "rebound in the step after impact"),
    BASE_FIELD_CHOICE(options, planar, "four|three", 0, "unknowns of a planar contact"),
    FORM_STORAGE_FIELD(options),
    FORM_DISTRIBUTION_FIELD(options),
    FORM_PUSH_FIELDS(options, 1),
    FORM_JOINTS_FIELD(options),
    FORM_JOINT_PUSH_FIELD(options),
};

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  poly_options o = *(const options *)opt;
  o.level = FORM_LEVEL_POSITION;
  o.restitution = (o.restitution == 1) ? POLY_TWO_STEPS : POLY_INELASTIC;
  o.activation = FORM_CLOSED;
  return poly_begin(state, c, &o, FORM_ROWS_ALL, start, err);
}

const formulation form_position = {
    .name = "position",
    .title = "Position-level polyhedral LCP",
    .cite = "stewart1996",
    .words = "The friction cone has flat facets; gaps, not velocities, are closed at the end of "
             "the step.",
    .when = "Bodies must not sink into each other, and nothing rebounds.",
    .apart = "facets",
    .model = FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_POLYHEDRAL | FORM_POSITION,
    .stands_for = "position",
    .sets = 1u << LCP_ORTHANT,
    .dimension = poly_dimension,
    .friction = poly_friction,
    POLY_FORM_PARTS,
};
