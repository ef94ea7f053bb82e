#include "harness/cli/verbs.h"

#include "lcp/base/status.h"

#include <string.h>

/* One verb: one constant in verb_NAME.c and one word here. */
/* clang-format off */
#define VERB_LIST(X) \
  X(list) \
  X(solve) \
  X(simulate) \
  X(calibrate) \
  X(check) \
  X(choose) \
  X(conform) \
  X(run) \
  X(status) \
  X(merge) \
  X(verify) \
  X(compare) \
  X(doctor) \
  X(export) \
  X(submit) \
  X(recommend) \
  X(report) \
  X(profile) \
  X(render) \
  X(help) \
  X(complete)
/* clang-format on */

#define DECLARE_(name) extern const cli_verb verb_##name;
VERB_LIST(DECLARE_)
#define ADDRESS_(name) &verb_##name,
static const cli_verb *const verbs[] = {VERB_LIST(ADDRESS_)};

const cli_verb *const *cli_verbs(int *count) {
  *count = BASE_COUNT(verbs);
  return verbs;
}

const cli_verb *cli_verb_find(const char *name) {
  for (int i = 0; i < BASE_COUNT(verbs); i++) {
    if (strcmp(verbs[i]->name, name) == 0) {
      return verbs[i];
    }
  }
  return NULL;
}
