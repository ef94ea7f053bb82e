/* world_standing.c - do bodies that cannot turn stand: can their contacts share the forces so that no moment is left?
 *
 * Where bodies cannot turn, the contacts between the same two sides with the same normal (a patch) move alike, and only the sum
 * of their forces acts. The step is one with rotation too where the forces can be shared so that no moment about a centre
 * remains and the force on every body stays; friction goes with the normal forces. Sought are normal impulses p >= 0 with
 *
 *   min |A p + b|^2,   rows: force, and moment over the reach, of every body;   columns: n + friction over press of the patch
 *
 * by active sets on A'A (non-negative least squares, Lawson & Hanson 1974, chapter 23). Where A p + b is 0 then, nothing turns. */
#include "problems/vec.h"
#include "problems/world/world_residual.h"

enum { FEET_MOST = 48 }; /* what costs more to judge is not left out */

/* Of the sum of all impulses: what is left of a force or moment is rounding; below that an impulse gains nothing. */
static const double little = 1e-10, gain_least = 1e-13;

/* A contact that may carry. */
typedef struct foot {
  int contact, patch, side[2]; /* side: a body that moves, or -1 */
  double column[2][AXES];      /* what 1 N s does to its sides: force [1], moment over reach [1] */
  double p, target;            /* [N s]; of the feet in use, were none to end at 0 */
  double least;                /* [N s], which it carries in any case */
  bool used;
} foot;

typedef struct patch {
  const double *normal;
  double force[3], press; /* [N s] */
} patch;

typedef struct feet {
  int n, n_patch, n_used;
  int used[FEET_MOST]; /* feet, in the order that they came into use */
  foot foot[FEET_MOST];
  patch patch[FEET_MOST];
  double factor[FEET_MOST * FEET_MOST]; /* lower triangle, of the Gram matrix of those in use */
} feet;

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

/* The axes that count. */
typedef unsigned axes_of(const world *w, int body, unsigned effects);

static void fill_side(const world *w, feet *s, foot *f, int k, unsigned effects, axes_of *axes) {
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

static void add_column(const world *w, const foot *f, double p, bool other) {
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

static void set_rest(const world *w, const feet *s) {
  for (int i = 0; i < w->n_body; i++) {
    residual *r = world_residual(w, i);
    memcpy(r->rest, r->other, sizeof r->rest);
  }
  for (int r = 0; r < s->n_used; r++) {
    add_column(w, &s->foot[s->used[r]], s->foot[s->used[r]].p, false);
  }
}

static void minimise(const world *w, feet *s, double scale) {
  set_rest(w, s);
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
    set_rest(w, s);
  }
}

/* ---- firmly ----------------------------------------------------------------------------------- */

/* Of a patch's load, evenly on its feet, before the rest is shared out; of a body's largest, for a patch to count. */
static const double spared = 0.1, light = 0.01;

static double most_pressed(const feet *s, int i) {
  double most = 0.0;
  for (int j = 0; j < s->n; j++) {
    most = (s->foot[j].side[0] == i) ? fmax(most, s->patch[s->foot[j].patch].press) : most;
  }
  return most;
}

static double dot(const double *x, const double *y) {
  double sum = 0.0;
  for (int a = 0; a < AXES; a++) {
    sum += x[a] * y[a];
  }
  return sum;
}

/* What each foot carries in any case, counted with all else that acts. */
static void press_all(const world *w, feet *s) {
  int count[FEET_MOST] = {0};
  for (int j = 0; j < s->n; j++) {
    count[s->foot[j].patch]++;
  }
  for (int j = 0; j < s->n; j++) {
    foot *f = &s->foot[j];
    const double press = s->patch[f->patch].press;
    const bool counts = press >= light * most_pressed(s, f->side[0]);
    f->least = counts ? spared * press / count[f->patch] : 0.0;
    add_column(w, f, f->least, true);
  }
}

/* Of as many feet of body i as space has dimensions: the least part of one's column that those before it do not have, the largest
 * there is each time; 0: they lie on a line. */
static double lever(const world *w, const feet *s, int i) {
  double left[FEET_MOST][AXES], least = HUGE_VAL;
  int n = 0;
  for (int j = 0; j < s->n; j++) {
    if (s->foot[j].side[0] == i && s->foot[j].least > 0.0) {
      memcpy(left[n++], s->foot[j].column[0], sizeof left[0]);
    }
  }
  for (int r = 0; r < w->dim; r++) {
    double most = 0.0, base[AXES] = {0};
    for (int j = 0; j < n; j++) {
      const double size = dot(left[j], left[j]);
      if (size > most) {
        most = size;
        memcpy(base, left[j], sizeof base);
      }
    }
    least = fmin(least, most);
    for (int j = 0; j < n && most > 0.0; j++) {
      const double part = dot(left[j], base) / most;
      for (int a = 0; a < AXES; a++) {
        left[j][a] -= part * base[a];
      }
    }
  }
  return (least > 1e-12) ? sqrt(least) : 0.0;
}

/* What is left of the balance of body i [N s]. */
static double left_of(const world *w, int i) {
  double sum = 0.0;
  for (int a = 0; a < AXES; a++) {
    sum += fabs(world_residual(w, i)->rest[a]);
  }
  return sum;
}

/* Body i, whose balance leaves `off`, is in the air, or a ball, or that and what rubs it are little beside what its feet have to spare. */
static bool holds(const world *w, const feet *s, int i, double off, double scale) {
  double spare = HUGE_VAL;
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    spare = (f->side[0] == i && f->least > 0.0) ? fmin(spare, f->least) : spare;
  }
  if (spare == HUGE_VAL || world_is_ball(w, i)) {
    return off <= little * scale;
  }
  return 10.0 * (off + world_residual(w, i)->rub) < spare * lever(w, s, i);
}

