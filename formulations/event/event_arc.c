#include "formulations/event/event_arc.h"

#include "lcp/linear/lapack_status.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest force at hand: less is rounding of the problem that chose the contacts. */
static const double force_tol = 1e-8;
static const double rank_tol = 1e-11; /* singular directions of redundant contacts */
/* delta over the largest diagonal entry, and that of friction over it: what redundancy leaves open is 1e-10 noise, and
 * each iteration takes four digits of delta away. */
static const double spring = 1e-6, friction_share = 1e-2;
enum { CORRECTIONS = 100, TURNS = 50 };
static const double settled = 1e-13;   /* a direction of sliding [1] */
static const double slowly = 1e-3;     /* an acceleration, beside what friction could do [1] */
static const double corrected = 1e-12; /* what delta may still hold, of the right side */
/* Where speeds of rounding are taken out, a direction that is nearly redundant would magnify them. */
static const double settle_rank_tol = 1e-8;

void arc_close(arc *a) {
  free(a->contact);
  free(a->mem);
  *a = (arc){0};
}

base_status arc_reserve(arc *a, int n_contact, base_error *err) {
  if (n_contact > a->cap) {
    arc_contact *more = realloc(a->contact, (size_t)n_contact * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", n_contact);
    }
    a->contact = more;
    a->cap = n_contact;
  }
  return BASE_OK;
}

/* Work arrays of one evaluation: m unknowns over n rows. */
typedef struct work {
  double *A, *b, *C, *lambda; /* m*m, m, n*n, n */
  double *x, *delta;          /* m */
  int *row;                   /* m: row of its contact; */
  int *of;                    /* m: contact in the list */
  lapack_int *pivot;          /* m */
} work;

static base_status reserve_work(arc *a, size_t m, size_t n, work *w, base_error *err) {
  const size_t doubles = m * m + 3 * m + n * n + n, ints = 3 * m;
  const size_t need = doubles + (ints * sizeof(lapack_int)) / sizeof(double) + 4;
  if (need > a->cap_mem) {
    free(a->mem);
    a->mem = malloc(2 * need * sizeof *a->mem);
    a->cap_mem = (a->mem != NULL) ? 2 * need : 0;
    if (a->mem == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %zu contact rows", m);
    }
  }
  double *d = a->mem;
  lapack_int *i = (lapack_int *)(void *)(d + doubles);
  double *x = d + m * m + m + n * n + n;
  *w = (work){.A = d,
              .b = d + m * m,
              .C = d + m * m + m,
              .lambda = d + m * m + m + n * n,
              .x = x,
              .delta = x + m,
              .row = i,
              .of = i + m,
              .pivot = i + 2 * m};
  return BASE_OK;
}

static int find(const arc *a, uint64_t id) {
  for (int i = 0; i < a->n; i++) {
    if (a->contact[i].id == id) {
      return i;
    }
  }
  return -1;
}

double arc_across(const arc_contact *k) {
  return fabs(k->u[2] * k->direction[0] - k->u[1] * k->direction[1]);
}

/* Gaps and velocities of the listed contacts, which alone take part. */
static void read_set(arc *a) {
  const contact_set *c = &a->set;
  int taking_part = 0;
  for (int i = 0; i < a->n; i++) {
    a->contact[i].present = false;
  }
  for (int g = 0; g < c->n_contact; g++) {
    const int i = find(a, c->id[g]);
    const double *u = c->u_before + c->row_start[g];
    a->space->gap[g] = (i < 0) ? 1.0 : 0.0;
    if (i < 0) {
      continue;
    }
    arc_contact *k = &a->contact[i];
    k->present = true;
    k->at = taking_part++;
    k->gap = c->gap[g];
    for (int r = 0; r < 3; r++) {
      k->u[r] = (r <= c->rows[g].tangent) ? u[r] : 0.0;
    }
    const double slip = hypot(k->u[1], k->u[2]);
    const bool rests = k->stick || (k->held && slip <= a->slow);
    k->mu = (c->rows[g].tangent > 0) ? (rests ? c->mu_static[g] : c->mu_kinetic[g]) : 0.0;
    const double along = k->u[1] * k->direction[0] + k->u[2] * k->direction[1];
    /* beyond the instant at which it turns round, which is an event, it keeps its side */
    if (!k->stick && !k->follows && slip > a->slow && along > 0.0) {
      k->direction[0] = k->u[1] / slip;
      k->direction[1] = k->u[2] / slip;
    }
  }
}

