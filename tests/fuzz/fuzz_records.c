/* results.csv of a campaign, read again by status, verify, merge and compare. */
#include "harness/plan/record.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".csv");
  record_table t;
  base_error err = {0};
  if (path != NULL && record_table_read(path, &t, &err) == BASE_OK) {
    record_table_free(&t);
  }
  return 0;
}
