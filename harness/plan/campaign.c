#include "harness/plan/campaign.h"

#include "harness/util/args.h"
#include "harness/util/installed.h"
#include "harness/util/yaml_read.h"
#include "lcp/base/fields.h"

#include <errno.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define AXIS_NAME_(name) #name,
static const char *const axis_names[] = {CAMPAIGN_AXES(AXIS_NAME_)};

const char *campaign_axis_name(int axis) {
  return axis_names[axis];
}

/* ---- lists ------------------------------------------------------------------------------------*/

base_status text_list_add(text_list *l, const char *text, base_error *err) {
  if (l->n == l->cap) {
    const int cap = (l->cap > 0) ? 2 * l->cap : 8;
    char **grown = realloc(l->item, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for a list of %d texts", cap);
    }
    l->item = grown;
    l->cap = cap;
  }
  char *copy = malloc(strlen(text) + 1);
  if (copy == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for '%.60s'", text);
  }
  memcpy(copy, text, strlen(text) + 1);
  l->item[l->n++] = copy;
  return BASE_OK;
}

void text_list_free(text_list *l) {
  for (int i = 0; i < l->n; i++) {
    free(l->item[i]);
  }
  free(l->item);
  *l = (text_list){0};
}

/* ---- members ----------------------------------------------------------------------------------*/

static base_status real_member(yaml_file *f, const char *key, yaml_node_t *v, double min,
                               double *out, base_error *err) {
  const char *text = yaml_text(v);
  if (text == NULL || !base_parse_real(text, out) || !(*out >= min)) {
    char rule[80];
    (void)snprintf(rule, sizeof rule, "need a number of at least %g", min);
    return yaml_fail(f, v, key, rule, err);
  }
  return BASE_OK;
}

static base_status count_member(yaml_file *f, const char *key, yaml_node_t *v, int *out,
                                base_error *err) {
  const char *text = yaml_text(v);
  if (text == NULL || !base_parse_int(text, out) || *out < 1) {
    return yaml_fail(f, v, key, "need an integer of at least 1", err);
  }
  return BASE_OK;
}

static base_status seconds_member(yaml_file *f, const char *key, yaml_node_t *v, double *out,
                                  base_error *err) {
  const char *text = yaml_text(v);
  if (text == NULL || !args_seconds(text, out) || !(*out > 0.0)) {
    return yaml_fail(f, v, key, "need a time above 0, such as 30s or 10m", err);
  }
  return BASE_OK;
}

static base_status text_member(yaml_file *f, const char *key, yaml_node_t *v, char *out, size_t cap,
                               base_error *err) {
  const char *text = yaml_text(v);
  if (text == NULL || text[0] == '\0' || strlen(text) >= cap) {
    return yaml_fail(f, v, key, "need a short text", err);
  }
  memcpy(out, text, strlen(text) + 1);
  return BASE_OK;
}

/* One of two words; true for the second. */
static base_status word_member(yaml_file *f, const char *key, yaml_node_t *v, const char *no,
                               const char *yes, bool *out, base_error *err) {
  const char *text = yaml_text(v);
  if (text == NULL || (strcmp(text, no) != 0 && strcmp(text, yes) != 0)) {
    char rule[80];
    (void)snprintf(rule, sizeof rule, "need %s or %s", no, yes);
    return yaml_fail(f, v, key, rule, err);
  }
  *out = strcmp(text, yes) == 0;
  return BASE_OK;
}

static base_status take_limit(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                              base_error *err) {
  campaign_limits *l = ctx;
  if (yaml_is(f, key, "time")) {
    return seconds_member(f, key, v, &l->time, err);
  }
  if (yaml_is(f, key, "grace")) {
    return seconds_member(f, key, v, &l->grace, err);
  }
  if (yaml_is(f, key, "memory")) {
    const char *text = yaml_text(v);
    return (text != NULL && args_bytes(text, &l->memory))
               ? BASE_OK
               : yaml_fail(f, v, key, "need bytes, such as 500M or 4G", err);
  }
  return BASE_EUNSUPPORTED;
}

typedef struct campaign_reader {
  campaign *c;
  yaml_node_t *quick;
  yaml_node_t *samples; /* the last of samples and max_samples that was read */
} campaign_reader;

static base_status take_sampling(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                                 base_error *err) {
  campaign_reader *r = ctx;
  campaign_sampling *s = &r->c->sampling;
  if (yaml_is(f, key, "processes")) {
    return count_member(f, key, v, &s->processes, err);
  }
  if (yaml_is(f, key, "samples")) {
    r->samples = v;
    return count_member(f, key, v, &s->samples, err);
  }
  if (yaml_is(f, key, "max_samples")) {
    r->samples = v;
    return count_member(f, key, v, &s->max_samples, err);
  }
  if (yaml_is(f, key, "half_width")) {
    return real_member(f, key, v, 0.0, &s->half_width, err);
  }
  if (yaml_is(f, key, "budget")) {
    return seconds_member(f, key, v, &s->budget, err);
  }
  if (yaml_is(f, key, "inner")) {
    return seconds_member(f, key, v, &s->inner, err);
  }
  if (yaml_is(f, key, "doctor")) {
    return seconds_member(f, key, v, &s->doctor, err);
  }
  if (yaml_is(f, key, "order")) {
    return word_member(f, key, v, "random", "abba", &s->abba, err);
  }
  if (yaml_is(f, key, "cache")) {
    return word_member(f, key, v, "warm", "cold", &s->cold, err);
  }
  return BASE_EUNSUPPORTED;
}