/* Unknowns: the normal of every contact, the tangents of sticking ones; settling, of all that start at
 * rest. */
static size_t number(const arc *a, bool settling, work *w) {
  size_t m = 0;
  for (int i = 0; i < a->n; i++) {
    const arc_contact *k = &a->contact[i];
    const bool rests = k->stick || (settling && k->starts);
    const int rows = !k->present ? 0 : (rests ? form_rows_of(&a->space->a, k->at) : 1);
    for (int r = 0; r < rows; r++, m++) {
      if (w != NULL) {
        w->row[m] = r;
        w->of[m] = i;
      }
    }
  }
  return m;
}

/* Adds the forces of contact k that unknown `row` at value f stands for to lambda. */
static void spread(const arc *a, const arc_contact *k, int row, double f, double *lambda) {
  const form_assembly *s = &a->space->a;
  double *own = lambda + s->row[k->at];
  own[row] += f;
  for (int t = 0; !k->stick && t < form_rows_of(s, k->at) - 1; t++) {
    own[1 + t] -= k->mu * k->direction[t] * f;
  }
}

/* Baumgarte's terms of row r of contact k. */
static double stabilised(const arc *a, const arc_contact *k, int r) {
  const double s = a->rate;
  return (r == 0) ? 2.0 * s * k->u[0] + s * s * k->gap : s * k->u[r];
}

/* The equations for what is added to the forces at the start of the arc. */
static void fill(arc *a, size_t m, const work *w) {
  const form_assembly *s = &a->space->a;
  const size_t n = (size_t)s->n_row;
  form_assembly_dense(s, w->C);
  for (size_t i = 0; i < m; i++) {
    const arc_contact *k = &a->contact[w->of[i]];
    w->b[i] = -(s->r[s->row[k->at] + w->row[i]] + stabilised(a, k, w->row[i]));
  }
  memset(w->x, 0, m * sizeof *w->x);
  for (size_t j = 0; j < m; j++) {
    const arc_contact *own = &a->contact[w->of[j]];
    memset(w->lambda, 0, n * sizeof *w->lambda);
    spread(a, own, w->row[j], 1.0, w->lambda);
    for (size_t i = 0; i < m; i++) {
      const size_t row = (size_t)s->row[a->contact[w->of[i]].at] + (size_t)w->row[i];
      double sum = 0.0;
      for (int r = s->row[own->at]; r < s->row[own->at + 1]; r++) {
        sum += w->C[(size_t)r * n + row] * w->lambda[r];
      }
      w->A[j * m + i] = sum;
      w->b[i] -= sum * own->start[w->row[j]];
      w->x[i] += fabs(sum * own->start[w->row[j]]);
    }
  }
  a->load = 0.0;
  for (size_t i = 0; i < m; i++) {
    a->load = fmax(a->load, w->x[i]);
  }
}

static base_status not_solved(lapack_int info, base_error *err) {
  return BASE_FAIL(err, lin_lapack_status(info), "event: contact equations could not be solved");
}

/* The least-norm solution of A x = b, in b. */
static base_status solve(size_t m, double tol, const work *w, base_error *err) {
  const lapack_int n = (lapack_int)m;
  lapack_int rank = 0;
  memset(w->pivot, 0, m * sizeof *w->pivot);
  const lapack_int info =
      (m > 0) ? LAPACKE_dgelsy(LAPACK_COL_MAJOR, n, n, 1, w->A, n, w->b, n, w->pivot, tol, &rank)
              : 0;
  return (info != 0) ? not_solved(info, err) : BASE_OK;
}

/* Of the contact of unknown j. */
static double soft_of(const arc *a, const work *w, size_t j) {
  const int at = a->contact[w->of[j]].at;
  return form_soft(&a->set, a->space->a.group[at], a->distribution);
}

/* The forces that springs share (MATHEMATICS 2.8): with delta on the diagonal, normal forces from zero, those
 * of sticking friction from the start of the arc, and the proximal iteration until delta has gone. b, in the
 * place of what is wanted of the correction, becomes the correction. Where a stiffness is so small beside the others
 * that the iteration does not end, the forces are those nearest to the start of the arc, and that counts. */
