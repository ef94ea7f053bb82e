/* Files into JSON trees; YAML is mapped onto the same tree, so that one reader serves both. */
#include "lcp/base/fields.h"
#include "lcp/base/input.h"
#include "problems/read/node.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <yaml.h>

enum { FILE_MAX = 64 << 20, DEPTH_MAX = 64 };

/* ---- YAML ----------------------------------------------------------------------------------- */

/* A plain (unquoted) scalar is null, true, false or a number where it looks like one (YAML 1.2
 * core schema without octal and without the words for infinity and NaN, which stay text). */
static json_t *plain_scalar(const char *text) {
  double x;
  int i;
  if (text[0] == '\0' || strcmp(text, "~") == 0 || strcmp(text, "null") == 0) {
    return json_null();
  }
  if (strcmp(text, "true") == 0 || strcmp(text, "false") == 0) {
    return json_boolean(text[0] == 't');
  }
  if (strspn(text, "+-.0123456789eE") != strlen(text)) {
    return json_string(text);
  }
  if (base_parse_int(text, &i)) {
    return json_integer(i);
  }
  return base_parse_real(text, &x) ? json_real(x) : json_string(text);
}

static base_status yaml_fail(const yaml_event_t *e, const char *rule, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "line %zu: %s", e->start_mark.line + 1, rule);
}

static base_status next_event(yaml_parser_t *p, yaml_event_t *e, base_error *err) {
  if (yaml_parser_parse(p, e) == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "line %zu: YAML: %s", p->problem_mark.line + 1,
                     p->problem != NULL ? p->problem : "unreadable");
  }
  return BASE_OK;
}

static base_status build(yaml_parser_t *p, yaml_event_t *e, int depth, json_t **out,
                         base_error *err);

static base_status build_sequence(yaml_parser_t *p, int depth, json_t *list, base_error *err) {
  for (;;) {
    yaml_event_t e;
    BASE_TRY(next_event(p, &e, err));
    json_t *item = NULL;
    const bool end = e.type == YAML_SEQUENCE_END_EVENT;
    const base_status status = end ? BASE_OK : build(p, &e, depth, &item, err);
    yaml_event_delete(&e);
    if (end || status != BASE_OK) {
      return status;
    }
    if (json_array_append_new(list, item) != 0) {
      return BASE_FAIL(err, BASE_ENOMEM, "YAML: no memory");
    }
  }
}

static base_status build_pair(yaml_parser_t *p, const yaml_event_t *key, int depth, json_t *map,
                              base_error *err) {
  if (key->type != YAML_SCALAR_EVENT) {
    return yaml_fail(key, "a key must be plain text", err);
  }
  const char *name = (const char *)key->data.scalar.value;
  if (json_object_get(map, name) != NULL) {
    return yaml_fail(key, "this key is there twice", err);
  }
  yaml_event_t e;
  json_t *value = NULL;
  BASE_TRY(next_event(p, &e, err));
  const base_status status = build(p, &e, depth, &value, err);
  yaml_event_delete(&e);
  BASE_TRY(status);
  return (json_object_set_new(map, name, value) == 0)
             ? BASE_OK
             : yaml_fail(key, "key is not UTF-8, or no memory", err);
}

static base_status build_mapping(yaml_parser_t *p, int depth, json_t *map, base_error *err) {
  for (;;) {
    yaml_event_t key;
    BASE_TRY(next_event(p, &key, err));
    const bool end = key.type == YAML_MAPPING_END_EVENT;
    const base_status status = end ? BASE_OK : build_pair(p, &key, depth, map, err);
    yaml_event_delete(&key);
    if (end || status != BASE_OK) {
      return status;
    }
  }
}

static base_status build(yaml_parser_t *p, yaml_event_t *e, int depth, json_t **out,
                         base_error *err) {
  if (depth > DEPTH_MAX) {
    return yaml_fail(e, "nested too deeply", err);
  }
  base_status status = BASE_OK;
  switch (e->type) {
  case YAML_SCALAR_EVENT: {
    const char *text = (const char *)e->data.scalar.value;
    *out =
        (e->data.scalar.style == YAML_PLAIN_SCALAR_STYLE) ? plain_scalar(text) : json_string(text);
    return (*out != NULL) ? BASE_OK : yaml_fail(e, "text is not UTF-8, or no memory", err);
  }
  case YAML_SEQUENCE_START_EVENT:
    *out = json_array();
    status = (*out != NULL) ? build_sequence(p, depth + 1, *out, err) : BASE_ENOMEM;
    break;
  case YAML_MAPPING_START_EVENT:
    *out = json_object();
    status = (*out != NULL) ? build_mapping(p, depth + 1, *out, err) : BASE_ENOMEM;
    break;
  case YAML_ALIAS_EVENT: /* a few bytes of aliases can unfold to gigabytes */
    return yaml_fail(e, "aliases are not supported", err);
  default:
    return yaml_fail(e, "need a value", err);
  }
  if (status != BASE_OK) {
    json_decref(*out);
    *out = NULL;
  }
  return status;
}

