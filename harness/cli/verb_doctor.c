/* lcpbench doctor: can this machine be trusted with timings, and to how many per cent? */
#include "harness/campaign/doctor.h"
#include "harness/cell/machine.h"
#include "harness/cli/cli.h"
#include "harness/util/args.h"
#include "harness/util/folder.h"

typedef struct doctor_options {
  const char *out;
  double seconds;
} doctor_options;

static const arg_option options[] = {
    ARG(doctor_options, out, "--out", ARG_TEXT, "DIR", "folder that gets doctor.json"),
    ARG(doctor_options, seconds, "--seconds", ARG_SECONDS, "T",
        "time to measure for; 6 s where none is given", .unit = "s", .above = true),
};
static const arg_table args = {options, BASE_COUNT(options), 0, 0, "", ""};

static int run(int argc, char **argv) {
  doctor_options o = {.seconds = 6.0};
  int n;
  base_error err = {0};
  noise_report report;
  if (args_parse(&args, &o, argc, argv, NULL, &n, &err) != BASE_OK) {
    return cli_report(&err);
  }
  if (o.out != NULL && folder_make(o.out, &err) != BASE_OK) {
    return cli_report(&err); /* before the measuring */
  }
  machine_pin(machine_last_cpu());
  noise_measure(o.seconds, 1, &report);
  json_t *found = doctor_json(&report);
  if (o.out != NULL && doctor_store(found, o.out, &err) != BASE_OK) {
    json_decref(found);
    return cli_report(&err);
  }
  const bool printed = json_out_print(found, stdout);
  return printed ? CLI_OK : CLI_INTERNAL;
}

extern const cli_verb verb_doctor;
const cli_verb verb_doctor = {
    .name = "doctor",
    .args = &args,
    .help = "clock, pinning, memory bandwidth and noise floor (A/A) of this machine, as JSON",
    .run = run,
};
