/* FCLIB HDF5 files, read and posed; without the child process that guards against libhdf5. */
#include "problems/import/friction_problem.h"
#include "tests/fuzz/fuzz_file.h"

static void pose(friction_problem *f) {
  known_lcp k;
  base_error err = {0};
  if (friction_condense(f, &err) != BASE_OK) {
    return;
  }
  if (friction_pose_cone(f, &k, &err) == BASE_OK) {
    known_lcp_free(&k);
  }
  if (friction_pose_facets(f, f->rows == 2 ? 2 : 4, &k, &err) == BASE_OK) {
    known_lcp_free(&k);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".hdf5");
  friction_problem f;
  base_error err = {0};
  if (path != NULL && friction_read_fclib_here(path, &f, &err) == BASE_OK) {
    pose(&f);
    friction_free(&f);
  }
  return 0;
}
