/* simulate_sleep.c - bodies that lie still sleep until something reaches them; what the formulation remembers of their contacts is kept. */
#include "harness/measure/simulate_state.h"

static bool asks_for_forces(const scene_spec *spec) {
  bool asks = false;
  for (int i = 0; i < spec->n_check && !asks; i++) {
    asks = spec->check[i].kind == CHECK_CONTACT_FORCE ||
           spec->check[i].kind == CHECK_CONTACT_FORCE_SUM;
  }
  return asks;
}

bool sim_may_sleep(const sim *s) {
  const sim_request *q = s->q;
  return q->sleep && s->iterates && q->form->form->memory != 0 && q->combinations == NULL &&
         q->spec->model == NULL && !asks_for_forces(q->spec);
}

static bool sleeps(const void *of, uint64_t id) {
  return world_contact_sleeps(of, id);
}

static bool is_awake(const void *of, uint64_t id) {
  return !world_contact_sleeps(of, id);
}

base_status sim_fall_asleep(sim *s, const contact_set *set, const formulation_answer *a,
                            base_error *err) {
  sim_result *r = s->out;
  s->slept = false;
  if (!s->sleeps) {
    return BASE_OK;
  }
  BASE_TRY(world_fall_asleep(s->w, a->shift, &s->slept, err));
  if (s->slept) {
    BASE_TRY(formulation_keep(s->form, &s->now, err));
    BASE_TRY(contact_memory_move(&s->now, &s->dream, sleeps, s->w, err));
    s->carrying = sim_carrying_of(s, set, a);
  }
  const int n = world_n_asleep(s->w);
  r->n_asleep += n;
  r->n_asleep_max = (n > r->n_asleep_max) ? n : r->n_asleep_max;
  return BASE_OK;
}

base_status sim_wake(sim *s, base_error *err) {
  BASE_TRY(world_wake(s->w, err));
  BASE_TRY(formulation_keep(s->form, &s->now, err));
  BASE_TRY(contact_memory_move(&s->dream, &s->now, is_awake, s->w, err));
  return formulation_recall(s->form, &s->now, err);
}
