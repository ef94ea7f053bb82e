#include "harness/sequence/sequence_file.h"

#include "harness/choice/solver_choice.h"
#include "harness/measure/dump.h"
#include "harness/measure/problem_source.h"
#include "harness/measure/solve_once.h"
#include "harness/util/folder.h"
#include "harness/util/json_file.h"
#include "harness/util/sha256.h"
#include "harness/util/version.h"
#include "harness/util/versions.h"
#include "lcp/lcp_solver.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char manifest_name[] = "manifest.json";
static const char format_name[] = "lcpbench sequence 1";

bool sequence_is_folder(const char *dir) {
  char path[1100];
  folder_file(dir, manifest_name, path, sizeof path);
  return strlen(dir) < 1000 && access(path, F_OK) == 0;
}

/* Over the files of one problem: M and q, or one for both, and the answer. */
static base_status hash_files(const char *dir, const char *file, const char *answer,
                              char hex[SHA256_HEX], base_error *err) {
  char path[1100];
  char one[SHA256_HEX];
  char q[DUMP_NAME];
  const size_t n = strlen(file);
  const bool plain = n > 6 && strcmp(file + n - 6, ".M.mtx") == 0;
  (void)snprintf(q, sizeof q, "%.*s.q.mtx", (int)(plain ? n - 6 : 0), file);
  const char *const name[] = {file, answer, plain ? q : NULL};
  sha256 s;
  sha256_begin(&s);
  for (int i = 0; i < BASE_COUNT(name); i++) {
    if (name[i] != NULL) {
      folder_file(dir, name[i], path, sizeof path);
      BASE_TRY(sha256_file(path, one, err));
      sha256_text(&s, one);
    }
  }
  sha256_end(&s, hex);
  return BASE_OK;
}

/* ---- writing --------------------------------------------------------------------------------- */

/* The blocks, each with the name of its contact or joint, which may have several. */
static base_status put_rows(json_t *o, const sequence_item *s, base_error *err) {
  json_t *all = json_array();
  (void)json_object_set_new(o, "rows", all);
  bool good = true;
  for (int i = 0, k = 0; good && i < s->p.n_block; i++) {
    const lcp_block *b = &s->block[i];
    char id[24];
    while (s->first[k + 1] <= b->start) {
      k++;
    }
    good = b->start + b->size <= s->first[k + 1];
    (void)snprintf(id, sizeof id, "%016llx", (unsigned long long)s->owner[k]);
    json_t *one = json_object();
    json_out_text(one, "id", id);
    json_out_int(one, "n", b->size);
    json_out_text(one, "set", lcp_set_name((int)b->set));
    json_out_real(one, "soft", b->soft);
    json_t *parts = json_array();
    for (int part = 0; part < b->n_part; part++) {
      (void)json_array_append_new(parts, json_pack("[i,f]", b->part_dim[part], b->part_mu[part]));
    }
    (void)json_object_set_new(one, "parts", parts);
    (void)json_array_append_new(all, one);
  }
  return good ? BASE_OK
              : BASE_FAIL(err, BASE_EINVAL,
                          "step %ld: a block of more than one contact, which no file tells",
                          s->step);
}

static base_status put_item(json_t *all, const sequence_item *s, const char *dir, base_error *err) {
  char file[DUMP_NAME];
  char answer[DUMP_NAME];
  char hex[SHA256_HEX];
  json_t *o = json_object();
  (void)json_array_append_new(all, o);
  BASE_TRY(dump_files(dir, s->step, s->solve, &s->p, s->z, file, answer, err));
  BASE_TRY(hash_files(dir, file, answer, hex, err));
  json_out_int(o, "step", s->step);
  json_out_int(o, "solve", s->solve);
  json_out_text(o, "file", file);
  json_out_text(o, "answer", s->verified ? answer : NULL);
  json_out_text(o, "iterate", s->verified ? NULL : answer);
  json_out_text(o, "status", run_status_name(s->status));
  json_out_bool(o, "verified", s->verified);
  json_out_real(o, "rho", s->rho);
  json_out_int(o, "n", s->p.M.n);
  json_out_text(o, "storage", storage_name(s->p.M.storage));
  json_t *sets = json_array();
  for (int k = 0; lcp_set_name(k) != NULL; k++) {
    if ((lcp_problem_sets(&s->p) & 1u << k) != 0) {
      (void)json_array_append_new(sets, json_string(lcp_set_name(k)));
    }
  }
  (void)json_object_set_new(o, "sets", sets);
  json_t *traits = json_array();
  for (int k = 0; lcp_trait_name(k) != NULL; k++) {
    if ((s->p.traits & 1u << k) != 0) {
      (void)json_array_append_new(traits, json_string(lcp_trait_name(k)));
    }
  }
  (void)json_object_set_new(o, "traits", traits);
  json_out_int(o, "active", s->n_active);
  json_out_int(o, "changed", s->n_changed);
  json_out_text(o, "sha256", hex);
  return put_rows(o, s, err);
}

