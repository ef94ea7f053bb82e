#include "harness/campaign/compare.h"

#include "harness/cell/stats.h"
#include "lcp/base/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COMPARE_SAMPLES = 1024, COMPARE_PROCESSES = 64, BOOTSTRAP = 1000 };

/* Samples of one cell, process by process. */
typedef struct samples {
  int n_process, start[COMPARE_PROCESSES + 1];
  double x[COMPARE_SAMPLES];
} samples;

static bool usable(const record *r, const char *column) {
  return strcmp(r->status, "ok") == 0 && record_real(r, column) > 0.0;
}

/* The rows of one cell, process by process. */
typedef struct span {
  const row_ref *row;
  int n;
  const record *first; /* in the file */
} span;

static void collect(const span *cell, const char *column, samples *out) {
  int n = 0;
  int64_t process = -1;
  out->n_process = 0;
  for (int i = 0; i < cell->n && n < COMPARE_SAMPLES; i++) {
    const record *r = cell->row[i].r;
    const bool same_class = strcmp(r->host_class, cell->first->host_class) == 0;
    if (!same_class || !usable(r, column)) { /* times of one class of machine */
      continue;
    }
    if (r->process != process) {
      if (out->n_process == COMPARE_PROCESSES) {
        break;
      }
      out->start[out->n_process++] = n;
      process = r->process;
    }
    out->x[n++] = record_real(r, column);
  }
  out->start[out->n_process] = n;
}

static int count(const samples *s) {
  return s->start[s->n_process];
}

static double median_of(const samples *s) {
  double sorted[COMPARE_SAMPLES];
  memcpy(sorted, s->x, (size_t)count(s) * sizeof *sorted);
  stats_sort(sorted, count(s));
  return stats_median(sorted, count(s));
}

static int draw(base_rng *rng, int n) {
  return (int)(base_rng_uniform(rng) * n);
}

static double resampled_median(const samples *s, base_rng *rng) {
  double x[COMPARE_SAMPLES];
  int n = 0;
  for (int p = 0; p < s->n_process; p++) {
    const int from = draw(rng, s->n_process);
    const int size = s->start[from + 1] - s->start[from];
    for (int k = 0; k < size && n < COMPARE_SAMPLES; k++) {
      x[n++] = s->x[s->start[from] + draw(rng, size)];
    }
  }
  stats_sort(x, n);
  return stats_median(x, n);
}

static void judge(const samples *a, const samples *b, compare_pair *out) {
  double ratio[BOOTSTRAP];
  base_rng rng = base_rng_seeded(1);
  for (int k = 0; k < BOOTSTRAP; k++) {
    ratio[k] = resampled_median(b, &rng) / resampled_median(a, &rng);
  }
  stats_sort(ratio, BOOTSTRAP);
  out->median_a = median_of(a);
  out->median_b = median_of(b);
  out->ratio = out->median_b / out->median_a;
  out->lo = stats_quantile(ratio, BOOTSTRAP, 0.025);
  out->hi = stats_quantile(ratio, BOOTSTRAP, 0.975);
  out->n_a = count(a);
  out->n_b = count(b);
  const bool outside = fabs(log(out->ratio)) > out->floor;
  if (out->word == COMPARE_DISTURBED) {
    return;
  }
  out->word = COMPARE_SAME;
  if (outside && out->hi < 1.0) {
    out->word = COMPARE_FASTER;
  } else if (outside && out->lo > 1.0) {
    out->word = COMPARE_SLOWER;
  }
}

/* ---- pairing ----------------------------------------------------------------------------------*/

/* The cells of one side. */
typedef struct side {
  row_ref *row; /* by cell, process, repetition; owned */
  span *cell;   /* owned */
  int n;
} side;

static int by_cell(const void *a, const void *b) {
  const record *x = ((const row_ref *)a)->r;
  const record *y = ((const row_ref *)b)->r;
  const int order = strcmp(x->cell_id, y->cell_id);
  if (order != 0) {
    return order;
  }
  if (x->process != y->process) {
    return (x->process < y->process) ? -1 : 1;
  }
  return (x > y) - (x < y);
}

