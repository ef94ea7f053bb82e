#include "harness/sequence/sequence.h"

#include "lcp/lcp_judge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* ---- one problem, copied --------------------------------------------------------------------- */

static void item_free(sequence_item *s) {
  void *const owned[] = {s->val, s->q, s->lo, s->hi, s->z, s->block, s->owner, s->first, s->active};
  for (int i = 0; i < BASE_COUNT(owned); i++) {
    free(owned[i]);
  }
  lcp_csc_free(&s->csc);
}

/* NULL without memory; of no bytes a block of one. */
static void *copy_of(const void *from, size_t count, size_t size) {
  void *to = malloc(count * size + 1);
  if (to != NULL && count > 0) {
    memcpy(to, from, count * size);
  }
  return to;
}

/* Dense as it is; anything else by columns, without entries that are zero, as files hold it. */
static base_status copy_matrix(const lcp_matrix *M, sequence_item *s, base_error *err) {
  const size_t n = (size_t)M->n;
  if (M->storage != LCP_DENSE) {
    BASE_TRY(lcp_matrix_to_csc(M, &s->csc, err));
    s->p.M = (lcp_matrix){.storage = LCP_CSC, .n = M->n, .csc = s->csc};
    return BASE_OK;
  }
  s->val = copy_of(M->val, n * n, sizeof *s->val);
  if (s->val == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a problem of %d unknowns", M->n);
  }
  for (size_t k = 0; k < n * n; k++) {
    s->val[k] += 0.0; /* -0.0 becomes 0.0: files have no entry for either */
  }
  s->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = M->n, .val = s->val};
  return BASE_OK;
}

static base_status copy_rest(const lcp_problem *p, int n_owner, const uint64_t *owner,
                             const int *first, const double *z, sequence_item *s, base_error *err) {
  const size_t n = (size_t)p->M.n;
  const lcp_block all = {.size = p->M.n, .set = LCP_ORTHANT};
  const int n_block = (p->block != NULL) ? p->n_block : 1;
  s->q = copy_of(p->q, n, sizeof *s->q);
  s->lo = copy_of(p->lo, p->lo != NULL ? n : 0, sizeof *s->lo);
  s->hi = copy_of(p->hi, p->hi != NULL ? n : 0, sizeof *s->hi);
  s->z = copy_of(z, n, sizeof *s->z);
  s->block = copy_of(p->block != NULL ? p->block : &all, (size_t)n_block, sizeof *s->block);
  s->owner = copy_of(owner, (size_t)n_owner, sizeof *s->owner);
  s->first = copy_of(first, (size_t)n_owner + 1, sizeof *s->first);
  s->active = calloc(n + 1, 1);
  if (s->q == NULL || s->lo == NULL || s->hi == NULL || s->z == NULL || s->block == NULL ||
      s->owner == NULL || s->first == NULL || s->active == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a problem of %d unknowns", p->M.n);
  }
  s->p.q = s->q;
  s->p.lo = (p->lo != NULL) ? s->lo : NULL;
  s->p.hi = (p->hi != NULL) ? s->hi : NULL;
  s->p.block = s->block;
  s->p.n_block = n_block;
  s->p.traits = p->traits;
  s->n_owner = n_owner;
  return BASE_OK;
}

/* ---- names and activity ---------------------------------------------------------------------- */

static bool is_named(int n, int n_owner, const uint64_t *owner, const int *first) {
  bool good = first[0] == 0 && first[n_owner] == n;
  for (int k = 0; k < n_owner; k++) {
    good = good && first[k] <= first[k + 1] && (k == 0 || owner[k - 1] < owner[k]);
  }
  return good;
}

static void note_active(sequence_item *s) {
  for (int b = 0; b < s->p.n_block; b++) {
    const lcp_block *k = &s->block[b];
    for (int i = k->start; i < k->start + k->size; i++) {
      const double z = s->z[i];
      s->active[i] = (k->set == LCP_FREE)   ? 1
                     : (k->set == LCP_BOX)  ? z > s->lo[i] && z < s->hi[i]
                     : (k->set == LCP_CONE) ? s->z[k->start] > 0.0
                                            : z > 0.0;
      s->n_active += s->active[i];
    }
  }
}

void sequence_match(const sequence_item *now, const sequence_item *before, int *from) {
  int at = 0;
  for (int k = 0; k < now->n_owner; k++) {
    const int size = now->first[k + 1] - now->first[k];
    while (at < before->n_owner && before->owner[at] < now->owner[k]) {
      at++;
    }
    const bool same = at < before->n_owner && before->owner[at] == now->owner[k] &&
                      before->first[at + 1] - before->first[at] == size;
    for (int i = 0; i < size; i++) {
      from[now->first[k] + i] = same ? before->first[at] + i : -1;
    }
  }
}

