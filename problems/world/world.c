/* world.c - opening, stepping and closing a world. */
#include "problems/world/world.h"

#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <assert.h>
#include <stdlib.h>

static const int bodies_max = (1 << ID_SIDE_BITS) - 1;

static base_status check_spec(const scene_spec *s, base_error *err) {
  if (s->n_body + s->n_static > bodies_max) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "scene %.64s: at most %d bodies and half-spaces",
                     s->id, bodies_max);
  }
  if (s->contact_multiplicity < 1 || s->contact_multiplicity > SPEC_COPIES) {
    return BASE_FAIL(err, BASE_EINVAL, "scene %.64s: contact_multiplicity must be 1 to %d", s->id,
                     SPEC_COPIES);
  }
  for (int i = 0; i < s->n_body; i++) {
    if (shape_pieces(&s->body[i].shape) > (1 << ID_PIECE_BITS)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "body %.32s: at most %d pieces", s->body[i].name,
                       1 << ID_PIECE_BITS);
    }
  }
  return BASE_OK;
}

static base_status fill_tables(world *w, const name_index *names, base_error *err) {
  const scene_spec *s = &w->spec;
  const struct {
    pair_table *table;
    const spec_coefficient *from;
  } all[] = {
      {&w->mu, &s->friction},
      {&w->mu_kinetic, (s->friction_kinetic.dflt < 0.0) ? &s->friction : &s->friction_kinetic},
      {&w->restitution, &s->restitution},
      {&w->rolling, &s->rolling},
      {&w->torsion, &s->torsion}};
  for (int i = 0; i < BASE_COUNT(all); i++) {
    const spec_coefficient *c = all[i].from;
    BASE_TRY(pair_table_open(all[i].table, names, c->dflt, c->pair, c->n_pair, err));
  }
  BASE_TRY(pair_table_open(&w->apart, names, 0.0, s->no_collision, s->n_no_collision, err));
  for (int i = 0; i < w->apart.n; i++) {
    w->apart.entry[i].value = 1.0;
  }
  return BASE_OK;
}

static base_status open_tables(world *w, base_error *err) {
  name_index names;
  BASE_TRY(name_index_open(&names, &w->spec, err));
  const base_status status = fill_tables(w, &names, err);
  name_index_close(&names);
  return status;
}

static bool is_centred_ball(const piece *p) {
  return p->kind == PIECE_POINT && p->vertex[0] == 0.0 && p->vertex[1] == 0.0 &&
         p->vertex[2] == 0.0;
}

/* Of a point that may turn: its inertia has a size, where it has none. */
static double gyration_of(const world *w, const spec_body *s) {
  const bool turns =
      (w->spec.effects & EFFECT_ROTATION) != 0 && (~s->lock & (unsigned)SPEC_ROT) != 0;
  double most = 0.0;
  for (int k = 0; k < ((w->dim == 3) ? 3 : 1); k++) {
    most = fmax(most, s->inertia[k]);
  }
  return (turns && s->mass > 0.0) ? sqrt(most / s->mass) : 0.0;
}

static base_status open_pieces(world *w, base_error *err) {
  int n_vertex = 0;
  w->n_piece = 0;
  for (int i = 0; i < w->n_body; i++) {
    w->n_piece += shape_pieces(&w->spec.body[i].shape);
    n_vertex += shape_vertices(&w->spec.body[i].shape, w->dim);
  }
  BASE_TRY(world_reserve(w, PER_PIECE, (size_t)w->n_piece, err));
  BASE_TRY(world_reserve(w, PER_VERTEX, (size_t)n_vertex, err));
  double *vertex = w->vertex;
  int first = 0;
  for (int i = 0; i < w->n_body; i++) {
    body *b = &w->body[i];
    b->first_piece = first;
    b->n_piece = shape_pieces(&w->spec.body[i].shape);
    shape_split(&w->spec.body[i].shape, w->dim, w->piece + first, &vertex);
    b->round = b->n_piece == 1 && is_centred_ball(&w->piece[first]);
    b->bound = 0.0;
    for (int k = 0; k < b->n_piece; k++) {
      b->bound = fmax(b->bound, piece_bound(&w->piece[first + k]));
    }
    b->bound = (b->bound > 0.0) ? b->bound : gyration_of(w, &w->spec.body[i]);
    first += b->n_piece;
  }
  return BASE_OK;
}

/* Scale of tolerances: the smallest extended body; a scene of points: the distance they cover. */
static double size_of(const world *w) {
  double size = HUGE_VAL, path = 0.0;
  for (int i = 0; i < w->n_body; i++) {
    const double r = w->body[i].bound;
    if (r > 0.0) {
      size = fmin(size, r);
    }
    path = fmax(path, v3_norm(w->body[i].v) * w->spec.duration);
  }
  if (size < HUGE_VAL) {
    return size;
  }
  path = fmax(path, 0.5 * v3_norm(w->spec.gravity) * w->spec.duration * w->spec.duration);
  return (path > 0.0) ? path : 1.0;
}