base_status sequence_write(const sequence *q, const char *dir, base_error *err) {
  solver_choice solver;
  BASE_TRY(folder_make(dir, err));
  BASE_TRY(solver_choose(q->solver, &solver, err));
  json_t *o = json_object();
  json_t *all = json_array();
  int unverified = 0;
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < q->n; i++) {
    unverified += !q->item[i].verified;
    done = put_item(all, &q->item[i], dir, err);
  }
  json_out_text(o, "format", format_name);
  json_out_text(o, "version", harness_version());
  json_out_text(o, "suite_commit", build_commit());
  json_out_text(o, "scene", q->scene);
  json_out_text(o, "formulation", q->formulation);
  json_out_text(o, "solver", q->solver);
  json_out_real(o, "tolerance", verdict_tolerance(solver.solver));
  json_out_real(o, "step_s", q->h);
  json_out_int(o, "count", q->count);
  json_out_int(o, "steps", q->steps);
  json_out_text(o, "status", run_status_name(q->status));
  json_out_text(o, "note", q->note);
  json_out_int(o, "n_problems", q->n);
  json_out_int(o, "n_unverified", unverified);
  json_out_real(o, "active_change", sequence_change(q));
  (void)json_object_set_new(o, "problems", all);
  if (done == BASE_OK) {
    done = json_file_write(o, dir, manifest_name, err);
  }
  json_decref(o);
  solver_choice_free(&solver);
  return done;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* What the manifest says of one problem. */
typedef struct item_words {
  const char *dir;
  long step;
  const char *file, *answer, *status, *storage, *sha256;
  int verified, n;
  double tolerance;
  json_t *traits, *rows;
  int n_owner, n_block;
  uint64_t *owner; /* owned, as the next two */
  int *first;
  lcp_block *block;
} item_words;

static base_status wrong(const item_words *w, const char *what, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%.200s/%s: step %ld: %.150s", w->dir, manifest_name, w->step,
                   what);
}

static int find_word(const char *word, const char *(*name)(int)) {
  int k = 0;
  while (name(k) != NULL && (word == NULL || strcmp(name(k), word) != 0)) {
    k++;
  }
  return (name(k) != NULL) ? k : -1;
}

static base_status take_parts(const item_words *w, json_t *parts, lcp_block *b, base_error *err) {
  const size_t n = json_array_size(parts);
  if (n > LCP_PARTS_MAX) {
    return wrong(w, "rows: more parts than a contact has", err);
  }
  for (size_t i = 0; i < n; i++) {
    json_error_t why;
    if (json_unpack_ex(json_array_get(parts, i), &why, 0, "[i,F]", &b->part_dim[i],
                       &b->part_mu[i]) != 0) {
      return wrong(w, "rows: need parts [dimension, coefficient]", err);
    }
  }
  b->n_part = (int)n;
  return BASE_OK;
}