/* stream start, document start, value, document end, stream end */
static base_status build_document(yaml_parser_t *p, json_t **out, base_error *err) {
  for (int i = 0; i < 2; i++) {
    yaml_event_t e;
    BASE_TRY(next_event(p, &e, err));
    const yaml_event_type_t got = e.type;
    yaml_event_delete(&e);
    if (got == YAML_STREAM_END_EVENT) {
      return BASE_FAIL(err, BASE_EINVAL, "YAML: the file is empty");
    }
  }
  yaml_event_t e;
  BASE_TRY(next_event(p, &e, err));
  const base_status status = build(p, &e, 0, out, err);
  yaml_event_delete(&e);
  BASE_TRY(status);
  for (int i = 0; i < 2; i++) {
    const base_status end = next_event(p, &e, err);
    const bool fine =
        end == BASE_OK && e.type == (i == 0 ? YAML_DOCUMENT_END_EVENT : YAML_STREAM_END_EVENT);
    if (end == BASE_OK) {
      yaml_event_delete(&e);
    }
    if (!fine) {
      json_decref(*out);
      *out = NULL;
      return (end != BASE_OK) ? end : BASE_FAIL(err, BASE_EINVAL, "YAML: need one document");
    }
  }
  return BASE_OK;
}

static base_status read_yaml(FILE *f, json_t **out, base_error *err) {
  yaml_parser_t p;
  if (yaml_parser_initialize(&p) == 0) {
    return BASE_FAIL(err, BASE_ENOMEM, "YAML: no memory");
  }
  yaml_parser_set_input_file(&p, f);
  const base_status status = build_document(&p, out, err);
  yaml_parser_delete(&p);
  return status;
}

/* ---- JSON ----------------------------------------------------------------------------------- */

static base_status read_json(FILE *f, json_t **out, base_error *err) {
  json_error_t e;
  *out = json_loadf(f, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &e);
  if (*out == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "line %d: JSON: %s", e.line, e.text);
  }
  return BASE_OK;
}

/* ---- either --------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end) {
  const size_t n = strlen(text), m = strlen(end);
  return n >= m && strcasecmp(text + n - m, end) == 0;
}

/* Of standard input, whose name does not tell: what begins with a brace or a bracket is JSON. */
static bool begins_as_yaml(FILE *f) {
  int c = getc(f);
  while (c == ' ' || c == '\n' || c == '\r' || c == '\t') {
    c = getc(f);
  }
  return c != '{' && c != '[' && c != EOF;
}

static base_status read_open(FILE *f, const char *path, json_t **out, base_error *err) {
  const long from = ftell(f); /* behind a byte-order mark */
  const long size = (from >= 0 && fseek(f, 0, SEEK_END) == 0) ? ftell(f) : -1;
  if (size < 0 || size > FILE_MAX || fseek(f, from, SEEK_SET) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "size of %ld bytes, need at most %d", size, FILE_MAX);
  }
  const bool yaml = base_in_is_stdin(path) ? begins_as_yaml(f)
                                           : ends_with(path, ".yaml") || ends_with(path, ".yml");
  if (fseek(f, from, SEEK_SET) != 0) {
    return BASE_FAIL(err, BASE_EIO, "cannot be read twice");
  }
  return yaml ? read_yaml(f, out, err) : read_json(f, out, err);
}

base_status node_read_file(const char *path, json_t **out, base_error *err) {
  *out = NULL;
  FILE *f;
  BASE_TRY(base_in_text(path, &f, err));
  base_error inner = {0};
  const base_status status = read_open(f, path, out, &inner);
  (void)fclose(f); /* read only */
  if (status != BASE_OK) {
    return BASE_FAIL(err, status, "%s: %s", path, inner.text);
  }
  return BASE_OK;
}
