#include "harness/problem_source.h"

#include "problems/family.h"
#include "problems/import/import.h"

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

static base_status open_mtx(const char *text, const char *q_path, problem_source *out,
                            base_error *err) {
  char beside[1024];
  if (q_path == NULL) {
    BASE_TRY(partner(text, beside, sizeof beside, err));
    q_path = beside;
  }
  out->p = &out->file.p;
  return lcp_read_mtx(text, q_path, &out->file, err);
}

static base_status open_import(const char *text, int facets, problem_source *out, base_error *err) {
  import_kind kind;
  BASE_TRY(import_detect(text, &kind, err));
  if (kind == IMPORT_UNKNOWN || kind == IMPORT_LCP) { /* the reader says what is wrong, and where */
    out->p = &out->file.p;
    return lcp_read_siconos(text, &out->file, err);
  }
  out->p = &out->known.p;
  return import_problem(text, facets, &out->known, err);
}

base_status problem_source_open(const char *text, const char *q_path, int facets,
                                problem_source *out, base_error *err) {
  *out = (problem_source){0};
  (void)snprintf(out->name, sizeof out->name, "%s", text);
  if (ends_with(text, ".mtx")) {
    return open_mtx(text, q_path, out, err);
  }
  if (ends_with(text, ".dat") || ends_with(text, ".hdf5") || ends_with(text, ".h5")) {
    return open_import(text, facets, out, err);
  }
  char name[64];
  (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(text, ":"), text);
  if (lcp_family_find(name) == NULL) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "problem '%s': need a family (lcpbench list problems) or a file .dat, .mtx, "
                     ".hdf5",
                     text);
  }
  out->p = &out->known.p;
  return lcp_family_load(text, &out->known, err);
}

void problem_source_close(problem_source *s) {
  lcp_file_problem_free(&s->file);
  known_lcp_free(&s->known);
  s->p = NULL;
}
