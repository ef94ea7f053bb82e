/* form_velocity.c - velocity-level LCP with a faceted friction cone: no approach of closed
 * contacts at the end of the step (Anitescu & Potra 1997). Open contacts are left alone until
 * they close, so that a fall ends within one step's travel of the surface, and an overlap stays
 * unless `push` removes a share of it every step. */
#include "formulations/polyhedral.h"

typedef poly_options options;

static const base_field fields[] = {
    BASE_FIELD(options, facets, BASE_INT, "1", 4, 3, POLY_FACETS_MAX, "directions of friction"),
    BASE_FIELD_CHOICE(options, cone, "inscribed|circumscribed", 0, "facets inside the circle"),
    BASE_FIELD_CHOICE(options, restitution, "newton|poisson|none", 0, "law of impact"),
    BASE_FIELD_CHOICE(options, planar, "four|three", 0, "unknowns of a planar contact"),
    FORM_STORAGE_FIELD(options),
    FORM_ACTIVATION_FIELD(options),
    FORM_DISTRIBUTION_FIELD(options),
    FORM_PUSH_FIELDS(options, 0),
    FORM_JOINTS_FIELD(options),
    FORM_JOINT_PUSH_FIELD(options),
};

static base_status begin(void *state, const contact_set *c, const void *opt,
                         formulation_start start, base_error *err) {
  poly_options o = *(const options *)opt;
  o.level = FORM_LEVEL_VELOCITY;
  return poly_begin(state, c, &o, FORM_ROWS_ALL, start, err);
}

const formulation form_velocity = {
    .name = "velocity",
    .title = "Velocity-level polyhedral LCP",
    .cite = "anitescu1997",
    .words = "The friction cone has flat facets; velocities obey it at the end of the step.",
    .when = "The common choice for rigid bodies; more facets bring it closer to the round cone and "
            "cost unknowns.",
    .apart = "facets",
    .model = FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_POLYHEDRAL,
    .stands_for = "velocity",
    .sets = 1u << LCP_ORTHANT,
    .dimension = poly_dimension,
    .friction = poly_friction,
    POLY_FORM_PARTS,
};