/* Numbers the dofs; returns the entries of all mass blocks. */
static size_t number_dofs(world *w) {
  size_t n_mass = 0;
  w->n_free = 0;
  w->n_dof = 0;
  for (int i = 0; i < w->n_body; i++) {
    body *b = &w->body[i];
    b->index = (b->n_dof > 0) ? w->n_free : -1;
    b->dof = w->n_dof;
    w->n_dof += b->n_dof;
    n_mass += (size_t)b->n_dof * b->n_dof;
    w->n_free += b->n_dof > 0;
  }
  return n_mass;
}

/* Sizes the arrays that depend on the dofs and fills the offsets. */
static base_status open_dofs(world *w, base_error *err) {
  set_store *s = &w->store;
  const size_t n_mass = number_dofs(w);
  BASE_TRY(world_reserve(w, PER_MOVING, (size_t)w->n_free, err));
  BASE_TRY(world_reserve(w, PER_MASS, n_mass, err));
  BASE_TRY(world_reserve(w, PER_DOF, (size_t)w->n_dof, err));
  s->dof_start[0] = 0;
  s->mass_start[0] = 0;
  for (int i = 0, k = 0; i < w->n_body; i++) {
    const int m = w->body[i].n_dof;
    if (m > 0) {
      w->free_body[k] = i;
      s->dof_start[k + 1] = s->dof_start[k] + m;
      s->mass_start[k + 1] = s->mass_start[k] + m * m;
      k++;
    }
  }
  return BASE_OK;
}

static bool is_compliant(const scene_spec *s) {
  bool differs = false;
  for (int i = 0; i < s->n_body; i++) {
    const spec_shape *shape = &s->body[i].shape;
    differs = differs || s->body[i].compliance != 1.0;
    for (int k = 0; k < shape->n_part; k++) {
      differs = differs || (shape->part[k].compliance != 0.0 && shape->part[k].compliance != 1.0);
    }
  }
  for (int i = 0; i < s->n_static; i++) {
    differs = differs || s->fixed[i].compliance != 1.0;
  }
  return differs;
}

/* The state at t = 0. */
static base_status start(world *w, base_error *err) {
  if (w->model != NULL) {
    model_start(w);
    return BASE_OK;
  }
  w->n_asleep = 0;
  for (int i = 0; i < w->n_body; i++) {
    body *b = &w->body[i];
    body_start(b, &w->spec.body[i], w->dim, w->effects);
    b->n_dof = (b->sleeps != 0) ? 0 : b->n_dof;
    w->n_asleep += b->sleeps != 0;
  }
  w->compliant = is_compliant(&w->spec);
  w->size = size_of(w);
  BASE_TRY(open_dofs(w, err));
  assert(world_finite(w)); /* of a spec that was checked */
  return joints_start(w, err);
}

static base_status open_parts(world *w, base_error *err) {
  BASE_TRY(check_spec(&w->spec, err));
  BASE_TRY(world_reserve(w, PER_BODY, (size_t)w->n_body, err));
  memset(w->body, 0, (size_t)w->n_body * sizeof *w->body);
  BASE_TRY(world_reserve(w, PER_JOINT, (size_t)w->spec.n_joint, err));
  BASE_TRY(open_tables(w, err));
  BASE_TRY(open_pieces(w, err));
  BASE_TRY(loads_check(w, err));
  return start(w, err);
}

static base_status open_world(world **out, const scene_spec *spec, bool borrows, unsigned effects,
                              base_error *err) {
  *out = NULL;
  world *w = calloc(1, sizeof *w);
  if (w == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "scene %.64s: no memory for its world", spec->id);
  }
  w->friction_reach = 1.0;
  base_status status = BASE_OK;
  w->borrows = borrows;
  if (borrows) {
    w->spec = *spec;
  } else {
    status = spec_copy(spec, &w->spec, err);
  }
  if (status == BASE_OK) {
    w->dim = spec->dim;
    w->effects = effects;
    w->model = spec->model;
    w->n_body = (spec->model != NULL) ? 0 : spec->n_body;
    status = (w->model != NULL) ? model_open(w, err) : open_parts(w, err);
  }
  if (status != BASE_OK) {
    world_close(w);
    return status;
  }
  *out = w;
  return BASE_OK;
}

base_status world_open(world **out, const scene_spec *spec, unsigned effects, base_error *err) {
  return open_world(out, spec, false, effects, err);
}

base_status world_open_over(world **out, const scene_spec *spec, unsigned effects,
                            base_error *err) {
  return open_world(out, spec, true, effects, err);
}

base_status world_renumber(world *w, base_error *err) {
  double *state = malloc(world_saved_size(w) * sizeof *state);
  if (state == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "scene %.64s: no memory to keep its state", w->spec.id);
  }
  world_save(w, state);
  const base_status done = start(w, err);
  world_load(w, state);
  world_still_locked(w);
  free(state);
  return done;
}

