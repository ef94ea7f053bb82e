/* lcpbench render: scripts/render as a verb; it reads its words itself, and a test holds its options to this table. */
#include "harness/cli/cli.h"
#include "harness/cli/script.h"

static const arg_option options[] = {
    {.name = "--out", .kind = ARG_TEXT, .value = "FOLDER", .help = "folder of the pictures"},
    {.name = "--frames",
     .kind = ARG_TEXT,
     .value = "N",
     .help = "number of frames of the animation"},
    {.name = "--times",
     .kind = ARG_TEXT,
     .value = "T,T,...",
     .help = "times of the stills, in seconds"},
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "TRAJECTORY", "file that simulate --trajectory wrote"};

static int run(int argc, char **argv) {
  return script_run("render", argc, argv);
}

extern const cli_verb verb_render;
const cli_verb verb_render = {
    .name = "render",
    .args = &args,
    .help = "pictures and an animation of a run",
    .run = run,
};
