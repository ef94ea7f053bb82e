/* Matrix Market: one file as the matrix and as the vector. */
#include "lcp/io/lcp_read.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".mtx");
  lcp_file_problem p;
  base_error err = {0};
  double x[8];
  if (path == NULL) {
    return 0;
  }
  if (lcp_read_mtx(path, path, &p, &err) == BASE_OK) {
    lcp_file_problem_free(&p);
  }
  (void)lcp_read_mtx_vector(path, 8, x, &err);
  return 0;
}
