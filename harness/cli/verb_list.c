/* lcpbench list: what this build has. Plain format is bare names, one per line, for scripts. */
#include "harness/cli/cli.h"
#include "harness/cli/list_json.h"
#include "harness/measure/registry.h"
#include "harness/plan/campaign.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/table.h"
#include "lcp/base/nearest.h"
#include "problems/families/family.h"
#include "problems/scenes/scene.h"

#include <errno.h>
#include <glob.h>
#include <string.h>
#include <unistd.h>

/* One component as rows of a table: the first column is its name. */
enum { LIST_COLUMNS = 6 }; /* the last stays NULL */
typedef struct list_row {
  const char *cell[LIST_COLUMNS];
} list_row;

typedef struct list_kind {
  const char *name;
  const char *column[LIST_COLUMNS]; /* NULL-terminated when shorter */
  bool (*row)(int i, list_row *out, char *scratch, size_t cap);
  int told;                       /* the column that says in words what it is */
  void (*more)(int i, json_t *o); /* members that JSON has and the table has not; NULL: none */
} list_kind;

/* "name [unit] = default (min..max)" of every option. */
static const char *describe(const base_field *f, int nf, char *buf, size_t cap) {
  size_t used = 0;
  buf[0] = '\0';
  for (int i = 0; i < nf && used < cap; i++) {
    int wrote = 0;
    if (f[i].kind == BASE_CHOICE) {
      wrote = snprintf(buf + used, cap - used, "%s%s=%s", i > 0 ? " " : "", f[i].name, f[i].words);
    } else {
      wrote = snprintf(buf + used, cap - used, "%s%s=%g[%s]", i > 0 ? " " : "", f[i].name,
                       f[i].dflt, f[i].unit);
    }
    used += (size_t)wrote;
  }
  return buf;
}

static bool solver_row(int i, list_row *out, char *scratch, size_t cap) {
  const lcp_solver *s = registry_solver(i);
  if (s == NULL) {
    return false;
  }
  *out = (list_row){{s->name, s->title, s->exact ? "exact" : "iterative",
                     describe(s->fields, s->n_fields, scratch, cap), s->cite}};
  return true;
}

static void solver_more(int i, json_t *o) {
  list_solver_more(o, registry_solver(i));
}

static void formulation_more(int i, json_t *o) {
  int count;
  list_formulation_more(o, formulations(&count)[i]);
}

static bool formulation_row(int i, list_row *out, char *scratch, size_t cap) {
  int count;
  const formulation *const *all = formulations(&count);
  if (i >= count) {
    return false;
  }
  const formulation *f = all[i];
  *out = (list_row){{f->name, f->title, (f->model & FORM_NO_LCP) ? "no_lcp" : "lcp",
                     describe(f->fields, f->n_fields, scratch, cap), f->cite}};
  return true;
}

static bool scene_row(int i, list_row *out, char *scratch, size_t cap) {
  int count;
  const scene *const *all = scenes(&count);
  if (i >= count) {
    return false;
  }
  const scene *s = all[i];
  *out = (list_row){
      {s->name, s->title, "scene", describe(s->fields, s->n_fields, scratch, cap), s->cite}};
  return true;
}

// NOLINTNEXTLINE(readability-non-const-parameter): the signature of list_kind.row
static bool effect_row(int i, list_row *out, char *scratch, size_t cap) {
  (void)scratch;
  (void)cap;
  if (i >= EFFECT_COUNT) {
    return false;
  }
  *out = (list_row){{effect_name(i), effect_words(i)}};
  return true;
}

// NOLINTNEXTLINE(readability-non-const-parameter): the signature of list_kind.row
static bool situation_row(int i, list_row *out, char *scratch, size_t cap) {
  (void)scratch;
  (void)cap;
  const int at = i + 1; /* without SITUATION_OTHER */
  if (at >= SITUATION_COUNT) {
    return false;
  }
  *out = (list_row){
      {scene_situation_name((scene_situation)at), scene_situation_words((scene_situation)at)}};
  return true;
}

