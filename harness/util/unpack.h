/* harness/util/unpack.h - text files that may be packed with xz. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdio.h>

bool unpack_is_xz(const char *path); /* by its ending */

/* As base_in_text; of a name that ends in .xz what is packed in it, unpacked in memory, at most 4 GiB. BASE_EINVAL:
 * it is damaged, or larger. */
base_status unpack_text(const char *path, FILE **out, base_error *err);
