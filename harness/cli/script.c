#include "harness/cli/script.h"

#include "harness/cli/cli.h"
#include "harness/util/installed.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *folder(char *room, size_t cap) {
  const char *dir = getenv("LCPBENCH_SCRIPTS");
  if (dir != NULL && dir[0] != '\0') {
    return dir;
  }
  return installed_data("scripts", room, cap) ? room : LCPBENCH_SCRIPT_DIR;
}

int script_run(const char *name, int argc, char **argv) {
  char room[4096];
  char path[4200];
  char *word[ARG_LIST_MAX * 4 + 2];
  base_error err;
  (void)snprintf(path, sizeof path, "%s/%s", folder(room, sizeof room), name);
  if (argc >= BASE_COUNT(word) - 1) {
    (void)BASE_FAIL(&err, BASE_EINVAL, "%s: more than %d words", name, BASE_COUNT(word) - 2);
    return cli_report(&err);
  }
  word[0] = path;
  memcpy(word + 1, argv, (size_t)argc * sizeof *word);
  word[argc + 1] = NULL;
  const ssize_t length = readlink("/proc/self/exe", room, sizeof room - 1);
  if (length > 0) { /* the scripts ask this program, unless they are told another */
    room[length] = '\0';
    (void)setenv("LCPBENCH", room, 0);
  }
  (void)execv(path, word);
  (void)BASE_FAIL(&err, BASE_EIO, "%.300s: %s; LCPBENCH_SCRIPTS names another folder", path,
                  strerror(errno));
  return cli_report(&err);
}
