/* What stands where in the folder of a run. */
#include "harness/campaign/runner_state.h"
#include "harness/util/folder.h"

#include <stdio.h>

void runner_solution_path(const runner *r, const char *id, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/solutions/%s.ans", r->o->out, id);
}

void runner_trace_path(const runner *r, const char *id, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/traces/%s.csv", r->o->out, id);
}

base_status runner_read_rows(const char *dir, record_table *out, base_error *err) {
  char path[1100];
  folder_file(dir, "results.csv", path, sizeof path);
  return record_table_read(path, out, err);
}

base_status runner_write_rows(const char *dir, const record_table *t, base_error *err) {
  char path[1100];
  folder_file(dir, "results.csv", path, sizeof path);
  return record_table_write(path, t, err);
}
