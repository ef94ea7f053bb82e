#include "harness/plan/plan.h"

#include "harness/plan/plan_check.h"
#include "harness/plan/plan_key.h"
#include "harness/util/shell.h"
#include "lcp/base/nearest.h"
#include "lcp/base/rng.h"

#include <fnmatch.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- texts ------------------------------------------------------------------------------------*/

enum { EXPAND_TEXT = 512 };

/* $NAME/rest and ${NAME:-other}/rest: the value of the variable before the rest; `other` where the
 * variable is not set, or empty. */
static base_status expand_variable(const char *text, char *buf, size_t cap, base_error *err) {
  char name[64] = "";
  char other[256] = "";
  int end = 0;
  (void)sscanf(text, "${%63[A-Za-z0-9_]:-%255[^}]}%n", name, other, &end);
  if (end == 0) {
    (void)sscanf(text, "$%63[A-Za-z0-9_]%n", name, &end);
  }
  if (end == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "problem '%s': need $NAME/ or ${NAME:-FOLDER}/", text);
  }
  const char *value = getenv(name);
  if (value == NULL || value[0] == '\0') {
    value = other;
  }
  if (value[0] == '\0') {
    return BASE_FAIL(err, BASE_EINVAL, "problem '%s': %s is not set in the environment", text,
                     name);
  }
  if ((size_t)snprintf(buf, cap, "%s%s", value, text + end) >= cap) {
    return BASE_FAIL(err, BASE_EINVAL, "problem '%s': longer than %zu characters", text, cap - 1);
  }
  return BASE_OK;
}

/* ./-x is no option of a command. */
static base_status add_file(const char *path, text_list *out, base_error *err) {
  char one[610];
  (void)snprintf(one, sizeof one, "%s%s", path[0] == '-' ? "./" : "", path);
  return text_list_add(out, one, err);
}

/* File patterns become the files that match, in order; other texts stay. */
static base_status expand_files(const char *text, text_list *out, base_error *err) {
  char pattern[EXPAND_TEXT];
  char one[EXPAND_TEXT + 88];
  if (strpbrk(text, "*?[") == NULL) {
    return add_file(text, out, err);
  }
  const char *tail =
      strstr(text, ":facets="); /* stands behind the pattern, and behind every file */
  (void)snprintf(pattern, sizeof pattern, "%.*s",
                 (int)(tail != NULL ? tail - text : EXPAND_TEXT - 1), text);
  glob_t found;
  base_status done = BASE_OK;
  if (glob(pattern, 0, NULL, &found) != 0) {
    if (access(pattern, F_OK) == 0) { /* a file may be called a[1] */
      return add_file(text, out, err);
    }
    return BASE_FAIL(err, BASE_EINVAL, "problem '%s': no file matches", text);
  }
  for (size_t i = 0; done == BASE_OK && i < found.gl_pathc; i++) {
    (void)snprintf(one, sizeof one, "%s%s", found.gl_pathv[i], tail != NULL ? tail : "");
    done = add_file(one, out, err);
  }
  globfree(&found);
  return done;
}

static base_status expand_axis(const text_list *axis, const char *dflt, bool files, text_list *out,
                               base_error *err) {
  if (axis->n == 0) {
    return text_list_add(out, dflt, err);
  }
  text_list plain = {0};
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < axis->n; i++) {
    char text[EXPAND_TEXT];
    const bool variable = files && axis->item[i][0] == '$';
    done = variable ? expand_variable(axis->item[i], text, sizeof text, err) : BASE_OK;
    if (done == BASE_OK) {
      done = brace_expand(variable ? text : axis->item[i], &plain, err);
    }
  }
  for (int i = 0; done == BASE_OK && i < plain.n; i++) {
    done = files ? expand_files(plain.item[i], out, err) : text_list_add(out, plain.item[i], err);
  }
  text_list_free(&plain);
  return done;
}

/* The store owns every text once, so that cells can hold views. */
static base_status keep(plan *p, const char *text, const char **out, base_error *err) {
  for (int i = p->store.n; i-- > 0;) {
    if (strcmp(p->store.item[i], text) == 0) {
      *out = p->store.item[i];
      return BASE_OK;
    }
  }
  BASE_TRY(text_list_add(&p->store, text, err));
  *out = p->store.item[p->store.n - 1];
  return BASE_OK;
}

/* ---- filters ----------------------------------------------------------------------------------*/

static const char *filter_value(const cell *c, const char *axis, size_t len, base_nearest *near) {
  const struct {
    const char *name, *value;
  } axes[] = {{"part", c->part},
              {"problem", c->problem},
              {"problems", c->problem},
              {"formulation", c->formulation},
              {"formulations", c->formulation},
              {"solver", c->solver},
              {"solvers", c->solver},
              {"step", c->step},
              {"tol", c->tol},
              {"start", c->start},
              {"effects", c->effects},
              {"duration", c->duration},
              {"contact_order", c->contact_order},
              {"islands", c->islands},
              {"cell", c->id},
              {"cell_id", c->id}};
  for (int i = 0; i < BASE_COUNT(axes); i++) {
    if (strlen(axes[i].name) == len && strncmp(axes[i].name, axis, len) == 0) {
      return axes[i].value;
    }
    base_nearest_offer(near, axes[i].name);
  }
  return NULL;
}

