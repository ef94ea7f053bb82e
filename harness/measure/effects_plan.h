/* harness/measure/effects_plan.h - which effects a run simulates, and from which step on.
 *
 *   TEXT             as effects_override takes it: declared, all, or -NAME,+NAME,...
 *   TEXT/12:TEXT     the second from the 13th step on, when 12 steps are done
 *
 * With +sleep among the words of the first text bodies that lie still sleep until something comes near, or the effects change
 * (world_fall_asleep), in all of the run.
 *
 * `--effects auto:E` ends in such a text, and a run with that text has its bits. An effect that comes in finds the bodies
 * where they are; what an effect moved that goes out stands still. The first step after a change starts cold where the
 * rows of the contacts are others. */
#pragma once

#include "problems/spec/spec.h"

enum { EFFECTS_SPANS = 16, EFFECTS_TEXT = 1600 };

typedef struct effects_span {
  long from; /* steps done before it */
  unsigned effects;
} effects_span;

typedef struct effects_plan {
  int n; /* at least 1 in use; the first from 0, ascending */
  effects_span span[EFFECTS_SPANS];
  bool sleep; /* bodies that lie still do */
} effects_plan;

/* BASE_EINVAL names the word or the step that is wrong. */
base_status effects_plan_parse(unsigned declared, const char *text, effects_plan *out,
                               base_error *err);
/* The text that gives the plan for these declared effects. */
void effects_plan_print(const effects_plan *p, unsigned declared, char text[EFFECTS_TEXT]);
/* Everything that is simulated at some time. */
unsigned effects_plan_union(const effects_plan *p);
/* The effects of the step that follows `done` steps. */
unsigned effects_plan_at(const effects_plan *p, long done);
