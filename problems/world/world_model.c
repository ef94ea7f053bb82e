/* world_model.c - a world of generalised coordinates (problems/world/model.h): one block of dofs against
 * the ground. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

static base_status model_check(const mech_model *m, base_error *err) {
  if (m->n_dof < 1 || m->n_dof > MODEL_DOF_MAX || m->n_contact < 0 ||
      (m->dim != 2 && m->dim != 3)) {
    return BASE_FAIL(err, BASE_EINVAL, "model %s: needs 1 to %d dofs, dim 2 or 3", m->name,
                     MODEL_DOF_MAX);
  }
  return BASE_OK;
}

base_status model_open(world *w, base_error *err) {
  const mech_model *m = w->model;
  set_store *s = &w->store;
  BASE_TRY(model_check(m, err));
  const size_t n = (size_t)m->n_dof;
  w->dim = m->dim;
  w->n_free = 1;
  w->n_dof = m->n_dof;
  w->size = 1.0; /* gaps in [m] of an unknown mechanism: 1e-9 m counts as closed */
  BASE_TRY(world_reserve(w, PER_MOVING, 1, err));
  BASE_TRY(world_reserve(w, PER_MASS, n * n, err));
  BASE_TRY(world_reserve(w, PER_DOF, n, err));
  s->dof_start[0] = s->mass_start[0] = 0;
  s->dof_start[1] = m->n_dof;
  s->mass_start[1] = m->n_dof * m->n_dof;
  model_start(w);
  return BASE_OK;
}

void model_start(world *w) {
  w->model->start(w->spec.model_param, w->q, w->qv);
}

/* A = L L', lower triangle by columns; false if A is not positive definite. */
static bool cholesky(const double *A, int n, double *L) {
  for (int j = 0; j < n; j++) {
    for (int i = j; i < n; i++) {
      double s = A[j * n + i];
      for (int k = 0; k < j; k++) {
        s -= L[k * n + i] * L[k * n + j];
      }
      if (i == j && !(s > 0.0)) {
        return false;
      }
      L[j * n + i] = (i == j) ? sqrt(s) : s / L[j * n + j];
    }
  }
  return true;
}

/* x = (L L')^-1 e_c */
static void inverse_column(const double *L, int n, int c, double *x) {
  for (int i = 0; i < n; i++) {
    double s = (i == c) ? 1.0 : 0.0;
    for (int k = 0; k < i; k++) {
      s -= L[k * n + i] * x[k];
    }
    x[i] = s / L[i * n + i];
  }
  for (int i = n - 1; i >= 0; i--) {
    double s = x[i];
    for (int k = i + 1; k < n; k++) {
      s -= L[i * n + k] * x[k];
    }
    x[i] = s / L[i * n + i];
  }
}

static bool invert_spd(const double *A, int n, double *inv) {
  double L[MODEL_DOF_MAX * MODEL_DOF_MAX];
  if (!cholesky(A, n, L)) {
    return false;
  }
  for (int c = 0; c < n; c++) {
    inverse_column(L, n, c, inv + (ptrdiff_t)c * n);
  }
  return true;
}

base_status model_acceleration(world *w, double *a, base_error *err) {
  const mech_model *m = w->model;
  set_store *s = &w->store;
  const int n = m->n_dof;
  double f[MODEL_DOF_MAX];
  m->mass(w->spec.model_param, w->q, s->mass);
  if (!invert_spd(s->mass, n, s->inv_mass)) {
    return BASE_FAIL(err, BASE_EINVAL, "model %s: mass matrix is not positive definite at t = %g",
                     m->name, w->t);
  }
  m->force(w->spec.model_param, w->t, w->q, w->qv, f);
  for (int i = 0; i < n; i++) {
    a[i] = 0.0;
    for (int j = 0; j < n; j++) {
      a[i] += s->inv_mass[j * n + i] * f[j];
    }
  }
  return BASE_OK;
}

static base_status free_motion(world *w, double h, base_error *err) {
  set_store *s = &w->store;
  double a[MODEL_DOF_MAX] = {0};
  BASE_TRY(model_acceleration(w, a, err));
  for (int i = 0; i < w->model->n_dof; i++) {
    s->v[i] = w->qv[i];
    s->v_free[i] = w->qv[i] + h * a[i];
  }
  return BASE_OK;
}

/* Largest gap change in the step by the speeds before and after the free motion. */
static double reach(const world *w, const double *jn, double h) {
  double before = 0.0, after = 0.0;
  for (int k = 0; k < w->n_dof; k++) {
    before += jn[k] * w->store.v[k];
    after += jn[k] * w->store.v_free[k];
  }
  return 1.5 * h * fmax(fabs(before), fabs(after));
}

