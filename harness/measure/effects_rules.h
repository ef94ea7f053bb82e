/* harness/measure/effects_rules.h - which effects no pilot may judge, from the scene alone.
 *
 * A pilot sees the first part of a run. What it did not see must not be able to happen: none of these may hold.
 *
 *   loads     a load or a driven motion may do later what it does not do yet
 *   late      two sides that do not touch at the start may come together in the run: their bounding balls are nearer than the
 *             speeds allow that all energy of the scene, in one of the bodies, would give it (v^2 = 2 E / m, E with what
 *             gravity can add in the time of the run)
 *   joints    what a joint carries is not in proportion to what it does early
 *   unstable  a body that spins has three different moments of inertia (it may turn over), some of its axes are locked, or a body that can turn does not stand on three
 *             contacts (two in the plane) of one plane, or may tip over an edge of them: its centre projects nearer to the
 *             edge than mu times its height
 *
 *   acts      at the start a closed contact has a coefficient of friction (rolling, torsion: over the size of the smallest
 *             body) above the level
 *
 * The first three forbid to leave out anything, "unstable" what turns (rotation, gyroscopic, spatial), "acts" the effect itself. */
#pragma once

#include "problems/spec/spec.h"

/* The run that is judged: contacts are those at the start of a step of h. */
typedef struct effects_span {
  double h, duration; /* [s] */
  double level;       /* E [1] */
} effects_span;

typedef struct effects_verdict {
  const char *all;           /* the rule that forbids everything; NULL: none does */
  unsigned unstable, acting; /* EFFECT_ bits that these forbid */
} effects_verdict;

base_status effects_rules(const scene_spec *spec, const effects_span *span, effects_verdict *out,
                          base_error *err);

/* The rule that keeps an effect (one EFFECT_ bit) in, NULL: a pilot may judge it. */
const char *effects_rule(const effects_verdict *v, unsigned bit);
