/* lcpbench-faulty: the command line with solvers that misbehave on purpose, for the tests. */
#include "harness/cli/cli.h"
#include "harness/measure/registry.h"
#include "tests/faulty/solver_faulty.h"

int main(int argc, char **argv) {
  registry_extend(faulty_solvers);
  return cli_main(argc, argv);
}
