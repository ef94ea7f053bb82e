/* lcpbench compare: is B faster than A, or is it noise? */
#include "harness/campaign/compare.h"
#include "harness/campaign/runner.h"
#include "harness/cli/cli.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "lcp/base/nearest.h"

#include <stdlib.h>
#include <string.h>

typedef struct compare_options {
  const char *solver_a, *solver_b, *column;
  double noise;
} compare_options;

static const char *const words[COMPARE_WORDS] = {"no difference", "faster", "slower",
                                                 "inconclusive: disturbed"};

/* One floor for every size. */
static doctor_floor flat(double floor) {
  return (doctor_floor){1, {HUGE_VAL}, {floor}};
}

/* "velocity:facets=4", "-" for none. */
static void print_component(const char *name, const char *options) {
  (void)printf("%s%s%s", name[0] != '\0' ? name : "-", options[0] != '\0' ? ":" : "", options);
}

static void print_pair(const compare_pair *p) {
  (void)printf("%s ", p->a->problem);
  print_component(p->a->formulation, p->a->formulation_options);
  (void)printf(" ");
  if (p->a->step_s > 0.0) {
    (void)printf("h = %g s ", p->a->step_s);
  }
  if (strcmp(p->a->start, "previous") == 0) {
    (void)printf("from the previous step ");
  }
  print_component(p->a->solver, p->a->solver_options);
  (void)printf(" -> ");
  print_component(p->b->solver, p->b->solver_options);
  (void)printf(": %.4g s -> %.4g s, ratio %.4f [%.4f, %.4f] %s\n", p->median_a, p->median_b,
               p->ratio, p->lo, p->hi, words[p->word]);
}

static void print_failures(const compare_failures *f) {
  if (f->a + f->b + f->both > 0) {
    (void)printf("failed, and in no ratio: %d of A only, %d of B only, %d of both\n", f->a, f->b,
                 f->both);
  }
  if (f->few > 0) {
    (void)printf("%d pairs have a single sample on a side, and no ratio\n", f->few);
  }
}

static int print_pairs(const compare_pair *pair, int n, const compare_failures *failed,
                       const doctor_floor *noise, const char *origin) {
  int count[COMPARE_WORDS] = {0};
  double sum = 0.0;
  double drift = 0.0;
  for (int i = 0; i < n; i++) {
    print_pair(&pair[i]);
    count[pair[i].word]++;
    sum += log(pair[i].ratio);
    drift = fmax(drift, pair[i].drift);
  }
  if (n > 0) {
    (void)printf("geometric mean of the ratios %.4f over %d pairs\n", exp(sum / n), n);
  }
  print_failures(failed);
  if (drift > 0.0) {
    (void)printf("canaries differ by up to %.2f %%, which is added to the noise floor\n",
                 100.0 * expm1(drift));
  }
  (void)printf("noise floor");
  for (int i = 0; i < noise->n; i++) {
    (void)printf("%s %.2f %%", i > 0 ? "," : "", 100.0 * noise->floor[i]);
  }
  (void)printf(" (%s): %d no difference, %d faster, %d slower", origin, count[COMPARE_SAME],
               count[COMPARE_FASTER], count[COMPARE_SLOWER]);
  if (count[COMPARE_DISTURBED] > 0) {
    (void)printf(", %d inconclusive (canary drift, throttling or more than %g CPUs of other work)",
                 count[COMPARE_DISTURBED], COMPARE_OTHERS);
  }
  (void)printf("\n");
  return CLI_OK;
}

static base_status compare(const char *const dir[2], const compare_options *o, int *code,
                           base_error *err) {
  record_table t[2] = {{0}, {0}};
  doctor_floor noise = flat(o->noise);
  const char *origin = "as given";
  if (isnan(o->noise)) { /* not given */
    noise = DOCTOR_UNKNOWN;
    BASE_TRY(doctor_read(dir[0], &noise, err));
    BASE_TRY(doctor_read(dir[1], &noise, err));
    origin = "doctor.json, by size";
  }
  if (doctor_floor_of(&noise, (double)NAN) < 0.0) {
    noise = flat(0.03);
    origin = "assumed; run lcpbench doctor --out DIR to measure it";
  }
  base_status done = runner_read_rows(dir[0], &t[0], err);
  if (done == BASE_OK) {
    done = runner_read_rows(dir[1], &t[1], err);
  }
  compare_pair *pair = NULL;
  int n = 0;
  compare_failures failed = {0};
  if (done == BASE_OK) {
    const compare_side a = {&t[0], o->solver_a};
    const compare_side b = {&t[1], o->solver_b};
    done = compare_sides(&a, &b, o->column, &noise, &pair, &n, &failed, err);
  }
  if (done == BASE_OK && n == 0 && failed.a + failed.b + failed.both == 0) {
    done = BASE_FAIL(err, BASE_EINVAL,
                     "compare: no cell of %s has a partner in %s, both with two samples of %s",
                     dir[0], dir[1], o->column);
  }
  if (done == BASE_OK) {
    *code = print_pairs(pair, n, &failed, &noise, origin);
  }
  free(pair);
  record_table_free(&t[0]);
  record_table_free(&t[1]);
  return done;
}

static const arg_option options[] = {
    ARG(compare_options, solver_a, "--solver-a", ARG_TEXT, "SOLVER",
        "rows of A by this solver only; together with --solver-b"),
    ARG(compare_options, solver_b, "--solver-b", ARG_TEXT, "SOLVER",
        "rows of B by this solver only"),
    ARG(compare_options, column, "--column", ARG_TEXT, "COLUMN",
        "time column that is compared; t_total_s where none is given"),
    ARG(compare_options, noise, "--noise", ARG_REAL, "X",
        "noise floor instead of the measured one, as a share", .unit = "1"),
};
static const arg_table args = {
    options, BASE_COUNT(options), 2, 2, "A B", "two campaign folders, or files of rows"};

static int run(int argc, char **argv) {
  compare_options o = {.column = "t_total_s", .noise = (double)NAN};
  const char *dir[2];
  int n;
  int code = CLI_INTERNAL;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, dir, &n, &err);
  if (done == BASE_OK && (o.solver_a == NULL) != (o.solver_b == NULL)) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--solver-a and --solver-b belong together");
  }
  if (done == BASE_OK && (strncmp(o.column, "t_", 2) != 0 || !record_has_real(o.column))) {
    char hint[BASE_NEAREST_HINT];
    base_nearest near = base_nearest_to(o.column, strlen(o.column));
    for (int i = 0; i < record_columns(); i++) {
      base_nearest_offer(&near, strncmp(record_column(i), "t_", 2) == 0 ? record_column(i) : "");
    }
    done = BASE_FAIL(&err, BASE_EINVAL, "--column %.100s: need a time column of results.csv%s",
                     o.column, base_nearest_hint(&near, hint));
  }
  if (done == BASE_OK) {
    done = compare(dir, &o, &code, &err);
  }
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_compare;
const cli_verb verb_compare = {
    .name = "compare",
    .args = &args,
    .help = "paired ratios B/A with intervals; inside the noise floor there is no difference",
    .run = run,
};
