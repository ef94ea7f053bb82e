/* harness/choice/plugins.h - the plug-ins of this run: from --plugin and LCPBENCH_PLUGINS. */
#pragma once

#include "harness/util/sha256.h"
#include "lcp/lcp_solver.h"

typedef struct plugin_file {
  char path[1024]; /* absolute */
  char sha256[SHA256_HEX];
  const lcp_solver *solver;
} plugin_file;

/* Loads the plug-in in `file`; the hash of its content becomes the version of its solver, and LCPBENCH_PLUGINS of this process and
 * its children names it. A file that is loaded already is loaded once. */
base_status plugins_take(const char *file, base_error *err);

/* Loads every file of LCPBENCH_PLUGINS, which are parted by colons. */
base_status plugins_take_environment(base_error *err);

/* The i-th plug-in; NULL past the end. */
const plugin_file *plugins_at(int i);

/* The plug-in of a solver; NULL where it is of the build. */
const plugin_file *plugins_of(const lcp_solver *s);
