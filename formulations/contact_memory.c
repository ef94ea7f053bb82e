#include "formulations/contact_memory.h"

#include "lcp/base/arena.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int contact_memory_kinds(const contact_set *c) {
  int kinds = 1;
  for (int i = 0; i < c->n_contact && kinds < CONTACT_KINDS; i++) {
    const int own = (c->rows[i].rolling > 0) ? 3 : (c->rows[i].torsion > 0) ? 2 : 1;
    kinds = (own > kinds) ? own : kinds;
  }
  return kinds;
}

contact_layout contact_memory_need(int kinds, bool springs, int own) {
  static const int rows[CONTACT_KINDS + 1] = {1, 1 + 2, 1 + 2 + 1, 1 + 2 + 1 + 2};
  return (contact_layout){.head = PAST_IMPULSE,
                          .impulse = rows[kinds],
                          .pull = springs ? PAST_PULL_NUMBERS * kinds : 0,
                          .own = own};
}

static int size_of(contact_layout l) {
  return l.head + l.impulse + l.pull + l.own;
}

static int longer(int a, int b) {
  return (a > b) ? a : b;
}

static contact_layout both(contact_layout a, contact_layout b) {
  return (contact_layout){.head = longer(a.head, b.head),
                          .impulse = longer(a.impulse, b.impulse),
                          .pull = longer(a.pull, b.pull),
                          .own = longer(a.own, b.own)};
}

static bool same(contact_layout a, contact_layout b) {
  return a.head == b.head && a.impulse == b.impulse && a.pull == b.pull && a.own == b.own;
}

static void lay_out(contact_memory *m, contact_layout l) {
  m->layout = l;
  m->stride = size_of(l);
}

static void layout(contact_memory *m, base_arena *a) {
  const size_t data = (size_t)m->cap * (size_t)m->stride;
  m->id = BASE_ARRAY(a, uint64_t, m->cap);
  m->id_old = BASE_ARRAY(a, uint64_t, m->cap);
  m->now = BASE_ARRAY(a, double, data);
  m->old = BASE_ARRAY(a, double, data);
  m->match = BASE_ARRAY(a, int, m->cap);
}

/* The past survives, the present is about to be written. */
static base_status grow(contact_memory *m, int n, base_error *err) {
  contact_memory next = *m;
  next.cap = base_room(n);
  base_arena measure = base_arena_measuring();
  layout(&next, &measure);
  next.mem = base_alloc(measure.used);
  if (next.mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "formulation: no memory to remember %d contacts", n);
  }
  base_arena arena = base_arena_over(next.mem, measure.used);
  layout(&next, &arena);
  if (m->n_old > 0) {
    memcpy(next.id_old, m->id_old, (size_t)m->n_old * sizeof *m->id_old);
    memcpy(next.old, m->old, (size_t)m->n_old * (size_t)m->stride * sizeof *m->old);
  }
  void *outgrown = m->mem;
  *m = next;
  free(outgrown);
  return BASE_OK;
}

/* An entry as `from` has it, in the longer parts of `to`. */
static void move_entry(contact_layout from, const double *in, contact_layout to, double *out) {
  const int had[] = {from.head, from.impulse, from.pull, from.own};
  const int has[] = {to.head, to.impulse, to.pull, to.own};
  memset(out, 0, (size_t)size_of(to) * sizeof *out);
  for (int k = 0; k < BASE_COUNT(has); k++) {
    memcpy(out, in, (size_t)had[k] * sizeof *out);
    in += had[k];
    out += has[k];
  }
}

/* The present moves to entries with longer parts. */
static base_status widen(contact_memory *m, contact_layout l, base_error *err) {
  contact_memory next = {.n = m->n, .h_now = m->h_now, .h_old = m->h_old};
  lay_out(&next, l);
  BASE_TRY(grow(&next, m->n + 1, err));
  for (int i = 0; i < m->n; i++) {
    move_entry(m->layout, contact_memory_now(m, i), l, contact_memory_now(&next, i));
    next.id[i] = m->id[i];
  }
  free(m->mem);
  *m = next;
  return BASE_OK;
}

base_status contact_memory_begin(contact_memory *m, contact_layout need, const contact_set *c,
                                 base_error *err) {
  need = both(m->layout, need);
  if (!same(need, m->layout)) {
    BASE_TRY(widen(m, need, err));
  }
  uint64_t *id = m->id;
  double *now = m->now;
  m->id = m->id_old;
  m->now = m->old;
  m->id_old = id;
  m->old = now;
  m->n_old = m->n;
  m->h_old = m->h_now;
  m->h_now = c->h;
  m->n = 0;
  if (c->n_contact > m->cap) {
    BASE_TRY(grow(m, c->n_contact, err));
  }
  m->n = c->n_contact;
  int k = 0;
  for (int i = 0; i < m->n; i++) {
    m->id[i] = c->id[i];
    while (k < m->n_old && m->id_old[k] < c->id[i]) {
      k++;
    }
    const bool found = k < m->n_old && m->id_old[k] == c->id[i];
    m->match[i] = found ? k : -1;
    k += found; /* ids may repeat (contacts listed twice): match them one to one, in order */
  }
  if (m->n > 0) {
    memset(m->now, 0, (size_t)m->n * (size_t)m->stride * sizeof *m->now);
  }
  return BASE_OK;
}

