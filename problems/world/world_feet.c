/* world_feet.c - patches, columns, and active sets on them (world_feet.h). */
#include "problems/world/world_feet.h"

#include "problems/vec.h"

static const double gain_least = 1e-13; /* of the sum of all impulses: an impulse gains nothing */

/* ---- patches ---------------------------------------------------------------------------------- */

static bool same_patch(const world *w, int i, const foot *f, const patch *p) {
  const contact_item *a = &w->store.item[w->store.key[i].item];
  const contact_item *b = &w->store.item[w->store.key[f->contact].item];
  const double *n = w->store.frame + 9 * (ptrdiff_t)i;
  return a->a == b->a && a->b == b->b && v3_dot(n, p->normal) > 1.0 - 1e-12;
}

/* -1: of none. */
static int patch_of(const world *w, const feet *s, int i) {
  for (int k = s->n - 1; k >= 0; k--) {
    if (same_patch(w, i, &s->foot[k], &s->patch[s->foot[k].patch])) {
      return s->foot[k].patch;
    }
  }
  return -1;
}

static bool add_foot(feet *s, int contact, int of) {
  if (s->n == FEET_MOST) {
    return false;
  }
  s->foot[s->n++] = (foot){.contact = contact, .patch = of};
  return true;
}

/* Those that press, and those closed beside them. */
static bool find_feet(const world *w, const double *impulse, feet *s) {
  const set_store *c = &w->store;
  for (int i = 0; i < w->set.n_contact; i++) {
    double f[3], m[3];
    if (!(impulse[c->row_start[i]] > 0.0)) {
      continue;
    }
    world_contact_impulse(w, i, impulse, f, m);
    int of = patch_of(w, s, i);
    if (of < 0) {
      of = s->n_patch;
    }
    if (v3_norm(m) > 0.0 || !add_foot(s, i, of)) {
      return false;
    }
    if (of == s->n_patch) {
      s->patch[s->n_patch++] = (patch){.normal = c->frame + 9 * (ptrdiff_t)i};
    }
    v3_add_scaled(s->patch[of].force, 1.0, f, s->patch[of].force);
    s->patch[of].press += impulse[c->row_start[i]];
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    const bool closed = c->gap[i] <= 1e-6 * w->size && !(impulse[c->row_start[i]] > 0.0);
    const int of = closed ? patch_of(w, s, i) : -1;
    if (of >= 0 && !add_foot(s, i, of)) {
      return false;
    }
  }
  return true;
}

/* ---- columns ---------------------------------------------------------------------------------- */

static void fill_side(const world *w, feet *s, foot *f, int k, unsigned effects,
                      world_axes_of *axes) {
  const contact_item *c = &w->store.item[w->store.key[f->contact].item];
  const int side = (k == 0) ? c->a : c->b;
  const double sign = (k == 0) ? 1.0 : -1.0;
  const patch *p = &s->patch[f->patch];
  double arm[3], moment[3];
  f->side[k] = (side < w->n_body && w->body[side].n_dof > 0) ? side : -1;
  if (f->side[k] < 0) {
    return;
  }
  const unsigned counted = axes(w, side, effects);
  v3_sub(c->x, w->body[side].at.x, arm);
  v3_cross(arm, p->force, moment);
  for (int a = 0; a < 3; a++) {
    const bool counts = (counted & 1u << (a + 3)) != 0;
    f->column[k][a] = sign * p->force[a] / p->press;
    f->column[k][a + 3] = counts ? sign * moment[a] / (p->press * w->body[side].bound) : 0.0;
  }
}

void world_feet_add(const world *w, const foot *f, double p, bool other) {
  for (int k = 0; k < 2; k++) {
    for (int a = 0; a < AXES && f->side[k] >= 0; a++) {
      residual *r = world_residual(w, f->side[k]);
      *(other ? &r->other[a] : &r->rest[a]) += p * f->column[k][a];
    }
  }
}

static double against(const world *w, const foot *f, bool other) {
  double sum = 0.0;
  for (int k = 0; k < 2; k++) {
    for (int a = 0; a < AXES && f->side[k] >= 0; a++) {
      const residual *r = world_residual(w, f->side[k]);
      sum -= f->column[k][a] * (other ? r->other[a] : r->rest[a]);
    }
  }
  return sum;
}

static double gram(const foot *f, const foot *g) {
  double sum = 0.0;
  for (int k = 0; k < 2; k++) {
    for (int m = 0; m < 2; m++) {
      for (int a = 0; a < AXES && f->side[k] >= 0 && f->side[k] == g->side[m]; a++) {
        sum += f->column[k][a] * g->column[m][a];
      }
    }
  }
  return sum;
}

/* ---- active sets ------------------------------------------------------------------------------ */

/* Row r of the factor; false: the foot depends on those before it. */
static bool factor_row(feet *s, int r) {
  const foot *f = &s->foot[s->used[r]];
  double *row = s->factor + (ptrdiff_t)FEET_MOST * r;
  const double whole = gram(f, f);
  double left = whole;
  for (int c = 0; c < r; c++) {
    const double *other = s->factor + (ptrdiff_t)FEET_MOST * c;
    row[c] = gram(f, &s->foot[s->used[c]]);
    for (int k = 0; k < c; k++) {
      row[c] -= row[k] * other[k];
    }
    row[c] /= other[c];
    left -= row[c] * row[c];
  }
  row[r] = sqrt(fmax(left, 0.0));
  return left > 1e-12 * whole;
}