static base_status take_rows(item_words *w, base_error *err) {
  const size_t n = json_array_size(w->rows);
  if (n > INT_MAX / 2) {
    return wrong(w, "rows: too many", err);
  }
  w->owner = calloc(n + 1, sizeof *w->owner);
  w->first = calloc(n + 1, sizeof *w->first);
  w->block = calloc(n + 1, sizeof *w->block);
  if (w->owner == NULL || w->first == NULL || w->block == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the names of %zu contacts", n);
  }
  w->n_block = (int)n;
  int row = 0;
  for (size_t k = 0; k < n; k++) {
    const char *id = NULL;
    const char *set = NULL;
    json_t *parts = NULL;
    lcp_block *b = &w->block[k];
    char *end = NULL;
    if (json_unpack(json_array_get(w->rows, k), "{s:s,s:i,s:s,s:F,s:o}", "id", &id, "n", &b->size,
                    "set", &set, "soft", &b->soft, "parts", &parts) != 0) {
      return wrong(w, "rows: need id, n, set, soft and parts", err);
    }
    const uint64_t owner = strtoull(id, &end, 16);
    const int kind = find_word(set, lcp_set_name);
    if (*end != '\0' || end == id || kind < 0 || b->size < 1 || b->size > w->n - row) {
      return wrong(w, "rows: an id, a set or a number of rows that cannot be", err);
    }
    b->set = (lcp_set)kind;
    b->start = row;
    row += b->size;
    if (k == 0 || w->owner[w->n_owner - 1] != owner) {
      w->owner[w->n_owner++] = owner;
    }
    w->first[w->n_owner] = row;
    BASE_TRY(take_parts(w, parts, b, err));
  }
  return (w->first[w->n_owner] == w->n) ? BASE_OK : wrong(w, "rows: do not add up to n", err);
}

static base_status take_traits(const item_words *w, unsigned *traits, base_error *err) {
  *traits = 0;
  for (size_t i = 0; i < json_array_size(w->traits); i++) {
    const int k = find_word(json_string_value(json_array_get(w->traits, i)), lcp_trait_name);
    if (k < 0) {
      return wrong(w, "traits: a word that is none", err);
    }
    *traits |= 1u << k;
  }
  return BASE_OK;
}

/* The problem of the file with blocks and traits of the manifest, its answer judged anew. */
static base_status judge_and_put(sequence *q, const item_words *w, lcp_problem *p, const double *z,
                                 base_error *err) {
  lcp_verdict v;
  run_status status = RUN_ERROR;
  p->block = w->block;
  p->n_block = w->n_block;
  BASE_TRY(take_traits(w, &p->traits, err));
  if (!run_status_find(w->status, &status)) {
    return wrong(w, "status: a word that is none", err);
  }
  BASE_TRY(lcp_problem_check(p, err));
  BASE_TRY(lcp_judge(p, z, &v, err));
  const double tol = fmin(w->tolerance, LCP_VERIFY_ITERATIVE);
  if (w->verified && !(v.rho <= tol && lcp_judged_small(&v, tol))) {
    return wrong(w, "the answer is called verified and does not pass the judge", err);
  }
  const sim_solved k = {.step = w->step,
                        .p = p,
                        .z = z,
                        .status = status,
                        .verified = w->verified != 0,
                        .rho = v.rho};
  return sequence_put_named(q, &k, w->n_owner, w->owner, w->first, err);
}

/* M in the storage in which it was posed; in *val or *csc, which are the caller's to free. */
static base_status as_posed(const item_words *w, const lcp_matrix *M, double **val, lcp_csc *csc,
                            lcp_matrix *out, base_error *err) {
  const size_t n = (size_t)M->n;
  *out = *M;
  if (strcmp(w->storage, storage_name(LCP_DENSE)) == 0) {
    *val = malloc(n * n * sizeof **val);
    if (*val == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for a problem of %d unknowns", M->n);
    }
    lcp_matrix_to_dense(M, *val);
    *out = (lcp_matrix){.storage = LCP_DENSE, .n = M->n, .val = *val};
    return BASE_OK;
  }
  if (strcmp(w->storage, storage_name(LCP_CSC)) != 0) {
    return wrong(w, "storage: need dense or csc", err);
  }
  BASE_TRY(lcp_matrix_to_csc(M, csc, err));
  *out = (lcp_matrix){.storage = LCP_CSC, .n = M->n, .csc = *csc};
  return BASE_OK;
}

/* src: the problem as its file has it. */
static base_status take_answer(sequence *q, const item_words *w, const lcp_problem *src,
                               base_error *err) {
  char path[1100];
  double *val = NULL;
  lcp_csc csc = {0};
  lcp_problem p = *src;
  double *z = malloc((size_t)w->n * sizeof *z);
  base_status done =
      (z != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "no memory for %d unknowns", w->n);
  if (done == BASE_OK) {
    folder_file(w->dir, w->answer, path, sizeof path);
    done = lcp_read_mtx_vector(path, w->n, z, err);
  }
  if (done == BASE_OK) {
    done = as_posed(w, &src->M, &val, &csc, &p.M, err);
  }
  if (done == BASE_OK) {
    done = judge_and_put(q, w, &p, z, err);
  }
  free(z);
  free(val);
  lcp_csc_free(&csc);
  return done;
}

