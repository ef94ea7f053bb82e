/* Manifests of sequences, beside the files of the sequence that the seed is of: two problems of two contacts. */
#include "harness/sequence/sequence_file.h"
#include "harness/util/folder.h"
#include "tests/fuzz/fuzz_file.h"

#include <stdlib.h>

static const char folder[] = "fuzz_sequence";

/* The files of the seed. */
static void write_files(void) {
  static bool written;
  static const double M[] = {2, 1, 1, 2}, q[] = {-1, -2}, z[] = {0, 1};
  static const uint64_t owner[] = {256, 512};
  static const int first[] = {0, 1, 2};
  const lcp_block block[] = {{.size = 1}, {.start = 1, .size = 1}};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M},
                         .q = q,
                         .block = block,
                         .n_block = 2,
                         .traits = LCP_SYMMETRIC | LCP_PD};
  sequence s = {.scene = "incline", .formulation = "regularized", .solver = "lemke", .h = 0.01};
  base_error err = {0};
  for (long step = 1; step <= 2 && !written; step++) {
    const sim_solved k = {.step = step, .p = &p, .z = z, .status = RUN_OK, .verified = true};
    if (sequence_put_named(&s, &k, 2, owner, first, &err) != BASE_OK) {
      abort();
    }
  }
  if (!written && sequence_write(&s, folder, &err) != BASE_OK) {
    abort();
  }
  written = true;
  sequence_free(&s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char path[64];
  base_error err = {0};
  sequence s;
  write_files();
  folder_file(folder, "manifest.json", path, sizeof path);
  FILE *f = fopen(path, "wb");
  if (f == NULL) {
    return 0;
  }
  const size_t wrote = fwrite(data, 1, size, f);
  if (fclose(f) == 0 && wrote == size) {
    (void)sequence_read(folder, &s, &err);
    sequence_free(&s);
  }
  return 0;
}
