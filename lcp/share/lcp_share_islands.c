/* lcp_share_islands.c - contacts that M couples, which of them rest, and what friction asks of their normal impulses. */
#include "lcp/share/lcp_share_facets.h"

static int root_of(const lcp_share *s, int k) {
  while (s->island[k] != k) {
    k = s->island[k];
  }
  return k;
}

static void join(lcp_share *s, int k, int m) {
  const int a = root_of(s, k), b = root_of(s, m);
  s->island[(a > b) ? a : b] = (a > b) ? b : a;
  s->n_island -= a != b;
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

/* Least normal impulse that carries the friction of the part at `row`, of facets or of a cone. */
static double carried_by_facets(const lcp_share *s, const lcp_block *b, int part, const double *z) {
  const share_facets f =
      lcp_share_facets(b, part); /* the slip speed's row is mu z_n less friction */
  const lcp_column c = lcp_column_of(&s->M, b->start);
  double slope = 0, sum = 0;
  for (int m = 0; m < c.count; m++) {
    slope = (lcp_column_row(&c, m) == f.speed) ? c.val[m] : slope;
  }
  for (int i = f.first; i < f.first + f.count; i++) {
    sum += z[i];
  }
  const double friction = lcp_share_speed_unit(s, f) * sum - s->p->q[f.speed];
  return (slope > 0) ? friction / slope : z[b->start];
}

static double carried_by_cone(const lcp_block *b, int part, int row, const double *z) {
  const double force = lcp_share_length(z + row, b->part_dim[part]);
  return (force > 0) ? force / b->part_mu[part] : 0;
}

double lcp_share_carried_by(const lcp_share *s, const lcp_block *b, int part, int row,
                            const double *z) {
  return (b->set == LCP_CONE) ? carried_by_cone(b, part, row, z) : carried_by_facets(s, b, part, z);
}

double lcp_share_carried(const lcp_share *s, const lcp_block *b, const double *z) {
  const int parts = (b->set == LCP_CONE || lcp_share_is_faceted(b)) ? b->n_part : 0;
  double least = 0;
  for (int k = 0, row = b->start + 1; k < parts; row += b->part_dim[k++]) {
    least = fmax(least, lcp_share_carried_by(s, b, k, row, z));
  }
  return fmin(least, z[b->start]);
}

bool lcp_share_is_at_least(const lcp_share *s, const lcp_block *b, const double *z) {
  return z[b->start] <= (1 + LCP_SHARE_AT_BOUND) * lcp_share_carried(s, b, z);
}

bool lcp_share_note_held(lcp_share *s) {
  bool any = false;
  for (int k = 0; k < s->n_contact; k++) {
    const int i = lcp_share_block(s, k)->start;
    s->held[k] = s->rests[k] && s->rows.kind[i] == SHARE_FIXED && s->lower[i] > 0;
    any = any || s->held[k];
  }
  return any;
}

/* Contacts and joints have a node each: contact k the k-th, the j-th free block the one j places after them all. */
static int node_of(const lcp_share *s, int row) {
  const int owner = s->owner[row];
  return (owner >= LCP_SHARE_NOBODY) ? owner : s->n_contact + LCP_SHARE_NOBODY - 1 - owner;
}

static void join_column(lcp_share *s, int row) {
  const lcp_column c = lcp_column_of(&s->M, row);
  const int own = node_of(s, row);
  for (int m = 0; m < c.count && s->n_island > 1; m++) {
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
    s->n_island++;
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
  s->n_island = s->n_contact;
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
