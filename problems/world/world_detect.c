/* world_detect.c - which pairs are near, and their contact points. */
#include "lcp/base/crew.h"
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <assert.h>
#include <stdlib.h>

/* Distance a body can cover in one step, from its speeds at the start and after the free motion,
 * half as much again for what contacts add. */
static double reach_of(const world *w, const body *b, double h) {
  double lin = v3_norm(b->v), ang = v3_norm(b->v + 3);
  const double *v_free = w->store.v_free + b->dof;
  double lin2 = 0.0, ang2 = 0.0;
  for (int k = 0; k < b->n_dof; k++) {
    *((b->axis[k] < 3) ? &lin2 : &ang2) += v_free[k] * v_free[k];
  }
  lin = fmax(lin, sqrt(lin2));
  ang = fmax(ang, sqrt(ang2));
  return 1.5 * h * (lin + ang * b->bound);
}

/* The same of one that sleeps, as if it were awake, so that its contacts are listed from as far: by its loads alone. */
static double reach_asleep(const world *w, int i, double h) {
  const body *b = &w->body[i];
  const double *f = w->store.wrench + AXES * (ptrdiff_t)i, *I = b->inertia;
  const double least = (w->dim == 2) ? I[2] : fmin(I[0], fmin(I[1], I[2]));
  const double turns = (least > 0.0) ? v3_norm(f + 3) / least : 0.0;
  return 1.5 * h * h * (v3_norm(f) / b->mass + turns * b->bound);
}

/* Where the points of one part of the work go. */
typedef struct finder {
  world *w;
  int part;
} finder;

static void push_points(const finder *f, int a, int b, int pieces, const gap_point *g, int n) {
  const int copies = f->w->spec.contact_multiplicity;
  assert(pieces >= 0 && pieces < 1 << (2 * ID_PIECE_BITS));
  for (int i = 0; i < n; i++) {
    assert((int)g[i].feature >= 0 && (int)g[i].feature < 1 << ID_FEATURE_BITS);
    const uint64_t base = ((uint64_t)a << ID_SIDE_A_SHIFT) | ((uint64_t)b << ID_SIDE_B_SHIFT) |
                          ((uint64_t)pieces << (ID_FEATURE_BITS + ID_COPY_BITS)) |
                          ((uint64_t)g[i].feature << ID_COPY_BITS);
    for (int c = 0; c < copies; c++) {
      contact_item *item = base_gather_add(&f->w->found, f->part);
      if (item == NULL) {
        return;
      }
      *item = (contact_item){.id = base | (uint64_t)c, .a = a, .b = b, .gap = g[i].gap};
      v3_copy(g[i].x, item->x);
      v3_copy(g[i].n, item->n);
    }
  }
}

/* Points of one pair of sides below margin, piece by piece; n_piece pairs are visited. */
static int pair_points(const world *w, int a, int ka, int b, int kb, double margin,
                       gap_point *out) {
  const body *A = &w->body[a];
  const piece *p = &w->piece[A->first_piece + ka];
  if (b >= w->n_body) {
    const spec_static *plane = &w->spec.fixed[b - w->n_body];
    return gap_halfspace(p, &A->at, plane->normal, plane->offset, margin, out);
  }
  const body *B = &w->body[b];
  const piece *q = &w->piece[B->first_piece + kb];
  return (w->dim == 2) ? gap_planar(p, &A->at, q, &B->at, margin, out)
                       : gap_spatial(p, &A->at, q, &B->at, margin, out);
}

static int n_pieces(const world *w, int side) {
  return (side < w->n_body) ? w->body[side].n_piece : 1;
}

static void narrow(const finder *f, int a, int b, double margin) {
  const world *w = f->w;
  gap_point point[GAP_MAX];
  const int n_b = n_pieces(w, b), pairs = n_pieces(w, a) * n_b;
  for (int p = 0; p < pairs; p++) {
    const int i = p / n_b, k = p % n_b;
    const int n = pair_points(w, a, i, b, k, margin, point);
    push_points(f, a, b, (i << ID_PIECE_BITS) | k, point, n);
  }
}

bool detect_may_collide(const world *w, int a, int b) {
  const bool fixed = !body_is_free(&w->body[a]) && (b >= w->n_body || !body_is_free(&w->body[b]));
  return !fixed && pair_value(&w->apart, a, b) == 0.0;
}

/* Does neither of two sides move, as far as a step knows? What is driven wakes a side that sleeps. */
static bool both_rest(const world *w, int a, int b) {
  const body *A = &w->body[a], *B = (b < w->n_body) ? &w->body[b] : NULL;
  return A->n_dof == 0 && !body_is_moved(A) && (B == NULL || (B->n_dof == 0 && !body_is_moved(B)));
}

