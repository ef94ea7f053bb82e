/* lcp_share_islands.c - contacts that M couples, which of them rest, and what friction asks of their normal impulses. */
#include "lcp/share/lcp_share_facets.h"

static const double at_bound = 1e-9; /* a normal impulse over what its friction asks for */

static int root_of(const lcp_share *s, int k) {
  while (s->island[k] != k) {
    k = s->island[k];
  }
  return k;
}

static void join(lcp_share *s, int k, int m) {
  const int a = root_of(s, k), b = root_of(s, m);
  s->island[(a > b) ? a : b] = (a > b) ? b : a;
}

/* The friction of a touching contact b works on nothing. */
static bool is_still(const lcp_share *s, const lcp_block *b) {
  if (b->size == 1 && lcp_share_end(s, b) == b->start + 1) { /* friction, if any, is inside M */
    return (s->p->traits & LCP_SYMMETRIC) != 0;
  }
  if (lcp_share_is_faceted(b)) {
    bool still = true;
    for (int k = 0; k < b->n_part; k++) { /* across what falls a facet is made of nothing */
      const share_facets f = lcp_share_facets(b, k);
      double most = 0;
      for (int i = f.first; i < f.first + f.count; i++) {
        most = fmax(most, s->size[i]);
      }
      still = still && lcp_share_speed_unit(s, f) * s->z[f.speed] <= LCP_SHARE_TOUCHING * most;
    }
    return still;
  }
  bool still = b->set == LCP_CONE || b->size == 1;
  for (int i = b->start + 1; i < lcp_share_end(s, b); i++) {
    still = still && fabs(s->w[i]) <= LCP_SHARE_TOUCHING * s->size[i];
  }
  return still;
}

double lcp_share_carried(const lcp_share *s, const lcp_block *b, const double *z) {
  const double normal = z[b->start];
  double least = 0;
  if (b->set == LCP_CONE) {
    for (int k = 0, row = b->start + 1; k < b->n_part; row += b->part_dim[k++]) {
      const double force = lcp_share_length(z + row, b->part_dim[k]);
      least = (force > 0) ? fmax(least, force / b->part_mu[k]) : least;
    }
  }
  for (int k = 0; lcp_share_is_faceted(b) && k < b->n_part;
       k++) { /* the row of the slip speed is mu z_n less the friction */
    const share_facets f = lcp_share_facets(b, k);
    const lcp_column c = lcp_column_of(&s->M, b->start);
    double slope = 0, sum = 0;
    for (int m = 0; m < c.count; m++) {
      slope = (lcp_column_row(&c, m) == f.speed) ? c.val[m] : slope;
    }
    for (int i = f.first; i < f.first + f.count; i++) {
      sum += z[i];
    }
    const double friction = lcp_share_speed_unit(s, f) * sum - s->p->q[f.speed];
    least = (slope > 0) ? fmax(least, friction / slope) : normal;
  }
  return fmin(fmax(least, 0.0), normal);
}

bool lcp_share_is_at_least(const lcp_share *s, const lcp_block *b, const double *z) {
  return z[b->start] <= (1 + at_bound) * lcp_share_carried(s, b, z);
}

/* Contacts and joints have a node each: contact k the k-th, the j-th free block the one j places after them all. */
static int node_of(const lcp_share *s, int row) {
  const int owner = s->owner[row];
  return (owner >= LCP_SHARE_NOBODY) ? owner : s->n_contact + LCP_SHARE_NOBODY - 1 - owner;
}

static void join_column(lcp_share *s, int row) {
  const lcp_column c = lcp_column_of(&s->M, row);
  const int own = node_of(s, row);
  for (int m = 0; m < c.count; m++) {
    const int other = node_of(s, lcp_column_row(&c, m));
    if (other > own && s->island[other] != s->island[own] && c.val[m] != 0) {
      join(s, own, other);
    }
  }
}

/* Contacts and joints in whose columns M has rows of one another. */
static void join_by_columns(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    join_column(s, lcp_share_block(s, k)->start);
  }
  for (int i = 0; i < s->p->M.n; i++) {
    if (s->owner[i] < LCP_SHARE_NOBODY) {
      join_column(s, i);
    }
  }
}

/* Contacts and joints at one body that moves. */
static void join_at_bodies(lcp_share *s) {
  const lcp_factored *f = s->p->M.factored;
  for (int b = 0; b < f->n_body; b++) {
    s->met[b] = -1;
  }
  for (int g = 0; g < f->n_group; g++) {
    const bool owned =
        f->row_start[g + 1] > f->row_start[g] && s->owner[f->row_start[g]] != LCP_SHARE_NOBODY;
    const int k = owned ? node_of(s, f->row_start[g]) : -1;
    for (int side = 0; side < 2 && k >= 0; side++) {
      const int b = f->body[2 * (ptrdiff_t)g + side];
      if (b >= 0 && f->dof_start[b + 1] > f->dof_start[b]) {
        if (s->met[b] >= 0) {
          join(s, s->met[b], k);
        }
        s->met[b] = k;
      }
    }
  }
}

static void own_free_rows(lcp_share *s) {
  for (int k = 0, n_free = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    if (b->set != LCP_FREE) {
      continue;
    }
    s->island[s->n_contact + n_free] = s->n_contact + n_free;
    n_free++;
    for (int i = b->start; i < b->start + b->size; i++) {
      s->owner[i] = LCP_SHARE_NOBODY - n_free;
    }
  }
}

/* Contacts that M couples, or the joints between them, and of which islands every touching contact is still: there only
 * normal impulses are chosen, and friction stays as it was found. */
void lcp_share_find_islands(lcp_share *s) {
  for (int i = 0; i < s->p->M.n; i++) {
    s->owner[i] = LCP_SHARE_NOBODY;
    s->lower[i] = 0;
  }
  own_free_rows(s);
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    s->island[k] = k;
    s->rests[k] = true;
    for (int i = b->start; i < lcp_share_end(s, b); i++) {
      s->owner[i] = k;
    }
  }
  (s->by_bodies ? join_at_bodies : join_by_columns)(s);
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    if (lcp_share_touches(s, b->start) && !is_still(s, b)) {
      s->rests[root_of(s, k)] = false;
    }
  }
  for (int k = 0; k < s->n_contact; k++) { /* roots come before the rest of their island */
    s->rests[k] = s->rests[root_of(s, k)];
  }
}