/* ---- parts ------------------------------------------------------------------------------------*/

static base_status read_list(yaml_file *f, const char *key, yaml_node_t *v, text_list *out,
                             base_error *err) {
  text_list_free(out);
  if (v->type != YAML_SEQUENCE_NODE) {
    return yaml_fail(f, v, key, "need a list: [a, b, ...]", err);
  }
  for (yaml_node_item_t *i = v->data.sequence.items.start; i < v->data.sequence.items.top; i++) {
    yaml_node_t *item = yaml_item(f, *i);
    const char *text = yaml_text(item);
    if (text == NULL || text[0] == '\0') {
      return yaml_fail(f, item, key, "need texts or numbers in the list", err);
    }
    BASE_TRY(text_list_add(out, text, err));
  }
  return (out->n > 0) ? BASE_OK : yaml_fail(f, v, key, "the list is empty", err);
}

static int find_axis(yaml_file *f, const char *key) {
  for (int a = 0; a < AXIS_COUNT; a++) {
    if (yaml_is(f, key, axis_names[a])) {
      return a;
    }
  }
  return -1;
}

static base_status take_axis(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                             base_error *err) {
  campaign_part *p = ctx;
  const int axis = find_axis(f, key);
  return (axis >= 0) ? read_list(f, key, v, &p->axis[axis], err) : BASE_EUNSUPPORTED;
}

typedef struct part_reader {
  campaign_part *part;
  yaml_node_t *quick;
} part_reader;

static base_status take_part(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                             base_error *err) {
  part_reader *r = ctx;
  if (yaml_is(f, key, "name")) {
    return text_member(f, key, v, r->part->name, sizeof r->part->name, err);
  }
  if (yaml_is(f, key, "words")) {
    return text_member(f, key, v, r->part->words, sizeof r->part->words, err);
  }
  if (yaml_is(f, key, "quick")) {
    r->quick = v;
    return BASE_OK;
  }
  return take_axis(r->part, f, key, v, err);
}

static base_status read_part(yaml_file *f, yaml_node_t *node, bool quick, campaign_part *part,
                             base_error *err) {
  part_reader r = {part, NULL};
  BASE_TRY(yaml_members(f, node, "part", take_part, &r, err));
  if (r.quick != NULL && quick) {
    BASE_TRY(yaml_members(f, r.quick, "quick", take_axis, part, err));
  }
  if (part->name[0] == '\0') {
    return yaml_fail(f, node, "name", "the part has none", err);
  }
  if (part->axis[AXIS_problems].n == 0 || part->axis[AXIS_solvers].n == 0) {
    return yaml_fail(f, node, part->axis[AXIS_problems].n == 0 ? "problems" : "solvers",
                     "the part has none", err);
  }
  return BASE_OK;
}

static base_status read_parts(yaml_file *f, yaml_node_t *v, campaign *c, base_error *err) {
  if (v->type != YAML_SEQUENCE_NODE) {
    return yaml_fail(f, v, "parts", "need a list of parts", err);
  }
  const size_t n = (size_t)(v->data.sequence.items.top - v->data.sequence.items.start);
  c->part = calloc(n + 1, sizeof *c->part);
  if (c->part == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %zu parts", f->path, n);
  }
  for (size_t i = 0; i < n; i++) {
    yaml_node_t *node = yaml_item(f, v->data.sequence.items.start[i]);
    BASE_TRY(read_part(f, node, c->quick, &c->part[c->n_part++], err));
  }
  return (n > 0) ? BASE_OK : yaml_fail(f, v, "parts", "the list is empty", err);
}

/* ---- campaign ---------------------------------------------------------------------------------*/

static base_status take_quick(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                              base_error *err) {
  campaign_reader *r = ctx;
  if (yaml_is(f, key, "limits")) {
    return yaml_members(f, v, key, take_limit, &r->c->limits, err);
  }
  if (yaml_is(f, key, "sampling")) {
    return yaml_members(f, v, key, take_sampling, r, err);
  }
  return BASE_EUNSUPPORTED;
}

