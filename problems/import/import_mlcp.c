/* Mixed LCPs in the text format of Siconos: two flags (M whole, M in four parts), n equations,
 * m inequalities, cumulative block ends from 0 to n + m, a flag per block (1: complementarity),
 * then M and q, then perhaps the parts again, which say the same. */
#include "lcp/io/lcp_text.h"
#include "problems/import/import.h"

#include <string.h>

typedef struct layout {
  long n, m;
  int n_block;
  int end[4096];
  bool complementary[4096];
} layout;

static base_status read_layout(lcp_text *t, layout *l, base_error *err) {
  long whole, parts, x;
  BASE_TRY(lcp_text_int(t, "the flag of the whole matrix", 1, 1, &whole, err));
  BASE_TRY(lcp_text_int(t, "the flag of the parts", 0, 1, &parts, err));
  BASE_TRY(lcp_text_int(t, "the number of equations", 0, 1000000, &l->n, err));
  BASE_TRY(lcp_text_int(t, "the number of inequalities", 0, 1000000, &l->m, err));
  const long total = l->n + l->m;
  if (total < 1) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: a problem without unknowns", t->path, t->line);
  }
  BASE_TRY(lcp_text_int(t, "the start of the blocks", 0, 0, &x, err));
  for (l->n_block = 0; x < total; l->n_block++) {
    if (l->n_block == 4096) {
      return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: more than 4096 blocks", t->path, t->line);
    }
    BASE_TRY(lcp_text_int(t, "the end of a block", x + 1, total, &x, err));
    l->end[l->n_block] = (int)x;
  }
  for (int b = 0; b < l->n_block; b++) {
    BASE_TRY(lcp_text_int(t, "the flag of a block", 0, 1, &x, err));
    l->complementary[b] = (x == 1);
  }
  return BASE_OK;
}

static base_status read_numbers(lcp_text *t, const layout *l, known_lcp *k, base_error *err) {
  const long n = l->n + l->m;
  long again;
  double *M, *q;
  static const char *const names[] = {"the storage type", "the number of rows",
                                      "the number of columns", "the number of rows of M",
                                      "the number of columns of M"};
  for (int i = 0; i < BASE_COUNT(names); i++) {
    const long want = (i == 0) ? 0 : n;
    BASE_TRY(lcp_text_int(t, names[i], want, want, &again, err));
  }
  BASE_TRY(lcp_text_holds(t, (double)n * (double)n + (double)n, "n + m", err));
  BASE_TRY(known_dense(k, (int)n, &M, &q, err));
  for (long i = 0; i < n * n; i++) {
    BASE_TRY(lcp_text_real(t, "an entry of M", &M[i], err));
  }
  for (long i = 0; i < n; i++) {
    BASE_TRY(lcp_text_real(t, "an entry of q", &q[i], err));
  }
  lcp_block *block = KNOWN_ARRAY(k, lcp_block, l->n_block);
  if (block == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for blocks", t->path);
  }
  for (int b = 0; b < l->n_block; b++) {
    block[b].start = (b > 0) ? l->end[b - 1] : 0;
    block[b].size = l->end[b] - block[b].start;
    block[b].set = l->complementary[b] ? LCP_ORTHANT : LCP_FREE;
  }
  k->p.block = block;
  k->p.n_block = l->n_block;
  k->p.traits = lcp_matrix_is_symmetric(&k->p.M) ? LCP_SYMMETRIC : 0u;
  return lcp_problem_check(&k->p, err);
}

base_status import_mlcp(const char *path, known_lcp *out, base_error *err) {
  lcp_text t;
  layout l = {0};
  memset(out, 0, sizeof *out);
  BASE_TRY(lcp_text_open(&t, path, err));
  base_status s = read_layout(&t, &l, err);
  if (s == BASE_OK) {
    s = read_numbers(&t, &l, out, err);
  }
  lcp_text_close(&t);
  if (s != BASE_OK) {
    known_lcp_free(out);
  }
  return s;
}
