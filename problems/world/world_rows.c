/* world_rows.c - from detected points and joints to the groups, rows and Jacobians of a set. */
#include "lcp/base/crew.h"
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <float.h>
#include <stdlib.h>

base_status world_reserve_set(world *w, size_t n_group, size_t n_row, size_t n_jac,
                              base_error *err) {
  BASE_TRY(world_reserve(w, PER_GROUP, n_group, err));
  BASE_TRY(world_reserve(w, PER_ROW, n_row, err));
  return world_reserve(w, PER_JACOBIAN, n_jac, err);
}

static const body *side_body(const world *w, int side) {
  return (side >= 0 && side < w->n_body) ? &w->body[side] : NULL;
}

static double side_spin(const world *w, int side, int k) {
  const body *b = side_body(w, side);
  return (b != NULL) ? b->v[3 + k] : 0.0;
}

static int side_dofs(const world *w, int side) {
  const body *b = side_body(w, side);
  return (b != NULL) ? b->n_dof : 0;
}

/* The rows of one group being written. */
typedef struct row_at {
  int row; /* the next one, of the set */
  double h;
  const body *body[2]; /* NULL: a side without a body */
  double arm[2][3];    /* from its centre to where the side is felt */
  double *jac[2];      /* the next row of either side */
} row_at;

static row_at rows_of_group(const world *w, int group, const int side[2], double h) {
  const set_store *s = &w->store;
  const int first = s->row_start[group];
  row_at r = {.row = first, .h = h, .body = {side_body(w, side[0]), side_body(w, side[1])}};
  const int n0 = (r.body[0] != NULL) ? r.body[0]->n_dof : 0;
  r.jac[0] = s->jac + s->jac_start[group];
  r.jac[1] = r.jac[0] + (ptrdiff_t)(s->row_start[group + 1] - first) * n0;
  return r;
}

static void felt_at(row_at *r, const double *pa, const double *pb) {
  const double *p[2] = {pa, pb};
  for (int k = 0; k < 2; k++) {
    if (r->body[k] != NULL) {
      v3_sub(p[k], r->body[k]->at.x, r->arm[k]);
    }
  }
}

/* Writes  sign * d . (velocity of side k)  (angular: d . omega) into its next row and adds the parts
 * that no dof carries to the drift and to the velocity before the step. */
static void write_side(world *w, row_at *r, int k, double sign, const double *d, bool angular) {
  const body *b = r->body[k];
  if (b == NULL) {
    return;
  }
  double full[6] = {0};
  if (angular) {
    v3_scale(sign, d, full + 3);
  } else {
    v3_scale(sign, d, full);
    v3_cross(r->arm[k], full, full + 3);
  }
  double *jac = r->jac[k];
  if (b->n_dof == 6) { /* every axis, in order */
    memcpy(jac, full, sizeof full);
  } else {
    for (int i = 0; i < b->n_dof; i++) {
      jac[i] = full[b->axis[i]];
    }
  }
  r->jac[k] = jac + b->n_dof;
  double before = 0.0;
  for (int i = 0; i < 6; i++) {
    before += full[i] * b->v[i];
  }
  w->store.u_before[r->row] += before;
  if (b->driven) {
    double v[6];
    body_driven(b, w->t + r->h, v);
    for (int i = 0; i < 6; i++) {
      w->store.u_drift[r->row] += full[i] * v[i];
    }
  }
}

static void write_row(world *w, row_at *r, const double *d, bool angular) {
  w->store.u_drift[r->row] = 0.0;
  w->store.u_before[r->row] = 0.0;
  write_side(w, r, 0, 1.0, d, angular);
  write_side(w, r, 1, -1.0, d, angular);
  r->row++;
}

/* The arm of a ball lies along the normal: its moment is zero, and not what rounding leaves of it. */
static void write_normal(world *w, row_at *r, const double *n) {
  double arm[2][3];
  memcpy(arm, r->arm, sizeof arm);
  for (int k = 0; k < 2; k++) {
    if (r->body[k] != NULL && r->body[k]->round) {
      v3_scale(0.0, r->arm[k], r->arm[k]);
    }
  }
  write_row(w, r, n, false);
  memcpy(r->arm, arm, sizeof arm);
}

/* Without the spatial effect all motion is in a plane: one tangent, one rolling axis. */
static bool in_plane(const world *w) {
  return w->dim == 2 || !world_has(w, EFFECT_SPATIAL);
}

/* Tangents: planar t = n turned by -90 degrees (n up: t along +x); spatial t1 = world x projected
 * on the contact plane, world y where x is nearly normal, t2 = n x t1. Motion in the x-z plane of space has t1 in that
 * plane, y x n, wherever n points. */
