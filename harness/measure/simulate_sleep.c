/* simulate_sleep.c - bodies that lie still sleep until something reaches them; what is known of their contacts is kept. */
#include "harness/measure/simulate_state.h"

base_status sim_asleep_copy(sim_asleep *to, const sim_asleep *from, base_error *err) {
  if (to->change == from->change) {
    return BASE_OK;
  }
  BASE_TRY(contact_memory_copy(&from->past, &to->past, err));
  to->energy = from->energy;
  to->resting.n = 0;
  for (int i = 0; i < from->resting.n; i++) {
    BASE_TRY(series_resting_add(&to->resting, &from->resting.force[i], err));
  }
  to->change = from->change;
  return BASE_OK;
}

void sim_asleep_close(sim_asleep *a) {
  contact_memory_drop(&a->past);
  series_resting_close(&a->resting);
}

bool sim_may_sleep(const sim *s) {
  const sim_request *q = s->q;
  return q->sleep && s->iterates && q->form->form->memory != 0 && q->combinations == NULL &&
         q->spec->model == NULL;
}

static bool contact_sleeps(const void *of, uint64_t id) {
  return world_contact_sleeps(of, id);
}

static bool contact_is_awake(const void *of, uint64_t id) {
  return !world_contact_sleeps(of, id);
}

/* The forces of contacts that have just fallen asleep go on. */
static base_status note_forces(sim *s, const contact_set *set, const double *impulse,
                               base_error *err) {
  for (int i = 0; impulse != NULL && i < set->n_contact; i++) {
    if (world_contact_sleeps(s->w, set->id[i])) {
      const series_force f = series_force_of(set, impulse, i);
      BASE_TRY(series_resting_add(&s->asleep.resting, &f, err));
    }
  }
  return BASE_OK;
}

static void stir(void *of, uint64_t id) {
  world_stir(of, id);
}

/* Those that lay still, on contacts whose springs and bounds of friction did not change, either. */
static base_status fall_asleep(sim *s, const double *shift, base_error *err) {
  static const double alike = 1e-9; /* of the largest normal impulse */
  s->slept = false;
  if (!world_count_still(s->w, shift)) {
    return BASE_OK;
  }
  BASE_TRY(formulation_unlike(s->form, alike, stir, s->w, err));
  return world_fall_asleep(s->w, &s->slept, err);
}

base_status sim_fall_asleep(sim *s, const contact_set *set, const formulation_answer *a,
                            base_error *err) {
  sim_result *r = s->out;
  if (!s->sleeps) {
    return BASE_OK;
  }
  BASE_TRY(fall_asleep(s, a->shift, err));
  if (s->slept) {
    BASE_TRY(formulation_keep(s->form, &s->awake, err));
    BASE_TRY(contact_memory_move(&s->awake, &s->asleep.past, contact_sleeps, s->w, err));
    BASE_TRY(formulation_recall(s->form, &s->awake, err));
    BASE_TRY(note_forces(s, set, a->impulse, err));
    s->asleep.change = ++s->n_change;
    s->asleep.energy = contact_memory_energy(&s->asleep.past);
    s->carrying = sim_carrying_of(s, set, a);
  }
  const int n = world_n_asleep(s->w);
  r->n_asleep += n;
  r->n_asleep_max = (n > r->n_asleep_max) ? n : r->n_asleep_max;
  return BASE_OK;
}

base_status sim_wake(sim *s, bool all, base_error *err) {
  series_resting *r = &s->asleep.resting;
  int n = 0;
  if (all && world_n_asleep(s->w) == 0) {
    return BASE_OK;
  }
  BASE_TRY(world_wake(s->w, all, err));
  BASE_TRY(formulation_keep(s->form, &s->awake, err));
  BASE_TRY(contact_memory_move(&s->asleep.past, &s->awake, contact_is_awake, s->w, err));
  for (int i = 0; i < r->n; i++) {
    if (world_contact_sleeps(s->w, r->force[i].id)) {
      r->force[n++] = r->force[i];
    }
  }
  r->n = n;
  s->asleep.change = ++s->n_change;
  s->asleep.energy = contact_memory_energy(&s->asleep.past);
  return formulation_recall(s->form, &s->awake, err);
}
