/* tests/support/files.h - the files that tests read: those of the repository, below tests/, and the
 * files of other codes as those codes wrote them, which may lie beside a clone. */
#pragma once

#include <stdbool.h>

struct CMUnitTest;

/* Path of tests/NAME. It need not exist: a reader that misses it says so, and the test fails. The text
 * is overwritten by the fifth call after it. */
const char *tests_file(const char *name);

/* Path of NAME in the folder that LCPBENCH_SHARED names, or ../shared; as long-lived as above. */
const char *shared_file(const char *name);

/* Is that file there? */
bool file_exists(const char *path);

/* The exit code of a program whose tests are all skipped, each by name (TAP), for this reason. cmocka 1.1
 * writes a skipped test as "not ok", which counts as failed. */
int skip_by_name(const struct CMUnitTest *tests, int n, const char *reason);
