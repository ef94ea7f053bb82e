/* lcpbench-tableau: the command line with the textbook's Lemke as one more solver, for
 * scripts/bench_steps. */
#include "harness/cli/cli.h"
#include "harness/measure/registry.h"
#include "tests/bench/solver_tableau.h"

int main(int argc, char **argv) {
  registry_extend(tableau_solvers);
  return cli_main(argc, argv);
}
