#include "harness/measure/contact_order.h"

#include "lcp/base/arena.h"
#include "lcp/base/fields.h"

#include <stdlib.h>
#include <string.h>

base_status contact_order_parse(const char *text, uint64_t *seed, base_error *err) {
  static const char random[] = "random:";
  int n = 0;
  *seed = 0;
  if (strcmp(text, "given") == 0) {
    return BASE_OK;
  }
  if (strncmp(text, random, strlen(random)) != 0 || !base_parse_int(text + strlen(random), &n) ||
      n < 1) {
    return BASE_FAIL(err, BASE_EINVAL, "contact order %.60s: need given or random:N with N >= 1",
                     text);
  }
  *seed = (uint64_t)n;
  return BASE_OK;
}

/* One-to-one on numbers of so many bits, in the manner of the finaliser of splitmix64 (Steele, Lea & Flood 2014, fig. 17): sums,
 * odd factors and shifts, all modulo a power of two. */
static uint64_t scramble(uint64_t x, uint64_t seed, int bits) {
  const uint64_t mask = UINT64_MAX >> (64 - bits);
  x = (x + seed * 0x9e3779b97f4a7c15u) & mask;
  x = (x ^ x >> (bits / 2)) * 0xbf58476d1ce4e5b9u & mask;
  x = (x ^ x >> (bits / 2)) * 0x94d049bb133111ebu & mask;
  return x ^ x >> (bits / 2);
}

/* Pairs of shapes in a random order, the features of a pair, and the copies of a contact: what belongs together stays so. */
static uint64_t another(uint64_t id, uint64_t seed) {
  enum { LOW = CONTACT_COPY_BITS + CONTACT_FEATURE_BITS };
  const uint64_t shapes = contact_shapes_of(id);
  const uint64_t feature = id >> CONTACT_COPY_BITS & ((1u << CONTACT_FEATURE_BITS) - 1);
  const uint64_t copy = id & ((1u << CONTACT_COPY_BITS) - 1);
  return scramble(shapes, seed, 64 - LOW) << LOW |
         scramble(feature, seed + shapes, CONTACT_FEATURE_BITS) << CONTACT_COPY_BITS |
         scramble(copy, seed + (id >> CONTACT_COPY_BITS), CONTACT_COPY_BITS);
}

/* ---- memory -----------------------------------------------------------------------------------*/

/* Every array of the permuted set, as large as that of c. */
typedef struct arrays {
  uint64_t *id;
  int *row_start, *body, *jac_start;
  contact_rows *rows;
  double *jac, *u_drift, *u_before, *u_curve;
  double *gap, *mu_static, *mu_kinetic, *mu_torsion, *mu_rolling, *restitution, *compliance, *frame,
      *spin;
} arrays;

static double *like(base_arena *a, const double *array, int n) {
  return (array != NULL) ? BASE_ARRAY(a, double, n) : NULL;
}

static void layout(contact_order *o, const contact_set *c, arrays *s, base_arena *a) {
  const int n = c->n_contact;
  o->from = BASE_ARRAY(a, int, n + 1);
  o->impulse = BASE_ARRAY(a, double, c->n_row + 1);
  o->bias = BASE_ARRAY(a, double, n + 1);
  o->mode = BASE_ARRAY(a, unsigned char, n + 1);
  s->id = BASE_ARRAY(a, uint64_t, n + 1);
  s->row_start = BASE_ARRAY(a, int, c->n_group + 1);
  s->body = BASE_ARRAY(a, int, 2 * c->n_group + 1);
  s->jac_start = BASE_ARRAY(a, int, c->n_group + 1);
  s->rows = BASE_ARRAY(a, contact_rows, n + 1);
  s->jac = BASE_ARRAY(a, double, c->jac_start[c->n_group] + 1);
  s->u_drift = like(a, c->u_drift, c->n_row + 1);
  s->u_before = like(a, c->u_before, c->n_row + 1);
  s->u_curve = like(a, c->u_curve, c->n_row + 1);
  s->gap = like(a, c->gap, n + 1);
  s->mu_static = like(a, c->mu_static, n + 1);
  s->mu_kinetic = like(a, c->mu_kinetic, n + 1);
  s->mu_torsion = like(a, c->mu_torsion, n + 1);
  s->mu_rolling = like(a, c->mu_rolling, n + 1);
  s->restitution = like(a, c->restitution, n + 1);
  s->compliance = like(a, c->compliance, n + 1);
  s->frame = like(a, c->frame, 9 * n + 1);
  s->spin = like(a, c->spin, 3 * n + 1);
}

static base_status reserve(contact_order *o, const contact_set *c, arrays *s, base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(o, c, s, &measure);
  if (measure.used > o->bytes) {
    free(o->mem);
    o->bytes = measure.used + measure.used / 2;
    o->mem = base_alloc(o->bytes);
    if (o->mem == NULL) {
      o->bytes = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to reorder %d contacts", c->n_contact);
    }
  }
  base_arena arena = base_arena_over(o->mem, o->bytes);
  layout(o, c, s, &arena);
  return BASE_OK;
}

/* ---- the order --------------------------------------------------------------------------------*/

typedef struct place {
  uint64_t id;
  int contact;
} place;

static int by_id(const void *a, const void *b) {
  const place *x = a;
  const place *y = b;
  return (x->id > y->id) - (x->id < y->id);
}

