/* harness/choice/plugin_solver.h - a shared object that follows lcp_plugin.h, as a solver like any other. */
#pragma once

#include "lcp/lcp_solver.h"

/* Loads the plug-in in `file` (a path; opened as it is, not searched for), checks its descriptor and adds its solver to
 * those that registry_solver knows. *out lives until the program ends. BASE_EIO: no such file, or it cannot be loaded;
 * BASE_EINVAL: no plug-in, of another interface, a descriptor that breaks a rule, or a name that is taken. */
base_status plugin_load(const char *file, const lcp_solver **out, base_error *err);
