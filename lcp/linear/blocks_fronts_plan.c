/* blocks_fronts_plan.c - which columns are a front, what is factored side by side, and where each front leaves its rest. */
#include "lcp/base/crew.h"
#include "lcp/linear/blocks_inside.h"

#include <stdlib.h>

enum {
  WIDEST = 30000, /* rows of a front: 7 GB */
  LIMBS = 24      /* into so many the work is to be cut, about */
};

static int parent_of(const lin_blocks *s, int p) {
  return (s->column[p + 1] > s->column[p]) ? s->row[s->column[p]] : -1;
}

static bool continues(const lin_blocks *s, int p) {
  return parent_of(s, p) == p + 1 &&
         s->column[p + 2] - s->column[p + 1] == s->column[p + 1] - s->column[p] - 1;
}

size_t lin_blocks_rows_below(const lin_blocks *s, int place) {
  size_t sum = 0;
  for (int k = s->column[place]; k < s->column[place + 1]; k++) {
    sum += (size_t)lin_blocks_rows(s, s->row[k]);
  }
  return sum;
}

/* Rows of the columns of front k, and in *left those below them. */
static size_t wide_of(const lin_blocks *s, int k, size_t *left) {
  const int end = s->front[k + 1].first;
  size_t wide = 0;
  for (int p = s->front[k].first; p < end; p++) {
    wide += (size_t)lin_blocks_rows(s, p);
  }
  *left = lin_blocks_rows_below(s, end - 1);
  return wide;
}

/* Fronts, each behind those that leave their rest to it. False: the order is not one in which that can be done. */
static bool find_fronts(lin_blocks *s) {
  int waiting = 0; /* rests */
  s->n_front = 0;
  for (int p = 0; p < s->n;) {
    const int k = s->n_front++;
    lin_front_plan *f = &s->front[k];
    int q = p;
    while (q + 1 < s->n && continues(s, q)) {
      q++;
    }
    *f = (lin_front_plan){
        .first = p, .parent = parent_of(s, q), .child = -1, .sibling = -1, .begin = k};
    s->front[k + 1].first = q + 1;
    int *last = &f->child;
    while (waiting > 0 && s->front[s->pending[waiting - 1]].parent <= q) {
      const int child = s->pending[--waiting];
      if (s->front[child].parent < p) {
        return false;
      }
      *last = child;
      last = &s->front[child].sibling;
      f->begin = s->front[child].begin;
      f->work += s->front[child].work;
    }
    size_t left;
    const double wide = (double)wide_of(s, k, &left), size = wide + (double)left;
    f->work += wide * size * size;
    if (f->parent >= 0) {
      s->pending[waiting++] = k;
    }
    p = q + 1;
  }
  return waiting == 0;
}

/* Limbs: neighbours, each with all that is below it, of no more than s->light work together. From the last one on. */
static void find_limbs(lin_blocks *s) {
  double work = 0;
  s->n_limb = 0;
  for (int k = s->n_front - 1; k >= 0; k--) {
    const lin_front_plan *f = &s->front[k];
    if (f->work > s->light) {
      continue;
    }
    if (s->n_limb > 0 && s->limb[s->n_limb - 1].first == k + 1 && work + f->work <= s->light) {
      work += f->work;
    } else {
      work = f->work;
      s->limb[s->n_limb++].end = k + 1;
    }
    k = s->limb[s->n_limb - 1].first = f->begin;
  }
}

/* Where front k leaves its rest on the stack, which ends at `top` and begins at `base`; returns its new end. */
static size_t place_rest(lin_blocks *s, int k, size_t base, size_t top) {
  lin_front_plan *f = &s->front[k];
  for (int c = f->child; c >= 0; c = s->front[c].sibling) {
    top = (s->front[c].at >= base) ? s->front[c].at : top;
  }
  size_t left;
  (void)wide_of(s, k, &left);
  f->at = top;
  return (f->parent >= 0) ? top + left * left : top;
}

static void widen(lin_blocks *s, int k, size_t *widest) {
  size_t left;
  const size_t wide = wide_of(s, k, &left);
  *widest = (wide + left > *widest) ? wide + left : *widest;
}

/* A stack for each limb, one after the other, and behind them one for the fronts above. Returns the end of all. */
static size_t place_rests(lin_blocks *s, size_t *widest) {
  size_t end = 0, in_limbs = 0;
  for (int i = 0; i < s->n_limb; i++) {
    const size_t base = end;
    size_t top = base;
    for (int k = s->limb[i].first; k < s->limb[i].end; k++) {
      top = place_rest(s, k, base, top);
      end = (top > end) ? top : end;
      widen(s, k, &in_limbs);
    }
  }
  const size_t base = end;
  size_t top = base;
  *widest = in_limbs;
  for (int k = 0; k < s->n_front; k++) {
    if (lin_blocks_is_above(s, k)) {
      top = place_rest(s, k, base, top);
      end = (top > end) ? top : end;
      widen(s, k, widest);
    }
  }
  s->apart = in_limbs * in_limbs;
  return end;
}

static void layout_plan(lin_blocks *s, base_arena *a) {
  s->front = BASE_ARRAY(a, lin_front_plan, s->cap_n + 1);
  s->limb = BASE_ARRAY(a, lin_limb, s->cap_n);
  s->pending = BASE_ARRAY(a, int, s->cap_n);
  s->offset = BASE_ARRAY(a, int, (size_t)s->cap_n *(size_t)s->hands);
}

static void layout_numbers(lin_blocks *s, base_arena *a) {
  s->rest = BASE_ARRAY(a, double, s->cap_rest);
  s->dense = BASE_ARRAY(a, double, s->cap_dense);
}

base_status lin_blocks_plan_fronts(lin_blocks *s, base_error *err) {
  double work = 0;
  s->hands = base_crew_size();
  BASE_TRY(lin_blocks_memory(s, &s->front_mem, layout_plan, err));
  if (!find_fronts(s)) {
    s->n_front = 0;
    return BASE_OK;
  }
  for (int k = 0; k < s->n_front; k++) {
    work += (s->front[k].parent < 0) ? s->front[k].work : 0;
  }
  s->light = (s->hands > 1) ? work / LIMBS : -1;
  find_limbs(s);
  size_t widest;
  const size_t stack = place_rests(s, &widest);
  if (widest > WIDEST) {
    s->n_front = 0;
    return BASE_OK;
  }
  const size_t apart = s->apart * (size_t)s->hands;
  const size_t dense = (apart > widest * widest) ? apart : widest * widest;
  if (s->dense_mem == NULL || stack > s->cap_rest || dense > s->cap_dense) {
    s->cap_rest = stack;
    s->cap_dense = dense;
    return lin_blocks_memory(s, &s->dense_mem, layout_numbers, err);
  }
  return BASE_OK;
}
