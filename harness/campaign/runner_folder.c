/* What stands where in the folder of a run. */
#include "harness/campaign/runner_state.h"
#include "harness/util/folder.h"

#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

void runner_solution_path(const runner *r, const char *id, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/solutions/%s.ans", r->o->out, id);
}

void runner_trace_path(const runner *r, const char *id, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/traces/%s.csv", r->o->out, id);
}

base_status runner_read_rows(const char *dir, record_table *out, base_error *err) {
  char path[1100];
  struct stat st;
  if (stat(dir, &st) == 0 && S_ISREG(st.st_mode)) {
    return record_table_read(dir, out, err);
  }
  folder_file(dir, "results.csv.xz", path, sizeof path);
  const bool packed = access(path, F_OK) == 0;
  folder_file(dir, "results.csv", path, sizeof path);
  if (packed && access(path, F_OK) == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: holds results.csv and results.csv.xz; need one", dir);
  }
  folder_file(dir, packed ? "results.csv.xz" : "results.csv", path, sizeof path);
  return record_table_read(path, out, err);
}

base_status runner_write_rows(const char *dir, const record_table *t, base_error *err) {
  char path[1100];
  folder_file(dir, "results.csv", path, sizeof path);
  return record_table_write(path, t, err);
}