static base_status matches(const cell *c, const char *filter, bool *out, base_error *err) {
  const bool negate = filter[0] == '-';
  const char *axis = filter + (negate ? 1 : 0);
  const size_t len = strcspn(axis, "=");
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(axis, len);
  const char *value = filter_value(c, axis, len, &near);
  if (value == NULL || axis[len] != '=') {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--filter %.80s: need axis=glob with axis part, problem, formulation, solver, "
                     "step, duration, tol, start, effects, contact_order, islands or cell%s",
                     filter, value == NULL ? base_nearest_hint(&near, hint) : "");
  }
  *out = (fnmatch(axis + len + 1, value, 0) == 0) != negate;
  return BASE_OK;
}

static base_status selected(const cell *c, const plan_filter *f, bool *out, base_error *err) {
  *out = true;
  for (int i = 0; i < f->filter.count; i++) {
    bool match = false;
    BASE_TRY(matches(c, f->filter.item[i], &match, err));
    *out = *out && match;
  }
  return BASE_OK;
}

/* ---- cells ------------------------------------------------------------------------------------*/

/* A row holds the texts of its cell and the command that reruns it whole. */
static base_status check_texts(const cell *c, const campaign_limits *limits, base_error *err) {
  char command[sizeof((record *)0)->command];
  const struct {
    const char *what, *text;
    size_t room;
  } texts[] = {{"problem", c->problem, sizeof((record *)0)->problem},
               {"formulation", c->formulation, sizeof((record *)0)->formulation_options},
               {"solver", c->solver, sizeof((record *)0)->solver_options}};
  for (int i = 0; i < BASE_COUNT(texts); i++) {
    if (strlen(texts[i].text) >= texts[i].room) {
      return BASE_FAIL(err, BASE_EINVAL, "%s '%.60s...': longer than %zu characters", texts[i].what,
                       texts[i].text, texts[i].room - 1);
    }
    if (!shell_can_quote(texts[i].text)) {
      return BASE_FAIL(err, BASE_EINVAL, "%s '%.200s': ends with a line break", texts[i].what,
                       texts[i].text);
    }
  }
  return (cell_command(c, limits, command, sizeof command) < sizeof command)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL,
                         "problem '%.100s': its command is longer than %zu characters", c->problem,
                         sizeof command - 1);
}

static base_status add_cell(plan *p, const campaign_part *part, const char *const value[AXIS_COUNT],
                            const plan_filter *f, problem_hashes *known, base_error *err) {
  cell c = {.skip = ""};
  const char **text[AXIS_COUNT] = {[AXIS_problems] = &c.problem,
                                   [AXIS_formulations] = &c.formulation,
                                   [AXIS_solvers] = &c.solver,
                                   [AXIS_steps] = &c.step,
                                   [AXIS_durations] = &c.duration,
                                   [AXIS_tolerances] = &c.tol,
                                   [AXIS_starts] = &c.start,
                                   [AXIS_effects] = &c.effects,
                                   [AXIS_contact_orders] = &c.contact_order,
                                   [AXIS_islands] = &c.islands};
  BASE_TRY(keep(p, part->name, &c.part, err));
  for (int a = 0; a < AXIS_COUNT; a++) {
    BASE_TRY(keep(p, value[a], text[a], err));
  }
  BASE_TRY(check_texts(&c, &p->campaign->limits, err));
  BASE_TRY(cell_key(p->campaign, known, &c, err));
  bool wanted;
  BASE_TRY(selected(&c, f, &wanted, err));
  for (int i = 0; wanted && i < p->n_cell; i++) {
    wanted = strcmp(p->cell[i].id, c.id) != 0; /* lists that overlap name a cell twice */
  }
  if (!wanted) {
    return BASE_OK;
  }
  if (p->n_cell == p->cap_cell) {
    const int cap = (p->cap_cell > 0) ? 2 * p->cap_cell : 64;
    cell *grown = realloc(p->cell, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d cells", cap);
    }
    p->cell = grown;
    p->cap_cell = cap;
  }
  p->cell[p->n_cell++] = c;
  return BASE_OK;
}

/* All combinations, the last axis fastest. */
static base_status add_product(plan *p, const campaign_part *part, const text_list list[AXIS_COUNT],
                               const plan_filter *f, problem_hashes *known, base_error *err) {
  int index[AXIS_COUNT] = {0};
  for (;;) {
    const char *value[AXIS_COUNT];
    for (int a = 0; a < AXIS_COUNT; a++) {
      value[a] = list[a].item[index[a]];
    }
    BASE_TRY(add_cell(p, part, value, f, known, err));
    int a = AXIS_COUNT - 1;
    while (a >= 0 && ++index[a] == list[a].n) {
      index[a--] = 0;
    }
    if (a < 0) {
      return BASE_OK;
    }
  }
}

