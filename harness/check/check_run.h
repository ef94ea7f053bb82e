/* harness/check/check_run.h - runs the cases of a case file with everything that applies, each in its
 * own process, and reports one outcome per check. */
#pragma once

#include "harness/cell/isolate.h"
#include "harness/check/check_report.h"
#include "harness/measure/registry.h"
#include "problems/read/case_file.h"

enum { CHECK_CHOICES = 48 };

typedef struct check_plan {
  const char *id_glob; /* "*": all */
  int n_solver, n_form;
  bool default_solvers; /* none was asked for: all for LCPs, check_default_solver for scenes */
  solver_choice solver[CHECK_CHOICES];
  formulation_choice form[CHECK_CHOICES];
  double step; /* [s]; 0: the steps of the file */
  isolate_limits limits;
  check_report *report;
} check_plan;

/* One LCP case (a member of the file's "lcp" list) with every solver of the plan. */
base_status check_lcp_case(const check_plan *plan, const lcp_case *c, base_error *err);

/* One scene with every formulation and solver of the plan, at each of its steps, as declared and
 * with each effect switched off that the scene makes a statement about. */
base_status check_scene_case(const check_plan *plan, const scene_spec *spec, base_error *err);

/* Two scenes that must agree ("equivalences" of the file). */
base_status check_equivalence(const check_plan *plan, const case_equivalence *e,
                              const scene_file *scenes, base_error *err);

/* Why a scene is not for this formulation, by the file's own word; NULL: it is. */
const char *check_not_applicable(const scene_spec *spec, const formulation_choice *form);

/* What the scene declares and the model lacks; NULL: nothing. Such a run is made all the same, and has
 * to end with an honest status and finite numbers, which are compared by checks that name the
 * formulation only. */
const char *check_limit(const scene_spec *spec, const formulation_choice *form);

/* The solver that a scene is run with where none was asked for: a finite method on the sets that the
 * formulation poses (lemke on orthants, ppm on boxes), nsgs on cones. */
const char *check_default_solver(const scene_spec *spec, const formulation_choice *form);

/* A case that an option out of a formulation's range keeps from running: skipped. */
void check_skip(const check_plan *plan, const char *id, const char *reason);
/* A case that cannot be run for want of something in `problems` (a shape, an effect, a load, a gap
 * function) or because it is wrong: failed, never skipped. */
void check_refuse(const check_plan *plan, const char *id, const char *reason);

bool check_selected(const check_plan *plan, const char *id);

/* Runs body in a child and adds what it emits to the report; a death is one failed outcome that
 * starts from `blank`. */
base_status check_isolated(const check_plan *plan, const check_outcome *blank,
                           void (*body)(void *ctx, isolate_channel *c), void *ctx, base_error *err);
