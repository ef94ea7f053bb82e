/* harness/sequence/sequence_source.h - a sequence from the text a user gives: the folder of an exported one, or
 * SCENE@FORMULATION@SOLVER@STEP@COUNT, the problems that so many steps of that run pose, solved by that solver. */
#pragma once

#include "harness/sequence/sequence.h"

/* The parts of the second form; q's texts, h and count are set. */
typedef struct sequence_text {
  char scene[SEQUENCE_TEXT], formulation[SEQUENCE_TEXT], solver[SEQUENCE_TEXT];
  double h; /* [s] */
  long count;
} sequence_text;

bool sequence_is_text(const char *text); /* has it four @? */
bool sequence_is(const char *text);      /* that, or a folder with a manifest */

/* BASE_EINVAL with what is wrong: a text that is too long, a step or a count that is no number above 0. */
base_status sequence_text_parse(const char *text, sequence_text *out, base_error *err);

/* Runs the scene from rest to the last step, or to the first that cannot be taken; what came of it is in status, steps and note
 * of *out, which the caller owns whatever is returned. Errors: what scene, formulation and solver say of their texts;
 * BASE_EUNSUPPORTED: no problem was posed. */
base_status sequence_pose(const sequence_text *t, sequence *out, base_error *err);

/* Either form. */
base_status sequence_open(const char *text, sequence *out, base_error *err);
