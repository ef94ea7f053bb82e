#include "harness/util/yaml_read.h"

#include "lcp/base/input.h"

#include <stdio.h>
#include <string.h>

base_status yaml_file_open(const char *path, yaml_file *out, base_error *err) {
  *out = (yaml_file){.path = path};
  FILE *from;
  BASE_TRY(base_in_open(path, &from, err)); /* libyaml knows every byte-order mark */
  yaml_parser_t parser;
  if (!yaml_parser_initialize(&parser)) {
    (void)fclose(from);
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory to read it", path);
  }
  yaml_parser_set_input_file(&parser, from);
  out->loaded = yaml_parser_load(&parser, &out->doc) != 0;
  base_status done = BASE_OK;
  if (!out->loaded) {
    done = BASE_FAIL(err, BASE_EINVAL, "%s:%zu: %s", path, parser.problem_mark.line + 1,
                     parser.problem != NULL ? parser.problem : "not YAML");
  } else if (yaml_root(out) == NULL) {
    done = BASE_FAIL(err, BASE_EINVAL, "%s:1: the file is empty", path);
  }
  yaml_parser_delete(&parser);
  (void)fclose(from);
  if (done != BASE_OK) {
    yaml_file_close(out);
  }
  return done;
}

void yaml_file_close(yaml_file *f) {
  if (f->loaded) {
    yaml_document_delete(&f->doc);
    f->loaded = false;
  }
}

yaml_node_t *yaml_root(yaml_file *f) {
  return yaml_document_get_root_node(&f->doc);
}

yaml_node_t *yaml_item(yaml_file *f, int index) {
  return yaml_document_get_node(&f->doc, index);
}

const char *yaml_text(const yaml_node_t *n) {
  return (n != NULL && n->type == YAML_SCALAR_NODE) ? (const char *)n->data.scalar.value : NULL;
}

base_status yaml_fail(const yaml_file *f, const yaml_node_t *n, const char *key, const char *rule,
                      base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%s:%zu: %s: %s", f->path,
                   (n != NULL) ? n->start_mark.line + 1 : 1, key, rule);
}

/* Is the key of `p` also that of a pair before it? Few pairs come that far: unknown keys end it. */
static bool given_before(yaml_file *f, const yaml_node_t *map, const yaml_node_pair_t *p,
                         const char *name) {
  for (const yaml_node_pair_t *e = map->data.mapping.pairs.start; e < p; e++) {
    if (strcmp(yaml_text(yaml_item(f, e->key)), name) == 0) {
      return true;
    }
  }
  return false;
}

bool yaml_is(yaml_file *f, const char *key, const char *name) {
  base_nearest_offer(&f->near, name);
  return strcmp(key, name) == 0;
}

base_status yaml_members(yaml_file *f, yaml_node_t *map, const char *what, yaml_take take,
                         void *ctx, base_error *err) {
  if (map->type != YAML_MAPPING_NODE) {
    return yaml_fail(f, map, what, "need a mapping (key: value)", err);
  }
  for (yaml_node_pair_t *p = map->data.mapping.pairs.start; p < map->data.mapping.pairs.top; p++) {
    yaml_node_t *key = yaml_item(f, p->key);
    yaml_node_t *value = yaml_item(f, p->value);
    const char *name = yaml_text(key);
    if (name == NULL || value == NULL) {
      return yaml_fail(f, key, what, "need plain keys", err);
    }
    if (given_before(f, map, p, name)) {
      return yaml_fail(f, key, name, "is given twice", err);
    }
    f->near = base_nearest_to(name, strlen(name));
    const base_status done = take(ctx, f, name, value, err);
    if (done == BASE_EUNSUPPORTED) {
      char rule[120 + BASE_NEAREST_HINT];
      char hint[BASE_NEAREST_HINT];
      (void)snprintf(rule, sizeof rule, "unknown key in %.60s%s", what,
                     base_nearest_hint(&f->near, hint));
      return yaml_fail(f, key, name, rule, err);
    }
    BASE_TRY(done);
  }
  return BASE_OK;
}
