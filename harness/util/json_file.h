/* harness/util/json_file.h - JSON objects as files beside the rows of a campaign. */
#pragma once

#include "harness/util/json_out.h"
#include "lcp/base/status.h"

/* DIR/name, whole or not at all. */
base_status json_file_write(const json_t *o, const char *dir, const char *name, base_error *err);

/* The object of DIR/name, a new reference; NULL where there is no such file. BASE_EINVAL, with the
 * place: it does not hold a JSON object. */
base_status json_file_read(const char *dir, const char *name, json_t **out, base_error *err);