/* What is active in both stands still; all else that is active in one of them has changed. */
static base_status note_change(sequence_item *now, const sequence_item *before, base_error *err) {
  now->n_changed = now->n_active;
  if (before == NULL) {
    return BASE_OK;
  }
  int *from = malloc((size_t)(now->p.M.n + 1) * sizeof *from);
  if (from == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d names", now->p.M.n);
  }
  int both = 0;
  sequence_match(now, before, from);
  for (int i = 0; i < now->p.M.n; i++) {
    both += now->active[i] && from[i] >= 0 && before->active[from[i]];
  }
  free(from);
  const int either = now->n_active + before->n_active - both;
  now->n_changed = either - both;
  now->change = (either > 0) ? (double)now->n_changed / either : 0.0;
  return BASE_OK;
}

/* ---- the list -------------------------------------------------------------------------------- */

/* Of the item behind the last; NULL without memory. */
static sequence_item *room(sequence *q) {
  if (q->n == q->cap) {
    const int cap = 2 * q->cap + 64;
    sequence_item *grown = realloc(q->item, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return NULL;
    }
    q->item = grown;
    q->cap = cap;
  }
  return &q->item[q->n];
}

base_status sequence_put_named(sequence *q, const sim_solved *k, int n_owner, const uint64_t *owner,
                               const int *first, base_error *err) {
  if (!is_named(k->p->M.n, n_owner, owner, first)) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "step %ld: the contacts are not in ascending order, or do not cover %d rows",
                     k->step, k->p->M.n);
  }
  sequence_item *s = room(q);
  if (s == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d problems", q->n + 1);
  }
  const sequence_item *before = (q->n > 0) ? s - 1 : NULL;
  *s = (sequence_item){.step = k->step,
                       .solve = (before != NULL && before->step == k->step) ? before->solve + 1 : 1,
                       .status = k->status,
                       .verified = k->verified && k->status == RUN_OK};
  base_status done = copy_matrix(&k->p->M, s, err);
  if (done == BASE_OK) {
    done = copy_rest(k->p, n_owner, owner, first, k->z, s, err);
  }
  lcp_verdict v = {0};
  if (done ==
      BASE_OK) { /* of the entries that are kept: a factored matrix has others in the last bit */
    done = lcp_judge(&s->p, s->z, &v, err);
    s->rho = v.rho;
  }
  if (done == BASE_OK) {
    note_active(s);
    done = note_change(s, before, err);
  }
  if (done != BASE_OK) {
    item_free(s);
    return done;
  }
  assert(lcp_problem_is_shaped(&s->p));
  q->n++;
  return BASE_OK;
}

base_status sequence_put(sequence *q, const sim_solved *k, base_error *err) {
  const formulation_rows *rows = &k->rows;
  const contact_set *c = rows->set;
  const size_t n = (size_t)rows->n_group;
  uint64_t *owner = malloc((n + 1) * sizeof *owner);
  int *first = malloc((n + 1) * sizeof *first);
  base_status done = (owner != NULL && first != NULL)
                         ? BASE_OK
                         : BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu names", n);
  for (int i = 0; done == BASE_OK && i <= rows->n_group; i++) {
    first[i] = (rows->first != NULL) ? rows->first[i] : i;
    if (i < rows->n_group) {
      const int g = rows->group[i];
      owner[i] = (g < c->n_contact) ? c->id[g] : SEQUENCE_JOINT + (uint64_t)(g - c->n_contact);
    }
  }
  if (done == BASE_OK) {
    done = sequence_put_named(q, k, rows->n_group, owner, first, err);
  }
  free(owner);
  free(first);
  return done;
}

void sequence_free(sequence *q) {
  for (int i = 0; i < q->n; i++) {
    item_free(&q->item[i]);
  }
  free(q->item);
  *q = (sequence){0};
}

int sequence_largest(const sequence *q) {
  int most = 0;
  for (int i = 0; i < q->n; i++) {
    most = (q->item[i].p.M.n > most) ? q->item[i].p.M.n : most;
  }
  return most;
}

double sequence_change(const sequence *q) {
  double sum = 0.0;
  for (int i = 1; i < q->n; i++) {
    sum += q->item[i].change;
  }
  return (q->n > 1) ? sum / (q->n - 1) : (double)NAN;
}