base_status world_set_effects(world *w, unsigned effects, base_error *err) {
  const unsigned before = w->effects;
  w->effects = effects;
  const base_status done = world_renumber(w, err);
  w->effects = (done == BASE_OK) ? effects : before;
  return done;
}

void world_close(world *w) {
  if (w == NULL) {
    return;
  }
  world_release(w);
  broad_close(&w->broad);
  base_gather_close(&w->found);
  pair_table *const tables[] = {&w->mu,      &w->mu_kinetic, &w->restitution,
                                &w->rolling, &w->torsion,    &w->apart};
  for (int i = 0; i < BASE_COUNT(tables); i++) {
    pair_table_close(tables[i]);
  }
  if (!w->borrows) {
    spec_free(&w->spec);
  }
  free(w);
}

/* ---- one step ------------------------------------------------------------------------------ */

/* Fills the views; arrays of effects that are off are NULL. */
static void view_set(world *w, double h, contact_set *c) {
  const set_store *s = &w->store;
  const bool turns = world_has(w, EFFECT_ROTATION) || w->model != NULL;
  c->dim = w->dim;
  c->h = h;
  c->t = w->t;
  c->tol = 1e-9 * w->size;
  c->n_body = w->n_free;
  c->n_dof = w->n_dof;
  c->dof_start = s->dof_start;
  c->mass_start = s->mass_start;
  c->mass = s->mass;
  c->inv_mass = s->inv_mass;
  c->v = s->v;
  c->v_free = s->v_free;
  c->row_start = s->row_start;
  c->body = s->group_body;
  c->jac_start = s->jac_start;
  c->jac = s->jac;
  c->u_drift = s->u_drift;
  c->u_before = s->u_before;
  c->id = s->id;
  c->rows = s->rows;
  c->gap = s->gap;
  c->mu_static = s->mu_static;
  c->mu_kinetic = s->mu_kinetic;
  c->mu_torsion = (world_has(w, EFFECT_TORSION) && turns) ? s->mu_torsion : NULL;
  c->mu_rolling = (world_has(w, EFFECT_ROLLING) && turns) ? s->mu_rolling : NULL;
  c->restitution = world_has(w, EFFECT_RESTITUTION) ? s->restitution : NULL;
  c->compliance = w->compliant ? s->compliance : NULL;
  c->frame = s->frame;
  c->spin = turns ? s->spin : NULL;
  c->joint_error = (c->n_group > c->n_contact) ? s->joint_error : NULL;
}

base_status world_contacts(world *w, double h, double margin, contact_set *out, base_error *err) {
  if (!(h > 0.0) || !isfinite(h)) {
    return BASE_FAIL(err, BASE_EINVAL, "step: need a finite h > 0, got %g", h);
  }
  w->h = h;
  if (w->model != NULL) {
    BASE_TRY(model_contacts(w, h, margin, err));
  } else {
    BASE_TRY(world_free_motion(w, h, err));
    BASE_TRY(world_detect(w, h, margin, err));
    BASE_TRY(world_assemble(w, h, err));
  }
  view_set(w, h, &w->set);
  assert(contact_set_is_ordered(&w->set));
  *out = w->set;
  return BASE_OK;
}

void world_note_impulses(world *w, const double *impulse) {
  const size_t bytes = (size_t)w->set.n_row * sizeof *impulse;
  if (w->set.n_row > 0) {
    (void)((impulse != NULL) ? memcpy(w->store.impulse, impulse, bytes)
                             : memset(w->store.impulse, 0, bytes));
  }
}

void world_shift(world *w, const double *shift) {
  for (int i = 0; i < w->n_body && w->model == NULL; i++) {
    body_shift(&w->body[i], w->dim, w->h, shift);
  }
}

base_status world_advance(world *w, const double *v_next, const double *impulse, base_error *err) {
  if (!(w->h > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "advance: no contact set was asked for yet");
  }
  world_note_impulses(w, impulse);
  w->t += w->h;
  if (w->model != NULL) {
    for (int k = 0; k < w->n_dof; k++) {
      w->qv[k] = v_next[k];
      w->q[k] += w->h * v_next[k];
    }
    return BASE_OK;
  }
  for (int i = 0; i < w->n_body; i++) {
    body_set_velocity(&w->body[i], v_next, w->t);
    body_move(&w->body[i], w->dim, w->h);
  }
  return BASE_OK;
}

double world_time(const world *w) {
  return w->t;
}

unsigned world_effects(const world *w) {
  return w->effects;
}

unsigned world_occurring(const world *w) {
  return w->effects & (w->model != NULL ? w->spec.effects : w->spec.present);
}

bool world_has_coordinates(const world *w) {
  return w->model != NULL;
}

int world_n_dof(const world *w) {
  return w->n_dof;
}
