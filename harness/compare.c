#include "harness/compare.h"

#include "harness/stats.h"
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

static void collect(const record_table *t, const char *id, const char *column, samples *out) {
  int n = 0;
  out->n_process = 0;
  for (int64_t process = 0; out->n_process < COMPARE_PROCESSES; process++) {
    bool any = false;
    out->start[out->n_process] = n;
    for (int i = 0; i < t->n && n < COMPARE_SAMPLES; i++) {
      const record *r = &t->row[i];
      if (r->process == process && strcmp(r->cell_id, id) == 0 && usable(r, column)) {
        out->x[n++] = record_real(r, column);
        any = true;
      }
    }
    if (!any) {
      break;
    }
    out->n_process++;
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
  out->word = COMPARE_SAME;
  if (outside && out->hi < 1.0) {
    out->word = COMPARE_FASTER;
  } else if (outside && out->lo > 1.0) {
    out->word = COMPARE_SLOWER;
  }
}

static bool same_experiment(const record *a, const record *b, bool by_solver) {
  const bool same = strcmp(a->part, b->part) == 0 && strcmp(a->problem, b->problem) == 0 &&
                    strcmp(a->formulation, b->formulation) == 0 &&
                    strcmp(a->formulation_config, b->formulation_config) == 0 &&
                    strcmp(a->start, b->start) == 0 && strcmp(a->effects, b->effects) == 0 &&
                    (a->step_s == b->step_s || (isnan(a->step_s) && isnan(b->step_s)));
  return same && (!by_solver || (strcmp(a->solver, b->solver) == 0 &&
                                 strcmp(a->solver_config, b->solver_config) == 0));
}

static bool first_of_cell(const record_table *t, int i) {
  for (int k = 0; k < i; k++) {
    if (strcmp(t->row[k].cell_id, t->row[i].cell_id) == 0) {
      return false;
    }
  }
  return true;
}

static bool takes(const compare_side *s, int i) {
  return (s->solver == NULL || strcmp(s->rows->row[i].solver, s->solver) == 0) &&
         first_of_cell(s->rows, i);
}

base_status compare_sides(const compare_side *a, const compare_side *b, const char *column,
                          const doctor_floor *noise, compare_pair **out, int *n, base_error *err) {
  const bool by_solver = a->solver == NULL && b->solver == NULL;
  *n = 0;
  *out = calloc((size_t)a->rows->n + 1, sizeof **out);
  samples *x = calloc(2, sizeof *x);
  if (*out == NULL || x == NULL) {
    free(x);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to compare %d rows", a->rows->n);
  }
  for (int i = 0; i < a->rows->n; i++) {
    if (!takes(a, i)) {
      continue;
    }
    for (int k = 0; k < b->rows->n; k++) {
      if (!takes(b, k) || !same_experiment(&a->rows->row[i], &b->rows->row[k], by_solver)) {
        continue;
      }
      collect(a->rows, a->rows->row[i].cell_id, column, &x[0]);
      collect(b->rows, b->rows->row[k].cell_id, column, &x[1]);
      if (count(&x[0]) > 1 && count(&x[1]) > 1) {
        compare_pair *p = &(*out)[(*n)++];
        *p = (compare_pair){.a = &a->rows->row[i], .b = &b->rows->row[k]};
        p->floor = doctor_floor_of(noise, fmax(p->a->workspace_B, p->b->workspace_B));
        judge(&x[0], &x[1], p);
      }
      break;
    }
  }
  free(x);
  return BASE_OK;
}
