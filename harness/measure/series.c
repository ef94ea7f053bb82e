#include "harness/measure/series.h"

#include <stdlib.h>
#include <string.h>

/* ---- columns --------------------------------------------------------------------------------- */

static bool same_var(const series_var *v, const spec_check *c) {
  return strcmp(v->var, c->var) == 0 && v->has_dir == c->has_dir &&
         (!c->has_dir ||
          (v->dir[0] == c->dir[0] && v->dir[1] == c->dir[1] && v->dir[2] == c->dir[2]));
}

const series_var *series_find_var(const series *s, const spec_check *c) {
  for (int i = 0; i < s->n_var; i++) {
    if (same_var(&s->var[i], c)) {
      return &s->var[i];
    }
  }
  return NULL;
}

static bool same_pair(const char *a1, const char *b1, const char *a2, const char *b2) {
  return (strcmp(a1, a2) == 0 && strcmp(b1, b2) == 0) ||
         (strcmp(a1, b2) == 0 && strcmp(b1, a2) == 0);
}

const series_pair *series_find_pair(const series *s, const spec_pair *p) {
  for (int i = 0; i < s->n_pair; i++) {
    if (same_pair(s->pair[i].a, s->pair[i].b, p->a, p->b)) {
      return &s->pair[i];
    }
  }
  return NULL;
}

static void add_var(series *s, const spec_check *c) {
  if (c->var[0] == '\0' || series_find_var(s, c) != NULL) {
    return;
  }
  series_var *v = &s->var[s->n_var++];
  memcpy(v->var, c->var, sizeof v->var);
  v->has_dir = c->has_dir;
  memcpy(v->dir, c->dir, sizeof v->dir);
  v->column = s->n_column++;
}

static void add_pairs(series *s, const spec_check *c) {
  for (int i = 0; i < c->n_pair; i++) {
    if (series_find_pair(s, &c->pair[i]) == NULL) {
      series_pair *p = &s->pair[s->n_pair++];
      memcpy(p->a, c->pair[i].a, sizeof p->a);
      memcpy(p->b, c->pair[i].b, sizeof p->b);
      p->normal = s->n_column++;
      p->tangential = s->n_column++;
    }
  }
}

static void add_check(series *s, const spec_check *c) {
  add_var(s, c);
  add_pairs(s, c);
}

static base_status reserve(series *s, int cap, base_error *err) {
  for (int i = 0; i < s->n_column; i++) {
    double *grown = realloc(s->column[i], (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "record: no memory for %d rows", cap);
    }
    s->column[i] = grown;
  }
  s->cap = cap;
  return BASE_OK;
}

base_status series_open(series *s, const scene_spec *spec, int n_step, base_error *err) {
  *s = (series){.n_column = SERIES_FIXED};
  const size_t n = (size_t)spec->n_check + (size_t)spec->n_off + (size_t)spec->n_observe + 1;
  s->var = calloc(n, sizeof *s->var);
  s->pair = calloc(n * SPEC_PAIRS, sizeof *s->pair);
  if (s->var != NULL && s->pair != NULL) {
    for (int i = 0; i < spec->n_check; i++) {
      add_check(s, &spec->check[i]);
    }
    for (int i = 0; i < spec->n_off; i++) {
      add_check(s, &spec->off[i].check);
    }
    for (int i = 0; i < spec->n_observe; i++) {
      spec_check c = {0};
      memcpy(c.var, spec->observe[i], sizeof c.var);
      add_var(s, &c);
    }
    s->column = calloc((size_t)s->n_column, sizeof *s->column);
  }
  if (s->column == NULL) {
    series_close(s);
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for the record", spec->id);
  }
  const base_status done = reserve(s, n_step + 1, err);
  if (done != BASE_OK) {
    series_close(s);
  }
  return done;
}

void series_close(series *s) {
  for (int i = 0; s->column != NULL && i < s->n_column; i++) {
    free(s->column[i]);
  }
  free(s->column);
  free(s->var);
  free(s->pair);
  *s = (series){0};
}

/* ---- rows ------------------------------------------------------------------------------------ */

