/* harness/util/version.h - the release this binary belongs to. */
#pragma once

const char *harness_version(void);
