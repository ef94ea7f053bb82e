/* Between two steps of a run: other effects, another formulation and solver, or bodies that fall asleep or wake, from where it is. */
#include "harness/measure/simulate_state.h"

#include <stdlib.h>
#include <string.h>

void sim_ask_admission(sim *s) {
  base_error refusal = {0};
  if (formulation_admits(s->q->form->form, s->w, &refusal) != BASE_OK) {
    sim_refuse(s, RUN_UNSUPPORTED, refusal.text);
  }
}

base_status sim_open_formulation(sim *s, base_error *err) {
  const sim_request *q = s->q;
  const lcp_solver *by = q->solver->solver;
  formulation_close(s->form);
  s->form = NULL;
  BASE_TRY(formulation_open(&s->form, q->form->form, q->form->opt, err));
  formulation_read_by(s->form, (formulation_reader){by->sets, by->by_factors, by->newton});
  return BASE_OK;
}

/* Formulation and solver stay: their workspaces follow the rows of every step, and memory is by contact. */
base_status sim_change_effects(sim *s, unsigned effects, base_error *err) {
  if (s->q->form->form->memory == 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: has no memory to go on with other effects",
                     s->q->form->form->name);
  }
  BASE_TRY(world_set_effects(s->w, effects, err));
  const int n_dof = world_n_dof(s->w);
  s->effects = effects;
  s->out->n_dof = (n_dof > s->out->n_dof || s->out->steps == 0) ? n_dof : s->out->n_dof;
  sim_ask_admission(s);
  return BASE_OK;
}

static bool same_solver(const solver_choice *a, const solver_choice *b) {
  return a->solver == b->solver && strcmp(a->config, b->config) == 0;
}

/* What keeps more than its contacts' memory, or other memory, cannot be begun anew where it was: it goes on. */
static bool goes_on(const formulation_choice *a, const formulation_choice *b) {
  return a->form == b->form && a->form->memory == 0 && strcmp(a->config, b->config) == 0;
}

base_status sim_change_combination(sim *s, const formulation_choice *form,
                                   const solver_choice *solver, base_error *err) {
  const formulation *last = s->q->form->form;
  const bool on = goes_on(s->q->form, form);
  if (last->memory != 0) {
    BASE_TRY(formulation_keep(s->form, &s->past, err));
    s->past_of = last;
  } else {
    contact_memory_settle(&s->past);
  }
  if (!same_solver(s->q->solver, solver)) {
    lcp_instance_close(s->instance);
    lcp_islands_close(s->islands);
    s->instance = NULL;
    s->islands = NULL;
  }
  s->changed = *s->q;
  s->changed.form = form;
  s->changed.solver = solver;
  s->q = &s->changed;
  s->iterates = (form->form->model & FORM_NO_LCP) == 0;
  if (!on) {
    BASE_TRY(sim_open_formulation(s, err));
    BASE_TRY(formulation_take_over(s->form, s->past_of, &s->past, err));
  }
  sim_ask_admission(s);
  return BASE_OK;
}

/* What follows is counted for the next combination. */
static void begin_part(sim_result *r) {
  r->part[r->n_part++] = (sim_part){.status = RUN_OK,
                                    .verified = true,
                                    .steps_before = r->steps,
                                    .solves_before = r->n_solves,
                                    .unsolved_before = r->n_unsolved,
                                    .work_before = r->work,
                                    .time_before = r->time};
}

base_status sim_follow_plans(sim *s, base_error *err) {
  const sim_request *q = s->q;
  const long steps = s->out->steps;
  if (q->combinations != NULL) {
    const combination_span *c = combination_plan_at(q->combinations, steps);
    if (&c->form != q->form) {
      begin_part(s->out);
      BASE_TRY(sim_change_combination(s, &c->form, &c->solver, err));
    }
  }
  const unsigned effects = (q->plan != NULL) ? effects_plan_at(q->plan, steps) : s->effects;
  if (effects == s->effects) {
    return BASE_OK;
  }
  BASE_TRY(sim_change_effects(s, effects, err));
  return sim_wake(s, true, err);
}

/* ---- bodies that sleep ----------------------------------------------------------------------- */

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

static void stir(void *of, uint64_t id, double by) {
  world_stir(of, id, by);
}

/* Those that lay still, on contacts whose springs and bounds of friction did not change, either. */
static base_status fall_asleep(sim *s, const double *shift, base_error *err) {
  if (!world_count_still(s->w, shift)) {
    return BASE_OK;
  }
  BASE_TRY(formulation_changes(s->form, stir, s->w, err));
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
    s->goes_on = sim_carrying_of(s, set, a);
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