static base_status take_campaign(void *ctx, yaml_file *f, const char *key, yaml_node_t *v,
                                 base_error *err) {
  campaign_reader *r = ctx;
  campaign *c = r->c;
  if (yaml_is(f, key, "name")) {
    BASE_TRY(text_member(f, key, v, c->name, sizeof c->name, err));
    return (strchr(c->name, '/') == NULL)
               ? BASE_OK
               : yaml_fail(f, v, key, "need a name without /: it becomes a folder", err);
  }
  if (yaml_is(f, key, "title")) {
    return text_member(f, key, v, c->title, sizeof c->title, err);
  }
  if (yaml_is(f, key, "seed")) {
    double seed = 0.0;
    BASE_TRY(real_member(f, key, v, 0.0, &seed, err));
    if (seed > 9007199254740992.0 || seed != floor(seed)) {
      return yaml_fail(f, v, key, "need an integer up to 2^53", err);
    }
    c->seed = (uint64_t)seed;
    return BASE_OK;
  }
  if (yaml_is(f, key, "solutions")) {
    return word_member(f, key, v, "off", "on", &c->solutions, err);
  }
  if (yaml_is(f, key, "trace")) {
    return word_member(f, key, v, "off", "on", &c->trace, err);
  }
  if (yaml_is(f, key, "parts")) {
    return read_parts(f, v, c, err);
  }
  if (yaml_is(f, key, "quick")) {
    r->quick = v;
    return BASE_OK;
  }
  return take_quick(r, f, key, v, err);
}

const char *campaign_directory(void) {
  static char installed[4096];
  const char *dir = getenv("LCPBENCH_CAMPAIGNS");
  if (dir != NULL && dir[0] != '\0') {
    return dir;
  }
  return installed_data("campaigns", installed, sizeof installed) ? installed
                                                                  : LCPBENCH_CAMPAIGN_DIR;
}

static void locate(const char *text, char *path, size_t cap) {
  const size_t n = strlen(text);
  const bool file =
      (n > 5 && strcmp(text + n - 5, ".yaml") == 0) || (n > 4 && strcmp(text + n - 4, ".yml") == 0);
  (void)snprintf(path, cap, file ? "%s%s" : "%s/%s.yaml", file ? "" : campaign_directory(), text);
}

static base_status read_file(yaml_file *f, campaign *c, base_error *err) {
  campaign_reader r = {.c = c};
  BASE_TRY(yaml_members(f, yaml_root(f), "the campaign", take_campaign, &r, err));
  if (r.quick != NULL && c->quick) {
    BASE_TRY(yaml_members(f, r.quick, "quick", take_quick, &r, err));
  }
  if (c->name[0] == '\0' || c->n_part == 0) {
    return yaml_fail(f, yaml_root(f), c->n_part == 0 ? "parts" : "name", "the campaign has none",
                     err);
  }
  if (c->sampling.max_samples < c->sampling.samples) {
    return yaml_fail(f, r.samples, "max_samples", "is below samples", err);
  }
  return BASE_OK;
}

/* `path` cannot be read, which was looked for as `text`. */
static base_status unknown_campaign(const char *text, const char *path, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  char pattern[600];
  const char *why = strerror(errno);
  base_nearest near = base_nearest_to(text, strlen(text));
  glob_t found;
  (void)snprintf(pattern, sizeof pattern, "%.590s/*.yaml", campaign_directory());
  if (glob(pattern, 0, NULL, &found) == 0) {
    for (size_t i = 0; i < found.gl_pathc; i++) {
      char name[BASE_NEAREST_WORD];
      const char *file = strrchr(found.gl_pathv[i], '/') + 1;
      (void)snprintf(name, sizeof name, "%.*s", (int)(strlen(file) - strlen(".yaml")), file);
      base_nearest_offer(&near, name);
    }
    globfree(&found);
  }
  return BASE_FAIL(err, BASE_EINVAL, "campaign '%.80s': %.150s: %s; see lcpbench list campaigns%s",
                   text, path, why, base_nearest_hint(&near, hint));
}

base_status campaign_read(const char *text, bool quick, campaign *out, base_error *err) {
  *out = (campaign){.quick = quick, .solutions = true, .seed = 1};
  out->limits = (campaign_limits){.time = 60.0, .grace = 2.0, .memory = 4.0 * 1073741824.0};
  out->sampling = (campaign_sampling){.processes = 5,
                                      .samples = 7,
                                      .max_samples = 31,
                                      .half_width = 0.02,
                                      .budget = 30.0,
                                      .inner = 0.01};
  locate(text, out->path, sizeof out->path);
  if (access(out->path, R_OK) != 0) {
    return unknown_campaign(text, out->path, err);
  }
  yaml_file f;
  BASE_TRY(yaml_file_open(out->path, &f, err));
  const base_status done = read_file(&f, out, err);
  yaml_file_close(&f);
  if (done != BASE_OK) {
    campaign_free(out);
  }
  return done;
}

void campaign_free(campaign *c) {
  for (int i = 0; i < c->n_part; i++) {
    for (int a = 0; a < AXIS_COUNT; a++) {
      text_list_free(&c->part[i].axis[a]);
    }
  }
  free(c->part);
  c->part = NULL;
  c->n_part = 0;
}
