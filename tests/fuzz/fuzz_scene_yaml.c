/* YAML scene files. */
#include "problems/read/case_file.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".yaml");
  case_file f;
  base_error err = {0};
  if (path != NULL && case_file_read(path, &f, &err) == BASE_OK) {
    case_file_free(&f);
  }
  return 0;
}
