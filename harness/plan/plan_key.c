#include "harness/plan/plan_key.h"

#include "harness/measure/problem_source.h"
#include "harness/measure/registry.h"
#include "harness/sequence/sequence_source.h"
#include "harness/util/sha256.h"
#include "harness/util/versions.h"
#include "problems/read/scene_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_file(const cell *c) {
  if (c->formulation[0] == '\0' && sequence_is(c->problem)) {
    sequence_text t;
    return !sequence_is_text(c->problem) ||
           (sequence_text_parse(c->problem, &t, NULL) == BASE_OK && scene_is_file(t.scene));
  }
  return (c->formulation[0] != '\0') ? scene_is_file(c->problem) : problem_is_file(c->problem);
}

/* The file of such a cell, and the facets asked for of it. */
static base_status file_of(const cell *c, char *path, size_t cap, int *facets, base_error *err) {
  const char *id;
  *facets = 0;
  if (c->formulation[0] == '\0' && sequence_is(c->problem)) {
    sequence_text t;
    if (!sequence_is_text(c->problem)) { /* the manifest has the hashes of the others */
      (void)snprintf(path, cap, "%s/manifest.json", c->problem);
      return BASE_OK;
    }
    BASE_TRY(sequence_text_parse(c->problem, &t, err));
    scene_file_split(t.scene, path, cap, &id);
    return BASE_OK;
  }
  if (c->formulation[0] == '\0') {
    return problem_file(c->problem, path, cap, facets, err);
  }
  scene_file_split(c->problem, path, cap, &id);
  return BASE_OK;
}

static void name_of(const char *text, char name[64]) {
  (void)snprintf(name, 64, "%.*s", (int)strcspn(text, ":"), text);
}

/* A sequence that is posed: by its text, and by what its problems and their answers come from. */
static base_status posed_key(const cell *c, char hex[SHA256_HEX], base_error *err) {
  sequence_text t;
  formulation_choice form;
  solver_choice solver = {0};
  char name[64];
  BASE_TRY(sequence_text_parse(c->problem, &t, err));
  BASE_TRY(formulation_choose(t.formulation, &form, err));
  base_status done = solver_choose(t.solver, &solver, err);
  sha256 s;
  sha256_begin(&s);
  sha256_text(&s, c->problem);
  name_of(t.scene, name);
  if (done == BASE_OK && is_file(c)) {
    char path[512];
    char file[SHA256_HEX];
    int facets;
    done = file_of(c, path, sizeof path, &facets, err);
    if (done == BASE_OK) {
      done = sha256_file(path, file, err);
    }
    if (done == BASE_OK) {
      sha256_text(&s, file);
    }
  } else if (done == BASE_OK) {
    sha256_text(&s, version_of_scene(name));
  }
  if (done == BASE_OK) {
    sha256_text(&s, version_of_formulation(form.form->name));
    sha256_text(&s, version_of_solver(solver.solver->name));
  }
  sha256_end(&s, hex);
  formulation_choice_free(&form);
  solver_choice_free(&solver);
  return done;
}

/* Files by content (a Matrix Market M with its q), scenes by their text and source. */
static base_status problem_key(const cell *c, char hex[SHA256_HEX], base_error *err) {
  char path[512];
  int facets;
  if (c->formulation[0] == '\0' && sequence_is_text(c->problem)) {
    return posed_key(c, hex, err);
  }
  if (!is_file(c)) {
    char name[64];
    name_of(c->problem, name);
    sha256 s;
    sha256_begin(&s);
    sha256_text(&s, c->problem);
    sha256_text(&s, c->formulation[0] != '\0' ? version_of_scene(name) : version_of_family(name));
    sha256_end(&s, hex);
    return BASE_OK;
  }
  BASE_TRY(file_of(c, path, sizeof path, &facets, err));
  BASE_TRY(sha256_file(path, hex, err));
  const size_t n = strlen(path);
  if (n > 6 && strcmp(path + n - 6, ".M.mtx") == 0) {
    char q[SHA256_HEX];
    path[n - 5] = 'q';
    BASE_TRY(sha256_file(path, q, err));
    sha256 s;
    sha256_begin(&s);
    sha256_text(&s, hex);
    sha256_text(&s, q);
    sha256_end(&s, hex);
  }
  if (facets != 0) {
    sha256 s;
    sha256_begin(&s);
    sha256_text(&s, hex);
    sha256_text(&s, strrchr(c->problem, ':'));
    sha256_end(&s, hex);
  }
  return BASE_OK;
}

