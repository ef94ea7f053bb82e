/* harness/measure/own_answers.h - what a solver answered by itself where another of the right answers was chosen, by contact.
 *
 * Of redundant contacts the choice (lcp/share) loads all, so that the rows it leaves active are dependent: no basis. A method
 * that starts from a basis would have to make one of them, in every step. It starts from its own last one instead, at each
 * contact where the formulation's start point has the support of what was chosen. Such starts are an affair of the solver;
 * the choice goes on from the start point. */
#pragma once

#include "formulations/contact_memory.h"
#include "formulations/formulation.h"

typedef struct own_answers {
  contact_memory memory; /* of a contact: its unknowns, own values, chosen values */
  bool fresh;            /* nothing was noted in this step yet */
} own_answers;

void own_answers_step(own_answers *o); /* a step begins */

/* z, the start point of a problem with these rows: the solver's own answer where the chosen one has the same support. */
void own_answers_start(const own_answers *o, const formulation_rows *rows, double *z);

/* The solver's answer to the problem with these rows, and what was chosen in its place; both the same where nothing was.
 * BASE_ENOMEM. */
base_status own_answers_note(own_answers *o, const formulation_rows *rows, const double *own,
                             const double *chosen, base_error *err);
void own_answers_close(own_answers *o);
