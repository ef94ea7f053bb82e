#include "formulations/bristle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

form_bristle_turn form_bristle_turn_of(const contact_set *c, int g) {
  if (c->spin == NULL) {
    return (form_bristle_turn){.cosine = 1};
  }
  const double *n = c->frame + 9 * (ptrdiff_t)g;
  const double *w = c->spin + 3 * (ptrdiff_t)g;
  const double angle = c->h * (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]);
  return (form_bristle_turn){.cosine = cos(angle), .sine = sin(angle)};
}

void form_bristle_to_frame(const contact_set *c, int g, form_bristle_turn by, const double *vector,
                           double *out) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  const double x = t1[0] * vector[0] + t1[1] * vector[1] + t1[2] * vector[2];
  const double y = t2[0] * vector[0] + t2[1] * vector[1] + t2[2] * vector[2];
  const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  const double now = sqrt(x * x + y * y);
  const double scale = (now > 0) ? length / now : 0;
  out[0] = scale * (by.cosine * x - by.sine * y);
  out[1] = scale * (by.sine * x + by.cosine * y);
}

void form_bristle_remember(const contact_set *c, int g, int dim, const double *in, double *vector) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  if (dim == 1) {
    vector[0] = in[0];
    return;
  }
  for (int k = 0; k < 3; k++) {
    vector[k] = in[0] * t1[k] + in[1] * t2[k];
  }
}

int form_bristle_rows(contact_rows rows, int kind, int *first) {
  *first = 1 + ((kind > 0) ? rows.tangent : 0) + ((kind > 1) ? rows.torsion : 0);
  return (kind == 0) ? rows.tangent : ((kind == 1) ? rows.torsion : rows.rolling);
}

void form_bristle_pull(const contact_set *c, int g, int kind, const contact_memory *memory,
                       double out[2]) {
  const double *past = contact_memory_old(memory, g);
  int first;
  const int dim = form_bristle_rows(c->rows[g], kind, &first);
  const double *kept = past + contact_memory_pulls(memory) + (ptrdiff_t)PAST_PULL_NUMBERS * kind;
  out[0] = out[1] = 0;
  if (past[PAST_SPRUNG] > 0 && dim == 2) {
    form_bristle_to_frame(c, g, form_bristle_turn_of(c, g), kept, out);
    return;
  }
  for (int m = 0; m < dim; m++) {
    out[m] = (past[PAST_SPRUNG] > 0) ? kept[m] : -past[PAST_IMPULSE + first + m] / memory->h_old;
  }
}

/* The point of a contact shows in its rows where one of the bodies has all of its dofs. */
static bool shows_point(const contact_set *c, int g) {
  const int all = (c->dim == 2) ? 3 : 6;
  return contact_dofs(c, c->body[2 * g]) == all || contact_dofs(c, c->body[2 * g + 1]) == all;
}

/* Rows of contacts between the same bodies agree to rounding. */
static bool same_rows(const contact_set *c, int g, int k) {
  static const double rounding = 1e-12;
  const int n = c->jac_start[g + 1] - c->jac_start[g];
  const double *a = c->jac + c->jac_start[g], *b = c->jac + c->jac_start[k];
  double largest = 0;
  bool same = n == c->jac_start[k + 1] - c->jac_start[k];
  for (int m = 0; m < n; m++) {
    largest = fmax(largest, fabs(a[m]));
  }
  for (int m = 0; m < n && same; m++) {
    same = fabs(a[m] - b[m]) <= rounding * largest;
  }
  return same;
}

/* Contacts g and k, of the same bodies, are one and the same. */
static bool copies(const contact_set *c, int g, int k) {
  const bool listed = c->id[g] >> CONTACT_COPY_BITS == c->id[k] >> CONTACT_COPY_BITS;
  return (listed || shows_point(c, g)) && same_rows(c, g, k);
}

static int by_bodies(const void *a, const void *b) {
  const form_bristle_key *x = a, *y = b;
  for (int k = 0; k < 2; k++) {
    if (x->body[k] != y->body[k]) {
      return (x->body[k] < y->body[k]) ? -1 : 1;
    }
  }
  return (x->at > y->at) - (x->at < y->at);
}

/* The contacts by their bodies; those of a pair mostly follow each other as they come. */
static void sort_keys(const contact_set *c, int n, const int *group, form_bristle_key *key) {
  bool sorted = true;
  for (int i = 0; i < n; i++) {
    const int *body = c->body + 2 * (ptrdiff_t)group[i];
    key[i] = (form_bristle_key){.body = {body[0], body[1]}, .at = i};
    sorted = sorted && (i == 0 || by_bodies(&key[i - 1], &key[i]) <= 0);
  }
  if (!sorted) {
    qsort(key, (size_t)n, sizeof *key, by_bodies);
  }
}

/* Those of key[first] .. key[last-1], all of one pair of bodies, that are copies of each other. */
static void count_copies(const contact_set *c, const int *group, const form_bristle_key *key,
                         int first, int last, int *out) {
  for (int i = first; i < last; i++) {
    for (int j = i + 1; j < last; j++) {
      const bool same = copies(c, group[key[i].at], group[key[j].at]);
      out[key[i].at] += same;
      out[key[j].at] += same;
    }
  }
}

void form_bristle_sharers(const contact_set *c, int n, const int *group, form_bristle_shared shared,
                          form_bristle_key *key, int *out) {
  for (int i = 0; i < n; i++) {
    out[i] = 1;
  }
  if (shared == FORM_BRISTLE_EACH) {
    return;
  }
  sort_keys(c, n, group, key);
  for (int first = 0, last = 0; first < n; first = last) {
    while (last < n && memcmp(key[first].body, key[last].body, sizeof key->body) == 0) {
      last++;
    }
    for (int i = first; i < last && shared == FORM_BRISTLE_PAIR; i++) {
      out[key[i].at] = last - first;
    }
    if (shared == FORM_BRISTLE_COPIES) {
      count_copies(c, group, key, first, last, out);
    }
  }
}