static int by_place(const void *a, const void *b) {
  const record *x = ((const span *)a)->first;
  const record *y = ((const span *)b)->first;
  return (x > y) - (x < y);
}

static int order_of(double x, double y) {
  const double a = isnan(x) ? -1.0 : x;
  const double b = isnan(y) ? -1.0 : y;
  return (a > b) - (a < b);
}

/* 0: the same experiment, whatever the solver. */
static int experiment(const record *a, const record *b) {
  const char *const pair[][2] = {{a->part, b->part},
                                 {a->problem, b->problem},
                                 {a->formulation, b->formulation},
                                 {a->formulation_config, b->formulation_config},
                                 {a->start, b->start},
                                 {a->effects, b->effects},
                                 {a->contact_order, b->contact_order},
                                 {a->islands, b->islands}};
  int order = order_of(a->step_s, b->step_s);
  for (int i = 0; order == 0 && i < BASE_COUNT(pair); i++) {
    order = strcmp(pair[i][0], pair[i][1]);
  }
  return order;
}

static int by_experiment(const void *a, const void *b) {
  const int order = experiment(((const span *)a)->first, ((const span *)b)->first);
  return (order != 0) ? order : by_place(a, b);
}

static void side_close(side *s) {
  free(s->row);
  free(s->cell);
}

static base_status side_open(const compare_side *from, side *s, base_error *err) {
  const record_table *t = from->rows;
  int n = 0;
  *s = (side){.row = calloc((size_t)t->n + 1, sizeof *s->row),
              .cell = calloc((size_t)t->n + 1, sizeof *s->cell)};
  if (s->row == NULL || s->cell == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to compare %d rows", t->n);
  }
  for (int i = 0; i < t->n; i++) {
    if (from->solver == NULL || strcmp(t->row[i].solver, from->solver) == 0) {
      s->row[n++].r = &t->row[i];
    }
  }
  qsort(s->row, (size_t)n, sizeof *s->row, by_cell);
  for (int i = 0; i < n; i++) {
    const record *r = s->row[i].r;
    if (i == 0 || strcmp(r->cell_id, s->row[i - 1].r->cell_id) != 0) {
      s->cell[s->n++] = (span){&s->row[i], 0, r};
    }
    span *c = &s->cell[s->n - 1];
    c->n++;
    c->first = (r < c->first) ? r : c->first;
  }
  qsort(s->cell, (size_t)s->n, sizeof *s->cell, by_place);
  return BASE_OK;
}

/* Without the limit that a campaign sets: it does not change what ends before it. */
static void without_limit(const char *config, char *buf, size_t cap) {
  static const char key[] = "max_seconds=";
  const char *at = strstr(config, key);
  const char *rest = (at != NULL) ? at + strcspn(at, ",") : "";
  const size_t before = (at != NULL) ? (size_t)(at - config) : strlen(config);
  (void)snprintf(buf, cap, "%.*s%s", (int)before, config, rest);
}

static bool same_solver(const record *a, const record *b) {
  char of_a[sizeof a->solver_config];
  char of_b[sizeof b->solver_config];
  without_limit(a->solver_config, of_a, sizeof of_a);
  without_limit(b->solver_config, of_b, sizeof of_b);
  return strcmp(a->solver, b->solver) == 0 && strcmp(of_a, of_b) == 0;
}

/* The first cell of b (sorted by experiment) that is a's partner; NULL: it has none. */
static const span *partner(const span *a, const side *b, bool by_solver) {
  int lo = 0;
  int hi = b->n;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (experiment(b->cell[mid].first, a->first) < 0) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  for (; lo < b->n && experiment(b->cell[lo].first, a->first) == 0; lo++) {
    if (!by_solver || same_solver(b->cell[lo].first, a->first)) {
      return &b->cell[lo];
    }
  }
  return NULL;
}

