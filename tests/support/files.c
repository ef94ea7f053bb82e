#include "tests/support/check.h"

#include "tests/support/files.h"

#include <stdio.h>

enum { PATHS = 5, PATH_CAP = 1024 };

static const char *join(const char *folder, const char *name) {
  static char path[PATHS][PATH_CAP];
  static int turn;
  char *out = path[turn = (turn + 1) % PATHS];
  const int wrote = snprintf(out, PATH_CAP, "%s/%s", folder, name);
  assert_in_range(wrote, 1, PATH_CAP - 1);
  return out;
}

const char *tests_file(const char *name) {
  return join(TESTS_DIR, name);
}

const char *shared_file(const char *name) {
  const char *folder = getenv("LCPBENCH_SHARED");
  return join(folder != NULL ? folder : "../shared", name);
}

bool file_exists(const char *path) {
  FILE *f = fopen(path, "rb");
  return f != NULL && fclose(f) == 0;
}

int skip_by_name(const struct CMUnitTest *tests, int n, const char *reason) {
  printf("1..%d\n", n);
  for (int i = 0; i < n; i++) {
    printf("ok %d - %s # SKIP %s\n", i + 1, tests[i].name, reason);
  }
  return 0;
}