/* First of n ascending ids that is not below `id`. */
static int first_from(const uint64_t *ids, int n, uint64_t id) {
  int low = 0, high = n;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    low = (ids[mid] < id) ? mid + 1 : low;
    high = (ids[mid] < id) ? high : mid;
  }
  return low;
}

void contact_memory_way(const contact_set *c, int i, const double *u, double way[3]) {
  for (int m = 0; m < 3; m++) {
    way[m] = 0;
    for (int k = 1; k <= c->rows[i].tangent; k++) {
      way[m] += u[k] * c->frame[9 * (ptrdiff_t)i + 3 * k + m];
    }
  }
}

/* Does contact i, which was open, slip: by more than what solves leave beside how it closes, or would without contacts? */
static bool slips_on(const contact_set *c, int i) {
  static const double left = 1e-6;
  const double *u = c->u_before + c->row_start[i];
  double slip = 0;
  for (int k = 1; k <= c->rows[i].tangent; k++) {
    slip = hypot(slip, u[k]);
  }
  return slip > left * fmax(fabs(u[0]), fabs(contact_free_speed(c, i)));
}

int contact_memory_slides(const contact_memory *m, const contact_set *c, int i) {
  static const double still = 1e-9;
  const double *past = contact_memory_old(m, i);
  double took = 0, on = 0, way[3];
  const bool falls = c->mu_kinetic[i] < c->mu_static[i];
  if (falls && !contact_memory_closed(m, i)) {
    return slips_on(c, i) ? 1 : 0;
  }
  if (past == NULL || past[PAST_SLIDES] == 0) {
    return 0;
  }
  if (!falls) {
    return 1;
  }
  contact_memory_way(c, i, c->u_before + c->row_start[i], way);
  for (int k = 1; k <= c->rows[i].tangent; k++) {
    took = hypot(took, past[PAST_IMPULSE + k]);
  }
  for (int k = 0; k < 3; k++) {
    on += way[k] * past[PAST_WAY + k];
  }
  if (hypot(hypot(way[0], way[1]), way[2]) <= still * contact_mobility(c, i, 1) * took) {
    return 0;
  }
  return (past[PAST_SLIDES] > 0 && !(on < 0)) ? 1 : -1;
}

bool contact_memory_closed(const contact_memory *m, int i) {
  if (m->match[i] >= 0) {
    return contact_memory_old(m, i)[PAST_CLOSED] > 0;
  }
  const uint64_t shapes = contact_shapes_of(m->id[i]);
  int k = first_from(m->id_old, m->n_old, shapes << (CONTACT_COPY_BITS + CONTACT_FEATURE_BITS));
  for (; k < m->n_old && contact_shapes_of(m->id_old[k]) == shapes; k++) {
    const int at = first_from(m->id, m->n, m->id_old[k]);
    const bool gone = at == m->n || m->id[at] != m->id_old[k];
    if (gone && m->old[(ptrdiff_t)k * m->stride + PAST_CLOSED] > 0) {
      return true;
    }
  }
  return false;
}

static double differs_by(const contact_memory *m, int i, bool lagged) {
  const double *was = contact_memory_old(m, i), *is = m->now + (ptrdiff_t)i * m->stride;
  if (was == NULL) {
    return HUGE_VAL;
  }
  const int pulls = contact_memory_pulls(m);
  double most = lagged ? fabs(is[PAST_IMPULSE] - was[PAST_IMPULSE]) : 0;
  for (int k = pulls; k < pulls + m->layout.pull; k++) {
    most = fmax(most, m->h_now * fabs(is[k] - was[k]));
  }
  return most;
}

void contact_memory_changes(const contact_memory *m, bool lagged,
                            void (*tell)(void *of, uint64_t id, double by), void *of) {
  for (int i = 0; i < m->n; i++) {
    tell(of, m->id[i], differs_by(m, i, lagged));
  }
}

void contact_memory_forget(contact_memory *m) {
  m->n = 0;
  m->n_old = 0;
  m->h_now = 0;
  m->h_old = 0;
}

void contact_memory_close(contact_memory *m) {
  free(m->mem);
  *m = (contact_memory){0};
}

_Static_assert(sizeof(uint64_t) == sizeof(double), "ids and numbers share an array");

/* Room for `need` numbers of n contacts. */
static base_status past_fits(contact_past *past, int n, int need, base_error *err) {
  if (need > past->cap) {
    contact_memory_drop(past);
    past->number = malloc((size_t)need * sizeof *past->number);
    if (past->number == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "formulation: no memory to keep %d contacts", n);
    }
    past->cap = need;
  }
  return BASE_OK;
}

base_status contact_memory_keep(const contact_memory *m, contact_past *past, base_error *err) {
  BASE_TRY(past_fits(past, m->n, m->n * (1 + m->stride), err));
  past->layout = m->layout;
  past->n = m->n;
  past->h = m->h_now;
  if (m->n > 0) {
    memcpy(past->number, m->id, (size_t)m->n * sizeof *m->id);
    memcpy(past->number + m->n, m->now, (size_t)m->n * (size_t)m->stride * sizeof *m->now);
  }
  return BASE_OK;
}

