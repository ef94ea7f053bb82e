#include "harness/choice/plugins.h"

#include "harness/choice/plugin_solver.h"
#include "harness/util/versions.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FILES_MAX = 32 };
static plugin_file files[FILES_MAX]; /* filled at start, read-only afterwards */
static int n_file;

const plugin_file *plugins_at(int i) {
  return (i < n_file) ? &files[i] : NULL;
}

const plugin_file *plugins_of(const lcp_solver *s) {
  for (int i = 0; i < n_file; i++) {
    if (files[i].solver == s) {
      return &files[i];
    }
  }
  return NULL;
}

/* LCPBENCH_PLUGINS names what is loaded, for the processes that this one starts. */
static base_status tell_children(base_error *err) {
  static char all[FILES_MAX * (sizeof files[0].path + 1)];
  size_t used = 0;
  for (int i = 0; i < n_file; i++) {
    used +=
        (size_t)snprintf(all + used, sizeof all - used, "%s%s", i > 0 ? ":" : "", files[i].path);
  }
  return (setenv("LCPBENCH_PLUGINS", all, 1) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory for LCPBENCH_PLUGINS");
}

base_status plugins_take(const char *file, base_error *err) {
  char *path = realpath(file, NULL);
  if (path == NULL) {
    return BASE_FAIL(err, BASE_EIO, "plug-in %.200s: %s", file, strerror(errno));
  }
  plugin_file *f = &files[n_file];
  for (int i = 0; i < n_file; i++) {
    if (strcmp(files[i].path, path) == 0) {
      free(path);
      return BASE_OK;
    }
  }
  const bool fits =
      n_file < FILES_MAX && strlen(path) < sizeof f->path && strchr(path, ':') == NULL;
  if (fits) {
    (void)snprintf(f->path, sizeof f->path, "%s", path);
  }
  free(path);
  if (!fits) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "plug-in %.200s: need a path without ':', and at most %d files", file,
                     FILES_MAX);
  }
  BASE_TRY(sha256_file(f->path, f->sha256, err));
  BASE_TRY(plugin_load(f->path, &f->solver, err));
  version_add_solver(f->solver->name, f->sha256);
  n_file++;
  return tell_children(err);
}

base_status plugins_take_environment(base_error *err) {
  const char *all = getenv("LCPBENCH_PLUGINS");
  char *copy = strdup(all != NULL ? all : "");
  if (copy == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for LCPBENCH_PLUGINS");
  }
  char *rest = NULL;
  base_error why = {0};
  base_status done = BASE_OK;
  for (char *f = strtok_r(copy, ":", &rest); f != NULL && done == BASE_OK;
       f = strtok_r(NULL, ":", &rest)) {
    done = plugins_take(f, &why);
  }
  free(copy);
  return (done == BASE_OK) ? BASE_OK : BASE_FAIL(err, done, "LCPBENCH_PLUGINS: %s", why.text);
}