static base_status take_files(sequence *q, const item_words *w, base_error *err) {
  char path[1100];
  char hex[SHA256_HEX];
  problem_source src;
  if (w->answer == NULL || strchr(w->file, '/') != NULL || strchr(w->answer, '/') != NULL) {
    return wrong(w, "need the name of a file of this folder", err);
  }
  BASE_TRY(hash_files(w->dir, w->file, w->answer, hex, err));
  if (strcmp(hex, w->sha256) != 0) {
    return wrong(w, "sha256: the files have changed since", err);
  }
  folder_file(w->dir, w->file, path, sizeof path);
  base_status done = problem_source_open(path, NULL, 0, &src, err);
  if (done == BASE_OK) {
    done = (src.p->M.n == w->n) ? take_answer(q, w, src.p, err)
                                : wrong(w, "n: the file has another number of unknowns", err);
  }
  problem_source_close(&src);
  return done;
}

static base_status take_item(sequence *q, const char *dir, double tolerance, json_t *o,
                             base_error *err) {
  item_words w = {.dir = dir, .tolerance = tolerance};
  json_error_t why;
  json_int_t step = 0;
  json_t *answer = NULL;
  json_t *iterate = NULL;
  if (json_unpack_ex(o, &why, 0, "{s:I,s:s,s:o,s:o,s:s,s:b,s:i,s:s,s:o,s:s,s:o}", "step", &step,
                     "file", &w.file, "answer", &answer, "iterate", &iterate, "status", &w.status,
                     "verified", &w.verified, "n", &w.n, "storage", &w.storage, "traits", &w.traits,
                     "sha256", &w.sha256, "rows", &w.rows) != 0) {
    return wrong(&w, why.text, err);
  }
  w.step = (long)step;
  w.answer = json_string_value(w.verified ? answer : iterate);
  base_status done =
      (w.n > 0 && w.n < INT_MAX / 8) ? take_rows(&w, err) : wrong(&w, "n: need at least 1", err);
  if (done == BASE_OK) {
    done = take_files(q, &w, err);
  }
  free(w.owner);
  free(w.first);
  free(w.block);
  return done;
}

static base_status take_head(sequence *q, const char *dir, json_t *o, double *tolerance,
                             json_t **all, base_error *err) {
  const char *format = NULL;
  const char *scene = NULL;
  const char *form = NULL;
  const char *solver = NULL;
  const char *status = NULL;
  const char *note = NULL;
  json_int_t count = 0;
  json_int_t steps = 0;
  json_error_t why;
  if (json_unpack_ex(o, &why, 0, "{s:s,s:s,s:s,s:s,s:F,s:F,s:I,s:I,s:s,s:s,s:o}", "format", &format,
                     "scene", &scene, "formulation", &form, "solver", &solver, "tolerance",
                     tolerance, "step_s", &q->h, "count", &count, "steps", &steps, "status",
                     &status, "note", &note, "problems", all) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%.200s/%s: %.150s", dir, manifest_name, why.text);
  }
  if (strcmp(format, format_name) != 0 || !run_status_find(status, &q->status) ||
      !json_is_array(*all)) {
    return BASE_FAIL(err, BASE_EINVAL, "%.200s/%s: no manifest of the format '%s'", dir,
                     manifest_name, format_name);
  }
  (void)snprintf(q->scene, sizeof q->scene, "%s", scene);
  (void)snprintf(q->formulation, sizeof q->formulation, "%s", form);
  (void)snprintf(q->solver, sizeof q->solver, "%s", solver);
  (void)snprintf(q->note, sizeof q->note, "%s", note);
  q->count = (long)count;
  q->steps = (long)steps;
  return BASE_OK;
}

base_status sequence_read(const char *dir, sequence *out, base_error *err) {
  *out = (sequence){0};
  json_t *o;
  json_t *all = NULL;
  double tolerance = 0.0;
  BASE_TRY(json_file_read(dir, manifest_name, &o, err));
  if (o == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: has no %s", dir, manifest_name);
  }
  base_status done = take_head(out, dir, o, &tolerance, &all, err);
  for (size_t i = 0; done == BASE_OK && i < json_array_size(all); i++) {
    done = take_item(out, dir, tolerance, json_array_get(all, i), err);
  }
  json_decref(o);
  return done;
}
