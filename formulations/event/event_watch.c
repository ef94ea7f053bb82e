#include "formulations/event/event_watch.h"

#include <math.h>
#include <stdlib.h>

void watch_close(event_watch *w) {
  free(w->was);
  free(w->now);
  *w = (event_watch){0};
}

static base_status reserve(event_watch *w, int n, base_error *err) {
  if (n <= w->cap) {
    return BASE_OK;
  }
  const int cap = 2 * n + 8;
  watched *was = realloc(w->was, (size_t)cap * sizeof *was);
  w->was = (was != NULL) ? was : w->was;
  watched *now = realloc(w->now, (size_t)cap * sizeof *now);
  w->now = (now != NULL) ? now : w->now;
  if (was == NULL || now == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", n);
  }
  w->cap = cap;
  return BASE_OK;
}

/* Contact g of the last evaluation is held by the arc. */
static bool held(const arc *a, int g) {
  return a->space->gap[g] == 0.0;
}

/* Entry of id, NULL if it was not there; the list ascends. */
static const watched *entry(const event_watch *w, uint64_t id) {
  int low = 0, high = w->n_was;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (w->was[mid].id < id) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  return (low < w->n_was && w->was[low].id == id) ? &w->was[low] : NULL;
}

base_status watch_take(event_watch *w, const arc *a, bool begins, double touching,
                       base_error *err) {
  const contact_set *c = &a->set;
  int n = 0;
  BASE_TRY(reserve(w, c->n_contact, err));
  for (int g = 0; g < c->n_contact; g++) {
    if (held(a, g)) {
      continue;
    }
    const watched *old = entry(w, c->id[g]);
    const double kept = (old != NULL && c->gap[g] <= touching) ? old->base : 0.0;
    const double base = begins ? fmin(c->gap[g], 0.0) : kept;
    w->now[n++] = (watched){c->id[g], c->gap[g], c->u_before[c->row_start[g]], base};
  }
  watched *const spare = w->was;
  w->was = w->now;
  w->now = spare;
  w->n_was = n;
  return BASE_OK;
}

static double limit_of(const event_watch *w, const arc *a, uint64_t id) {
  const watched *old = entry(w, id);
  return ((old != NULL) ? old->base : 0.0) - a->set.tol;
}

bool watch_closes(const event_watch *w, const arc *a) {
  const contact_set *c = &a->set;
  for (int g = 0; g < c->n_contact; g++) {
    if (!held(a, g) && c->gap[g] < -c->tol && c->gap[g] < limit_of(w, a, c->id[g])) {
      return true;
    }
  }
  return false;
}

double watch_least(double gap0, double u0, double gap1, double u1, double dt) {
  const double at = (gap0 - gap1 + u1 * dt) / (u1 - u0);
  return (at <= 0.0 || at >= dt) ? fmin(gap0, gap1) : gap0 + u0 * at;
}

bool watch_passes(const event_watch *w, const arc *a, double dt, double slack, int *g, watched *old,
                  watched *now) {
  const contact_set *c = &a->set;
  while (*g < c->n_contact) {
    const int i = (*g)++;
    const double u = c->u_before[c->row_start[i]];
    const watched *was = (held(a, i) || u <= 0.0) ? NULL : entry(w, c->id[i]);
    if (was == NULL || was->u >= 0.0) {
      continue;
    }
    const double least = watch_least(was->gap, was->u, c->gap[i], u, dt);
    if (least - slack * dt * (u - was->u) < was->base - c->tol) {
      *old = *was;
      *now = (watched){c->id[i], c->gap[i], u, was->base};
      return true;
    }
  }
  return false;
}

bool watch_find(const arc *a, uint64_t id, double *gap, double *u) {
  const contact_set *c = &a->set;
  for (int g = 0; g < c->n_contact; g++) {
    if (c->id[g] == id) {
      *gap = c->gap[g];
      *u = c->u_before[c->row_start[g]];
      return true;
    }
  }
  return false;
}
