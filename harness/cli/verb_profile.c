/* lcpbench profile: scripts/profile as a verb; it reads its words itself, and a test holds its options to this table. */
#include "harness/cli/cli.h"
#include "harness/cli/script.h"

static const arg_option options[] = {
    {.name = "--out",
     .kind = ARG_TEXT,
     .value = "FOLDER",
     .help = "folder of profile.pdf and profile.png; . where none is given"},
    {.name = "--format",
     .kind = ARG_TEXT,
     .value = "table|csv|json",
     .help = "form of the table that is printed; table where none is given"},
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "DIR", "campaign folder, or a folder of them"};

static int run(int argc, char **argv) {
  return script_run("profile", argc, argv);
}

extern const cli_verb verb_profile;
const cli_verb verb_profile = {
    .name = "profile",
    .args = &args,
    .help = "performance profile of the solvers over the problems of a folder of rows, failures in "
            "the denominator",
    .run = run,
};
