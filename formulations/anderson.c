#include "formulations/anderson.h"

#include "formulations/workspace.h"

#include <stdlib.h>

static void layout(void *state, base_arena *m) {
  anderson *a = state;
  lin_anderson_layout(&a->mixing, a->cap, m);
}

void anderson_close(anderson *a) {
  free(a->mem);
  *a = (anderson){0};
}

base_status anderson_begin(anderson *a, int n, base_error *err) {
  if (a->mem == NULL || n > a->cap) {
    a->cap = base_room(n) + 4;
    BASE_TRY(form_memory(&a->mem, layout, a, err));
  }
  lin_anderson_begin(&a->mixing, n);
  return BASE_OK;
}

base_status anderson_next(anderson *a, const double *step, int from, double *x, base_error *err) {
  return lin_anderson_next(&a->mixing, step, from, x, err);
}
