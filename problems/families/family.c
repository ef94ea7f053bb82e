#include "problems/families/family.h"

#include "family_list.h"
#include "lcp/base/nearest.h"

#include <stdlib.h>
#include <string.h>

#define DECLARE_(name) extern const lcp_family family_##name;
FAMILY_LIST(DECLARE_)
#define ADDRESS_(name) &family_##name,
static const lcp_family *const all[] = {FAMILY_LIST(ADDRESS_) NULL};

const lcp_family *const *lcp_families(int *count) {
  *count = BASE_COUNT(all) - 1;
  return all;
}

const lcp_family *lcp_family_find(const char *name) {
  for (int i = 0; all[i] != NULL; i++) {
    if (strcmp(all[i]->name, name) == 0) {
      return all[i];
    }
  }
  return NULL;
}

static base_status build(const lcp_family *f, const char *parameters, known_lcp *out,
                         base_error *err) {
  void *param = calloc(1, f->param_size + 1);
  if (param == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for parameters");
  }
  base_fields_default(f->fields, f->n_fields, param);
  base_status status = base_fields_parse(f->fields, f->n_fields, param, parameters, err);
  if (status == BASE_OK) {
    status = f->build(param, out, err);
  }
  free(param);
  return (status == BASE_OK) ? lcp_problem_check(&out->p, err) : status;
}

base_status lcp_family_unknown(const char *name, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  int count;
  const lcp_family *const *families = lcp_families(&count);
  base_nearest near = base_nearest_to(name, strlen(name));
  for (int i = 0; i < count; i++) {
    base_nearest_offer(&near, families[i]->name);
  }
  return BASE_FAIL(err, BASE_EINVAL,
                   "unknown problem '%.100s': need one of `lcpbench list problems` or a file .dat, "
                   ".mtx, .npz, .hdf5%s",
                   name, base_nearest_hint(&near, hint));
}

base_status lcp_family_load(const char *text, known_lcp *out, base_error *err) {
  char name[64] = "";
  memset(out, 0, sizeof *out);
  const size_t len = strcspn(text, ":");
  if (len < sizeof name) {
    memcpy(name, text, len);
    name[len] = '\0';
  }
  const lcp_family *f = lcp_family_find(name);
  if (f == NULL) {
    return lcp_family_unknown(len < sizeof name ? name : text, err);
  }
  base_error inner = {0};
  const base_status status = build(f, text[len] == ':' ? text + len + 1 : NULL, out, &inner);
  if (status != BASE_OK) {
    known_lcp_free(out);
    return BASE_FAIL(err, status, "problem %s: %s", name, inner.text);
  }
  return BASE_OK;
}
