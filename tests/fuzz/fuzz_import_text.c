/* Siconos text: LCP, mixed LCP, friction; small problems are posed as well. */
#include "problems/import/import.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".dat");
  for (int facets = 0; path != NULL && facets <= 4; facets += 4) {
    known_lcp k;
    base_error err = {0};
    if (import_problem(path, facets, &k, &err) == BASE_OK) {
      known_lcp_free(&k);
    }
  }
  return 0;
}
