#include "harness/measure/trace.h"

#include "lcp/base/fields.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { TRACE_POINTS = 200000 }; /* of one solve */

base_status trace_open(trace_file *t, const char *path, base_error *err) {
  *t = (trace_file){.buffer.cap = TRACE_POINTS};
  t->buffer.iteration = malloc(TRACE_POINTS * sizeof *t->buffer.iteration);
  t->buffer.residual = malloc(TRACE_POINTS * sizeof *t->buffer.residual);
  base_status done = BASE_OK;
  if (t->buffer.iteration == NULL || t->buffer.residual == NULL) {
    done = BASE_FAIL(err, BASE_ENOMEM, "no memory for a history of %d points", TRACE_POINTS);
  } else {
    done = base_out_open(&t->file, path, err);
  }
  if (done == BASE_OK && fputs("solve,iteration,residual\n", t->file.to) == EOF) {
    done = BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  if (done != BASE_OK) {
    return trace_finish(t, done, err);
  }
  return done;
}

lcp_trace *trace_begin(trace_file *t) {
  t->buffer.len = 0;
  return &t->buffer;
}

base_status trace_end(trace_file *t, base_error *err) {
  char number[32];
  bool good = true;
  t->solves++;
  for (int i = 0; good && i < t->buffer.len; i++) {
    base_real_print(t->buffer.residual[i], number, sizeof number);
    good = fprintf(t->file.to, "%ld,%ld,%s\n", t->solves, t->buffer.iteration[i], number) > 0;
  }
  t->points += t->buffer.len;
  t->full = t->full || t->buffer.len == t->buffer.cap;
  return good ? BASE_OK : BASE_FAIL(err, BASE_EIO, "%s: could not be written", t->file.path);
}

base_status trace_finish(trace_file *t, base_status done, base_error *err) {
  free(t->buffer.iteration);
  free(t->buffer.residual);
  t->buffer = (lcp_trace){0};
  return base_out_finish(&t->file, done, err);
}
