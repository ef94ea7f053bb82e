/* Siconos text: LCP, mixed LCP, friction; small problems are posed as well. */
#include "problems/import/import.h"
#include "tests/fuzz/fuzz_file.h"

#include <string.h>

/* HDF5 is tried in a child process first, and to fork this process is slow: fuzz_import_hdf5 has it. */
static bool is_hdf5(const uint8_t *data, size_t size) {
  return size >= 4 && memcmp(data, "\x89HDF", 4) == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (is_hdf5(data, size)) {
    return 0;
  }
  const char *path = fuzz_file(data, size, ".dat");
  for (int facets = 0; path != NULL && facets <= 4; facets += 4) {
    import_posed p;
    base_error err = {0};
    if (import_pose(path, facets, &p, &err) == BASE_OK) {
      import_posed_free(&p);
    }
  }
  return 0;
}