static double norm3(const double x[3]) {
  return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

series_force series_force_of(const contact_set *c, const double *impulse, int i) {
  const double *row = impulse + c->row_start[i];
  const double *frame = c->frame + 9 * (size_t)i;
  series_force f = {.id = c->id[i], .normal = row[0] / c->h};
  for (int k = 0; k < c->rows[i].tangent; k++) {
    for (int d = 0; d < 3; d++) {
      f.tangent[d] += row[1 + k] / c->h * frame[3 * (k + 1) + d];
    }
  }
  return f;
}

base_status series_resting_add(series_resting *r, const series_force *f, base_error *err) {
  if (r->n == r->cap) {
    const int cap = 2 * r->cap + 16;
    series_force *grown = realloc(r->force, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for the forces of %d contacts at rest", cap);
    }
    r->force = grown;
    r->cap = cap;
  }
  r->force[r->n++] = *f;
  return BASE_OK;
}

void series_resting_close(series_resting *r) {
  free(r->force);
  *r = (series_resting){0};
}

/* A contact of bodies a and b is one of the pair's. */
static bool covers(const series_pair *p, const char *a, const char *b) {
  if (strcmp(p->b, SPEC_ANY) == 0) {
    return strcmp(a, p->a) == 0 || strcmp(b, p->a) == 0;
  }
  return same_pair(a, b, p->a, p->b);
}

/* Adds a force to that of the pair, if it is one of its. */
static void add_force(const world *w, const series_pair *p, const series_force *f,
                      series_force *sum) {
  const char *a;
  const char *b;
  world_contact_pair(w, f->id, &a, &b);
  if (covers(p, a, b)) {
    sum->normal += f->normal;
    for (int d = 0; d < 3; d++) {
      sum->tangent[d] += f->tangent[d];
    }
  }
}

static int contacts_of(const contact_set *c, const double *impulse) {
  return (c != NULL && impulse != NULL) ? c->n_contact : 0;
}

static void record_pair(series *s, const world *w, const contact_set *c, const double *impulse,
                        const series_resting *resting, const series_pair *p) {
  series_force sum = {0};
  for (int i = 0; i < contacts_of(c, impulse); i++) {
    const series_force f = series_force_of(c, impulse, i);
    add_force(w, p, &f, &sum);
  }
  for (int i = 0; resting != NULL && i < resting->n; i++) {
    add_force(w, p, &resting->force[i], &sum);
  }
  s->column[p->normal][s->n_row] = sum.normal;
  s->column[p->tangential][s->n_row] = norm3(sum.tangent);
}

static double total_normal_force(const contact_set *c, const double *impulse,
                                 const series_resting *resting) {
  double sum = 0.0;
  for (int i = 0; i < contacts_of(c, impulse); i++) {
    sum += impulse[c->row_start[i]] / c->h;
  }
  for (int i = 0; resting != NULL && i < resting->n; i++) {
    sum += resting->force[i].normal;
  }
  return sum;
}

/* What a row says of the state alone. */
static base_status record_state(series *s, const world *w, int row, double stored,
                                base_error *err) {
  double L[3];
  double p[3];
  world_angular_momentum(w, L);
  world_momentum(w, p);
  s->column[SERIES_TIME][row] = world_time(w);
  s->column[SERIES_ENERGY][row] = world_energy(w) + stored;
  s->column[SERIES_SPEED][row] = world_max_speed(w);
  s->column[SERIES_ANGULAR][row] = norm3(L);
  s->column[SERIES_MOMENTUM_X][row] = p[0];
  for (int i = 0; i < s->n_var; i++) {
    const series_var *v = &s->var[i];
    if (!world_observe(w, v->var, v->has_dir ? v->dir : NULL, &s->column[v->column][row])) {
      return BASE_FAIL(err, BASE_EINVAL, "check of '%s': no such quantity in the scene", v->var);
    }
  }
  return BASE_OK;
}

base_status series_record(series *s, world *w, const contact_set *set, const double *impulse,
                          const series_resting *resting, double stored, base_error *err) {
  if (s->n_row == s->cap) {
    BASE_TRY(reserve(s, 2 * s->cap, err));
  }
  const int row = s->n_row;
  s->column[SERIES_PENETRATION][row] = 0.0;
  s->column[SERIES_STEP][row] = 0.0;
  s->column[SERIES_ANY_FORCE][row] = total_normal_force(set, impulse, resting);
  for (int i = 0; i < s->n_pair; i++) {
    record_pair(s, w, set, impulse, resting, &s->pair[i]);
  }
  BASE_TRY(record_state(s, w, row, stored, err));
  s->n_row++;
  return BASE_OK;
}

/* The mean of the last two rows in the row before the last. */
static void average(series *s, int column) {
  double *x = s->column[column] + s->n_row - 2;
  x[0] = 0.5 * (x[0] + x[1]);
}

base_status series_join(series *s, const world *w, double stored, base_error *err) {
  double *deep = s->column[SERIES_PENETRATION] + s->n_row - 2;
  double *spent = s->column[SERIES_STEP] + s->n_row - 2;
  deep[0] = fmax(deep[0], deep[1]);
  spent[0] += spent[1];
  average(s, SERIES_ANY_FORCE);
  for (int i = 0; i < s->n_pair; i++) {
    average(s, s->pair[i].normal);
    average(s, s->pair[i].tangential);
  }
  s->n_row--;
  return record_state(s, w, s->n_row - 1, stored, err);
}

void series_penetration(series *s, const contact_set *set) {
  double deepest = 0.0;
  for (int i = 0; i < set->n_contact; i++) {
    deepest = fmax(deepest, -set->gap[i]);
  }
  s->column[SERIES_PENETRATION][s->n_row - 1] = deepest;
}

bool series_at(const series *s, int column, double t, double *value) {
  const double *time = s->column[SERIES_TIME];
  const double *x = s->column[column];
  const int last = s->n_row - 1;
  const double slack = 1e-9 * (1.0 + fabs(t));
  if (last < 0 || t > time[last] + slack || t < time[0] - slack) {
    return false;
  }
  int lo = 0;
  int hi = last;
  while (hi - lo > 1) {
    const int mid = lo + (hi - lo) / 2;
    if (time[mid] <= t) {
      lo = mid;
    } else {
      hi = mid;
    }
  }
  const double span = time[hi] - time[lo];
  if (fabs(t - time[hi]) <= slack || !(span > 0.0)) {
    *value = x[hi];
  } else if (fabs(t - time[lo]) <= slack) {
    *value = x[lo];
  } else {
    const double a = (t - time[lo]) / span;
    *value = (1.0 - a) * x[lo] + a * x[hi];
  }
  return true;
}