static double plane_distance(const body *b, const spec_static *plane) {
  return v3_dot(plane->normal, b->at.x) - plane->offset - b->bound;
}

enum { INSERT_MOST = 64 }; /* keys; so few are sooner moved than counted */

/* Stable; nearly linear, as most points are found in order. */
static void insert_keys(item_key *key, int n) {
  for (int i = 1; i < n; i++) {
    const item_key moved = key[i];
    int at = i;
    for (; at > 0 && key[at - 1].id > moved.id; at--) {
      key[at] = key[at - 1];
    }
    key[at] = moved;
  }
}

/* LSD radix sort by id: stable, linear, deterministic; bytes that are the same everywhere are
 * skipped. */
static void sort_keys(set_store *s) {
  const int n = s->n_item;
  uint64_t all = ~(uint64_t)0, any = 0;
  for (int i = 0; i < n; i++) {
    s->key[i] = (item_key){s->item[i].id, i};
    all &= s->item[i].id;
    any |= s->item[i].id;
  }
  if (n <= INSERT_MOST) {
    insert_keys(s->key, n);
    return;
  }
  for (int shift = 0; shift < 64; shift += 8) {
    if ((((all ^ any) >> shift) & 0xFF) == 0) {
      continue;
    }
    int count[257] = {0};
    for (int i = 0; i < n; i++) {
      count[((s->key[i].id >> shift) & 0xFF) + 1]++;
    }
    for (int k = 0; k < 256; k++) {
      count[k + 1] += count[k];
    }
    for (int i = 0; i < n; i++) {
      s->swap[count[(s->key[i].id >> shift) & 0xFF]++] = s->key[i];
    }
    item_key *t = s->key;
    s->key = s->swap;
    s->swap = t;
  }
}

/* Balls around the bodies, widened by their reach (given margin: by half of it). */
static base_status fill_balls(world *w, double h, double margin, base_error *err) {
  BASE_TRY(broad_reserve(&w->broad, w->n_body, err));
  for (int i = 0; i < w->n_body; i++) {
    const body *b = &w->body[i];
    broad_ball *ball = &w->broad.ball[i];
    v3_copy(b->at.x, ball->x);
    const double reach = (b->sleeps != 0) ? reach_asleep(w, i, h) : reach_of(w, b, h);
    const double extra = (margin >= 0.0) ? 0.5 * margin : reach + 0.01 * w->size;
    ball->r = b->bound + extra;
  }
  return BASE_OK;
}

static void against_planes(const finder *f, int a, double margin) {
  const world *w = f->w;
  for (int i = 0; i < w->spec.n_static; i++) {
    const int b = w->n_body + i;
    if (!both_rest(w, a, b) && !(plane_distance(&w->body[a], &w->spec.fixed[i]) >= margin) &&
        detect_may_collide(w, a, b)) {
      narrow(f, a, b, margin);
    }
  }
}

/* What is added to the bounding radius of body a for this step. */
static double widened(const world *w, int a) {
  return w->broad.ball[a].r - w->body[a].bound;
}

enum { SHARE = 512 }; /* pairs, or bodies, of one part of the work */

typedef struct detection {
  world *w;
  double margin;
} detection;

/* Pairs of bodies come first, then bodies against the half-spaces. */
static void find_points(void *of, int part, int hand) {
  const detection *d = of;
  const world *w = d->w;
  const finder f = {d->w, part};
  const int n_pair = w->broad.n_pair;
  (void)hand;
  for (int k = part * SHARE; k < base_part_end(part, n_pair + w->n_body, SHARE); k++) {
    if (k >= n_pair) {
      const int a = k - n_pair;
      against_planes(&f, a, (d->margin >= 0.0) ? d->margin : widened(w, a));
      continue;
    }
    const broad_pair p = w->broad.pair[k];
    if (!both_rest(w, p.a, p.b) && detect_may_collide(w, p.a, p.b)) {
      narrow(&f, p.a, p.b, widened(w, p.a) + widened(w, p.b));
    }
  }
}

/* Does a point found have a side that sleeps? The other one is awake, or driven. */
static bool reaches(const world *w) {
  bool some = false;
  for (int i = 0; w->n_asleep > 0 && i < w->store.n_item && !some; i++) {
    const contact_item *c = &w->store.item[i];
    some = w->body[c->a].sleeps != 0 || (c->b < w->n_body && w->body[c->b].sleeps != 0);
  }
  return some;
}