/* What an axis is where a part leaves it out; NULL: nothing. */
static const char *const absent[AXIS_COUNT] = {[AXIS_starts] = "cold",
                                               [AXIS_effects] = "declared",
                                               [AXIS_contact_orders] = "given",
                                               [AXIS_islands] = "off"};

static base_status add_part(plan *p, const campaign_part *part, const plan_filter *f,
                            problem_hashes *known, base_error *err) {
  text_list list[AXIS_COUNT];
  memset(list, 0, sizeof list);
  base_status done = BASE_OK;
  for (int a = 0; done == BASE_OK && a < AXIS_COUNT; a++) {
    const char *dflt = absent[a];
    done =
        expand_axis(&part->axis[a], (dflt != NULL) ? dflt : "", a == AXIS_problems, &list[a], err);
    const text_list *problems = &list[AXIS_problems];
    const part_kind kind =
        plan_kind(part->axis[AXIS_formulations].n > 0, problems->n > 0 ? problems->item[0] : "");
    if (done == BASE_OK && part->axis[a].n > 0) {
      done = plan_check_axis(a, kind, err);
    }
    for (int i = 0; done == BASE_OK && i < list[a].n; i++) {
      done = plan_check_value(a, kind, list[a].item[i], err);
    }
  }
  if (done == BASE_OK) {
    done = add_product(p, part, list, f, known, err);
  }
  for (int a = 0; a < AXIS_COUNT; a++) {
    text_list_free(&list[a]);
  }
  if (done != BASE_OK && err != NULL) {
    char text[sizeof err->text];
    memcpy(text, err->text, sizeof text);
    return BASE_FAIL(err, done, "%.120s: part %s: %.250s", p->campaign->path, part->name, text);
  }
  return done;
}

/* ---- order ------------------------------------------------------------------------------------*/

static uint64_t hash_text(const char *text, uint64_t seed) {
  uint64_t h = 0xcbf29ce484222325u ^ seed;
  for (; *text != '\0'; text++) {
    h = (h ^ (unsigned char)*text) * 0x100000001b3u;
  }
  base_rng mixed = base_rng_seeded(h);
  return base_rng_bits(&mixed);
}

typedef struct ranked {
  uint64_t group, rank;
  unit u;
} ranked;

static int by_rank(const void *a, const void *b) {
  const ranked *x = a;
  const ranked *y = b;
  if (x->group != y->group) {
    return (x->group < y->group) ? -1 : 1;
  }
  if (x->rank != y->rank) {
    return (x->rank < y->rank) ? -1 : 1;
  }
  return (x->u.process > y->u.process) - (x->u.process < y->u.process);
}

/* Position of a cell's solver among those of its problem, by the seed: the order that abba runs
 * forth in even processes and back in odd ones. */
static uint64_t rank_of(const plan *p, const cell *c, int process) {
  const uint64_t seed = p->campaign->seed + 1;
  if (!p->campaign->sampling.abba) {
    return hash_text(c->id, seed + (uint64_t)process);
  }
  const uint64_t forth = hash_text(c->id, seed) >> 16;
  const uint64_t block = (uint64_t)process << 48;
  return block | ((process % 2 == 0) ? forth : (UINT64_MAX >> 16) - forth);
}

static base_status order_units(plan *p, const plan_filter *f, base_error *err) {
  const int processes = p->campaign->sampling.processes;
  const size_t n = (size_t)p->n_cell * (size_t)processes;
  ranked *r = calloc(n + 1, sizeof *r);
  p->unit = calloc(n + 1, sizeof *p->unit);
  if (r == NULL || p->unit == NULL) {
    free(r);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu processes", n);
  }
  size_t m = 0;
  for (int i = 0; i < p->n_cell; i++) {
    const uint64_t group = hash_text(p->cell[i].problem, p->campaign->seed);
    const uint64_t shard = hash_text(p->cell[i].problem, 0);
    if (f->n_shard > 0 && (int)(shard % (uint64_t)f->n_shard) != f->shard - 1) {
      continue;
    }
    for (int k = 0; k < processes; k++) {
      r[m++] = (ranked){group, rank_of(p, &p->cell[i], k), {i, k}};
    }
  }
  qsort(r, m, sizeof *r, by_rank);
  for (size_t i = 0; i < m; i++) {
    p->unit[i] = r[i].u;
  }
  p->n_unit = (int)m;
  free(r);
  return BASE_OK;
}

base_status plan_make(const campaign *c, const plan_filter *f, plan *out, base_error *err) {
  *out = (plan){.campaign = c, .whole = f->filter.count == 0 && f->n_shard == 0};
  problem_hashes known = {0};
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < c->n_part; i++) {
    done = add_part(out, &c->part[i], f, &known, err);
  }
  free(known.at);
  if (done == BASE_OK && out->n_cell == 0) {
    done = BASE_FAIL(err, BASE_EINVAL, "campaign %s: the filter matches no cell", c->name);
  }
  if (done == BASE_OK) {
    done = order_units(out, f, err);
  }
  if (done != BASE_OK) {
    plan_free(out);
  }
  return done;
}

void plan_free(plan *p) {
  text_list_free(&p->store);
  free(p->cell);
  free(p->unit);
  *p = (plan){0};
}
