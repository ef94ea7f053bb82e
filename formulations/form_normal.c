/* form_normal.c - the frictionless unilateral LCP(J_n W J_n', J_n v_free + b_n): p unknowns,
 * symmetric positive semidefinite, whatever friction the scene declares. The end velocity is
 * unique; the impulses are iff the normal rows are independent. */
#include "formulations/polyhedral.h"

typedef poly_options options;

static const base_field fields[] = {
    BASE_FIELD_CHOICE(options, restitution, "newton|poisson|none", 0, "law of impact"),
    BASE_FIELD_CHOICE(options, level, "velocity|position", 0, "closed contacts, or all in margin"),
    BASE_FIELD_CHOICE(options, storage, "auto|dense|csc|factored", 0,
                      "matrix handed to the solver"),
    BASE_FIELD_CHOICE(options, activation, "closed|moreau", 0, "gap, or gap half a step ahead"),
    BASE_FIELD(options, push, BASE_REAL, "1", 0, 0, 1, "share of an overlap removed a step"),
    BASE_FIELD(options, push_speed, BASE_REAL, "m/s", 1e9, 0, 1e9, "limit of that speed"),
    BASE_FIELD(options, rest, BASE_REAL, "1", 2, 0, 1e6, "approach in steps of load: no bounce"),
    BASE_FIELD_CHOICE(options, joints, "eliminated|mixed", 0,
                      "or free rows (always when factored)"),
    BASE_FIELD(options, joint_push, BASE_REAL, "1", 0.2, 0, 1, "share of a joint error removed"),
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
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(polyhedral),
    .dimension = dimension,
    .close = poly_close,
    .begin = begin,
    .assemble = poly_assemble,
    .recover = poly_recover,
    .answer = poly_answer,
};