const char *compare_disturbed(const record *r, const char *column) {
  const bool others =
      isnan(r->load_other) ? r->load1 > 1.0 + COMPARE_OTHERS : r->load_other > COMPARE_OTHERS;
  if (strcmp(column, "t_cpu_s") == 0) {
    return (r->throttled == 1) ? "throttled" : NULL;
  }
  return record_has_flag(r, "canary_drift") ? "canary_drift"
         : (r->throttled == 1)              ? "throttled"
         : others                           ? "other work"
                                            : NULL;
}

static bool any_disturbed(const span *cell, const char *column) {
  bool any = false;
  for (int i = 0; i < cell->n && !any; i++) {
    any = compare_disturbed(cell->row[i].r, column) != NULL;
  }
  return any;
}

/* |log ratio| of the canaries before the two cells: how far the machine itself moved between them. */
static double drift(const span *a, const span *b) {
  const double ratio = b->first->canary_s / a->first->canary_s;
  return (ratio > 0.0 && isfinite(ratio)) ? fabs(log(ratio)) : 0.0;
}

static bool solved(const span *cell) {
  bool all = true;
  for (int i = 0; i < cell->n; i++) {
    all = all && strcmp(cell->row[i].r->status, "ok") == 0;
  }
  return all;
}

/* Is there a ratio? Where one side failed there is none, and the pair counts as a failure of it. */
static bool both_solved(const span *a, const span *b, const samples x[2], compare_failures *f) {
  const bool a_solved = solved(a);
  const bool b_solved = solved(b);
  f->both += !a_solved && !b_solved;
  f->a += !a_solved && b_solved;
  f->b += a_solved && !b_solved;
  const bool enough = count(&x[0]) > 1 && count(&x[1]) > 1;
  f->few += a_solved && b_solved && !enough;
  return a_solved && b_solved && enough;
}

static void compare_cells(const span *a, const span *b, const char *column,
                          const doctor_floor *noise, samples x[2], compare_pair *p) {
  const bool disturbed = any_disturbed(a, column) || any_disturbed(b, column);
  *p = (compare_pair){.a = a->first,
                      .b = b->first,
                      .drift = drift(a, b),
                      .word = disturbed ? COMPARE_DISTURBED : COMPARE_SAME};
  p->floor = p->drift + doctor_floor_of(noise, fmax(p->a->workspace_B, p->b->workspace_B));
  judge(&x[0], &x[1], p);
}

base_status compare_sides(const compare_side *a, const compare_side *b, const char *column,
                          const doctor_floor *noise, compare_pair **out, int *n,
                          compare_failures *failed, base_error *err) {
  const bool by_solver = a->solver == NULL && b->solver == NULL;
  side sa = {0};
  side sb = {0};
  *n = 0;
  *failed = (compare_failures){0};
  *out = calloc((size_t)a->rows->n + 1, sizeof **out);
  samples *x = calloc(2, sizeof *x);
  base_status done = (*out != NULL && x != NULL)
                         ? side_open(a, &sa, err)
                         : BASE_FAIL(err, BASE_ENOMEM, "no memory to compare %d rows", a->rows->n);
  if (done == BASE_OK) {
    done = side_open(b, &sb, err);
  }
  if (done == BASE_OK) {
    qsort(sb.cell, (size_t)sb.n, sizeof *sb.cell, by_experiment);
  }
  for (int i = 0; done == BASE_OK && i < sa.n; i++) {
    const span *found = partner(&sa.cell[i], &sb, by_solver);
    if (found != NULL) {
      collect(&sa.cell[i], column, &x[0]);
      collect(found, column, &x[1]);
      if (both_solved(&sa.cell[i], found, x, failed)) {
        compare_cells(&sa.cell[i], found, column, noise, x, &(*out)[(*n)++]);
      }
    }
  }
  side_close(&sa);
  side_close(&sb);
  free(x);
  return done;
}