static bool hold(const world *w, const feet *s, bool nearly, double scale) {
  bool all = true;
  for (int i = 0; i < w->n_body && all; i++) {
    all = holds(w, s, i, nearly ? left_of(w, i) : 0.0, scale);
  }
  return all;
}

/* Do the impulses that there are keep the balance nearly, with enough on every foot? Then no others need to be sought. */
static bool as_it_is(const world *w, const feet *s, const double *impulse, double scale) {
  set_rest(w, s);
  for (int j = 0; j < s->n; j++) {
    const foot *f = &s->foot[j];
    const double more = fmax(impulse[w->store.row_start[f->contact]], 0.0) - f->least;
    if (more < 0.0) {
      return false;
    }
    add_column(w, f, more, false);
  }
  return hold(w, s, true, scale);
}

/* ---- the whole -------------------------------------------------------------------------------- */

/* b: against the force that the contacts have, and the moment of all others; returns the sum of the impulses. */
static double set_other(const world *w, unsigned effects, const double *impulse, axes_of *axes) {
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

/* The feet and what they are to carry; false: it is not judged (too many, joints, torsion or rolling that acts). */
static bool set_up(const world *w, unsigned effects, const double *impulse, axes_of *axes, feet *s,
                   double *scale) {
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

/* Do they carry it? */
static bool balanced(const world *w, feet *s, double scale) {
  bool all = true;
  minimise(w, s, scale);
  for (int i = 0; i < w->n_body; i++) {
    for (int a = 0; a < AXES; a++) {
      all = all && fabs(world_residual(w, i)->rest[a]) <= little * scale;
    }
  }
  return all;
}

bool world_stands(const world *w, unsigned effects, const double *impulse) {
  feet s;
  double scale;
  return set_up(w, effects, impulse, world_locked_now, &s, &scale) && balanced(w, &s, scale);
}

bool world_stands_firmly(const world *w, unsigned effects, const double *impulse) {
  feet s;
  double scale;
  if (!set_up(w, effects, impulse, world_free_axes, &s, &scale)) {
    return false;
  }
  press_all(w, &s);
  return as_it_is(w, &s, impulse, scale) || (hold(w, &s, false, scale) && balanced(w, &s, scale));
}
