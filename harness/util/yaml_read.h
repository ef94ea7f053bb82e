/* harness/util/yaml_read.h - small YAML documents with messages that name file, line and key. */
#pragma once

#include "lcp/base/nearest.h"
#include "lcp/base/status.h"

#include <stdbool.h>
#include <yaml.h>

typedef struct yaml_file {
  const char *path;
  yaml_document_t doc;
  bool loaded;
  base_nearest near; /* to the key at hand, of the names it was held against */
} yaml_file;

base_status yaml_file_open(const char *path, yaml_file *out, base_error *err);
void yaml_file_close(yaml_file *f);

yaml_node_t *yaml_root(yaml_file *f);
yaml_node_t *yaml_item(yaml_file *f, int index);
const char *yaml_text(const yaml_node_t *n); /* NULL unless a scalar */

/* "path:line: key: rule" */
base_status yaml_fail(const yaml_file *f, const yaml_node_t *n, const char *key, const char *rule,
                      base_error *err);

/* Is this the key of that name? Asked of every name that a mapping knows. */
bool yaml_is(yaml_file *f, const char *key, const char *name);

/* Calls take(ctx, key, value) for every member of a mapping; a key that take does not know makes it
 * return BASE_EUNSUPPORTED, which becomes "unknown key", with the nearest name that yaml_is was asked. */
typedef base_status (*yaml_take)(void *ctx, yaml_file *f, const char *key, yaml_node_t *value,
                                 base_error *err);
base_status yaml_members(yaml_file *f, yaml_node_t *map, const char *what, yaml_take take,
                         void *ctx, base_error *err);
