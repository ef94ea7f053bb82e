/* Certificates in plain text. */
#include "lcp/lcp_certificate.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *path = fuzz_file(data, size, ".txt");
  lcp_certificate_file f;
  base_error err = {0};
  if (path != NULL && lcp_certificate_read(path, &f, &err) == BASE_OK) {
    lcp_certificate_free(&f);
  }
  return 0;
}
