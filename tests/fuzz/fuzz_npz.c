/* numpy's .npz: the archive with its sums; and, since those let little through, a member of it by itself. */
#include "lcp/io/lcp_read.h"
#include "lcp/io/npy.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".npz");
  lcp_file_problem p;
  lcp_npy a;
  base_error err = {0};
  if (path != NULL && lcp_read_npz(path, &p, &err) == BASE_OK) {
    lcp_file_problem_free(&p);
  }
  if (lcp_npy_view(&a, "a", "a", data, size, &err) == BASE_OK && a.count > 0) {
    double x;
    int i;
    char text[16];
    (void)lcp_npy_real(&a, a.count - 1, &x, &err);
    (void)lcp_npy_int(&a, a.count - 1, -9, 9, &i, &err);
    (void)lcp_npy_text(&a, text, sizeof text, &err);
  }
  return 0;
}
