/* lcpbench choose: which formulation and solver `simulate --error` would take for a scene, how sure that is, and with
 * --measure what the first of them really take. */
#include "harness/cli/cli.h"
#include "harness/control/repeat.h"
#include "harness/control/simulation.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/stop.h"

typedef struct choose_options {
  simulation_texts t;
  int measure;
} choose_options;

static const arg_option options[] = {
    ARG(choose_options, t.error, "--error", ARG_TEXT, "E",
        "error of the motion: 1%, of the scene's scale, or 1e-3m, 0.01rad", .needed = true),
    ARG(choose_options, t.rows, "--rows", ARG_TEXT, "FILE|DIR",
        "measured errors (choices.tsv) to choose from instead of those that come with the program"),
    ARG(choose_options, measure, "--measure", ARG_INT, "N",
        "runs the first N candidates, and orders them by the time that kept the error", .unit = "1",
        .min = 0, .max = CHOICE_MOST),
    ARG(choose_options, t.work, "--work", ARG_TEXT, "N",
        "most steps that the runs of one candidate may solve", .unit = "1", .above = true),
    ARG(choose_options, t.time_limit, "--time-limit", ARG_TEXT, "T",
        "longest that the runs of one candidate may take: 30, 30s, 10m; none given: no limit"),
};
static const arg_table args = {
    options, BASE_COUNT(options),
    1,       1,
    "SCENE", "scene with its parameters, or scene file; - is standard input"};

/* What a candidate took; kept: it promises the error. */
typedef struct measured {
  bool done, kept;
  run_status status;
  double seconds, estimate;
} measured;

static base_status measure(const simulation_texts *asked, const choice_candidate *c, measured *out,
                           base_error *err) {
  simulation_texts t = *asked;
  simulation s;
  series record = {0};
  sim_result r;
  t.formulation = c->formulation;
  t.solver = c->solver;
  t.rows = NULL;
  base_status done = simulation_open(&t, &s, err);
  if (done == BASE_OK) {
    done = simulation_run(&s, &record, &r, err);
  }
  if (done == BASE_OK && stop_requested() == 0) {
    *out = (measured){true, s.found.promised, r.status, sim_total_seconds(&r), s.found.estimate};
  }
  series_close(&record);
  simulation_close(&s);
  return done;
}

/* Does a stand before b? Who kept the error by time, then who was not run as it was ranked, then who failed. */
static bool before(const measured *a, const measured *b) {
  const int ra = a->kept ? 0 : (a->done ? 2 : 1);
  const int rb = b->kept ? 0 : (b->done ? 2 : 1);
  return ra < rb || (ra == 0 && rb == 0 && a->seconds < b->seconds);
}

static void order(const measured *m, int n, int *place) {
  for (int i = 0; i < n; i++) {
    int k = i;
    for (; k > 0 && before(&m[i], &m[place[k - 1]]); k--) {
      place[k] = place[k - 1];
    }
    place[k] = i;
  }
}

static json_t *candidate(const simulation *s, const simulation_texts *t, const choice_candidate *c,
                         const measured *m) {
  json_t *o = json_object();
  char command[8192];
  json_out_text(o, "formulation", c->formulation);
  json_out_text(o, "solver", c->solver);
  json_out_real(o, "cost", c->cost);
  json_out_real(o, "sure", c->sure);
  if (m->done) {
    json_out_text(o, "status", run_status_name(m->status));
    json_out_bool(o, "promised", m->kept);
    json_out_real(o, "err_estimate", m->estimate);
    json_out_real(o, "t_total_s", m->seconds);
  }
  shell_line l = {command, sizeof command, 0};
  repeat_run(&l, t, c->formulation, c->solver, t->effects);
  repeat_error(&l, t, &s->error);
  json_out_text(o, "command", command);
  return o;
}

static json_t *to_json(const simulation *s, const simulation_texts *t, const measured *m,
                       const int *place) {
  const choice *c = &s->choice;
  json_t *o = json_object();
  json_out_text(o, "scene", s->spec.id);
  json_out_real(o, "asked", s->error.E);
  json_out_text(o, "unit", s->error.unit[0] != '\0' ? s->error.unit : "of the scale");
  json_out_text(o, "rows", c->rows);
  json_t *list = json_object();
  for (int i = 0; i < FEATURES; i++) {
    json_out_real(list, features_name(i), s->features.x[i]);
  }
  (void)json_object_set_new(o, "features", list);
  list = json_array();
  for (int i = 0; i < c->n_near; i++) {
    json_t *one = json_object();
    json_out_text(one, "near", c->near[i]);
    json_out_real(one, "distance", c->distance[i]);
    (void)json_array_append_new(list, one);
  }
  (void)json_object_set_new(o, "nearest", list);
  list = json_array();
  for (int i = 0; i < c->n; i++) {
    (void)json_array_append_new(list, candidate(s, t, &c->candidate[place[i]], &m[place[i]]));
  }
  (void)json_object_set_new(o, "candidates", list);
  return o;
}

static int run(int argc, char **argv) {
  choose_options o = {0};
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &o.t.scene, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  simulation s;
  measured m[CHOICE_MOST] = {{0}};
  int place[CHOICE_MOST];
  bool kept = o.measure == 0;
  json_t *found = NULL;
  base_status done = simulation_open(&o.t, &s, &err);
  stop_catch_first_signal(); /* what was measured is told */
  for (int i = 0; done == BASE_OK && i < o.measure && i < s.choice.n && stop_requested() == 0;
       i++) {
    done = measure(&o.t, &s.choice.candidate[i], &m[i], &err);
    kept = kept || m[i].kept;
  }
  if (done == BASE_OK) {
    order(m, s.choice.n, place);
    found = to_json(&s, &o.t, m, place);
  }
  simulation_close(&s);
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  const int code = (stop_requested() != 0) ? cli_stopped() : (kept ? CLI_OK : CLI_HONEST);
  return json_out_print(found, stdout) ? code : CLI_INTERNAL;
}

extern const cli_verb verb_choose;
const cli_verb verb_choose = {
    .name = "choose",
    .args = &args,
    .help = "formulation and solver for any scene and an error, predicted from measured scenes "
            "that are like it",
    .run = run,
};
