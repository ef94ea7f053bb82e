/* harness/trajectory.h - body poses over time as CSV, one row per body and step. */
#pragma once

#include "problems/world.h"

#include <stdio.h>

/* `to` may be NULL: nothing is written. */
base_status trajectory_header(FILE *to, base_error *err);
base_status trajectory_row(FILE *to, const scene_spec *spec, const world *w, base_error *err);
