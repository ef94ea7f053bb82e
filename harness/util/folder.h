/* harness/util/folder.h - folders of results. */
#pragma once

#include "lcp/base/status.h"

/* Makes the folder and those above it; one that is there is fine. */
base_status folder_make(const char *path, base_error *err);
