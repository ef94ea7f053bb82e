/* lcpbench doctor: can this machine be trusted with timings, and to how many per cent? */
#include "harness/args.h"
#include "harness/cli.h"
#include "harness/json_out.h"
#include "harness/machine.h"
#include "harness/noise.h"
#include "harness/runner.h"
#include "harness/versions.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

static json_t *advice(const machine *m, const noise_report *n, double load) {
  json_t *a = json_array();
  if (m->governor[0] != '\0' && strcmp(m->governor, "performance") != 0) {
    (void)json_array_append_new(a, json_string("the governor is not 'performance'"));
  }
  if (load > 0.5) {
    (void)json_array_append_new(a, json_string("other work is running (load above 0.5)"));
  }
  if (n->floor > 0.05) {
    (void)json_array_append_new(a, json_string("differences below 5 % cannot be seen here"));
  }
  if (strcmp(build_options(), "") != 0 && strstr(build_options(), "buildtype=release") == NULL) {
    (void)json_array_append_new(a, json_string("this is not a release build"));
  }
  return a;
}

static json_t *to_json(const noise_report *n) {
  machine m;
  char when[24];
  machine_read(&m);
  machine_utc(when, sizeof when);
  const double load = machine_load();
  json_t *o = json_object();
  json_out_text(o, "written_utc", when);
  json_out_text(o, "host", m.host);
  json_out_text(o, "cpu", m.cpu_model);
  json_out_int(o, "n_cpu", m.n_cpu);
  json_out_text(o, "governor", m.governor[0] != '\0' ? m.governor : NULL);
  json_out_real(o, "freq_MHz", machine_frequency(machine_last_cpu()));
  json_out_int(o, "pinned_to", machine_last_cpu());
  json_out_real(o, "load1", load);
  json_out_real(o, "canary_s", machine_canary());
  json_out_real(o, "clock_cost_s", n->clock_cost);
  json_out_real(o, "clock_step_s", n->clock_step);
  json_out_real(o, "bandwidth_B_s", n->bandwidth);
  json_t *classes = json_array();
  for (int i = 0; i < NOISE_CLASSES; i++) {
    json_t *c = json_object();
    json_out_text(c, "size", n->size[i].name);
    json_out_real(c, "sample_s", n->size[i].seconds);
    json_out_real(c, "noise_floor", n->size[i].floor);
    json_out_real(c, "spread", n->size[i].spread);
    (void)json_array_append_new(classes, c);
  }
  (void)json_object_set_new(o, "classes", classes);
  json_out_real(o, "noise_floor", n->floor);
  (void)json_object_set_new(o, "advice", advice(&m, n, load));
  return o;
}

static base_status store(json_t *o, const char *dir, base_error *err) {
  char path[1100];
  if (mkdir(dir, 0777) != 0 && errno != EEXIST) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", dir, strerror(errno));
  }
  runner_path(dir, "doctor.json", path, sizeof path);
  return (json_dump_file(o, path, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%s: could not be written", path);
}

static int run(int argc, char **argv) {
  const char *out = NULL;
  double seconds = 6.0;
  const arg_option options[] = {{"--out", ARG_TEXT, &out}, {"--seconds", ARG_SECONDS, &seconds}};
  const arg_table table = {options, BASE_COUNT(options), 0, 0, ""};
  int n;
  base_error err = {0};
  noise_report report;
  if (args_parse(&table, argc, argv, NULL, &n, &err) != BASE_OK) {
    return cli_report(&err);
  }
  machine_pin(machine_last_cpu());
  noise_measure(seconds, 1, &report);
  json_t *o = to_json(&report);
  const base_status done = (out != NULL) ? store(o, out, &err) : BASE_OK;
  const bool printed = json_out_print(o, stdout);
  return (done != BASE_OK) ? cli_report(&err) : printed ? CLI_OK : CLI_INTERNAL;
}

extern const cli_verb verb_doctor;
const cli_verb verb_doctor = {
    .name = "doctor",
    .usage = "doctor [--out DIR] [--seconds T]",
    .help = "clock, pinning, memory bandwidth and noise floor (A/A) of this machine, as JSON",
    .run = run,
};
