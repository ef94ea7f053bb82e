/* lcpbench recommend: scripts/recommend as a verb; it reads its words itself, and a test holds its options to this table. */
#include "harness/cli/cli.h"
#include "harness/cli/script.h"

static const arg_option options[] = {
    {.name = "--scene",
     .kind = ARG_TEXT,
     .value = "SCENE",
     .help = "problem as in the rows, or a pattern; the name of its family is enough",
     .needed = true},
    {.name = "--error",
     .kind = ARG_TEXT,
     .value = "E",
     .help = "error to stay below, in the unit of the yardstick, or 1% of its size",
     .needed = true},
    {.name = "--yardstick",
     .kind = ARG_TEXT,
     .value = "trajectory|physical|algebraic",
     .help = "which of the three errors; trajectory where none is given"},
};
static const arg_table args = {
    options, BASE_COUNT(options),
    0,       1,
    "DIR",   "campaign folder, or a folder of them; results/runs where none is given"};

static int run(int argc, char **argv) {
  return script_run("recommend", argc, argv);
}

extern const cli_verb verb_recommend;
const cli_verb verb_recommend = {
    .name = "recommend",
    .args = &args,
    .help = "the cheapest verified combination that measured rows know for a scene and an error",
    .run = run,
};
