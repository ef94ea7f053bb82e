#include "lcp/share/lcp_share_parts.h"

#include "lcp/base/crew.h"
#include "lcp/share/lcp_share_state.h"

#include <stdlib.h>
#include <string.h>

/* The choice in an island. */
typedef struct chosen {
  lcp_share *share;  /* owned */
  double *z, *start; /* cap: of the island, owned as one by z */
  int cap;
  lcp_share_result made;
  base_status status;
  base_error err;
} chosen;

struct lcp_share_parts {
  chosen *of; /* cap */
  int cap;
  /* of the call at hand: views */
  const lcp_islands *islands;
  const double *start, *z;
  int n_contact; /* of all islands */
};

base_status lcp_share_parts_open(lcp_share_parts **out, base_error *err) {
  *out = calloc(1, sizeof **out);
  return (*out != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "no memory for shared impulses");
}

void lcp_share_parts_close(lcp_share_parts *s) {
  for (int k = 0; s != NULL && k < s->cap; k++) {
    lcp_share_close(s->of[k].share);
    free(s->of[k].z);
  }
  if (s != NULL) {
    free(s->of);
    free(s);
  }
}

void lcp_share_parts_rest(lcp_share_parts *s) {
  for (int k = 0; k < s->cap; k++) {
    if (s->of[k].share != NULL) {
      lcp_share_rest(s->of[k].share);
    }
  }
}

static base_status grow(lcp_share_parts *s, int count, base_error *err) {
  if (count > s->cap) {
    chosen *more = realloc(s->of, (size_t)(2 * count) * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to share the impulses of %d islands", count);
    }
    memset(more + s->cap, 0, (size_t)(2 * count - s->cap) * sizeof *more);
    s->of = more;
    s->cap = 2 * count;
  }
  return BASE_OK;
}

static base_status open_island(chosen *own, int n, base_error *err) {
  if (own->share == NULL) {
    BASE_TRY(lcp_share_open(&own->share, err));
  }
  if (n > own->cap) {
    free(own->z);
    own->cap = base_room(n);
    own->z = malloc(2 * (size_t)own->cap * sizeof *own->z);
    if (own->z == NULL) {
      own->cap = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to share %d impulses", n);
    }
    own->start = own->z + own->cap;
  }
  return BASE_OK;
}

/* Of the island that is number `part` by size. */
static void choose_in(void *parts, int part, int hand) {
  const lcp_share_parts *s = parts;
  const lcp_islands_view v = lcp_islands_at(s->islands, part);
  chosen *own = &s->of[v.number];
  const int n = v.p->M.n;
  (void)hand;
  own->err = (base_error){0};
  own->status = open_island(own, n, &own->err);
  for (int i = 0; i < n && own->status == BASE_OK; i++) {
    own->z[i] = s->z[v.row[i]];
    own->start[i] = (s->start != NULL) ? s->start[v.row[i]] : 0.0;
  }
  if (own->status == BASE_OK) {
    own->share->n_whole = s->n_contact;
    own->status = lcp_share_apply(own->share, v.p, (s->start != NULL) ? own->start : NULL, own->z,
                                  &own->made, &own->err);
  }
}

static int contacts_of(const lcp_problem *p) {
  int count = 0;
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    count += p->block[k].soft > 0;
  }
  return count;
}

static void add(lcp_share_result *sum, const lcp_share_result *own) {
  sum->outcome = (own->outcome > sum->outcome) ? own->outcome : sum->outcome;
  const bool counted = sum->deficit != LCP_SHARE_UNCOUNTED && own->deficit != LCP_SHARE_UNCOUNTED;
  sum->deficit = counted ? sum->deficit + own->deficit : LCP_SHARE_UNCOUNTED;
  sum->rounds += own->rounds;
  sum->factorizations += own->factorizations;
  sum->backsolves += own->backsolves;
}

base_status lcp_share_parts_apply(lcp_share_parts *s, const lcp_islands *islands,
                                  const double *start, double *z, lcp_share_result *out,
                                  base_error *err) {
  const int count = lcp_islands_count(islands);
  *out = (lcp_share_result){.outcome = LCP_SHARE_UNIQUE};
  BASE_TRY(grow(s, count, err));
  s->islands = islands;
  s->start = start;
  s->z = z;
  s->n_contact = 0;
  for (int k = 0; k < count; k++) {
    s->n_contact += contacts_of(lcp_islands_at(islands, k).p);
  }
  base_share(count, choose_in, s);
  for (int k = 0; k < count; k++) {
    if (s->of[k].status != BASE_OK) {
      *err = s->of[k].err;
      return s->of[k].status;
    }
    add(out, &s->of[k].made);
  }
  for (int k = 0; k < count && out->outcome == LCP_SHARE_MADE; k++) {
    const lcp_islands_view v = lcp_islands_at(islands, k);
    for (int i = 0; i < v.p->M.n; i++) {
      z[v.row[i]] = s->of[v.number].z[i];
    }
  }
  return BASE_OK;
}
