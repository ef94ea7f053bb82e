#include "harness/control/checkpoint.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

base_status checkpoint_open(checkpoint *c, const sim *s, base_error *err) {
  *c = (checkpoint){.state = malloc(world_saved_size(s->w) * sizeof *c->state),
                    .out = malloc(sizeof *c->out)};
  if (s->sleeps) {
    c->asleep = malloc((world_sleep_size(s->w) + 1) * sizeof *c->asleep);
  }
  return (c->state != NULL && c->out != NULL && (c->asleep != NULL || !s->sleeps))
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory to keep the state of a run");
}

static size_t result_size(const sim_result *r) {
  return offsetof(sim_result, part) + (size_t)r->n_part * sizeof *r->part;
}

base_status checkpoint_take(checkpoint *c, const sim *s, const series *record, base_error *err) {
  BASE_TRY(formulation_keep(s->form, &c->past, err));
  BASE_TRY(contact_memory_keep(&s->own.memory, &c->own, err));
  world_save(s->w, c->state);
  if (c->asleep != NULL) {
    world_sleep_save(s->w, c->asleep);
    BASE_TRY(sim_asleep_copy(&c->of_asleep, &s->asleep, err));
  }
  memcpy(c->out, s->out, result_size(s->out));
  c->held = s->held;
  c->carrying = s->carrying;
  c->goes_on = s->goes_on;
  c->n_row = record->n_row;
  return BASE_OK;
}

base_status checkpoint_return(const checkpoint *c, sim *s, series *record, base_error *err) {
  BASE_TRY(formulation_recall(s->form, &c->past, err));
  BASE_TRY(contact_memory_recall(&s->own.memory, &c->own, err));
  if (c->asleep != NULL) {
    BASE_TRY(world_sleep_load(s->w, c->asleep, err));
    BASE_TRY(sim_asleep_copy(&s->asleep, &c->of_asleep, err));
  }
  world_load(s->w, c->state); /* behind who sleeps, whose axes do not move */
  const sim_result spent = *s->out;
  memcpy(s->out, c->out, result_size(c->out));
  s->out->time = spent.time;
  s->out->work = spent.work;
  s->out->n_solves = spent.n_solves;
  s->out->n_modes = spent.n_modes;
  s->out->n_fallbacks = spent.n_fallbacks;
  s->out->n_evaluations = spent.n_evaluations;
  s->out->workspace = spent.workspace;
  s->out->step_longest = spent.step_longest;
  s->held = c->held;
  s->carrying = c->carrying;
  s->goes_on = c->goes_on;
  record->n_row = c->n_row;
  return BASE_OK;
}

void checkpoint_close(checkpoint *c) {
  free(c->state);
  free(c->out);
  contact_memory_drop(&c->past);
  contact_memory_drop(&c->own);
  sim_asleep_close(&c->of_asleep);
  free(c->asleep);
  *c = (checkpoint){0};
}