base_status contact_memory_recall(contact_memory *m, const contact_past *past, base_error *err) {
  if (past->n > m->cap || !same(past->layout, m->layout)) {
    lay_out(m, past->layout);
    m->n_old = 0;
    BASE_TRY(grow(m, past->n, err));
  }
  m->n = past->n;
  m->h_now = past->h;
  if (past->n > 0) {
    memcpy(m->id, past->number, (size_t)past->n * sizeof *m->id);
    memcpy(m->now, past->number + past->n, (size_t)past->n * (size_t)m->stride * sizeof *m->now);
  }
  return BASE_OK;
}

base_status contact_memory_copy(const contact_past *from, contact_past *to, base_error *err) {
  const int need = from->n * (1 + size_of(from->layout));
  BASE_TRY(past_fits(to, from->n, need, err));
  to->layout = from->layout;
  to->n = from->n;
  to->h = from->h;
  if (need > 0) {
    memcpy(to->number, from->number, (size_t)need * sizeof *to->number);
  }
  return BASE_OK;
}

static uint64_t id_of(const contact_past *past, int i) {
  uint64_t id;
  memcpy(&id, past->number + i, sizeof id);
  return id;
}

static const double *entry_of(const contact_past *past, int i) {
  return past->number + past->n + (ptrdiff_t)i * size_of(past->layout);
}

double contact_memory_energy(const contact_past *past) {
  double sum = 0.0;
  for (int i = 0; i < past->n && past->layout.head > PAST_ENERGY; i++) {
    sum += entry_of(past, i)[PAST_ENERGY];
  }
  return sum;
}

/* Appends entry i of `from`; `out` has room for out_most. Impulses are those of its own step. */
static void append(const contact_past *from, int i, contact_past *out, int out_most) {
  double *entry = out->number + out_most + (ptrdiff_t)out->n * size_of(out->layout);
  memcpy(out->number + out->n, from->number + i, sizeof *from->number);
  move_entry(from->layout, entry_of(from, i), out->layout, entry);
  for (int k = 0; k < out->layout.impulse && from->h != out->h; k++) {
    entry[out->layout.head + k] *= out->h / from->h;
  }
  out->n++;
}

/* An empty past with room for `most` entries; its entries move up to its ids once it is `closed`. */
static base_status open_past(contact_past *out, contact_layout l, double h, int most,
                             base_error *err) {
  *out = (contact_past){.layout = l, .h = h, .cap = most * (1 + size_of(l))};
  out->number = malloc(((size_t)out->cap + 1) * sizeof *out->number);
  return (out->number != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "formulation: no memory to keep %d contacts", most);
}

static void close_past(contact_past *out, int most) {
  memmove(out->number + out->n, out->number + most,
          (size_t)out->n * (size_t)size_of(out->layout) * sizeof *out->number);
}

base_status contact_memory_move(contact_past *from, contact_past *to,
                                bool (*those)(const void *of, uint64_t id), const void *of,
                                base_error *err) {
  const int most = from->n + to->n;
  const contact_layout l = both(from->layout, to->layout);
  contact_past stay;
  contact_past now;
  BASE_TRY(open_past(&stay, l, from->h, from->n, err));
  const base_status done = open_past(&now, l, (to->n > 0) ? to->h : from->h, most, err);
  if (done != BASE_OK) {
    contact_memory_drop(&stay);
    return done;
  }
  int k = 0;
  for (int i = 0; i < from->n; i++) {
    const uint64_t id = id_of(from, i);
    for (; k < to->n && id_of(to, k) < id; k++) {
      append(to, k, &now, most);
    }
    const bool moves = those(of, id);
    append(from, i, moves ? &now : &stay, moves ? most : from->n);
  }
  for (; k < to->n; k++) {
    append(to, k, &now, most);
  }
  close_past(&stay, from->n);
  close_past(&now, most);
  contact_memory_drop(from);
  contact_memory_drop(to);
  *from = stay;
  *to = now;
  return BASE_OK;
}

void contact_memory_strip(contact_past *past) {
  double *entry = past->number + past->n;
  const int stride = size_of(past->layout), common = stride - past->layout.own;
  for (int i = 0; i < past->n && common < stride; i++) {
    memmove(entry + (ptrdiff_t)i * common, entry + (ptrdiff_t)i * stride,
            (size_t)common * sizeof *entry);
  }
  past->layout.own = 0;
}

void contact_memory_settle(contact_past *past) {
  double *entry = past->number + past->n;
  const int stride = size_of(past->layout);
  for (int i = 0; i < past->n; i++) {
    entry[(ptrdiff_t)i * stride + PAST_APPROACH] = 0;
    entry[(ptrdiff_t)i * stride + PAST_SLIDES] = 0;
  }
}

void contact_memory_drop(contact_past *past) {
  free(past->number);
  *past = (contact_past){0};
}
