#include "harness/measure/own_answers.h"

#include <string.h>

void own_answers_step(own_answers *o) {
  o->fresh = true;
}

/* Unknowns of group k, the first of which is *first. */
static int unknowns(const formulation_rows *rows, int k, int *first) {
  *first = (rows->first != NULL) ? rows->first[k] : k;
  return (rows->first != NULL) ? rows->first[k + 1] - *first : 1;
}

void own_answers_start(const own_answers *o, const formulation_rows *rows, double *z) {
  const contact_memory *m = &o->memory;
  int at = 0;
  for (int k = 0; k < rows->n_group && rows->group[k] < rows->set->n_contact; k++) {
    const uint64_t id = rows->set->id[rows->group[k]];
    while (at < m->n && m->id[at] < id) {
      at++;
    }
    if (at == m->n) {
      return;
    }
    int first;
    const int n = unknowns(rows, k, &first);
    const double *entry = m->now + (ptrdiff_t)at * m->stride;
    bool same = m->id[at] == id && entry[0] == n;
    for (int i = 0; i < n && same; i++) {
      same = (z[first + i] > 0) == (entry[1 + n + i] > 0);
    }
    if (same) {
      memcpy(z + first, entry + 1, (size_t)n * sizeof *z);
    }
    at += m->id[at] == id; /* ids may repeat */
  }
}

static int widest(const formulation_rows *rows) {
  int width = 1;
  for (int k = 0; k < rows->n_group; k++) {
    int first;
    const int n = unknowns(rows, k, &first);
    width = (n > width) ? n : width;
  }
  return width;
}

base_status own_answers_note(own_answers *o, const formulation_rows *rows, const double *own,
                             const double *chosen, base_error *err) {
  contact_memory *m = &o->memory;
  if (o->fresh) {
    const contact_layout entry = {.own = 1 + 2 * widest(rows)};
    BASE_TRY(contact_memory_begin(m, entry, rows->set, err));
    o->fresh = false;
  }
  for (int k = 0; k < rows->n_group && rows->group[k] < rows->set->n_contact; k++) {
    int first;
    const int n = unknowns(rows, k, &first);
    const bool fits = 1 + 2 * n <= m->stride; /* a later problem of a step may have larger blocks */
    double *entry = contact_memory_now(m, rows->group[k]);
    entry[0] = fits ? n : 0;
    memcpy(entry + 1, own + first, fits ? (size_t)n * sizeof *own : 0);
    memcpy(entry + 1 + n, chosen + first, fits ? (size_t)n * sizeof *own : 0);
  }
  return BASE_OK;
}

void own_answers_close(own_answers *o) {
  contact_memory_close(&o->memory);
}