static void tangents(const world *w, double *frame) {
  const double *n = frame;
  double *t1 = frame + 3, *t2 = frame + 6;
  if (w->dim == 2) {
    t1[0] = n[1], t1[1] = -n[0], t1[2] = 0.0;
    t2[0] = t2[1] = t2[2] = 0.0;
    return;
  }
  const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
  if (in_plane(w) && hypot(n[0], n[2]) > 0.0) {
    v3_cross(y, n, t1);
  } else {
    const double *e = (fabs(n[0]) < 1.0 - 1e-6) ? x : y;
    v3_add_scaled(e, -v3_dot(e, n), n, t1);
  }
  v3_scale(1.0 / v3_norm(t1), t1, t1);
  v3_cross(n, t1, t2);
}

static contact_rows rows_of(const world *w, const contact_item *c) {
  contact_rows r = {0};
  if (world_has(w, EFFECT_FRICTION) &&
      (pair_value(&w->mu, c->a, c->b) > 0.0 || pair_value(&w->mu_kinetic, c->a, c->b) > 0.0)) {
    r.tangent = in_plane(w) ? 1 : 2;
  }
  if (!world_has(w, EFFECT_ROTATION)) {
    return r;
  }
  if (world_has(w, EFFECT_TORSION) && !in_plane(w) && pair_value(&w->torsion, c->a, c->b) > 0.0) {
    r.torsion = 1;
  }
  if (world_has(w, EFFECT_ROLLING) && pair_value(&w->rolling, c->a, c->b) > 0.0) {
    r.rolling = in_plane(w) ? 1 : 2;
  }
  return r;
}

/* Index of a side among the bodies with dofs, -1. */
static int group_side(const world *w, int side) {
  const body *b = side_body(w, side);
  return (b != NULL) ? b->index : -1;
}

/* Of a side's surface; a body of several pieces has one for each. */
static double side_compliance(const world *w, int side, int part) {
  if (side >= w->n_body) {
    return w->spec.fixed[side - w->n_body].compliance;
  }
  const spec_body *b = &w->spec.body[side];
  const double own = (b->shape.n_part > 0) ? b->shape.part[part].compliance : 0.0;
  return (own > 0.0) ? own : b->compliance;
}

/* Springs in series add; half of the sum, so that two surfaces of 1 make a contact of 1. */
static double compliance_of(const world *w, const contact_item *c) {
  const int pieces = (int)(c->id >> (ID_FEATURE_BITS + ID_COPY_BITS));
  const int mask = (1 << ID_PIECE_BITS) - 1;
  return 0.5 * side_compliance(w, c->a, pieces >> ID_PIECE_BITS & mask) +
         0.5 * side_compliance(w, c->b, pieces & mask);
}

static void fill_contact(world *w, const contact_item *c, int i, double h) {
  set_store *s = &w->store;
  const contact_rows r = s->rows[i];
  const int side[2] = {c->a, c->b};
  double *frame = s->frame + 9 * (ptrdiff_t)i;
  static const double z[3] = {0, 0, 1};
  v3_copy(c->n, frame);
  tangents(w, frame);
  v3_copy(c->x, s->point + 3 * (ptrdiff_t)i);
  s->id[i] = c->id;
  s->gap[i] = c->gap;
  s->mu_static[i] = (r.tangent > 0) ? pair_value(&w->mu, c->a, c->b) : 0.0;
  s->mu_kinetic[i] = (r.tangent > 0) ? pair_value(&w->mu_kinetic, c->a, c->b) : 0.0;
  s->mu_torsion[i] = (r.torsion > 0) ? pair_value(&w->torsion, c->a, c->b) : 0.0;
  s->mu_rolling[i] = (r.rolling > 0) ? pair_value(&w->rolling, c->a, c->b) : 0.0;
  s->restitution[i] = pair_value(&w->restitution, c->a, c->b);
  s->compliance[i] = w->compliant ? compliance_of(w, c) : 1.0;
  double *spin = s->spin + 3 * (ptrdiff_t)i;
  for (int k = 0; k < 3; k++) {
    spin[k] = 0.5 * (side_spin(w, c->a, k) + side_spin(w, c->b, k));
  }
  const int first = s->row_start[i];
  row_at at = rows_of_group(w, i, side, h);
  felt_at(&at, c->x, c->x);
  write_normal(w, &at, frame);
  for (int k = 0; k < r.tangent; k++) {
    write_row(w, &at, frame + 3 + 3 * (ptrdiff_t)k, false);
  }
  if (r.torsion > 0) {
    write_row(w, &at, frame, true);
  }
  if (r.rolling == 1) { /* about the normal of the plane of motion */
    write_row(w, &at, (w->dim == 2) ? z : frame + 6, true);
  }
  for (int k = 0; r.rolling == 2 && k < 2; k++) {
    write_row(w, &at, frame + 3 + 3 * (ptrdiff_t)k, true);
  }
  if (c->b >= w->n_body && world_has(w, EFFECT_MOTION)) { /* belts */
    const double *belt = w->spec.fixed[c->b - w->n_body].surface_velocity;
    for (int k = 0; k <= r.tangent; k++) {
      const double u = v3_dot(frame + 3 * (ptrdiff_t)k, belt);
      s->u_drift[first + k] -= u;
      s->u_before[first + k] -= u;
    }
  }
}