/* Where the contact is drawn: the numbers of a model do not need it. */
static void set_place(const world *w, int i, double *point, double *frame) {
  static const double upright[9] = {0, 1, 0, 1, 0, 0, 0, 0, 0};
  static const double upright3[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  memcpy(frame, (w->dim == 2) ? upright : upright3, sizeof upright);
  memset(point, 0, 3 * sizeof *point);
  if (w->model->place != NULL) {
    w->model->place(w->spec.model_param, w->q, i, point, frame, frame + 3);
  }
}

static void add_contact(world *w, int i, double gap, const double *jac, const mech_contact *m) {
  set_store *s = &w->store;
  const int n = w->n_dof, c = w->set.n_contact;
  const bool rough = world_has(w, EFFECT_FRICTION) && m->mu > 0.0;
  const int rows = rough ? w->dim : 1;
  s->rows[c] = (contact_rows){.tangent = (unsigned char)(rows - 1)};
  s->id[c] = (uint64_t)i << ID_COPY_BITS;
  s->gap[c] = gap;
  s->mu_static[c] = rough ? m->mu : 0.0;
  s->mu_kinetic[c] = s->mu_static[c];
  s->mu_torsion[c] = s->mu_rolling[c] = 0.0;
  s->restitution[c] = m->restitution;
  memset(s->spin + 3 * (ptrdiff_t)c, 0, 3 * sizeof(double));
  set_place(w, i, s->point + 3 * (ptrdiff_t)c, s->frame + 9 * (ptrdiff_t)c);
  int *side = s->group_body + (ptrdiff_t)2 * c;
  side[0] = 0;
  side[1] = -1;
  memcpy(s->jac + s->jac_start[c], jac, (size_t)(rows * n) * sizeof *jac);
  for (int r = 0; r < rows; r++) {
    double u = 0.0;
    for (int k = 0; k < n; k++) {
      u += jac[r * n + k] * s->v[k];
    }
    s->u_before[s->row_start[c] + r] = u;
    s->u_drift[s->row_start[c] + r] = 0.0;
  }
  s->row_start[c + 1] = s->row_start[c] + rows;
  s->jac_start[c + 1] = s->jac_start[c] + rows * n;
  w->set.n_contact++;
}

base_status model_contacts(world *w, double h, double margin, base_error *err) {
  const mech_model *m = w->model;
  const size_t most = (size_t)m->n_contact, rows = most * (size_t)w->dim;
  double jac[3 * MODEL_DOF_MAX] = {0};
  BASE_TRY(free_motion(w, h, err));
  BASE_TRY(world_reserve_set(w, most, rows, rows * (size_t)m->n_dof, err));
  w->set.n_contact = 0;
  w->store.row_start[0] = 0;
  w->store.jac_start[0] = 0;
  for (int i = 0; world_has(w, EFFECT_CONTACT) && i < m->n_contact; i++) {
    mech_contact c = {0};
    double gap;
    m->contact(w->spec.model_param, i, &c);
    m->gap(w->spec.model_param, w->q, i, &gap, jac, jac + m->n_dof);
    if (gap < ((margin >= 0.0) ? margin : reach(w, jac, h) + 1e-6 * w->size)) {
      add_contact(w, i, gap, jac, &c);
    }
  }
  w->set.n_group = w->set.n_contact;
  w->set.n_row = w->store.row_start[w->set.n_contact];
  return BASE_OK;
}

double model_min_gap(const world *w) {
  double best = HUGE_VAL, jac[3 * MODEL_DOF_MAX];
  for (int i = 0; i < w->model->n_contact; i++) {
    double gap;
    w->model->gap(w->spec.model_param, w->q, i, &gap, jac, jac + w->n_dof);
    best = fmin(best, gap);
  }
  return best;
}

double model_energy(const world *w, bool kinetic_only) {
  const mech_model *m = w->model;
  double M[MODEL_DOF_MAX * MODEL_DOF_MAX] = {0}, T = 0.0;
  m->mass(w->spec.model_param, w->q, M);
  for (int i = 0; i < m->n_dof * m->n_dof; i++) {
    T += 0.5 * M[i] * w->qv[i % m->n_dof] * w->qv[i / m->n_dof];
  }
  if (kinetic_only || m->potential == NULL) {
    return T;
  }
  return T + m->potential(w->spec.model_param, w->t, w->q);
}

bool model_observe(const world *w, const char *var, double *value) {
  for (int k = 0; k < w->n_dof; k++) {
    const char *name = w->model->dof_name[k];
    const size_t len = strlen(name);
    if (strncmp(var, name, len) != 0) {
      continue;
    }
    if (var[len] == '\0' || strcmp(var + len, ".v") == 0) {
      *value = (var[len] == '\0') ? w->q[k] : w->qv[k];
      return true;
    }
  }
  return false;
}
