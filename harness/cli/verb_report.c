/* lcpbench report: scripts/report as a verb; it reads its words itself, and a test holds its options to this table. */
#include "harness/cli/cli.h"
#include "harness/cli/script.h"

static const arg_option options[] = {
    {.name = "--out",
     .kind = ARG_TEXT,
     .value = "FOLDER",
     .help = "folder of the page and the figures; DIR/report where none is given"},
    {.name = "--pgf",
     .kind = ARG_FLAG,
     .value = NULL,
     .help = "the figures as PGF, too; slow, needs pdflatex"},
    {.name = "--pdf", .kind = ARG_FLAG, .value = NULL, .help = "builds the LaTeX document, too"},
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "DIR", "campaign folder, or a folder of them"};

static int run(int argc, char **argv) {
  return script_run("report", argc, argv);
}

extern const cli_verb verb_report;
const cli_verb verb_report = {
    .name = "report",
    .args = &args,
    .help = "one HTML page and a LaTeX document from measured rows",
    .run = run,
};
