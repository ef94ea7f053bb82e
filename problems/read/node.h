/* problems/read/node.h - typed access to one JSON object, for the readers of scene and case files.
 * Every failure names the object, the key and the rule; every key must be known. */
#pragma once

#include "lcp/base/status.h"

#include <jansson.h>
#include <stdbool.h>

typedef struct node {
  json_t *v;       /* borrowed; jansson's iterators want it writable */
  char where[160]; /* "scene 'B01.a': body 'ball'" */
  base_error *err;
} node;

/* v must be an object; `where` is a format for the name it gets in messages. */
base_status node_open(node *n, json_t *v, base_error *err, const char *where, ...)
    BASE_PRINTF(4, 5);

/* Fails on the first key that is not among the words of "a|b|c". */
base_status node_keys(const node *n, const char *known);

bool node_has(const node *n, const char *key);

/* Absent keys leave *out as it is; a wrong type or a number that is not finite fails. */
base_status node_real(const node *n, const char *key, double *out);
base_status node_int(const node *n, const char *key, int *out);
base_status node_bool(const node *n, const char *key, bool *out);
base_status node_text(const node *n, const char *key, char *out, size_t cap);
/* An array of exactly `count` numbers. */
base_status node_vector(const node *n, const char *key, int count, double *out);
/* An array of at most max items; *out is NULL and *count 0 when absent. */
base_status node_list(const node *n, const char *key, int max, json_t **out, int *count);
/* One of "a|b|c" as its index. */
base_status node_choice(const node *n, const char *key, const char *words, int *out);

/* The same, but the key must be there. */
base_status node_need(const node *n, const char *key);

/* Items of arrays. */
base_status node_number(const node *n, const json_t *v, const char *what, double *out);
base_status node_string(const node *n, const json_t *v, const char *what, char *out, size_t cap);

/* Whole files, at most 64 MiB, by their ending: .yaml and .yml are read as YAML, all else as JSON.
 * The tree is the caller's (json_decref). */
base_status node_read_file(const char *path, json_t **out, base_error *err);
