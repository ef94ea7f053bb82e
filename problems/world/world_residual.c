/* world_residual.c - axes and impulses, as world_omitted.c and world_standing.c count them. */
#include "problems/world/world_residual.h"

#include "problems/vec.h"

unsigned world_free_axes(const world *w, int i, unsigned effects) {
  const spec_body *s = &w->spec.body[i];
  return s->kinematic ? 0u : body_axes(w->dim, effects) & ~(s->lock | s->prescribed);
}

unsigned world_locked_now(const world *w, int i, unsigned effects) {
  return world_free_axes(w, i, effects) & ~world_free_axes(w, i, w->effects);
}

void world_contact_impulse(const world *w, int i, const double *impulse, double *f, double *m) {
  static const double z[3] = {0, 0, 1};
  const set_store *s = &w->store;
  const double *frame = s->frame + 9 * (ptrdiff_t)i;
  const double *row = impulse + s->row_start[i];
  const contact_rows r = s->rows[i];
  memset(m, 0, 3 * sizeof *m);
  v3_scale(*row++, frame, f);
  for (int k = 0; k < r.tangent; k++) {
    v3_add_scaled(f, *row++, frame + 3 + 3 * (ptrdiff_t)k, f);
  }
  if (r.torsion > 0) {
    v3_add_scaled(m, *row++, frame, m);
  }
  if (r.rolling == 1) {
    v3_add_scaled(m, *row, (w->dim == 2) ? z : frame + 6, m);
  }
  for (int k = 0; r.rolling == 2 && k < 2; k++) {
    v3_add_scaled(m, *row++, frame + 3 + 3 * (ptrdiff_t)k, m);
  }
}

void world_add_foot(const world *w, int i) {
  const contact_item *c = &w->store.item[w->store.key[i].item];
  world_residual(w, c->a)->feet += 1.0;
  if (c->b < w->n_body) {
    world_residual(w, c->b)->feet += 1.0;
  }
}
