#include "harness/control/choice.h"

#include "harness/util/folder.h"
#include "harness/util/installed.h"
#include "lcp/base/fields.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* problem, error, formulation, solver, kept, t_total_s, then the features; others may follow */
enum { HEAD = 6, COLUMNS_MOST = 40, LEVELS_MOST = 64 };

typedef struct row {
  char problem[CHOICE_TEXT];
  int combination; /* among the candidates */
  double error, seconds;
  bool kept;
  features f;
} row;

typedef struct table {
  choice *out;
  row *row;
  int n, cap;
} table;

/* ---- reading --------------------------------------------------------------------------------- */

static int split(char *line, char *column[COLUMNS_MOST]) {
  int n = 0;
  line[strcspn(line, "\r\n")] = '\0';
  for (char *at = line; at != NULL && n < COLUMNS_MOST; n++) {
    column[n] = strsep(&at, "\t");
  }
  return n;
}

static base_status header_fits(char *column[COLUMNS_MOST], int n, const char *path,
                               base_error *err) {
  static const char *const head[HEAD] = {"problem", "error", "formulation",
                                         "solver",  "kept",  "t_total_s"};
  for (int i = 0; i < HEAD + FEATURES; i++) {
    const char *want = (i < HEAD) ? head[i] : features_name(i - HEAD);
    if (i >= n || strcmp(column[i], want) != 0) {
      return BASE_FAIL(err, BASE_EINVAL, "%.200s: column %d is not %s", path, i + 1, want);
    }
  }
  return BASE_OK;
}

/* The candidate of these names, a new one if there is none; -1: too many. */
static int combination(choice *c, const char *formulation, const char *solver) {
  for (int i = 0; i < c->n; i++) {
    if (strcmp(c->candidate[i].formulation, formulation) == 0 &&
        strcmp(c->candidate[i].solver, solver) == 0) {
      return i;
    }
  }
  if (c->n == CHOICE_MOST) {
    return -1;
  }
  choice_candidate *a = &c->candidate[c->n];
  (void)snprintf(a->formulation, sizeof a->formulation, "%s", formulation);
  (void)snprintf(a->solver, sizeof a->solver, "%s", solver);
  return c->n++;
}

static bool read_row(table *t, char *column[COLUMNS_MOST], int n, row *r) {
  if (n < HEAD + FEATURES) {
    return false;
  }
  (void)snprintf(r->problem, sizeof r->problem, "%s", column[0]);
  r->combination = combination(t->out, column[2], column[3]);
  r->kept = strcmp(column[4], "1") == 0;
  bool good = r->combination >= 0 && (r->kept || strcmp(column[4], "0") == 0) &&
              base_parse_real(column[1], &r->error) && r->error > 0.0 &&
              base_parse_real(column[5], &r->seconds) && r->seconds > 0.0;
  for (int i = 0; i < FEATURES; i++) {
    good = good && base_parse_real(column[HEAD + i], &r->f.x[i]);
  }
  return good;
}

static base_status read_rows(table *t, FILE *from, const char *path, base_error *err) {
  char line[2048];
  char *column[COLUMNS_MOST];
  if (fgets(line, sizeof line, from) == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%.200s: empty, need a header and rows", path);
  }
  BASE_TRY(header_fits(column, split(line, column), path, err));
  for (int at = 2; fgets(line, sizeof line, from) != NULL; at++) {
    if (t->n == t->cap) {
      t->cap = 2 * t->cap + 256;
      row *grown = realloc(t->row, (size_t)t->cap * sizeof *grown);
      if (grown == NULL) {
        return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d rows", t->cap);
      }
      t->row = grown;
    }
    if (!read_row(t, column, split(line, column), &t->row[t->n])) {
      return BASE_FAIL(err, BASE_EINVAL, "%.200s, line %d: no row of measured errors", path, at);
    }
    t->n++;
  }
  return (t->n > 0) ? BASE_OK : BASE_FAIL(err, BASE_EINVAL, "%.200s: no rows", path);
}

