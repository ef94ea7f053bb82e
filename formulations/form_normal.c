/* form_normal.c - the frictionless unilateral LCP(J_n W J_n', J_n v_free + b_n): p unknowns,
 * symmetric positive semidefinite, whatever friction the scene declares. The end velocity is
 * unique; the impulses are iff the normal rows are independent. */
#include "formulations/polyhedral.h"

typedef poly_options options;

static const base_field fields[] = {
    BASE_FIELD_CHOICE(options, restitution, "newton|poisson|none", 0, "law of impact"),
    BASE_FIELD_CHOICE(options, level, "velocity|position", 0, "closed contacts, or all in margin"),
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
  o.facets = 3;
  o.cone = 0;
  o.planar = POLY_FOUR;
  return poly_begin(state, c, &o, FORM_ROWS_NORMAL, start, err);
}

static long dimension(int dim, int p, const void *opt) {
  (void)dim;
  (void)opt;
  return p;
}

const formulation form_normal = {
    .name = "normal",
    .title = "Frictionless unilateral LCP",
    .cite = "lotstedt1982; moreau1988",
    .words = "Contacts push but do not rub.",
    .when = "There is no friction, or its price is asked for: the same scene without it.",
    .model = FORM_NORMAL_ONLY | FORM_UNILATERAL,
    .stands_for = NULL,
    .sets = 1u << LCP_ORTHANT,
    .dimension = dimension,
    POLY_FORM_PARTS,
};