static base_status sort_contacts(contact_order *o, const contact_set *c, uint64_t *id,
                                 base_error *err) {
  place *p = malloc(((size_t)c->n_contact + 1) * sizeof *p);
  if (p == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to reorder %d contacts", c->n_contact);
  }
  for (int i = 0; i < c->n_contact; i++) {
    p[i] = (place){another(c->id[i], o->seed), i};
  }
  qsort(p, (size_t)c->n_contact, sizeof *p, by_id);
  for (int i = 0; i < c->n_contact; i++) {
    id[i] = p[i].id;
    o->from[i] = p[i].contact;
  }
  free(p);
  return BASE_OK;
}

static void gather(const contact_order *o, int n, int width, const double *from, double *to) {
  for (int i = 0; from != NULL && i < n; i++) {
    memcpy(to + (size_t)i * (size_t)width, from + (size_t)o->from[i] * (size_t)width,
           (size_t)width * sizeof *to);
  }
}

static void copy_range(double *to, int at, const double *from, int begin, int n) {
  if (from != NULL) {
    memcpy(to + at, from + begin, (size_t)n * sizeof *to);
  }
}

/* Row groups: contacts in the new order, joints behind them as they were. */
static void gather_rows(const contact_order *o, const contact_set *c, arrays *s) {
  s->row_start[0] = s->jac_start[0] = 0;
  for (int i = 0; i < c->n_group; i++) {
    const int k = (i < c->n_contact) ? o->from[i] : i;
    const int row = c->row_start[k];
    const int n_row = c->row_start[k + 1] - row;
    const int n_jac = c->jac_start[k + 1] - c->jac_start[k];
    copy_range(s->jac, s->jac_start[i], c->jac, c->jac_start[k], n_jac);
    copy_range(s->u_drift, s->row_start[i], c->u_drift, row, n_row);
    copy_range(s->u_before, s->row_start[i], c->u_before, row, n_row);
    copy_range(s->u_curve, s->row_start[i], c->u_curve, row, n_row);
    s->body[2 * i] = c->body[2 * k];
    s->body[2 * i + 1] = c->body[2 * k + 1];
    s->row_start[i + 1] = s->row_start[i] + n_row;
    s->jac_start[i + 1] = s->jac_start[i] + n_jac;
  }
}

static void gather_contacts(const contact_order *o, const contact_set *c, const arrays *s) {
  const struct {
    const double *from;
    double *to;
    int width;
  } each[] = {{c->gap, s->gap, 1},
              {c->mu_static, s->mu_static, 1},
              {c->mu_kinetic, s->mu_kinetic, 1},
              {c->mu_torsion, s->mu_torsion, 1},
              {c->mu_rolling, s->mu_rolling, 1},
              {c->restitution, s->restitution, 1},
              {c->compliance, s->compliance, 1},
              {c->frame, s->frame, 9},
              {c->spin, s->spin, 3}};
  for (int i = 0; i < BASE_COUNT(each); i++) {
    gather(o, c->n_contact, each[i].width, each[i].from, each[i].to);
  }
  for (int i = 0; i < c->n_contact; i++) {
    s->rows[i] = c->rows[o->from[i]];
  }
}

base_status contact_order_apply(contact_order *o, const contact_set *c, const contact_set **out,
                                base_error *err) {
  *out = c;
  if (o->seed == 0) {
    return BASE_OK;
  }
  arrays s = {0};
  BASE_TRY(reserve(o, c, &s, err));
  BASE_TRY(sort_contacts(o, c, s.id, err));
  gather_rows(o, c, &s);
  gather_contacts(o, c, &s);
  contact_set *p = &o->set;
  *p = *c;
  p->row_start = s.row_start;
  p->body = s.body;
  p->jac_start = s.jac_start;
  p->jac = s.jac;
  p->u_drift = s.u_drift;
  p->u_before = s.u_before;
  p->u_curve = s.u_curve;
  p->id = s.id;
  p->rows = s.rows;
  p->gap = s.gap;
  p->mu_static = s.mu_static;
  p->mu_kinetic = s.mu_kinetic;
  p->mu_torsion = s.mu_torsion;
  p->mu_rolling = s.mu_rolling;
  p->restitution = s.restitution;
  p->compliance = s.compliance;
  p->frame = s.frame;
  p->spin = s.spin;
  *out = p;
  return BASE_OK;
}

void contact_order_restore(contact_order *o, const contact_set *c, formulation_answer *a) {
  if (o->seed == 0) {
    return;
  }
  const contact_set *p = &o->set;
  for (int i = 0; i < c->n_group; i++) {
    const int k = (i < c->n_contact) ? o->from[i] : i;
    copy_range(o->impulse, c->row_start[k], a->impulse, p->row_start[i],
               p->row_start[i + 1] - p->row_start[i]);
  }
  for (int i = 0; i < c->n_contact; i++) {
    copy_range(o->bias, o->from[i], a->bias, i, 1);
    if (a->mode != NULL) {
      o->mode[o->from[i]] = a->mode[i];
    }
  }
  a->impulse = (a->impulse != NULL) ? o->impulse : NULL;
  a->bias = (a->bias != NULL) ? o->bias : NULL;
  a->mode = (a->mode != NULL) ? o->mode : NULL;
}

void contact_order_close(contact_order *o) {
  free(o->mem);
  o->mem = NULL;
  o->bytes = 0;
}
