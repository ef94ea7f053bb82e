#include "formulations/formulation.h"

#include "form_list.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DECLARE_(name) extern const formulation form_##name;
FORM_LIST(DECLARE_)
#define ADDRESS_(name) &form_##name,
static const formulation *const all[] = {FORM_LIST(ADDRESS_) NULL};

const formulation *const *formulations(int *count) {
  *count = BASE_COUNT(all) - 1;
  return all;
}

const formulation *formulation_find(const char *name) {
  for (int i = 0; all[i] != NULL; i++) {
    if (strcmp(all[i]->name, name) == 0) {
      return all[i];
    }
  }
  return NULL;
}

formulation_friction formulation_friction_of(const formulation *f, int dim, const void *opt) {
  if (f->friction != NULL) {
    return f->friction(dim, opt);
  }
  const bool round = dim == 2 || (f->model & (FORM_CONE_EXACT | FORM_REGULARISED)) != 0;
  const bool lagged = (f->model & FORM_BOUNDS_LAGGED) != 0;
  return (formulation_friction){.most = (round ? 1.0 : sqrt(2.0)) * (lagged ? sqrt(2.0) : 1.0)};
}

const char *formulation_model_word(int bit) {
  static const char *const words[] = {
      "unilateral", "friction", "cone_exact",   "cone_polyhedral", "regularised", "bounds_lagged",
      "penalty",    "position", "acceleration", "no_lcp",          "normal_only"};
  return (bit >= 0 && bit < BASE_COUNT(words)) ? words[bit] : NULL;
}

void formulation_model_print(unsigned model, char *buf, size_t cap) {
  size_t used = 0;
  buf[0] = '\0';
  for (int i = 0; formulation_model_word(i) != NULL && used < cap; i++) {
    if ((model & 1u << i) != 0) {
      used += (size_t)snprintf(buf + used, cap - used, "%s%s", used > 0 ? " " : "",
                               formulation_model_word(i));
    }
  }
}

struct formulation_run {
  const formulation *form;
  const void *opt; /* borrowed */
  void *state;     /* owned */
};

base_status formulation_open(formulation_run **out, const formulation *f, const void *opt,
                             base_error *err) {
  *out = NULL;
  formulation_run *r = calloc(1, sizeof *r);
  void *state = calloc(1, f->state_size > 0 ? f->state_size : 1);
  if (r == NULL || state == NULL) {
    free(r);
    free(state);
    return BASE_FAIL(err, BASE_ENOMEM, "formulation %s: no memory for its state", f->name);
  }
  *r = (formulation_run){f, opt, state};
  const base_status s = (f->open != NULL) ? f->open(state, opt, err) : BASE_OK;
  if (s != BASE_OK) {
    formulation_close(r);
    return s;
  }
  *out = r;
  return BASE_OK;
}

void formulation_read_by(formulation_run *r, formulation_reader reader) {
  if (r->form->reader != 0) {
    *(formulation_reader *)((char *)r->state + r->form->reader) = reader;
  }
}

void formulation_close(formulation_run *r) {
  if (r != NULL) {
    if (r->form->close != NULL) {
      r->form->close(r->state);
    }
    free(r->state);
    free(r);
  }
}

/* The one test of `lacks`. */
static base_status refuse(const formulation *f, unsigned occurs, base_error *err) {
  const unsigned lacking = f->lacks & occurs;
  char words[160];
  if (lacking == 0) {
    return BASE_OK;
  }
  if ((lacking & FORM_COORDINATES) != 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s: needs bodies, the scene has generalised coordinates", f->name);
  }
  effects_print(lacking, words, sizeof words);
  return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: does not simulate %s", f->name, words);
}

base_status formulation_admits(const formulation *f, const world *w, base_error *err) {
  return refuse(f, world_occurring(w) | (world_has_coordinates(w) ? FORM_COORDINATES : 0u), err);
}

static base_status memory_of(const formulation_run *r, contact_memory **memory, base_error *err) {
  if (r->form->memory == 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: cannot come back to an earlier step",
                     r->form->name);
  }
  *memory = (contact_memory *)((char *)r->state + r->form->memory);
  return BASE_OK;
}

base_status formulation_keep(const formulation_run *r, contact_past *past, base_error *err) {
  contact_memory *m;
  BASE_TRY(memory_of(r, &m, err));
  return contact_memory_keep(m, past, err);
}

base_status formulation_recall(formulation_run *r, const contact_past *past, base_error *err) {
  contact_memory *m;
  BASE_TRY(memory_of(r, &m, err));
  return contact_memory_recall(m, past, err);
}

base_status formulation_changes(const formulation_run *r,
                                void (*tell)(void *of, uint64_t id, double by), void *of,
                                base_error *err) {
  contact_memory *m;
  BASE_TRY(memory_of(r, &m, err));
  contact_memory_changes(m, (r->form->model & FORM_BOUNDS_LAGGED) != 0, tell, of);
  return BASE_OK;
}

base_status formulation_take_over(formulation_run *r, const formulation *f, contact_past *past,
                                  base_error *err) {
  if (f != r->form && r->form->memory != 0) {
    contact_memory_strip(past);
  }
  return (r->form->memory != 0 && f != NULL) ? formulation_recall(r, past, err) : BASE_OK;
}

/* What the rows of a set show of its scene's effects. */
static unsigned effects_of_rows(const contact_set *c) {
  unsigned seen = (c->n_group > c->n_contact) ? EFFECT_JOINTS : 0u;
  for (int i = 0; i < c->n_contact; i++) {
    seen |= (c->rows[i].torsion > 0 ? EFFECT_TORSION : 0u) |
            (c->rows[i].rolling > 0 ? EFFECT_ROLLING : 0u);
  }
  return seen;
}

base_status formulation_begin(formulation_run *r, const contact_set *c, formulation_start start,
                              base_error *err) {
  if (r->form->lacks != 0) {
    BASE_TRY(refuse(r->form, effects_of_rows(c), err));
  }
  assert(contact_set_is_ordered(c));
  return r->form->begin(r->state, c, r->opt, start, err);
}

base_status formulation_assemble(formulation_run *r, lcp_problem *out, const double **z0,
                                 bool *pending, base_error *err) {
  BASE_TRY(r->form->assemble(r->state, out, z0, pending, err));
  assert(!*pending || lcp_problem_is_shaped(out));
  return BASE_OK;
}

base_status formulation_rows_of(const formulation_run *r, formulation_rows *out, base_error *err) {
  if (r->form->rows == NULL) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s: steps by itself, the rows of its problems have no contacts",
                     r->form->name);
  }
  r->form->rows(r->state, out);
  return BASE_OK;
}

base_status formulation_recover(formulation_run *r, const double *z, lcp_outcome claimed,
                                base_error *err) {
  return r->form->recover(r->state, z, claimed, err);
}

void formulation_answer_of(const formulation_run *r, formulation_answer *out) {
  r->form->answer(r->state, out);
}

base_status formulation_in_time(const formulation_solver *solver, const char *name, double t,
                                base_error *err) {
  const bool due = solver != NULL && solver->due != NULL && solver->due(solver->ctx);
  return due ? BASE_FAIL(err, BASE_EEXTERNAL, "%s: time is up at t=%g s", name, t) : BASE_OK;
}

base_status formulation_step(formulation_run *r, world *w, double h,
                             const formulation_solver *solver, formulation_answer *out,
                             base_error *err) {
  BASE_TRY(formulation_admits(r->form, w, err));
  return r->form->step(r->state, w, h, solver, out, err);
}
