#include "harness/control/step_list.h"

#include "harness/control/extrapolation.h"
#include "lcp/base/fields.h"
#include "lcp/base/output.h"

#include <stdlib.h>
#include <string.h>

/* Behind the length in a file, in this order: words of the ways. */
static const struct {
  unsigned way;
  const char *word;
} words[] = {{STEP_TURNED, " turned"}, {STEP_EXTRAPOLATED, " extrapolated"}};
enum { WORDS = sizeof words / sizeof *words };

base_status step_list_append(step_list *l, double h, unsigned way, base_error *err) {
  if (l->n == l->cap) {
    const long cap = 2 * l->cap + 64;
    double *grown = realloc(l->h, (size_t)cap * sizeof *grown);
    l->h = (grown != NULL) ? grown : l->h;
    unsigned char *ways = realloc(l->way, (size_t)cap * sizeof *ways);
    l->way = (ways != NULL) ? ways : l->way;
    if (grown == NULL || ways == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %ld steps", cap);
    }
    l->cap = cap;
  }
  l->h[l->n] = h;
  l->way[l->n++] = (unsigned char)way;
  l->n_turned += (way & STEP_TURNED) != 0;
  l->n_extrapolated += (way & STEP_EXTRAPOLATED) != 0;
  return BASE_OK;
}

/* Takes the words off the end of a line. */
static unsigned take_words(char *line) {
  unsigned way = 0;
  for (int i = WORDS - 1; i >= 0; i--) {
    const size_t n = strlen(line);
    const size_t m = strlen(words[i].word);
    if (n > m && strcmp(line + n - m, words[i].word) == 0) {
      line[n - m] = '\0';
      way |= words[i].way;
    }
  }
  return way;
}

static base_status read_lines(step_list *l, FILE *from, const char *path, base_error *err) {
  char line[80];
  for (long at = 1; fgets(line, sizeof line, from) != NULL; at++) {
    double h;
    line[strcspn(line, "\n")] = '\0';
    const unsigned way = take_words(line);
    if (!base_parse_real(line, &h) || !(h > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL, "%.200s, line %ld: need a step above 0 [s]", path, at);
    }
    BASE_TRY(step_list_append(l, h, way, err));
  }
  return BASE_OK;
}

double step_list_length(const step_list *l, double duration, bool *whole) {
  double sum = 0.0;
  for (long i = 0; i < l->n; i++) {
    sum += l->h[i];
  }
  const double last = (l->n > 0) ? l->h[l->n - 1] : 0.0;
  const double slack = 1e-6 * duration;
  *whole = fabs(sum - duration) <= slack || (sum > duration && sum - last < duration - slack);
  return sum;
}

base_status step_list_read(step_list *l, const char *path, double duration, base_error *err) {
  *l = (step_list){0};
  FILE *from = fopen(path, "r");
  if (from == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%.200s: cannot be read", path);
  }
  const base_status done = read_lines(l, from, path, err);
  (void)fclose(from);
  BASE_TRY(done);
  bool whole;
  const double sum = step_list_length(l, duration, &whole);
  if (!whole) {
    return BASE_FAIL(err, BASE_EINVAL, "%.200s: its steps cover %g s of a run of %g s", path, sum,
                     duration);
  }
  return BASE_OK;
}

base_status step_list_write(const step_list *l, const char *path, base_error *err) {
  base_out file;
  BASE_TRY(base_out_open(&file, path, err));
  for (long i = 0; i < l->n; i++) {
    (void)fprintf(file.to, "%.17g", l->h[i]);
    for (int k = 0; k < WORDS; k++) {
      (void)fputs((l->way[i] & words[k].way) != 0 ? words[k].word : "", file.to);
    }
    (void)fputc('\n', file.to);
  }
  return base_out_finish(&file, BASE_OK, err);
}

void step_list_close(step_list *l) {
  free(l->h);
  free(l->way);
  *l = (step_list){0};
}

/* ---- repeating ------------------------------------------------------------------------------- */

static base_status repeat(sim *s, const step_list *l, series *record, base_error *err) {
  step_pair pair;
  base_status done = step_pair_open(&pair, s, err);
  bool taken = true;
  for (long i = 0; done == BASE_OK && taken && i < l->n && !sim_hopeless(s); i++) {
    s->turned = (l->way[i] & STEP_TURNED) != 0;
    if ((l->way[i] & STEP_EXTRAPOLATED) == 0) {
      done = sim_step(s, record, l->h[i], &taken, err);
      continue;
    }
    done = step_pair_try(&pair, s, record, s->carrying, l->h[i], err);
    taken = pair.coarse.good && pair.fine.good;
    if (done == BASE_OK && taken) {
      done = step_pair_extrapolate(&pair, s, record, err);
    }
  }
  step_pair_close(&pair);
  return done;
}

base_status step_list_run(const sim_request *q, const step_list *l, series *record, sim_result *out,
                          base_error *err) {
  if (l->n_turned + l->n_extrapolated == 0) {
    return simulate(q, record, out, err);
  }
  if (q->form->form->memory == 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "extrapolated steps: %s cannot come back to an earlier step",
                     q->form->form->name);
  }
  if (q->plan != NULL || q->combinations != NULL || q->store != NULL || q->replay != NULL) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "extrapolated steps: with one set of effects, one formulation and one solver");
  }
  sim s;
  base_status done = sim_open(&s, q, record, out, err);
  if (done == BASE_OK) {
    done = repeat(&s, l, record, err);
  }
  if (done == BASE_OK) {
    sim_finish(&s, record);
  }
  sim_close(&s);
  return done;
}

base_status step_list_run_none(const sim_request *q, series *record, sim_result *out,
                               base_error *err) {
  const sim_result found = *out;
  sim_request still = *q;
  sim s;
  still.h = q->duration;
  still.step = NULL;
  base_status done = sim_open(&s, &still, record, out, err);
  if (done == BASE_OK) {
    sim_finish(&s, record);
    out->status = found.status;
    memcpy(out->note, found.note, sizeof out->note);
  }
  sim_close(&s);
  return done;
}