static base_status share(arc *a, size_t m, const work *w, base_error *err) {
  const lapack_int n = (lapack_int)m;
  double most = 0.0, enough = 0.0, carried = 0.0, most_soft = 0.0;
  memcpy(w->C, w->A, m * m * sizeof *w->C); /* which has been read */
  for (size_t j = 0; j < m; j++) {
    most = fmax(most, w->A[j * m + j]);
    enough = fmax(enough, corrected * fabs(w->b[j]));
    carried = fmax(carried, fabs(w->A[j * m + j] * a->contact[w->of[j]].start[w->row[j]]));
    most_soft = fmax(most_soft, soft_of(a, w, j));
    w->x[j] = 0.0;
  }
  /* b is what the forces of the start leave of the loads: it is known to their rounding, of which friction that can take the place of
   * a normal force makes more in the row of that */
  enough = fmax(enough, (double)m * DBL_EPSILON * carried / friction_share);
  for (size_t j = 0; j < m; j++) {
    const double share = (w->row[j] == 0) ? soft_of(a, w, j) / most_soft : friction_share;
    w->delta[j] = share * spring * most;
    w->A[j * m + j] += w->delta[j];
    if (w->row[j] == 0) { /* the correction of a normal force is anchored at no force at all */
      w->x[j] = -a->contact[w->of[j]].start[0];
    }
  }
  const lapack_int info =
      (m > 0) ? LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, w->A, n, w->pivot) : 0;
  if (info != 0) {
    return not_solved(info, err);
  }
  double *old = w->lambda, left = HUGE_VAL;
  for (int k = 0; k < CORRECTIONS && left > enough && m > 0; k++) {
    left = 0.0;
    memcpy(old, w->x, m * sizeof *old);
    for (size_t j = 0; j < m; j++) {
      w->x[j] = w->b[j] + w->delta[j] * w->x[j];
    }
    (void)LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, 'N', n, 1, w->A, n, w->pivot, w->x, n);
    for (size_t j = 0; j < m; j++) {
      left = fmax(left, w->delta[j] * fabs(w->x[j] - old[j]));
    }
  }
  if (left > enough && m > 0) {
    a->unshared++;
    a->distribution = FORM_EXTREME; /* to the end of the arc, whose forces would jump otherwise */
    memcpy(w->A, w->C, m * m * sizeof *w->A);
    return solve(m, rank_tol, w, err);
  }
  memcpy(w->b, w->x, m * sizeof *w->b);
  return BASE_OK;
}

/* Forces, accelerations and what tangents are accelerated by, for the directions that stand. */
static base_status solve_forces(arc *a, size_t m, const work *w, base_error *err) {
  form_assembly *s = &a->space->a;
  fill(a, m, w);
  BASE_TRY((a->distribution != FORM_EXTREME) ? share(a, m, w, err) : solve(m, rank_tol, w, err));
  memset(w->lambda, 0, (size_t)s->n_row * sizeof *w->lambda);
  for (size_t j = 0; j < m; j++) {
    const arc_contact *k = &a->contact[w->of[j]];
    spread(a, k, w->row[j], k->start[w->row[j]] + w->b[j], w->lambda);
  }
  double *rate = w->C; /* C has been read */
  form_assembly_velocity(s, w->lambda, rate);
  for (int i = 0; i < a->n; i++) {
    arc_contact *k = &a->contact[i];
    memset(k->force, 0, sizeof k->force);
    memset(k->rate, 0, sizeof k->rate);
    if (k->present) {
      memcpy(k->force, w->lambda + s->row[k->at],
             (size_t)form_rows_of(s, k->at) * sizeof *k->force);
      memcpy(k->rate, rate + s->row[k->at] + 1,
             (size_t)(form_rows_of(s, k->at) - 1) * sizeof *k->rate);
    }
  }
  form_assembly_answer(s, w->lambda);
  return BASE_OK;
}

/* c mu f of a contact with two tangents, c the mean of what friction does to them [m/s^2]. */
static double friction_alone(const arc *a, const arc_contact *k) {
  const double *own = form_own_block(&a->space->a, k->at);
  return 0.5 * (own[4] + own[8]) * k->mu * k->force[0];
}

bool arc_begins_slowly(const arc *a, const arc_contact *k) {
  return k->present && form_rows_of(&a->space->a, k->at) >= 3 &&
         hypot(k->rate[0], k->rate[1]) < slowly * friction_alone(a, k);
}