/* The impulses of those in use without a bound. */
static void solve(const world *w, feet *s) {
  double x[FEET_MOST];
  for (int r = 0; r < s->n_used; r++) {
    const double *row = s->factor + (ptrdiff_t)FEET_MOST * r;
    x[r] = against(w, &s->foot[s->used[r]], true);
    for (int c = 0; c < r; c++) {
      x[r] -= row[c] * x[c];
    }
    x[r] /= row[r];
  }
  for (int r = s->n_used - 1; r >= 0; r--) {
    for (int c = r + 1; c < s->n_used; c++) {
      x[r] -= s->factor[(ptrdiff_t)FEET_MOST * c + r] * x[c];
    }
    x[r] /= s->factor[(ptrdiff_t)FEET_MOST * r + r];
    s->foot[s->used[r]].target = x[r];
  }
}

/* Towards the targets as far as no impulse turns negative; those that end at 0 go. True: all the way. */
static bool move(feet *s) {
  double share = 1.0;
  int kept = 0, first = s->n_used, ends = -1;
  for (int r = 0; r < s->n_used; r++) {
    const foot *f = &s->foot[s->used[r]];
    const double reached =
        (f->target > 0.0) ? 1.0 : ((f->p > 0.0) ? f->p / (f->p - f->target) : 0.0);
    ends = (f->target <= 0.0 && reached <= share) ? s->used[r] : ends;
    share = fmin(share, reached);
  }
  for (int r = 0; r < s->n_used; r++) {
    foot *f = &s->foot[s->used[r]];
    f->p += share * (f->target - f->p);
    f->used = s->used[r] != ends && f->p > 0.0;
    f->p = f->used ? f->p : 0.0;
    first = f->used ? first : ((first < r) ? first : r);
    s->used[kept] = s->used[r];
    kept += f->used;
  }
  s->n_used = kept;
  for (int r = first; r < kept; r++) {
    (void)factor_row(s, r); /* a part of an independent set */
  }
  return ends < 0;
}

/* The one whose impulse would take most away; -1: none. */
static int best_foot(const world *w, const feet *s, double least) {
  double most = 0.0;
  int best = -1;
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    const double gain = f->used ? 0.0 : against(w, f, false);
    if (gain > most && gain > least * sqrt(gram(f, f))) {
      most = gain;
      best = j;
    }
  }
  return best;
}

void world_feet_set_rest(const world *w, const feet *s) {
  for (int i = 0; i < w->n_body; i++) {
    residual *r = world_residual(w, i);
    memcpy(r->rest, r->other, sizeof r->rest);
  }
  for (int r = 0; r < s->n_used; r++) {
    world_feet_add(w, &s->foot[s->used[r]], s->foot[s->used[r]].p, false);
  }
}

static void minimise(const world *w, feet *s, double scale) {
  world_feet_set_rest(w, s);
  for (int turn = 0; turn < 3 * s->n; turn++) {
    const int j = best_foot(w, s, gain_least * scale);
    if (j < 0) {
      return;
    }
    s->used[s->n_used] = j;
    s->foot[j].used = factor_row(s, s->n_used);
    if (!s->foot[j].used) {
      return; /* all that rounding leaves to gain */
    }
    s->n_used++;
    do {
      solve(w, s);
    } while (!move(s));
    if (!s->foot[j].used) {
      return;
    }
    world_feet_set_rest(w, s);
  }
}

/* ---- the whole -------------------------------------------------------------------------------- */

/* b: against the force that the contacts have, and the moment of all others; returns the sum of the impulses. */
static double set_other(const world *w, unsigned effects, const double *impulse,
                        world_axes_of *axes) {
  double scale = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    residual *r = world_residual(w, i);
    const unsigned counted = axes(w, i, effects);
    for (int a = 0; a < 3; a++) {
      const bool counts = (counted & 1u << (a + 3)) != 0;
      r->other[a] = r->load[a] - r->wrench[a];
      r->other[a + 3] = counts ? r->load[a + 3] / w->body[i].bound : 0.0;
    }
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    scale += fmax(impulse[w->store.row_start[i]], 0.0);
  }
  return scale;
}

bool world_feet_set_up(const world *w, unsigned effects, const double *impulse, world_axes_of *axes,
                       feet *s, double *scale) {
  s->n = s->n_patch = s->n_used = 0;
  if (w->n_joint > 0 || !find_feet(w, impulse, s)) {
    return false;
  }
  for (int j = 0; j < s->n; j++) {
    for (int k = 0; k < 2; k++) {
      fill_side(w, s, &s->foot[j], k, effects, axes);
    }
  }
  *scale = set_other(w, effects, impulse, axes);
  return true;
}

bool world_feet_balanced(const world *w, feet *s, double scale) {
  bool all = true;
  minimise(w, s, scale);
  for (int i = 0; i < w->n_body; i++) {
    for (int a = 0; a < AXES; a++) {
      all = all && fabs(world_residual(w, i)->rest[a]) <= WORLD_FEET_LITTLE * scale;
    }
  }
  return all;
}
