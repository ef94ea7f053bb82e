#include "formulations/contact_memory.h"

#include "lcp/base/arena.h"

#include <stdlib.h>
#include <string.h>

static base_status grow(contact_memory *m, int n, base_error *err) {
  const int cap = n + n / 2;
  const size_t data = (size_t)cap * (size_t)m->stride * sizeof(double);
  uint64_t *id = base_alloc((size_t)cap * sizeof *id);
  uint64_t *id_old = base_alloc((size_t)cap * sizeof *id);
  double *now = base_alloc(data);
  double *old = base_alloc(data);
  int *match = base_alloc((size_t)cap * sizeof *match);
  if (id == NULL || id_old == NULL || now == NULL || old == NULL || match == NULL) {
    free(id);
    free(id_old);
    free(now);
    free(old);
    free(match);
    return BASE_FAIL(err, BASE_ENOMEM, "formulation: no memory to remember %d contacts", n);
  }
  if (m->n_old > 0) {
    memcpy(id_old, m->id_old, (size_t)m->n_old * sizeof *id);
    memcpy(old, m->old, (size_t)m->n_old * (size_t)m->stride * sizeof *old);
  }
  const contact_memory was = *m;
  m->cap = cap;
  m->id = id;
  m->id_old = id_old;
  m->now = now;
  m->old = old;
  m->match = match;
  free(was.id);
  free(was.id_old);
  free(was.now);
  free(was.old);
  free(was.match);
  return BASE_OK;
}

base_status contact_memory_begin(contact_memory *m, int stride, const contact_set *c,
                                 base_error *err) {
  if (stride != m->stride) {
    contact_memory_close(m);
    m->stride = stride;
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
    memset(m->now, 0, (size_t)m->n * (size_t)stride * sizeof *m->now);
  }
  return BASE_OK;
}

void contact_memory_forget(contact_memory *m) {
  m->n = 0;
  m->n_old = 0;
  m->h_now = 0;
  m->h_old = 0;
}

void contact_memory_close(contact_memory *m) {
  free(m->id);
  free(m->id_old);
  free(m->now);
  free(m->old);
  free(m->match);
  *m = (contact_memory){0};
}