/* d <- (a_t + c mu f d) / |...| of the contacts that slide where they are accelerated to: a contraction with a_t parallel to d
 * at its fixed point. Returns whether a direction moved. */
static bool follow(arc *a) {
  bool moved = false;
  for (int i = 0; i < a->n; i++) {
    arc_contact *k = &a->contact[i];
    if (!k->follows || k->stick || !k->present || form_rows_of(&a->space->a, k->at) < 3) {
      continue;
    }
    const double hold = friction_alone(a, k);
    const double d[2] = {k->rate[0] + hold * k->direction[0], k->rate[1] + hold * k->direction[1]};
    const double size = hypot(d[0], d[1]);
    if (!(size > 0.0)) {
      continue;
    }
    for (int t = 0; t < 2; t++) {
      moved = moved || fabs(d[t] / size - k->direction[t]) > settled;
      k->direction[t] = d[t] / size;
    }
  }
  return moved;
}

base_status arc_forces(arc *a, double *acc, base_error *err) {
  form_assembly *s = &a->space->a;
  BASE_TRY(world_contacts_curved(a->w, a->probe, a->margin, &a->set, err));
  BASE_TRY(world_acceleration(a->w, acc, err));
  BASE_TRY(space_reserve(a->space, &a->set, err));
  read_set(a);
  BASE_TRY(space_forces(a->space, &a->set, acc, err));
  work w = {0};
  const size_t m = number(a, false, NULL);
  BASE_TRY(reserve_work(a, m, (size_t)s->n_row, &w, err));
  (void)number(a, false, &w);
  bool turned = true;
  for (int k = 0; turned && k < TURNS; k++) {
    a->evaluations++;
    BASE_TRY(solve_forces(a, m, &w, err));
    turned = follow(a);
  }
  a->unsettled += turned;
  memcpy(acc, s->v_next, (size_t)a->set.n_dof * sizeof *acc);
  return BASE_OK;
}

/* The largest force at hand. */
static double largest_force(const arc *a) {
  double largest = 0.0;
  for (int i = 0; i < a->n; i++) {
    largest = fmax(largest, fmax(fabs(a->contact[i].force[0]), a->contact[i].start[0]));
  }
  return largest;
}

bool arc_slips(const arc *a, const arc_contact *k) {
  const double beyond = hypot(k->force[1], k->force[2]) - k->mu * k->force[0];
  return k->stick && beyond > force_tol * largest_force(a);
}

bool arc_carries(const arc *a) {
  const double least = -force_tol * largest_force(a);
  for (int i = 0; i < a->n; i++) {
    const arc_contact *k = &a->contact[i];
    if (!k->present || k->force[0] < least || arc_slips(a, k)) {
      return false;
    }
  }
  return true;
}

base_status arc_settle(arc *a, double *v, base_error *err) {
  form_assembly *s = &a->space->a;
  BASE_TRY(world_contacts(a->w, a->probe, a->margin, &a->set, err));
  BASE_TRY(space_reserve(a->space, &a->set, err));
  read_set(a);
  BASE_TRY(space_impact(a->space, &a->set, err));
  work w = {0};
  const size_t m = number(a, true, NULL), n = (size_t)s->n_row;
  BASE_TRY(reserve_work(a, m, n, &w, err));
  (void)number(a, true, &w);
  form_assembly_dense(s, w.C);
  for (size_t i = 0; i < m; i++) {
    const size_t row = (size_t)s->row[a->contact[w.of[i]].at] + (size_t)w.row[i];
    w.b[i] = -s->r[row];
    for (size_t j = 0; j < m; j++) {
      w.A[j * m + i] = w.C[(size_t)(s->row[a->contact[w.of[j]].at] + w.row[j]) * n + row];
    }
  }
  BASE_TRY(solve(m, settle_rank_tol, &w, err));
  memset(w.lambda, 0, n * sizeof *w.lambda);
  for (size_t i = 0; i < m; i++) {
    w.lambda[s->row[a->contact[w.of[i]].at] + w.row[i]] = w.b[i];
  }
  form_assembly_answer(s, w.lambda);
  memcpy(v, s->v_next, (size_t)a->set.n_dof * sizeof *v);
  return BASE_OK;
}
