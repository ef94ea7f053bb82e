/* Campaign files, as written and in their quick form. */
#include "harness/plan/campaign.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".yaml");
  for (int quick = 0; path != NULL && quick < 2; quick++) {
    campaign c;
    base_error err = {0};
    if (campaign_read(path, quick == 1, &c, &err) == BASE_OK) {
      campaign_free(&c);
    }
  }
  return 0;
}
