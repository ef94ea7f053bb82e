#include "harness/control/extrapolation.h"

#include "harness/measure/trajectory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

base_status step_pair_open(step_pair *p, const sim *s, base_error *err) {
  const size_t n = world_saved_size(s->w);
  *p = (step_pair){0};
  BASE_TRY(checkpoint_open(&p->start, s, err));
  const size_t n_dof = (size_t)world_n_dof(s->w);
  p->coarse.state = malloc((5 * n + 2 * n_dof) * sizeof *p->coarse.state);
  if (p->coarse.state == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to compare steps");
  }
  p->fine.state = p->coarse.state + n;
  p->past = p->fine.state + n;
  p->coarse.law = p->past + 3 * n;
  p->fine.law = p->coarse.law + n_dof;
  return BASE_OK;
}

void step_pair_close(step_pair *p) {
  checkpoint_close(&p->start);
  free(p->coarse.state);
  free(p->load[0].pair);
  free(p->load[1].pair);
  *p = (step_pair){0};
}

/* Adds what the friction of the last step was beyond Coulomb's to that of the way. */
static void note_law(step_end *end, const sim *s) {
  const int n = world_n_dof(s->w);
  if (s->friction.bent && !end->friction.bent) {
    memset(end->law, 0, (size_t)n * sizeof *end->law);
  }
  for (int k = 0; s->friction.bent && k < n; k++) {
    end->law[k] += s->law[k];
  }
  end->friction.bent = end->friction.bent || s->friction.bent;
  end->friction.left = fmax(end->friction.left, s->friction.left);
}

/* `n` steps of h from where the run stands, the last one for the files of `last`. */
static base_status go(step_pair *p, sim *s, series *record, const sim_request *last, double h,
                      int n, step_end *end, base_error *err) {
  const run_status before = s->out->status;
  *end = (step_end){.state = end->state,
                    .law = end->law,
                    .closing.at = HUGE_VAL,
                    .stops = HUGE_VAL,
                    .good = true};
  for (int i = 0; i < n && end->good; i++) {
    bool taken;
    s->q = (i == n - 1) ? last : &p->quiet;
    BASE_TRY(sim_step(s, record, h, &taken, err));
    p->solved++;
    end->good = taken && s->out->status == before;
    end->mixed = end->mixed || (i > 0 && s->carrying.slips != end->carrying.slips);
    end->carrying = s->carrying;
    end->event = end->event || s->carrying.ids != p->carrying.ids;
    end->more = end->more || s->carrying.n > p->carrying.n;
    if (i == 0) {
      end->start = s->depth.start;
      end->closing = end->event ? s->struck : s->closing;
      end->stops = s->slip.stops;
      end->broke_at_once = s->slip.broke;
    }
    if (n == 2) {
      BASE_TRY(sim_loads_copy(&p->load[i], &s->loads, err));
    }
    end->doubt = fmax(end->doubt, s->doubt);
    note_law(end, s);
    end->pushed = fmax(end->pushed, s->slip.pushed);
    end->broke = fmax(end->broke, s->slip.broke);
    end->held = fmax(0.0, s->depth.held - end->start);
    end->even = fmax(0.0, s->depth.even - end->start);
    end->sunk = fmax(end->held, s->depth.open - end->start);
  }
  world_save(s->w, end->state);
  return BASE_OK;
}

base_status step_pair_begin(step_pair *p, sim *s, series *record, sim_carrying carrying, double h,
                            base_error *err) {
  const sim_request *q = s->q;
  p->quiet = *q;
  p->quiet.trajectory = NULL;
  p->quiet.dump = NULL;
  p->carrying = carrying;
  BASE_TRY(checkpoint_take(&p->start, s, record, err));
  s->part = true;
  const base_status done = go(p, s, record, &p->quiet, h, 1, &p->coarse, err);
  s->q = q;
  s->part = false;
  return done;
}

base_status step_pair_finish(step_pair *p, sim *s, series *record, double h, base_error *err) {
  const sim_request *q = s->q;
  BASE_TRY(checkpoint_return(&p->start, s, record, err));
  p->quiet.dump = q->dump;
  s->part = true;
  const base_status done = go(p, s, record, q, 0.5 * h, 2, &p->fine, err);
  s->q = q;
  s->part = false;
  return done;
}

base_status step_pair_try(step_pair *p, sim *s, series *record, sim_carrying carrying, double h,
                          base_error *err) {
  BASE_TRY(step_pair_begin(p, s, record, carrying, h, err));
  return step_pair_finish(p, s, record, h, err);
}

double step_pair_unsteady(const step_pair *p, const sim *s, double h) {
  const size_t n = world_saved_size(s->w);
  const saved_step before = {p->past_h, p->past, p->past + n, p->past + 2 * n};
  const saved_step now = {h, p->start.state, p->coarse.state, p->fine.state};
  return (p->past_h > 0.0) ? world_saved_unsteady(s->w, &before, &now) : HUGE_VAL;
}

void step_pair_keep(step_pair *p, const sim *s, double h, bool smooth) {
  const size_t n = world_saved_size(s->w);
  p->past_h = smooth ? h : 0.0;
  memcpy(p->past, p->start.state, n * sizeof *p->past);
  memcpy(p->past + n, p->coarse.state, 2 * n * sizeof *p->past);
}

base_status step_pair_undo(const step_pair *p, sim *s, series *record, base_error *err) {
  return checkpoint_return(&p->start, s, record, err);
}

base_status step_pair_extrapolate(const step_pair *p, sim *s, series *record, base_error *err) {
  const double stored =
      record->column[SERIES_ENERGY][record->n_row - 1] - world_energy(s->w); /* in springs [J] */
  world_extrapolate(s->w, p->coarse.state, p->fine.state);
  s->out->steps--;
  BASE_TRY(series_join(record, s->w, stored, err));
  return trajectory_row(s->q->trajectory, s->w, err);
}
