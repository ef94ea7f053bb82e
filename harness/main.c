/* main.c - the lcpbench command line. The only file that prints and decides exit codes. */
#include "harness/version.h"

#include <stdio.h>

int main(void) {
  printf("lcpbench %s\n", harness_version());
  return 0;
}
