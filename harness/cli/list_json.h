/* harness/cli/list_json.h - components as whole JSON objects, for tools that build on them. */
#pragma once

#include "formulations/formulation.h"
#include "lcp/lcp_solver.h"
#include "problems/scenes/scene.h"

#include <jansson.h>

/* What a solver declares beyond its row of the table: words and when (a sentence each), exact, warm,
 * peer (another project's code), sets (of blocks it takes). */
void list_solver_more(json_t *o, const lcp_solver *s);

/* What a formulation declares beyond its row: words and when, apart (options of which every value is a
 * curve of its own), model (what of Coulomb's law it keeps, in the words of the rows' column), the
 * same as traits: polyhedral, compliant, normal_only, frictionless, forces (not impulses); solver
 * (whether it poses problems to one), sets (of blocks in them), lacks (effects that it cannot simulate; coordinates:
 * scenes without bodies). */
void list_formulation_more(json_t *o, const formulation *f);

/* A built-in scene: name, title, about, cite, situation (empty: none), redundant, solvable (false: no
 * rigid motion exists), parameters, and, as it is with the defaults of its parameters: dim, duration_s, step_s, bodies, effects, observables
 * [{name, unit}], predictions [{quantity, unit, time_s, value, tolerance {abs, h, ...}, formulations, source}] (times and values null where the
 * check has none; formulations empty: all of them). */
base_status list_scene_json(const scene *s, json_t **out, base_error *err);
