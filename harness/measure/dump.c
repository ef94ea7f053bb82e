#include "harness/measure/dump.h"

#include "harness/measure/export_lcp.h"
#include "harness/measure/solve_once.h"
#include "harness/util/folder.h"
#include "lcp/base/fields.h"
#include "lcp/io/lcp_read.h"

#include <string.h>

base_status dump_range(const char *text, long *first, long *last, base_error *err) {
  char from[16];
  const char *colon = strchr(text, ':');
  const size_t n = (colon != NULL) ? (size_t)(colon - text) : strlen(text);
  int a = 0;
  int b = 0;
  bool good = n < sizeof from;
  if (good) {
    memcpy(from, text, n);
    from[n] = '\0';
    good = base_parse_int(from, &a) && a >= 1;
    b = a;
  }
  if (good && colon != NULL) {
    good = base_parse_int(colon + 1, &b) && b >= a;
  }
  *first = a;
  *last = b;
  return good ? BASE_OK
              : BASE_FAIL(err, BASE_EINVAL, "step %s: need N or A:B with 1 <= A <= B", text);
}

base_status dump_open(dump *d, const char *folder, long first, long last, base_error *err) {
  char path[1100];
  *d = (dump){.folder = folder, .first = first, .last = last};
  BASE_TRY(folder_make(folder, err));
  folder_file(folder, "index.csv", path, sizeof path);
  BASE_TRY(base_out_open(&d->index, path, err));
  (void)fputs("step,solve,n,nnz,status,problem,answer\n", d->index.to);
  return BASE_OK;
}

base_status dump_files(const char *folder, long step, int solve, const lcp_problem *p,
                       const double *z, char file[DUMP_NAME], char answer[DUMP_NAME],
                       base_error *err) {
  char path[1100];
  const unsigned sets = lcp_problem_sets(p);
  const bool plain = sets == 1u << LCP_ORTHANT;
  const int used = snprintf(file, DUMP_NAME, "step_%06ld_%02d", step, solve);
  (void)snprintf(answer, DUMP_NAME, "%s.z.mtx", file);
  const bool boxes = (sets & 1u << LCP_BOX) != 0;
  const char *end = boxes ? ".npz" : ".dat";
  (void)snprintf(path, sizeof path, "%.1000s/%s%s", folder, file, plain ? "" : end);
  (void)snprintf(file + used, DUMP_NAME - (size_t)used, "%s", plain ? ".M.mtx" : end);
  const base_status done = plain                          ? export_lcp_mtx(p, path, err)
                           : boxes                        ? lcp_write_npz(path, p, err)
                           : (sets & 1u << LCP_FREE) != 0 ? export_lcp_text(p, path, err)
                                                          : export_lcp_friction(p, path, err);
  if (done == BASE_EUNSUPPORTED && err != NULL) { /* the caller asked for what no file can hold */
    const base_error why = *err;
    return BASE_FAIL(err, BASE_EINVAL, "step %ld: %.300s", step, why.text);
  }
  BASE_TRY(done);
  (void)snprintf(path, sizeof path, "%.1000s/%s", folder, answer);
  return lcp_write_mtx_vector(path, p->M.n, z, err);
}

base_status dump_problem(dump *d, long step, const lcp_problem *p, const double *z,
                         const char *status, base_error *err) {
  if (step < d->first || step > d->last) {
    return BASE_OK;
  }
  char file[DUMP_NAME];
  char answer[DUMP_NAME];
  d->solve = (step == d->step) ? d->solve + 1 : 1;
  d->step = step;
  BASE_TRY(dump_files(d->folder, step, d->solve, p, z, file, answer, err));
  (void)fprintf(d->index.to, "%ld,%d,%d,%ld,%s,%s,%s\n", step, d->solve, p->M.n,
                lcp_matrix_entries(&p->M), status, file, answer);
  d->n_dumped++;
  return BASE_OK;
}

base_status dump_close(dump *d, bool complete, base_error *err) {
  BASE_TRY(base_out_close(&d->index, true, err));
  if (complete && d->n_dumped == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--dump-step %ld:%ld: no problem was posed in these steps",
                     d->first, d->last);
  }
  return BASE_OK;
}
