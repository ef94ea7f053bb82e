#include "harness/util/versions.h"

#include "lcp/base/status.h"
#include "versions_generated.h"

#include <stdio.h>
#include <string.h>

#define ROW_(name, hash) {name, hash},
static const struct { const char *name, *hash; } versions[] = {COMPONENT_VERSIONS(ROW_){"", ""}};

static const char *find(const char *kind, const char *name) {
  char key[96];
  (void)snprintf(key, sizeof key, "%s_%s", kind, name);
  for (int i = 0; i < BASE_COUNT(versions); i++) {
    if (strcmp(versions[i].name, key) == 0) {
      return versions[i].hash;
    }
  }
  return "external";
}

enum { ADDED_MAX = 32 };
static struct { char name[48], hash[17]; } added[ADDED_MAX]; /* at start, read-only afterwards */
static int n_added;

void version_add_solver(const char *name, const char *hash) {
  if (n_added < ADDED_MAX) {
    (void)snprintf(added[n_added].name, sizeof added[n_added].name, "%s", name);
    (void)snprintf(added[n_added].hash, sizeof added[n_added].hash, "%.16s", hash);
    n_added++;
  }
}

const char *version_of_solver(const char *name) {
  for (int i = 0; i < n_added; i++) {
    if (strcmp(added[i].name, name) == 0) {
      return added[i].hash;
    }
  }
  return find("solver", name);
}

const char *version_of_formulation(const char *name) {
  return find("form", name);
}

const char *version_of_scene(const char *name) {
  return find("scene", name);
}

const char *version_of_family(const char *name) {
  return find("family", name);
}

const char *build_commit(void) {
  return BUILD_COMMIT;
}

int build_dirty(void) {
  return BUILD_DIRTY;
}

const char *build_compiler(void) {
  return BUILD_COMPILER;
}

const char *build_options(void) {
  return BUILD_OPTIONS;
}

const char *build_base(void) {
  return BUILD_BASE;
}

const char *build_hash(void) {
  return BUILD_HASH;
}
