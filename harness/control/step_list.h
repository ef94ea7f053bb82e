/* harness/control/step_list.h - the lengths of the steps of a run, and how each is taken. */
#pragma once

#include "harness/measure/simulate.h"

/* How a step is taken: bits. STEP_MET is not written to files: in this step, or in this half and the one before it, other contacts carry than at
 * the start. */
enum {
  STEP_TURNED = 1,       /* its contacts are world_contacts_turned */
  STEP_EXTRAPOLATED = 2, /* one step of h and two of h/2 (extrapolation.h) */
  STEP_MET = 4
};

typedef struct step_list {
  double *h;          /* [s]; owned */
  unsigned char *way; /* STEP_; owned */
  long n, cap, n_turned, n_extrapolated;
} step_list;

base_status step_list_append(step_list *l, double h, unsigned way, base_error *err);

/* Of a file: one length a line [s], with the words `turned` and `extrapolated` behind it where it is; BASE_EINVAL names the line. The
 * last one must reach the end of the run, and begin before it, as the last of even steps does. */
base_status step_list_read(step_list *l, const char *path, double duration, base_error *err);
base_status step_list_write(const step_list *l, const char *path, base_error *err);
void step_list_close(step_list *l);
/* The time that its steps take [s]; *whole: `duration` ends in the last one, as a file of them has to have it. */
double step_list_length(const step_list *l, double duration, bool *whole);

/* As simulate() with these steps, which are those of the request. BASE_EUNSUPPORTED: extrapolated ones with a plan of effects, or
 * with answers stored or replayed. */
base_status step_list_run(const sim_request *q, const step_list *l, series *record, sim_result *out,
                          base_error *err);
/* The start of a run whose limit came before its first step: files and record are of that, the outcome is what *out says. */
base_status step_list_run_none(const sim_request *q, series *record, sim_result *out,
                               base_error *err);