static void locate(const char *path, char *file, size_t cap) {
  struct stat s;
  if (path == NULL) {
    if (!installed_data("choices.tsv", file, cap)) {
      (void)snprintf(file, cap, "%s", LCPBENCH_CHOICES);
    }
  } else if (stat(path, &s) == 0 && S_ISDIR(s.st_mode)) {
    folder_file(path, "choices.tsv", file, cap);
  } else {
    (void)snprintf(file, cap, "%s", path);
  }
}

/* ---- choosing -------------------------------------------------------------------------------- */

/* A scene of the rows: its first row. */
typedef struct scene_near {
  int row;
  double distance;
} scene_near;

static int nearer(const void *a, const void *b) {
  const scene_near *x = a;
  const scene_near *y = b;
  return (x->distance != y->distance) ? (x->distance > y->distance) - (x->distance < y->distance)
                                      : (x->row > y->row) - (x->row < y->row);
}

static int scenes_of(const table *t, const features *f, scene_near *near) {
  int n = 0;
  for (int i = 0; i < t->n; i++) {
    bool seen = false;
    for (int k = 0; k < n && !seen; k++) {
      seen = strcmp(t->row[near[k].row].problem, t->row[i].problem) == 0;
    }
    if (!seen) {
      near[n++] = (scene_near){i, features_distance(f, &t->row[i].f)};
    }
  }
  qsort(near, (size_t)n, sizeof *near, nearer);
  return n;
}

/* The levels of error in a scene's rows and their shares of its weight, which add up to 1; -1: more than LEVELS_MOST. */
static int levels_of(const table *t, const char *problem, double E, double level[LEVELS_MOST],
                     double share[LEVELS_MOST]) {
  int n = 0;
  double sum = 0.0;
  for (int i = 0; i < t->n; i++) {
    bool seen = strcmp(t->row[i].problem, problem) != 0;
    for (int k = 0; k < n && !seen; k++) {
      seen = level[k] == t->row[i].error;
    }
    if (!seen && n == LEVELS_MOST) {
      return -1;
    }
    if (!seen) {
      level[n] = t->row[i].error;
      share[n] = pow(CHOICE_DECADE, fabs(log10(level[n] / E)));
      sum += share[n++];
    }
  }
  for (int k = 0; k < n; k++) {
    share[k] /= sum;
  }
  return n;
}

/* The level that stands for E: the largest not above it, otherwise the least; its index. */
static int level_for(const double level[LEVELS_MOST], int n, double E) {
  int best = 0;
  for (int k = 1; k < n; k++) {
    const bool fits = level[k] <= E * (1.0 + 1e-9);
    const bool fitted = level[best] <= E * (1.0 + 1e-9);
    if ((fits == fitted) ? (level[k] > level[best]) == fits : fits) {
      best = k;
    }
  }
  return best;
}

/* Time of every combination to one level in one scene, HUGE_VAL where it did not keep the error; the least of them. */
static double times_of(const table *t, const char *problem, double level,
                       double seconds[CHOICE_MOST]) {
  double best = HUGE_VAL;
  for (int c = 0; c < t->out->n; c++) {
    seconds[c] = HUGE_VAL;
  }
  for (int i = 0; i < t->n; i++) {
    const row *r = &t->row[i];
    if (strcmp(r->problem, problem) == 0 && r->error == level && r->kept) {
      seconds[r->combination] = fmin(seconds[r->combination], r->seconds);
      best = fmin(best, r->seconds);
    }
  }
  return best;
}

static int cheaper(const void *a, const void *b) {
  const choice_candidate *x = a;
  const choice_candidate *y = b;
  if (x->cost != y->cost) {
    return (x->cost > y->cost) - (x->cost < y->cost);
  }
  const int form = strcmp(x->formulation, y->formulation);
  return (form != 0) ? form : strcmp(x->solver, y->solver);
}

