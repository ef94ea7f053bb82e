#include "problems/import/import.h"

#include "lcp/base/input.h"
#include "lcp/io/lcp_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* LCPs begin "n 0 n n", friction problems "d nc type size size" with d = 2, 3 or 5, mixed LCPs
 * "1 flag n m 0". */
static import_kind by_numbers(const long *x, int count) {
  if (count >= 4 && x[0] >= 1 && x[1] == 0 && x[2] == x[0] && x[3] == x[0]) {
    return IMPORT_LCP;
  }
  if (count == 5 && (x[0] == 2 || x[0] == 3 || x[0] == 5) && x[1] >= 1 && x[2] >= 0 && x[2] <= 2 &&
      x[3] == x[4]) {
    return IMPORT_FRICTION;
  }
  const bool flags = x[0] >= 0 && x[0] <= 1 && x[1] >= 0 && x[1] <= 1;
  return (count == 5 && flags && x[4] == 0) ? IMPORT_MLCP : IMPORT_UNKNOWN;
}

base_status import_detect(const char *path, import_kind *kind, base_error *err) {
  unsigned char head[8] = {0};
  long x[5] = {-1, -1, -1, -1, -1};
  *kind = IMPORT_UNKNOWN;
  FILE *f;
  BASE_TRY(base_in_text(path, &f, err));
  const long from = ftell(f);
  const size_t got = fread(head, 1, sizeof head, f);
  if (got == sizeof head && memcmp(head, "\x89HDF\r\n\x1a\n", sizeof head) == 0) {
    *kind = IMPORT_FCLIB;
  } else if (from >= 0 && fseek(f, from, SEEK_SET) == 0) {
    int count = 0;
    while (count < 5 &&
           fscanf(f, "%9ld", &x[count]) == 1 /* NOLINT(cert-err34-c): nine digits fit */) {
      count++;
    }
    *kind = by_numbers(x, count);
  }
  (void)fclose(f);
  return BASE_OK;
}

/* Hands the arrays of a reader of lcp/io over to *out. */
static base_status adopt(const char *path, known_lcp *out, base_error *err) {
  lcp_file_problem file;
  memset(out, 0, sizeof *out);
  BASE_TRY(lcp_read_siconos(path, &file, err));
  out->p = file.p;
  for (int i = 0; i < file.n_owned; i++) {
    out->owned[out->n_owned++] = file.owned[i];
  }
  return BASE_OK;
}

static base_status pose(friction_problem *p, int facets, import_posed *out, base_error *err) {
  const bool global = p->global;
  BASE_TRY(friction_condense(p, err));
  known_lcp *exact = (facets == 0) ? &out->posed : &out->cone;
  BASE_TRY(friction_pose_cone(p, exact, err));
  exact->p.traits |= global ? (LCP_SYMMETRIC | LCP_PSD) : 0u; /* H' M^-1 H */
  if (facets == 0) {
    return BASE_OK;
  }
  out->rows = p->rows;
  out->facets = (p->rows == 2) ? 2 : facets;
  BASE_TRY(friction_pose_facets(p, out->facets, &out->posed, err));
  out->posed.p.traits |= global ? LCP_COPOSITIVE : 0u;
  return BASE_OK;
}

static base_status import_friction(const char *path, import_kind kind, int facets,
                                   import_posed *out, base_error *err) {
  friction_problem p;
  base_error inner = {0};
  BASE_TRY(kind == IMPORT_FCLIB ? friction_read_fclib(path, &p, err)
                                : friction_read_siconos(path, &p, err));
  const base_status status = pose(&p, facets, out, &inner);
  friction_free(&p);
  return (status == BASE_OK) ? BASE_OK : BASE_FAIL(err, status, "%s: %s", path, inner.text);
}

static base_status import_kinds(const char *path, int facets, import_posed *out, base_error *err) {
  import_kind kind;
  BASE_TRY(import_detect(path, &kind, err));
  switch (kind) {
  case IMPORT_LCP:
    return adopt(path, &out->posed, err);
  case IMPORT_MLCP:
    return import_mlcp(path, &out->posed, err);
  case IMPORT_FRICTION:
  case IMPORT_FCLIB:
    return import_friction(path, kind, facets, out, err);
  default:
    return BASE_FAIL(err, BASE_EINVAL,
                     "%s: neither a Siconos text problem (LCP, mixed LCP, friction) nor FCLIB HDF5",
                     path);
  }
}

base_status import_pose(const char *path, int facets, import_posed *out, base_error *err) {
  memset(out, 0, sizeof *out);
  const base_status status = import_kinds(path, facets, out, err);
  if (status != BASE_OK) {
    import_posed_free(out);
  }
  return status;
}

void import_posed_free(import_posed *p) {
  known_lcp_free(&p->posed);
  known_lcp_free(&p->cone);
  memset(p, 0, sizeof *p);
}

base_status import_judge_cone(const import_posed *p, const double *z, lcp_verdict *out,
                              base_error *err) {
  const int n = p->cone.p.M.n;
  if (n == 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "not a friction problem with facets");
  }
  double *r = malloc((size_t)n * sizeof *r);
  if (r == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d impulses", n);
  }
  friction_facet_impulse(p->rows, n / p->rows, p->facets, z, r);
  const base_status status = lcp_judge(&p->cone.p, r, out, err);
  free(r);
  return status;
}
