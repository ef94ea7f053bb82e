/* harness/util/installed.h - what `meson install` puts beside the program. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* The file or folder `name` of the installed data, found from the place of the running program, so that the tree may stand
 * anywhere. False: the program is not installed, or there is no such thing. */
bool installed_data(const char *name, char *path, size_t cap);
