/* main.c - the lcpbench executable. */
#include "harness/cli/cli.h"
#include "harness/util/memory.h"

int main(int argc, char **argv) {
  memory_return_from(1u << 22);
  return cli_main(argc, argv);
}