static bool problem_row(int i, list_row *out, char *scratch, size_t cap) {
  int count;
  const lcp_family *const *all = lcp_families(&count);
  if (i >= count) {
    return false;
  }
  const lcp_family *f = all[i];
  *out = (list_row){
      {f->name, f->title, "family", describe(f->fields, f->n_fields, scratch, cap), f->cite}};
  return true;
}

/* Shipped campaigns: the .yaml files of the campaign directory, sorted. */
static bool campaign_row(int i, list_row *out, char *scratch, size_t cap) {
  char pattern[600];
  glob_t found;
  (void)snprintf(pattern, sizeof pattern, "%s/*.yaml", campaign_directory());
  if (glob(pattern, 0, NULL, &found) != 0) {
    return false;
  }
  const bool any = (size_t)i < found.gl_pathc;
  if (any) {
    const char *path = found.gl_pathv[i];
    const char *name = strrchr(path, '/') + 1;
    const size_t len = strlen(name) - strlen(".yaml");
    (void)snprintf(scratch, cap, "%.*s", (int)len, name);
    campaign c;
    char *title = scratch + len + 1;
    title[0] = '\0';
    if (campaign_read(scratch, false, &c, NULL) == BASE_OK) {
      (void)snprintf(title, cap - len - 1, "%s", c.title);
      campaign_free(&c);
    }
    *out = (list_row){{scratch, title}};
  }
  globfree(&found);
  return any;
}

/* Its parts that have words of their own, for readers of its rows: parts [{name, words}]. */
static void campaign_more(int i, json_t *o) {
  (void)i;
  campaign c;
  json_t *parts = json_array();
  const char *name = json_string_value(json_object_get(o, "name"));
  if (name != NULL && campaign_read(name, false, &c, NULL) == BASE_OK) {
    for (int p = 0; p < c.n_part; p++) {
      if (c.part[p].words[0] != '\0') {
        json_t *part = json_object();
        json_out_text(part, "name", c.part[p].name);
        json_out_text(part, "words", c.part[p].words);
        (void)json_array_append_new(parts, part);
      }
    }
    campaign_free(&c);
  }
  (void)json_object_set_new(o, "parts", parts);
}

/* What of the formulation's blocks the solver does not take; by declaration, without a problem. */
static const char *compat_verdict(const formulation *f, const lcp_solver *s) {
  const unsigned missing = f->sets & ~s->sets;
  if (f->sets == 0) {
    return "no: the formulation poses no problem";
  }
  if ((missing & 1u << LCP_CONE) != 0) {
    return "no: needs the second-order cone";
  }
  if ((missing & 1u << LCP_BOX) != 0) {
    return "no: needs boxes";
  }
  if (missing != 0) {
    return "no: needs the orthant";
  }
  return (s->needs != 0) ? "where the problem has the traits the solver needs" : "yes";
}

/* i runs over formulation x solver. */
static bool compat_row(int i, list_row *out, char *scratch, size_t cap) {
  int n_form;
  const formulation *const *all = formulations(&n_form);
  int n_solver = 0;
  while (registry_solver(n_solver) != NULL) {
    n_solver++;
  }
  if (n_solver == 0 || i >= n_form * n_solver) {
    return false;
  }
  const formulation *f = all[i / n_solver];
  const lcp_solver *s = registry_solver(i % n_solver);
  (void)snprintf(scratch, cap, "%s x %s", f->name, s->name);
  *out = (list_row){{scratch, f->name, s->name, compat_verdict(f, s)}};
  return true;
}

static base_status campaigns_exist(base_error *err) {
  const char *dir = campaign_directory();
  return (access(dir, R_OK) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%s: %s; LCPBENCH_CAMPAIGNS names another folder", dir,
                         strerror(errno));
}

