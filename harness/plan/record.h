/* harness/plan/record.h - one row of results.csv: one repetition of one cell. results/FORMAT.md explains
 * every column; this list is the only place in the code that knows their order. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* T(column, length): text; I(column): integer; R(column): real; B(column): true or false.
 * Not measured is empty: "", INT64_MIN, NaN, -1. */
/* clang-format off */
#define RECORD_COLUMNS(T, I, R, B)                                                                 \
  I(schema)                                                                                        \
  T(campaign, 48) T(part, 48) T(cell_id, 24) I(process) I(rep) I(order)                            \
  T(problem_family, 64) T(problem, 320) T(problem_sha256, 72) I(seed)                              \
  T(formulation, 32) T(formulation_options, 320) T(formulation_config, 480) T(model, 160)          \
  T(solver, 32) T(solver_options, 320) T(solver_config, 480) T(solver_variant, 32)                 \
  T(solver_version, 24)                                                                            \
  R(step_s) R(duration_s) T(start, 16) T(contact_order, 24) T(islands, 8) T(effects, 200) T(effects_auto, 1600) R(tol) I(threads)      \
  B(quick) T(cache, 8)                                                                             \
  I(n_bodies) I(n_dof) I(n_contacts) I(n_active) I(lcp_dim) I(n_island) I(largest_island) I(nnz) R(density) T(storage, 16)       \
  R(t_contacts_s) R(t_assemble_s) R(t_setup_s) R(t_factor_s) R(t_solve_s) R(t_share_s) R(t_advance_s) R(t_watch_s) \
  R(t_total_s) R(t_step_s) R(t_step_max_s) R(t_step_p50_s) R(t_step_p95_s) R(t_step_p99_s)         \
  R(share_1ms) R(share_4ms) R(share_16ms) R(t_cpu_s) I(n_inner) R(t_limit_s) R(mem_limit_B)                       \
  I(n_steps) I(n_solves) I(n_unsolved) I(n_iter) I(n_pivot) I(n_matvec) I(n_factor)                \
  I(n_linesearch) I(n_evaluations) I(n_modes) I(n_fallback)  \
  R(active_change) I(regressions) I(regressions_time)                                              \
  I(uniqueness) I(n_shared) I(n_share_missed) R(workspace_B) R(rss_peak_B)                            \
  T(status, 16) T(status_claimed, 16) B(verified) I(exit_signal) T(note, 240) T(flags, 120)        \
  I(metric_version)                                                                                \
  R(rho) R(res_natural) R(res_natural_rel) R(res_feas_z) R(res_feas_w) R(res_comp)                 \
  R(res_ncp) R(res_ncp_rel) R(res_cone) R(dissipation_gap_J) R(penetration_m) R(approach_m) R(energy_defect_J) \
  R(energy_drift_rel) R(stiffness_ratio) R(v_slip) R(deflection_m)                                 \
  R(err_ref) T(err_quantity, 80) R(err_predicted) R(err_tol) T(err_source, 160) R(err_worst)       \
  T(end_quantity, 64) R(end_value)                                                                 \
  I(n_predictions) I(n_predictions_missed) T(missed, 160) T(effects_seen, 200)                     \
  T(solution_hash, 24)                                                                             \
  T(host, 64) T(host_class, 160) T(cpu_set, 16) I(mem_node) R(freq_MHz) I(ctx_invol) I(major_faults) R(load1) R(load_other) \
  B(throttled) R(canary_s) T(trace, 48) T(started_utc, 24) T(suite_commit, 48) B(suite_dirty)      \
  T(build_hash, 24) T(base_hash, 24)                                                                                \
  T(command, 1200)
/* clang-format on */

#define RECORD_TEXT_(name, len) char name[len];
#define RECORD_INT_(name)       int64_t name;
#define RECORD_REAL_(name)      double name;
#define RECORD_BOOL_(name)      int8_t name;
typedef struct record {
  RECORD_COLUMNS(RECORD_TEXT_, RECORD_INT_, RECORD_REAL_, RECORD_BOOL_)
} record;

enum { RECORD_SCHEMA = 1, RECORD_METRIC = 2, RECORD_ROW = 8192 };

void record_clear(record *r); /* everything not measured */

/* The header line, and a row, with the newline. Returns the length; false if it does not fit. */
size_t record_header(char *buf, size_t cap);
size_t record_row(const record *r, char *buf, size_t cap);

/* Parses a row (without the newline) written under the same header. */
base_status record_parse(const char *row, record *r, base_error *err);

int record_columns(void);
const char *record_column(int i);

/* A real column by name; NaN where not measured or no such column. */
double record_real(const record *r, const char *name);
bool record_has_real(const char *name);

/* Adds a word to the row's flags, once. */
void record_flag(record *r, const char *word);
bool record_has_flag(const record *r, const char *word);

/* All rows of a results.csv (or .csv.xz, packed), by the names in its header: columns this version does not know are left
 * out, columns the file lacks are not measured, and `foreign` tells of either; rows of another schema
 * number are refused. A last line without its newline (a run killed while writing) is left out with
 * the rows of its process, and reported in torn. */
typedef struct record_table {
  record *row; /* owned */
  int n, cap;
  bool torn, foreign;
} record_table;
base_status record_table_read(const char *path, record_table *out, base_error *err);
base_status record_table_append(record_table *t, const record *r, base_error *err);
/* Writes all rows to path, whole or not at all. */
base_status record_table_write(const char *path, const record_table *t, base_error *err);
/* A row of a table that is sorted by something. */
typedef struct row_ref {
  const record *r;
} row_ref;

/* All rows, those of one cell together and in their order; an array of n, to be freed. */
base_status record_table_by_cell(const record_table *t, row_ref **out, base_error *err);
/* How many of the first of these n > 0 rows are of the same cell. */
int record_same_cell(const row_ref *row, int n);
void record_table_free(record_table *t);
