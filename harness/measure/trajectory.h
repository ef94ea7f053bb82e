/* harness/measure/trajectory.h - a run as CSV for pictures and for other programs: first what there is
 * (shapes, vertices, planes), then per step the pose of every body and the force in every contact.
 * Columns: results/FORMAT.md. */
#pragma once

#include "formulations/formulation.h"
#include "problems/world/world.h"

#include <stdio.h>

/* `to` may be NULL in all of them: nothing is written. */
base_status trajectory_header(FILE *to, const scene_spec *spec, base_error *err);
base_status trajectory_row(FILE *to, const world *w, base_error *err);

/* Contacts of the step that has just been taken; mode as in formulation_answer, or NULL. */
base_status trajectory_contacts(FILE *to, const world *w, const contact_set *set,
                                const unsigned char *mode, base_error *err);
