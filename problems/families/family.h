/* problems/families/family.h - complementarity problems by name and parameters, with known answers.
 *
 * A family is one constant in one file under problems/families. */
#pragma once

#include "lcp/base/fields.h"
#include "problems/families/known_lcp.h"

typedef struct lcp_family {
  const char *name, *title, *cite; /* cite: keys of docs/references.bib; "": none */
  const char *about;               /* one paragraph: what is known, what it is hard for, source */
  const base_field *fields;
  int n_fields;
  size_t param_size;
  /* Fills a zeroed *out; the caller frees it on success and failure. */
  base_status (*build)(const void *param, known_lcp *out, base_error *err);
} lcp_family;

/* The members of a descriptor that every file of a family calls the same; its parameters are the struct param_. */
#define FAMILY_PARTS(param_)                                                                       \
  .fields = fields, .n_fields = BASE_COUNT(fields), .param_size = sizeof(param_), .build = build

const lcp_family *const *lcp_families(int *count);
const lcp_family *lcp_family_find(const char *name);

/* The failure where lcp_family_find has none, with the nearest name. */
base_status lcp_family_unknown(const char *name, base_error *err);

/* "NAME" or "NAME:par=val,..." into a problem that passes lcp_problem_check; free with
 * known_lcp_free (nothing to free on failure). */
base_status lcp_family_load(const char *text, known_lcp *out, base_error *err);
