#include "harness/measure/problem_source.h"

#include "lcp/base/fields.h"
#include "lcp/base/input.h"
#include "problems/families/family.h"
#include "problems/import/import.h"

#include <stdio.h>
#include <string.h>

static bool ends_with(const char *text, const char *tail) {
  const size_t n = strlen(text);
  const size_t m = strlen(tail);
  return n >= m && strcmp(text + n - m, tail) == 0;
}

bool problem_is_import(const char *path) {
  return ends_with(path, ".dat") || ends_with(path, ".hdf5") || ends_with(path, ".h5");
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

/* What standard input holds, whose name does not tell. */
static base_status sniff(char begin[16], base_error *err) {
  FILE *f;
  BASE_TRY(base_in_open("-", &f, err));
  const size_t got = fread(begin, 1, 15, f);
  begin[got] = '\0';
  (void)fclose(f);
  return BASE_OK;
}

static base_status open_npz(const char *text, problem_source *out, base_error *err) {
  out->p = &out->file.p;
  return lcp_read_npz(text, &out->file, err);
}

static base_status open_import(const char *text, int facets, problem_source *out, base_error *err) {
  import_kind kind;
  BASE_TRY(import_detect(text, &kind, err));
  if (kind == IMPORT_UNKNOWN || kind == IMPORT_LCP) { /* the reader says what is wrong, and where */
    out->p = &out->file.p;
    return lcp_read_siconos(text, &out->file, err);
  }
  out->p = &out->import.posed.p;
  return import_pose(text, facets, &out->import, err);
}

/* A friction problem's file may have its facets behind it. */
static bool is_import_text(const char *text) {
  return problem_is_import(text) || strstr(text, ".dat:") != NULL ||
         strstr(text, ".hdf5:") != NULL || strstr(text, ".h5:") != NULL;
}

bool problem_is_file(const char *text) {
  return ends_with(text, ".mtx") || ends_with(text, ".npz") || is_import_text(text);
}

base_status problem_file(const char *text, char *path, size_t cap, int *facets, base_error *err) {
  static const char key[] = ":facets=";
  const char *at = strstr(text, key);
  *facets = 0;
  (void)snprintf(path, cap, "%.*s", (int)(at != NULL ? at - text : (ptrdiff_t)strlen(text)), text);
  if (at == NULL || !problem_is_import(path)) {
    (void)snprintf(path, cap, "%s", text);
    return BASE_OK;
  }
  if (!base_parse_int(at + strlen(key), facets) || *facets < 2) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: facets: need at least 2", text);
  }
  return BASE_OK;
}

static base_status no_facets(const char *text, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%s: facets: it is no friction problem", text);
}

static base_status open_file(const char *text, int facets, problem_source *out, base_error *err) {
  char path[1024];
  int own;
  BASE_TRY(problem_file(text, path, sizeof path, &own, err));
  if (own != 0 && facets != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: facets are given twice", text);
  }
  BASE_TRY(open_import(path, own + facets, out, err));
  return (own + facets == 0 || out->import.cone.p.M.n > 0) ? BASE_OK : no_facets(text, err);
}

bool problem_source_has_cone(const problem_source *s) {
  return s->import.cone.p.M.n > 0 ||
         (s->p == &s->import.posed.p && lcp_problem_sets(s->p) == 1u << LCP_CONE);
}

base_status problem_source_judge_cone(const problem_source *s, const double *z, lcp_verdict *out,
                                      base_error *err) {
  return (s->import.cone.p.M.n > 0) ? import_judge_cone(&s->import, z, out, err)
                                    : lcp_judge(s->p, z, out, err);
}

base_status problem_source_open(const char *text, const char *q_path, int facets,
                                problem_source *out, base_error *err) {
  *out = (problem_source){0};
  (void)snprintf(out->name, sizeof out->name, "%s", text);
  char begin[16] = "";
  if (base_in_is_stdin(text)) {
    BASE_TRY(sniff(begin, err));
  }
  const bool mtx = ends_with(text, ".mtx") || strncmp(begin, "%%Matrix", 8) == 0;
  const bool npz = ends_with(text, ".npz") || strncmp(begin, "PK", 2) == 0;
  if (q_path != NULL && !mtx) {
    return BASE_FAIL(err, BASE_EINVAL, "--q %s: %s has a q already, only a .mtx needs one", q_path,
                     text);
  }
  if (mtx || npz) {
    return (facets != 0) ? no_facets(text, err)
           : mtx         ? open_mtx(text, q_path, out, err)
                         : open_npz(text, out, err);
  }
  if (is_import_text(text) || base_in_is_stdin(text)) {
    return open_file(text, facets, out, err);
  }
  char name[64];
  (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(text, ":"), text);
  if (lcp_family_find(name) == NULL) {
    return lcp_family_unknown(name, err);
  }
  if (facets != 0) {
    return no_facets(text, err);
  }
  out->p = &out->known.p;
  return lcp_family_load(text, &out->known, err);
}

void problem_source_close(problem_source *s) {
  lcp_file_problem_free(&s->file);
  known_lcp_free(&s->known);
  import_posed_free(&s->import);
  s->p = NULL;
}