/* Can any dof move this row? Rows that none can are not posed. */
static bool row_moves(const world *w, const joint_data *j, const joint_row *r) {
  const int side[2] = {j->a, j->b};
  for (int s = 0; s < 2; s++) {
    const body *b = side_body(w, side[s]);
    for (int k = 0; b != NULL && k < b->n_dof; k++) {
      const int axis = b->axis[k];
      double arm[3], turn[3];
      v3_sub((s == 0) ? r->p_a : r->p_b, b->at.x, arm);
      v3_cross(arm, r->d, turn);
      const double value = (axis < 3) ? (r->angular ? 0.0 : r->d[axis])
                                      : (r->angular ? r->d[axis - 3] : turn[axis - 3]);
      if (value != 0.0) {
        return true;
      }
    }
  }
  return false;
}

int joint_rows_posed(const world *w, const joint_data *j, joint_row *row) {
  const int n = joint_rows(w, j, row);
  int kept = 0;
  for (int k = 0; k < n; k++) {
    if (row_moves(w, j, &row[k])) {
      row[kept++] = row[k];
    }
  }
  return kept;
}

static void fill_joint(world *w, const joint_data *j, int group, double h) {
  set_store *s = &w->store;
  joint_row row[JOINT_ROWS_MAX];
  const int n = joint_rows_posed(w, j, row), side[2] = {j->a, j->b};
  row_at at = rows_of_group(w, group, side, h);
  for (int k = 0; k < n; k++) {
    const int own = at.row - s->row_start[w->set.n_contact];
    s->joint_error[own] = row[k].error;
    s->joint_curve[own] = row[k].curve;
    felt_at(&at, row[k].p_a, row[k].p_b);
    write_row(w, &at, row[k].d, row[k].angular);
  }
}

/* Appends a group of `rows` rows between two sides to the index arrays (capacity is there). */
static void add_group(world *w, int *group, int a, int b, int rows) {
  set_store *s = &w->store;
  const int g = (*group)++;
  int *side = s->group_body + (ptrdiff_t)2 * g;
  side[0] = group_side(w, a);
  side[1] = group_side(w, b);
  s->row_start[g + 1] = s->row_start[g] + rows;
  s->jac_start[g + 1] = s->jac_start[g] + rows * (side_dofs(w, a) + side_dofs(w, b));
}

static base_status index_groups(world *w, int *n_group, base_error *err) {
  set_store *s = &w->store;
  joint_row row[JOINT_ROWS_MAX];
  BASE_TRY(world_reserve(w, PER_GROUP, (size_t)(s->n_item + w->n_joint), err));
  s->row_start[0] = 0;
  s->jac_start[0] = 0;
  int g = 0;
  for (int i = 0; i < s->n_item; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const contact_rows r = rows_of(w, c);
    s->rows[i] = r;
    if (s->jac_start[g] > INT32_MAX - 6 * 12) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "contact set: %d contacts overflow the indices", i);
    }
    add_group(w, &g, c->a, c->b, 1 + r.tangent + r.torsion + r.rolling);
  }
  w->set.n_contact = s->n_item;
  for (int i = 0; i < w->n_joint; i++) {
    const int rows = joint_rows_posed(w, &w->joint[i], row);
    if (rows > 0) {
      add_group(w, &g, w->joint[i].a, w->joint[i].b, rows);
    }
  }
  *n_group = g;
  return world_reserve_set(w, (size_t)g, (size_t)s->row_start[g], (size_t)s->jac_start[g], err);
}

/* A gap is a difference of two positions, each rounded where it stands. */
static double noise_of_gaps(const world *w) {
  double far = 0;
  for (int i = 0; i < w->store.n_item; i++) {
    for (int k = 0; k < 3; k++) {
      far = fmax(far, fabs(w->store.item[i].x[k]));
    }
  }
  return 2 * DBL_EPSILON * far;
}

enum { SHARE = 64 }; /* contacts of one part of the work */

typedef struct filling {
  world *w;
  double h;
} filling;

static void fill_contacts(void *of, int part, int hand) {
  const filling *f = of;
  const set_store *s = &f->w->store;
  (void)hand;
  for (int i = part * SHARE; i < base_part_end(part, s->n_item, SHARE); i++) {
    fill_contact(f->w, &s->item[s->key[i].item], i, f->h);
  }
}

base_status world_assemble(world *w, double h, base_error *err) {
  set_store *s = &w->store;
  joint_row row[JOINT_ROWS_MAX];
  int g = 0;
  BASE_TRY(index_groups(w, &g, err));
  filling f = {w, h};
  base_share(base_parts(s->n_item, SHARE), fill_contacts, &f);
  int group = s->n_item;
  for (int i = 0; i < w->n_joint; i++) {
    if (joint_rows_posed(w, &w->joint[i], row) > 0) {
      fill_joint(w, &w->joint[i], group++, h);
    }
  }
  w->set.noise = noise_of_gaps(w);
  w->set.n_group = g;
  w->set.n_row = s->row_start[g];
  return BASE_OK;
}
