/* main.c - the lcpbench executable. */
#include "harness/cli/cli.h"

#include <stdlib.h>

#ifdef __GLIBC__
#include <malloc.h>

/* Large blocks go back to the system when they are freed, always: glibc would keep the more the larger those were that were freed
 * before. What is smaller stays, and is used again. */
static void give_back(void) {
  (void)mallopt(M_MMAP_THRESHOLD, 1 << 22);
  (void)mallopt(M_TRIM_THRESHOLD, 1 << 22);
}
#else
static void give_back(void) {
}
#endif

int main(int argc, char **argv) {
  give_back();
  return cli_main(argc, argv);
}