/* Sums over the scenes that count, by weight. */
typedef struct tally {
  double log_cost[CHOICE_MOST], weight[CHOICE_MOST]; /* over all levels of error */
  double kept[CHOICE_MOST], far, at_E;               /* over the levels that stand for E */
} tally;

/* Adds what a scene at this distance says; false: nobody keeps any of its levels, so that it says nothing of who does. */
static bool count_scene(const table *t, const char *problem, double E, double distance, tally *of) {
  double level[LEVELS_MOST];
  double share[LEVELS_MOST];
  const int n = levels_of(t, problem, E, level, share);
  const int asked = level_for(level, n, E);
  const double w = pow(CHOICE_SOFT + distance, -2.0);
  bool says = false;
  for (int k = 0; k < n; k++) {
    double seconds[CHOICE_MOST];
    const double best = times_of(t, problem, level[k], seconds);
    if (!(best < HUGE_VAL)) {
      continue;
    }
    says = true;
    of->at_E += (k == asked) ? w : 0.0;
    of->far += (k == asked) ? w * distance : 0.0;
    for (int i = 0; i < t->out->n; i++) {
      const bool good = seconds[i] < HUGE_VAL;
      of->kept[i] += (good && k == asked) ? w : 0.0;
      if (good || level[k] >= level[asked]) { /* nobody asks it for a smaller error than E */
        of->log_cost[i] += w * share[k] * log(good ? seconds[i] / best : CHOICE_FAILED);
        of->weight[i] += w * share[k];
      }
    }
  }
  return says;
}

static void rank(const table *t, const scene_near *near, int n, double E) {
  choice *c = t->out;
  tally of = {0};
  for (int k = 0; k < n && c->n_near < CHOICE_NEAR; k++) {
    const char *problem = t->row[near[k].row].problem;
    if (count_scene(t, problem, E, near[k].distance, &of)) {
      (void)snprintf(c->near[c->n_near], sizeof c->near[0], "%s", problem);
      c->distance[c->n_near++] = near[k].distance;
    }
  }
  for (int i = 0; i < c->n; i++) {
    c->candidate[i].cost =
        (of.weight[i] > 0.0) ? exp(of.log_cost[i] / of.weight[i]) : CHOICE_FAILED;
    c->candidate[i].sure = (of.at_E > 0.0) ? of.kept[i] / (of.at_E + of.far) : 0.0;
  }
  qsort(c->candidate, (size_t)c->n, sizeof c->candidate[0], cheaper);
}

static base_status choose(table *t, const features *f, double E, base_error *err) {
  scene_near *near = malloc((size_t)t->n * sizeof *near);
  if (near == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d scenes", t->n);
  }
  t->out->n_scene = scenes_of(t, f, near);
  for (int k = 0; k < t->out->n_scene; k++) {
    double level[LEVELS_MOST];
    double share[LEVELS_MOST];
    const char *problem = t->row[near[k].row].problem;
    if (levels_of(t, problem, E, level, share) < 0) {
      free(near);
      return BASE_FAIL(err, BASE_EINVAL, "%.200s: more than %d errors of %.80s", t->out->rows,
                       LEVELS_MOST, problem);
    }
  }
  t->out->n_row = t->n;
  rank(t, near, t->out->n_scene, E);
  free(near);
  return (t->out->n_near > 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "%.200s: no combination keeps an error of %g",
                         t->out->rows, E);
}

base_status choice_make(const features *f, double E, const char *path, choice *out,
                        base_error *err) {
  *out = (choice){0};
  table t = {.out = out};
  locate(path, out->rows, sizeof out->rows);
  FILE *from = fopen(out->rows, "r");
  if (from == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%.200s: rows of measured errors cannot be read", out->rows);
  }
  base_status done = read_rows(&t, from, out->rows, err);
  (void)fclose(from);
  if (done == BASE_OK) {
    done = choose(&t, f, E, err);
  }
  free(t.row);
  return done;
}
