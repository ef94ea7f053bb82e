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
enum { HEAD = 6, COLUMNS_MOST = 40 };

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

/* The level of error in a scene's rows that counts for E. */
static double level_of(const table *t, const char *problem, double E) {
  double best = 0.0;
  double least = HUGE_VAL;
  for (int i = 0; i < t->n; i++) {
    if (strcmp(t->row[i].problem, problem) == 0) {
      const double e = t->row[i].error;
      least = fmin(least, e);
      best = (e <= E * (1.0 + 1e-9)) ? fmax(best, e) : best;
    }
  }
  return (best > 0.0) ? best : least;
}

/* Time of every combination in one scene, HUGE_VAL where it did not keep the error; the least of them. */
static double times_of(const table *t, const char *problem, double E, double seconds[CHOICE_MOST]) {
  const double level = level_of(t, problem, E);
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

static void rank(const table *t, const scene_near *near, int n, double E) {
  choice *c = t->out;
  double log_cost[CHOICE_MOST] = {0};
  double kept[CHOICE_MOST] = {0};
  double weight = 0.0;
  double far = 0.0;
  for (int k = 0; k < n && c->n_near < CHOICE_NEAR; k++) {
    const char *problem = t->row[near[k].row].problem;
    double seconds[CHOICE_MOST];
    const double best = times_of(t, problem, E, seconds);
    if (!(best < HUGE_VAL)) {
      continue; /* nobody keeps this error there: says nothing of who does */
    }
    const double w = pow(CHOICE_SOFT + near[k].distance, -2.0);
    for (int i = 0; i < c->n; i++) {
      const bool good = seconds[i] < HUGE_VAL;
      log_cost[i] += w * log(good ? seconds[i] / best : CHOICE_FAILED);
      kept[i] += good ? w : 0.0;
    }
    weight += w;
    far += w * near[k].distance;
    (void)snprintf(c->near[c->n_near], sizeof c->near[0], "%s", problem);
    c->distance[c->n_near++] = near[k].distance;
  }
  for (int i = 0; i < c->n && weight > 0.0; i++) {
    c->candidate[i].cost = exp(log_cost[i] / weight);
    c->candidate[i].sure = kept[i] / weight / (1.0 + far / weight);
  }
  qsort(c->candidate, (size_t)c->n, sizeof c->candidate[0], cheaper);
}

static base_status choose(table *t, const features *f, double E, base_error *err) {
  scene_near *near = malloc((size_t)t->n * sizeof *near);
  if (near == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d scenes", t->n);
  }
  t->out->n_scene = scenes_of(t, f, near);
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
