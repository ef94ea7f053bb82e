#include "harness/problem_source.h"

#include <stdio.h>
#include <string.h>

static bool ends_with(const char *text, const char *tail) {
  const size_t n = strlen(text);
  const size_t m = strlen(tail);
  return n >= m && strcmp(text + n - m, tail) == 0;
}

/* NAME.M.mtx -> NAME.q.mtx */
static base_status partner(const char *m_path, char *q_path, size_t cap, base_error *err) {
  const size_t n = strlen(m_path);
  if (!ends_with(m_path, ".M.mtx") || n >= cap) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: a Matrix Market problem needs --q FILE.mtx", m_path);
  }
  memcpy(q_path, m_path, n + 1);
  q_path[n - strlen("M.mtx")] = 'q';
  return BASE_OK;
}

base_status problem_source_open(const char *text, const char *q_path, problem_source *out,
                                base_error *err) {
  *out = (problem_source){0};
  (void)snprintf(out->name, sizeof out->name, "%s", text);
  if (ends_with(text, ".dat")) {
    return lcp_read_siconos(text, &out->file, err);
  }
  if (ends_with(text, ".mtx")) {
    char beside[1024];
    if (q_path == NULL) {
      BASE_TRY(partner(text, beside, sizeof beside, err));
      q_path = beside;
    }
    return lcp_read_mtx(text, q_path, &out->file, err);
  }
  return BASE_FAIL(err, BASE_EINVAL,
                   "problem '%s': need a .dat (Siconos text) or .mtx (Matrix Market) file", text);
}

void problem_source_close(problem_source *s) {
  lcp_file_problem_free(&s->file);
}
