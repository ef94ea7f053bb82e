/* workspace.c - one block of memory for all arrays of a layout. */
#include "formulations/workspace.h"

#include <stdlib.h>

base_status form_memory(void **mem, void (*layout)(void *, base_arena *), void *state,
                        base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(state, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "formulation: no memory for %zu bytes of contact space",
                     measure.used);
  }
  base_arena a = base_arena_over(*mem, measure.used);
  layout(state, &a);
  return BASE_OK;
}
