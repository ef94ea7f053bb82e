#include "formulations/impulse_log.h"

#include <stdlib.h>
#include <string.h>

impulse_entry *impulse_log_find(impulse_log *l, uint64_t id) {
  for (int i = 0; i < l->n; i++) {
    if (l->entry[i].id == id) {
      return &l->entry[i];
    }
  }
  return NULL;
}

base_status impulse_log_at(impulse_log *l, uint64_t id, double memory, impulse_entry **out,
                           base_error *err) {
  *out = impulse_log_find(l, id);
  if (*out != NULL) {
    return BASE_OK;
  }
  if (l->n == l->cap) {
    const int cap = (l->cap > 0) ? 2 * l->cap : 16;
    impulse_entry *more = realloc(l->entry, (size_t)cap * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "impulse log: no memory for %d contacts", cap);
    }
    l->entry = more;
    l->cap = cap;
  }
  *out = &l->entry[l->n++];
  **out = (impulse_entry){.id = id, .memory = memory};
  return BASE_OK;
}

void impulse_log_begin(impulse_log *l) {
  for (int i = 0; i < l->n; i++) {
    l->entry[i].seen = false;
  }
}

void impulse_log_add(impulse_entry *e, double dt, const double force[3]) {
  for (int r = 0; r < 3; r++) {
    e->impulse[r] += 0.5 * dt * (e->force[r] + force[r]);
    e->force[r] = force[r];
  }
  e->seen = true;
}

void impulse_log_end(impulse_log *l, double dt) {
  static const double none[3] = {0, 0, 0};
  for (int i = 0; i < l->n; i++) {
    if (!l->entry[i].seen) {
      impulse_log_add(&l->entry[i], dt, none);
      l->entry[i].seen = false;
    }
  }
}

void impulse_log_next_step(impulse_log *l) {
  int kept = 0;
  for (int i = 0; i < l->n; i++) {
    if (l->entry[i].seen) {
      l->entry[kept] = l->entry[i];
      memset(l->entry[kept++].impulse, 0, sizeof l->entry[0].impulse);
    }
  }
  l->n = kept;
}

/* Contact of the set that has the id, or else the first of its two shapes; -1: they have none. */
static int teller(const contact_set *c, uint64_t id) {
  int first = -1;
  for (int i = 0; i < c->n_contact; i++) {
    if (c->id[i] == id) {
      return i;
    }
    const bool same = contact_shapes_of(c->id[i]) == contact_shapes_of(id);
    first = (same && first < 0) ? i : first;
  }
  return first;
}

int impulse_log_write(impulse_log *l, const contact_set *c, double *impulse) {
  int known = 0;
  memset(impulse, 0, (size_t)c->n_row * sizeof *impulse);
  for (int k = 0; k < l->n; k++) {
    const impulse_entry *e = &l->entry[k];
    const int i = teller(c, e->id);
    for (int r = 0; i >= 0 && r < 1 + c->rows[i].tangent; r++) {
      impulse[c->row_start[i] + r] += e->impulse[r];
    }
    known += (i >= 0 && c->id[i] == e->id);
  }
  return known;
}

void impulse_log_close(impulse_log *l) {
  free(l->entry);
  *l = (impulse_log){0};
}

base_status joint_log_add(joint_log *l, const contact_set *c, const double *lambda, double dt,
                          bool jump, base_error *err) {
  const int first = c->row_start[c->n_contact];
  const int n = c->n_row - first;
  if (n > l->cap) {
    double *more = calloc(2 * (size_t)n, sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "impulse log: no memory for %d joint rows", n);
    }
    free(l->force);
    *l = (joint_log){.force = more, .impulse = more + n, .cap = n};
  }
  if (n != l->n) {
    memset(l->force, 0, 2 * (size_t)l->cap * sizeof *l->force);
    l->n = n;
  }
  for (int r = 0; r < n; r++) {
    const double now = lambda[first + r];
    l->impulse[r] += jump ? now : 0.5 * dt * (l->force[r] + now);
    l->force[r] = jump ? l->force[r] : now;
  }
  return BASE_OK;
}

void joint_log_next_step(joint_log *l) {
  for (int r = 0; r < l->n; r++) {
    l->impulse[r] = 0;
  }
}

void joint_log_write(const joint_log *l, const contact_set *c, double *impulse) {
  const int first = c->row_start[c->n_contact];
  if (c->n_row - first == l->n && l->n > 0) {
    memcpy(impulse + first, l->impulse, (size_t)l->n * sizeof *impulse);
  }
}

void joint_log_close(joint_log *l) {
  free(l->force);
  *l = (joint_log){0};
}