base_status cell_file_unchanged(const cell *c, const char *recorded, base_error *err) {
  char hex[SHA256_HEX];
  char path[512];
  int facets;
  if (!is_file(c)) {
    return BASE_OK;
  }
  BASE_TRY(file_of(c, path, sizeof path, &facets, err));
  BASE_TRY(problem_key(c, hex, err));
  return (strcmp(hex, recorded) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "%.200s: the file has changed since", path);
}

static base_status remember(problem_hashes *known, const cell *c, base_error *err) {
  if (known->n == known->cap) {
    const int cap = (known->cap > 0) ? 2 * known->cap : 64;
    problem_hash *grown = realloc(known->at, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d problems", cap);
    }
    known->at = grown;
    known->cap = cap;
  }
  problem_hash *new = &known->at[known->n++];
  *new = (problem_hash){.problem = c->problem, .is_scene = c->formulation[0] != '\0'};
  memcpy(new->sha256, c->problem_sha256, sizeof new->sha256);
  return BASE_OK;
}

/* The cells of a problem follow each other: looked for from the end. */
static base_status hash_problem(problem_hashes *known, cell *c, base_error *err) {
  const bool is_scene = c->formulation[0] != '\0';
  for (int i = known->n; i-- > 0;) {
    const problem_hash *h = &known->at[i];
    if (h->problem == c->problem && h->is_scene == is_scene) {
      memcpy(c->problem_sha256, h->sha256, sizeof h->sha256);
      return BASE_OK;
    }
  }
  BASE_TRY(problem_key(c, c->problem_sha256, err));
  return remember(known, c, err);
}

base_status cell_key(const campaign *camp, problem_hashes *known, cell *c, base_error *err) {
  solver_choice solver;
  formulation_choice form = {0};
  BASE_TRY(solver_choose(c->solver, &solver, err));
  (void)snprintf(c->solver_version, sizeof c->solver_version, "%s",
                 version_of_solver(solver.solver->name));
  base_status done = hash_problem(known, c, err);
  if (done == BASE_OK && c->formulation[0] != '\0') {
    done = formulation_choose(c->formulation, &form, err);
  }
  if (done == BASE_OK) {
    char hex[SHA256_HEX];
    char seed[32];
    (void)snprintf(seed, sizeof seed, "%llu", (unsigned long long)camp->seed);
    const char *slash = strrchr(c->problem, '/');
    const char *fields[] = {c->part,
                            slash != NULL ? slash + 1 : c->problem, /* not the folder */
                            c->problem_sha256,
                            form.form != NULL ? form.form->name : "",
                            form.config,
                            form.form != NULL ? version_of_formulation(form.form->name) : "",
                            solver.solver->name,
                            solver.config,
                            c->solver_version,
                            c->step,
                            c->duration,
                            c->tol,
                            c->start,
                            c->effects,
                            camp->quick ? "quick" : "full",
                            camp->sampling.cold ? "cold" : "warm",
                            seed};
    sha256 s;
    sha256_begin(&s);
    for (int i = 0; i < BASE_COUNT(fields); i++) {
      sha256_text(&s, fields[i]);
    }
    if (strcmp(c->contact_order, "given") != 0) { /* the keys of other cells stay as they were */
      sha256_text(&s, c->contact_order);
    }
    if (strcmp(c->islands, "off") != 0) {
      sha256_text(&s, "islands");
    }
    sha256_end(&s, hex);
    memcpy(c->id, hex, CELL_ID - 1);
    c->id[CELL_ID - 1] = '\0';
  }
  if (done == BASE_OK && c->tol[0] != '\0') {
    done = solver_choice_set(&solver, "tol", c->tol, err); /* is it one that the solver takes? */
  }
  solver_choice_free(&solver);
  formulation_choice_free(&form);
  return done;
}
