/* harness/util/folder.h - folders of results. */
#pragma once

#include "lcp/base/status.h"

/* Makes the folder and those above it; one that is there is fine. */
base_status folder_make(const char *path, base_error *err);

/* "DIR/NAME" into buf, cut at cap - 1 characters. */
void folder_file(const char *dir, const char *name, char *buf, size_t cap);