static const list_kind kinds[] = {
    {"problems", {"name", "title", "kind", "options", "cite"}, problem_row, 1, NULL},
    {"scenes", {"name", "title", "kind", "options", "cite"}, scene_row, 1, NULL},
    {"formulations",
     {"name", "title", "kind", "options", "cite"},
     formulation_row,
     1,
     formulation_more},
    {"solvers", {"name", "title", "kind", "options", "cite"}, solver_row, 1, solver_more},
    {"campaigns", {"name", "title"}, campaign_row, 1, campaign_more},
    {"effects", {"name", "words"}, effect_row, 1, NULL},
    {"situations", {"name", "words"}, situation_row, 1, NULL},
    {"compat", {"name", "formulation", "solver", "admits"}, compat_row, 3, NULL},
};

static json_t *row_json(const list_row *r, const list_kind *k) {
  json_t *o = json_object();
  for (int c = 0; c < LIST_COLUMNS && k->column[c] != NULL; c++) {
    json_out_text(o, k->column[c], r->cell[c]);
  }
  return o;
}

/* Scenes are whole objects in JSON: parameters, effects, predictions. */
static int print_scenes_json(void) {
  int n;
  const scene *const *all = scenes(&n);
  json_t *list = json_array();
  base_error err = {0};
  for (int i = 0; i < n; i++) {
    json_t *o;
    if (list_scene_json(all[i], &o, &err) != BASE_OK) {
      json_decref(list);
      return cli_report(&err);
    }
    (void)json_array_append_new(list, o);
  }
  return json_out_print(list, stdout) ? CLI_OK : CLI_INTERNAL;
}

static int print_names(const list_kind *k) {
  char scratch[4096];
  list_row row;
  for (int i = 0; k->row(i, &row, scratch, sizeof scratch); i++) {
    (void)printf("%s\n", row.cell[0]);
  }
  return CLI_OK;
}

/* For a terminal: the name and what it is, without the options. */
static int print_kind(const list_kind *k, const char *format) {
  char scratch[4096];
  list_row row;
  json_t *all = json_array();
  const char *const brief[] = {k->column[0], k->column[k->told], NULL};
  const bool words = strcmp(format, "table") == 0;
  for (int i = 0; k->row(i, &row, scratch, sizeof scratch); i++) {
    json_t *o = row_json(&row, k);
    if (k->more != NULL && strcmp(format, "json") == 0) {
      k->more(i, o);
    }
    (void)json_array_append_new(all, o);
  }
  return table_print(all, words ? brief : k->column, format, stdout) ? CLI_OK : CLI_INTERNAL;
}

typedef struct list_options {
  const char *format;
} list_options;

static const arg_option options[] = {
    ARG(list_options, format, "--format", ARG_TEXT, "plain|table|csv|json",
        "bare names, or the columns; a terminal gets names with titles, a pipe bare names where "
        "none is given"),
};
static const arg_table args = {
    options, BASE_COUNT(options),
    1,       1,
    "KIND",  "problems, scenes, formulations, solvers, campaigns, effects, situations or compat"};

static int run(int argc, char **argv) {
  list_options o = {.format = isatty(STDOUT_FILENO) ? "table" : "plain"};
  const char *what;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &what, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  const bool plain = strcmp(o.format, "plain") == 0;
  if (!plain && table_format(o.format, &err) != BASE_OK) {
    return cli_report(&err);
  }
  for (int i = 0; i < BASE_COUNT(kinds); i++) {
    if (strcmp(kinds[i].name, what) == 0) {
      if (strcmp(what, "scenes") == 0 && strcmp(o.format, "json") == 0) {
        return print_scenes_json();
      }
      if (strcmp(what, "campaigns") == 0 && campaigns_exist(&err) != BASE_OK) {
        return cli_report(&err);
      }
      return plain ? print_names(&kinds[i]) : print_kind(&kinds[i], o.format);
    }
  }
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(what, strlen(what));
  for (int i = 0; i < BASE_COUNT(kinds); i++) {
    base_nearest_offer(&near, kinds[i].name);
  }
  (void)BASE_FAIL(&err, BASE_EINVAL, "list '%.100s': need %s%s", what, args.positional_help,
                  base_nearest_hint(&near, hint));
  return cli_report(&err);
}

extern const cli_verb verb_list;
const cli_verb verb_list = {
    .name = "list",
    .args = &args,
    .help = "what this build has",
    .run = run,
};