base_status world_detect(world *w, double h, double margin, base_error *err) {
  set_store *s = &w->store;
  s->n_item = 0;
  w->reached = false;
  if (!world_has(w, EFFECT_CONTACT)) {
    return BASE_OK;
  }
  BASE_TRY(fill_balls(w, h, margin, err));
  BASE_TRY(broad_find(&w->broad, w->dim, err));
  const int parts = base_parts(w->broad.n_pair + w->n_body, SHARE);
  int n = 0;
  detection d = {w, margin};
  BASE_TRY(base_gather_begin(&w->found, parts, sizeof *s->item, err));
  base_share(parts, find_points, &d);
  BASE_TRY(base_gather_count(&w->found, "points of contact", &n, err));
  BASE_TRY(world_reserve(w, PER_POINT, (size_t)n, err));
  base_gather_join(&w->found, s->item);
  s->n_item = n;
  w->reached = reaches(w);
  sort_keys(s);
  return BASE_OK;
}

/* The larger of `so_far` and the rate of a pair that comes nearer at up to `speed`. */
static double faster(const world *w, int a, int b, double speed, double distance, double so_far) {
  const double rate = speed / distance;
  return (rate > so_far && detect_may_collide(w, a, b)) ? rate : so_far;
}

/* Speed of the points of b about its centre of mass, at most. */
static double spin_of(const body *b) {
  return v3_norm(b->v + 3) * b->bound;
}

double world_closing_rate(const world *w, double margin) {
  double best = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const body *a = &w->body[i];
    for (int k = 0; k < w->spec.n_static; k++) {
      const spec_static *plane = &w->spec.fixed[k];
      const double speed = fmax(-v3_dot(plane->normal, a->v), 0.0) + spin_of(a);
      best = faster(w, i, w->n_body + k, speed, fmax(margin, plane_distance(a, plane)), best);
    }
    for (int j = i + 1; j < w->n_body; j++) {
      const body *b = &w->body[j];
      double v[3], x[3];
      v3_sub(a->v, b->v, v);
      v3_sub(a->at.x, b->at.x, x);
      const double speed = v3_norm(v) + spin_of(a) + spin_of(b);
      best = faster(w, i, j, speed, fmax(margin, v3_norm(x) - a->bound - b->bound), best);
    }
  }
  return best;
}

static double least(const gap_point *g, int n, double so_far) {
  for (int i = 0; i < n; i++) {
    so_far = fmin(so_far, g[i].gap);
  }
  return so_far;
}

static double pair_gap(const world *w, int a, int b, double margin, double best) {
  gap_point point[GAP_MAX];
  for (int i = 0; i < n_pieces(w, a); i++) {
    for (int k = 0; k < n_pieces(w, b); k++) {
      best = least(point, pair_points(w, a, i, b, k, margin, point), best);
    }
  }
  return best;
}

double detect_pair_gap(const world *w, int a, int b) {
  return pair_gap(w, a, b, HUGE_VAL, HUGE_VAL);
}

/* Pairs of bodies within `margin` of each other by their bounding balls. */
static base_status near_gap(world *w, double margin, double *best, base_error *err) {
  BASE_TRY(fill_balls(w, 0.0, margin, err));
  BASE_TRY(broad_find(&w->broad, w->dim, err));
  for (int k = 0; k < w->broad.n_pair; k++) {
    const broad_pair p = w->broad.pair[k];
    if (detect_may_collide(w, p.a, p.b)) {
      *best = pair_gap(w, p.a, p.b, HUGE_VAL, *best);
    }
  }
  return BASE_OK;
}

/* The least gap to planes that is less than `best`, else that. */
static double plane_gap(world *w, double best) {
  for (int a = 0; a < w->n_body; a++) {
    for (int i = 0; i < w->spec.n_static; i++) {
      if (plane_distance(&w->body[a], &w->spec.fixed[i]) < best &&
          detect_may_collide(w, a, w->n_body + i)) {
        best = pair_gap(w, a, w->n_body + i, HUGE_VAL, best);
      }
    }
  }
  return best;
}

base_status detect_depth(world *w, double *depth, base_error *err) {
  double least = plane_gap(w, 0.0);
  BASE_TRY(near_gap(w, 0.0, &least, err));
  *depth = -least;
  return BASE_OK;
}

base_status detect_min_gap(world *w, double *gap, base_error *err) {
  double best = plane_gap(w, HUGE_VAL);
  /* widen until the least gap found is inside the searched shell or every pair was seen */
  double margin = 0.1 * w->size;
  const long all = (long)w->n_body * (w->n_body - 1) / 2;
  do {
    BASE_TRY(near_gap(w, margin, &best, err));
    if (best <= margin) {
      break;
    }
    margin *= 4.0;
  } while (w->broad.n_pair < all);
  *gap = best;
  return BASE_OK;
}
