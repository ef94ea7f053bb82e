/* lcpbench doctor: can this machine be trusted with timings, and to how many per cent? */
#include "harness/campaign/doctor.h"
#include "harness/cli/cli.h"
#include "harness/measure/machine.h"
#include "harness/util/args.h"
#include "harness/util/folder.h"

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
  if (!(seconds > 0.0)) {
    (void)BASE_FAIL(&err, BASE_EINVAL, "--seconds: need a time above 0");
    return cli_report(&err);
  }
  if (out != NULL && folder_make(out, &err) != BASE_OK) {
    return cli_report(&err); /* before the measuring */
  }
  machine_pin(machine_last_cpu());
  noise_measure(seconds, 1, &report);
  json_t *o = doctor_json(&report);
  if (out != NULL && doctor_store(o, out, &err) != BASE_OK) {
    json_decref(o);
    return cli_report(&err);
  }
  const bool printed = json_out_print(o, stdout);
  return printed ? CLI_OK : CLI_INTERNAL;
}

extern const cli_verb verb_doctor;
const cli_verb verb_doctor = {
    .name = "doctor",
    .usage = "doctor [--out DIR] [--seconds T]",
    .help = "clock, pinning, memory bandwidth and noise floor (A/A) of this machine, as JSON",
    .run = run,
};
