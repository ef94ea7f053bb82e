/* lcp_share_rows.c - which rows are active, and how: facets, cones, boxes, and islands at rest. */
#include "lcp/lcp_column.h"
#include "lcp/lcp_share_state.h"

/* ---- facets ---------------------------------------------------------------------------------- */

typedef struct facets {
  int first, count, speed; /* unknowns: facets, then the slip speed of the part */
} facets;

static facets facets_of(const lcp_block *b, int part) {
  facets f = {.first = b->start + 1, .speed = b->start + b->size - b->n_part + part};
  for (int k = 0; k < part; k++) {
    f.first += b->part_dim[k];
  }
  f.count = b->part_dim[part];
  return f;
}

static bool is_faceted(const lcp_block *b) {
  return b->set == LCP_ORTHANT && b->n_part > 0;
}

/* Coefficient of the slip speed in the rows of its facets; one value for all of them. */
static double speed_unit(const lcp_share *s, facets f) {
  const lcp_column c = lcp_column_of(&s->M, f.speed);
  for (int k = 0; k < c.count; k++) {
    const int row = lcp_column_row(&c, k);
    if (row >= f.first && row < f.first + f.count) {
      return c.val[k];
    }
    if (c.row == NULL && row < f.first) { /* dense: straight to the row */
      k = f.first - 1;
    }
  }
  return 0;
}

/* A part without friction impulse: its slip speed is the least that its facets allow, and the facet that allows no
 * less is the one against the motion. `moves`: these two enter the system, else they are slack. */
static void settle_speed(lcp_share *s, facets f, bool moves) {
  const double unit = speed_unit(s, f);
  const double had = s->z[f.speed];
  double least = 0;
  int against = -1;
  for (int i = f.first; i < f.first + f.count; i++) {
    const double need = (unit > 0) ? had - s->w[i] / unit : 0;
    if (need > least) {
      least = need;
      against = i;
    }
    s->rows.kind[i] = SHARE_FIXED;
    s->z[i] = 0;
  }
  s->z[f.speed] = least;
  for (int i = f.first; i < f.first + f.count; i++) {
    s->w[i] += unit * (least - had);
  }
  const bool slips = moves && against >= 0 && unit * least > LCP_SHARE_TOUCHING * s->size[against];
  s->rows.kind[f.speed] = slips ? SHARE_ACTIVE : SHARE_FIXED;
  if (slips) {
    s->rows.kind[against] = SHARE_ACTIVE;
  } else if (moves) {
    s->z[f.speed] = 0;
  }
}

/* ---- cones ----------------------------------------------------------------------------------- */

static double length(const double *x, int n) {
  return (n == 1) ? fabs(x[0]) : sqrt(x[0] * x[0] + x[1] * x[1]);
}

/* Friction of the part at `row` against the unit vector d, linearised in d = w_t/|w_t| at the present point; where the
 * part does not move d stands still. A slow slip is nearly a stick, and its rows are scaled as one. */
static void slip_along(lcp_share *s, const lcp_block *b, int row, int dim, double mu,
                       const double *d, double speed) {
  share_rows *r = &s->rows;
  const double own = (s->diagonal[row] > 0) ? s->diagonal[row] : 1;
  const double turn = (dim == 2 && speed > 0) ? mu * fmax(s->z[b->start], 0.0) / speed : 0;
  const double scale = own / (1 + own * turn);
  for (int k = 0; k < dim; k++) {
    r->kind[row + k] = SHARE_SLIP;
    r->own[row + k] = scale;
    r->pull[row + k] = scale * mu * d[k];
    for (int m = 0; m < dim; m++) {
      r->gain[2 * (row + k) + m] = scale * turn * ((k == m ? 1.0 : 0.0) - d[k] * d[m]);
    }
  }
}

/* A part of a cone at the present point. */
typedef struct share_part {
  int row, dim;
  double mu, normal, speed, force;
  bool moves;
} share_part;

static share_part part_at(const lcp_share *s, const lcp_block *b, int k, int row) {
  share_part p = {.row = row, .dim = b->part_dim[k], .mu = b->part_mu[k], .normal = s->z[b->start]};
  p.speed = length(s->w + row, p.dim);
  p.force = length(s->z + row, p.dim);
  p.moves = p.speed > 100 * LCP_SHARE_ROW_TOL * s->size[row];
  return p;
}

static bool part_slips(const lcp_share *s, const share_part *p) {
  if (p->mu == 0) {
    return true;
  }
  if (s->rows.kind[p->row] != SHARE_SLIP) {
    return (p->speed > LCP_SHARE_TOUCHING * s->size[p->row] &&
            p->force >= (1 - 1e-6) * p->mu * p->normal) ||
           p->force >
               p->mu * p->normal * (1 + 1e-9) + LCP_SHARE_ROW_TOL * lcp_share_scale(s, p->row);
  }
  double along = 0; /* friction that drives has changed sides */
  for (int m = 0; m < p->dim; m++) {
    along -= s->z[p->row + m] * s->w[p->row + m];
  }
  return !p->moves || along > 0 || p->normal <= 0;
}

static bool stick_part(lcp_share *s, const share_part *p) {
  const bool changed = s->rows.kind[p->row] != SHARE_ACTIVE;
  for (int m = 0; m < p->dim; m++) {
    s->rows.kind[p->row + m] = SHARE_ACTIVE;
  }
  return changed;
}

static bool slip_part(lcp_share *s, const lcp_block *b, const share_part *p) {
  const double *u = s->w + p->row, *l = s->z + p->row;
  double d[2] = {0}, off = 0;
  for (int m = 0; m < p->dim; m++) {
    d[m] = p->moves ? u[m] / p->speed : (p->force > 0 ? -l[m] / p->force : 0);
    off = fmax(off, p->moves ? fabs(l[m] + p->mu * p->normal * d[m]) : 0);
  }
  if (s->rows.kind[p->row] == SHARE_SLIP &&
      off <= LCP_SHARE_ROW_TOL * fmax(p->mu * p->normal, lcp_share_scale(s, p->row))) {
    return false; /* the factor at hand is of this direction */
  }
  slip_along(s, b, p->row, p->dim, p->mu, d, p->moves ? p->speed : 0);
  return true;
}

/* Stick or slip of every part from the present z and w; true where something is to be solved again. */
static bool settle_cone(lcp_share *s, const lcp_block *b) {
  bool changed = false;
  for (int k = 0, row = b->start + 1; k < b->n_part; row += b->part_dim[k++]) {
    const share_part p = part_at(s, b, k, row);
    changed = (part_slips(s, &p) ? slip_part(s, b, &p) : stick_part(s, &p)) || changed;
  }
  return changed;
}

/* ---- islands --------------------------------------------------------------------------------- */

static int root_of(const lcp_share *s, int k) {
  while (s->island[k] != k) {
    k = s->island[k];
  }
  return k;
}

static void join(lcp_share *s, int k, int m) {
  const int a = root_of(s, k), b = root_of(s, m);
  s->island[(a > b) ? a : b] = (a > b) ? b : a;
}

/* The friction of a touching contact b works on nothing. */
static bool is_still(const lcp_share *s, const lcp_block *b) {
  if (b->size == 1 && lcp_share_end(s, b) == b->start + 1) { /* friction, if any, is inside M */
    return (s->p->traits & LCP_SYMMETRIC) != 0;
  }
  if (is_faceted(b)) {
    bool still = true;
    for (int k = 0; k < b->n_part; k++) {
      const facets f = facets_of(b, k);
      still = still && speed_unit(s, f) * s->z[f.speed] <= LCP_SHARE_TOUCHING * s->size[f.first];
    }
    return still;
  }
  bool still = b->set == LCP_CONE || b->size == 1;
  for (int i = b->start + 1; i < lcp_share_end(s, b); i++) {
    still = still && fabs(s->w[i]) <= LCP_SHARE_TOUCHING * s->size[i];
  }
  return still;
}

/* Least normal impulse that carries the friction of contact b. */
static double carried(const lcp_share *s, const lcp_block *b) {
  double least = 0;
  if (b->set == LCP_CONE) {
    for (int k = 0, row = b->start + 1; k < b->n_part; row += b->part_dim[k++]) {
      const double force = length(s->z + row, b->part_dim[k]);
      least = (force > 0) ? fmax(least, force / b->part_mu[k]) : least;
    }
  }
  for (int k = 0; is_faceted(b) && k < b->n_part;
       k++) { /* the row of the slip speed is mu z_n less the friction */
    const facets f = facets_of(b, k);
    const lcp_column c = lcp_column_of(&s->M, b->start);
    double slope = 0;
    for (int m = 0; m < c.count; m++) {
      slope = (lcp_column_row(&c, m) == f.speed) ? c.val[m] : slope;
    }
    least = (slope > 0) ? fmax(least, s->z[b->start] - s->w[f.speed] / slope) : s->z[b->start];
  }
  return fmin(fmax(least, 0.0), s->z[b->start]);
}

/* Contacts and joints have a node each: contact k the k-th, the j-th free block the one j places after them all. */
static int node_of(const lcp_share *s, int row) {
  const int owner = s->owner[row];
  return (owner >= LCP_SHARE_NOBODY) ? owner : s->n_contact + LCP_SHARE_NOBODY - 1 - owner;
}

static void join_column(lcp_share *s, int row) {
  const lcp_column c = lcp_column_of(&s->M, row);
  const int own = node_of(s, row);
  for (int m = 0; m < c.count; m++) {
    const int other = node_of(s, lcp_column_row(&c, m));
    if (other > own && s->island[other] != s->island[own] && c.val[m] != 0) {
      join(s, own, other);
    }
  }
}

/* Contacts and joints in whose columns M has rows of one another. */
static void join_by_columns(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    join_column(s, lcp_share_block(s, k)->start);
  }
  for (int i = 0; i < s->p->M.n; i++) {
    if (s->owner[i] < LCP_SHARE_NOBODY) {
      join_column(s, i);
    }
  }
}

/* Contacts and joints at one body that moves. */
static void join_at_bodies(lcp_share *s) {
  const lcp_factored *f = s->p->M.factored;
  for (int b = 0; b < f->n_body; b++) {
    s->met[b] = -1;
  }
  for (int g = 0; g < f->n_group; g++) {
    const bool owned =
        f->row_start[g + 1] > f->row_start[g] && s->owner[f->row_start[g]] != LCP_SHARE_NOBODY;
    const int k = owned ? node_of(s, f->row_start[g]) : -1;
    for (int side = 0; side < 2 && k >= 0; side++) {
      const int b = f->body[2 * (ptrdiff_t)g + side];
      if (b >= 0 && f->dof_start[b + 1] > f->dof_start[b]) {
        if (s->met[b] >= 0) {
          join(s, s->met[b], k);
        }
        s->met[b] = k;
      }
    }
  }
}

static void own_free_rows(lcp_share *s) {
  for (int k = 0, n_free = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    if (b->set != LCP_FREE) {
      continue;
    }
    s->island[s->n_contact + n_free] = s->n_contact + n_free;
    n_free++;
    for (int i = b->start; i < b->start + b->size; i++) {
      s->owner[i] = LCP_SHARE_NOBODY - n_free;
    }
  }
}

/* Contacts that M couples, or the joints between them, and of which islands every touching contact is still: there only
 * normal impulses are chosen, and friction stays as it was found. */
void lcp_share_find_islands(lcp_share *s) {
  for (int i = 0; i < s->p->M.n; i++) {
    s->owner[i] = LCP_SHARE_NOBODY;
    s->lower[i] = 0;
  }
  own_free_rows(s);
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    s->island[k] = k;
    s->rests[k] = true;
    for (int i = b->start; i < lcp_share_end(s, b); i++) {
      s->owner[i] = k;
    }
  }
  (s->by_bodies ? join_at_bodies : join_by_columns)(s);
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    if (lcp_share_touches(s, b->start) && !is_still(s, b)) {
      s->rests[root_of(s, k)] = false;
    }
  }
  for (int k = 0; k < s->n_contact; k++) { /* roots come before the rest of their island */
    s->rests[k] = s->rests[root_of(s, k)];
  }
}

/* ---- active rows ----------------------------------------------------------------------------- */

/* Contact block b touches: its rows enter the system as the present z and w ask. */
static void open_contact(lcp_share *s, const lcp_block *b) {
  unsigned char *kind = s->rows.kind;
  kind[b->start] = SHARE_ACTIVE;
  if (b->set == LCP_CONE) {
    (void)settle_cone(s, b);
  }
  for (int k = 0; is_faceted(b) && k < b->n_part; k++) {
    const facets f = facets_of(b, k);
    double sum = 0;
    for (int i = f.first; i < f.first + f.count; i++) {
      sum += s->z[i];
    }
    if (sum <= LCP_SHARE_TOUCHING * lcp_share_scale(s, b->start) && s->p->q[f.speed] <= 0) {
      settle_speed(s, f, true);
      continue;
    }
    for (int i = f.first; i < f.first + f.count; i++) {
      kind[i] = (s->z[i] > LCP_SHARE_TOUCHING * sum) ? SHARE_ACTIVE : SHARE_FIXED;
      s->z[i] = (kind[i] == SHARE_ACTIVE) ? s->z[i] : 0;
    }
    const bool slips = speed_unit(s, f) * s->z[f.speed] > LCP_SHARE_TOUCHING * s->size[f.first];
    kind[f.speed] = slips ? SHARE_ACTIVE : SHARE_FIXED;
    s->z[f.speed] = slips ? s->z[f.speed] : 0;
  }
}

/* Contact block b carries nothing. */
static void close_contact(lcp_share *s, const lcp_block *b) {
  const int end = b->start + (is_faceted(b) ? b->size - b->n_part : b->size);
  for (int i = b->start; i < end; i++) {
    s->rows.kind[i] = SHARE_FIXED;
    s->z[i] = 0;
  }
  for (int k = 0; is_faceted(b) && k < b->n_part; k++) {
    const facets f = facets_of(b, k);
    s->rows.kind[f.speed] = SHARE_FIXED;
    if (s->p->q[f.speed] <= 0) {
      settle_speed(s, f, false);
    }
  }
}

/* Unknown i of an orthant that no contact block covers, a facet or a slip speed. True if its row changes. */
static bool settle_sign(lcp_share *s, int i, double scale) {
  unsigned char *kind = &s->rows.kind[i];
  if (*kind == SHARE_ACTIVE && s->z[i] < 0) {
    const double slack = (s->diagonal[i] > 0) ? LCP_SHARE_ROW_TOL : s->speed_slack;
    const bool far = s->z[i] < -slack * scale;
    s->z[i] = 0;
    *kind = far ? SHARE_FIXED : SHARE_ACTIVE;
    return far;
  }
  if (*kind == SHARE_FIXED && s->w[i] < -LCP_SHARE_ROW_TOL * s->size[i]) {
    *kind = SHARE_ACTIVE;
    return true;
  }
  return false;
}

/* The normal row of a contact of a resting island, which presses against what carries its friction. */
static bool settle_resting(lcp_share *s, const lcp_block *b) {
  const int i = b->start;
  const double slack = LCP_SHARE_ROW_TOL * lcp_share_scale(s, i);
  if (s->rows.kind[i] == SHARE_ACTIVE) {
    /* what delta takes of a row that the limit has let go is no reason to hold it again */
    const bool below = s->z[i] < s->lower[i] - slack && !(s->let_go[i] && s->pull > 0);
    s->z[i] = fmax(s->z[i], s->lower[i]);
    s->rows.kind[i] = below ? SHARE_FIXED : SHARE_ACTIVE;
    return below;
  }
  /* what the answer had of a residual stays in its friction */
  const bool leaves =
      s->w[i] + s->pull * s->rows.delta[i] * s->z[i] < -LCP_SHARE_ROW_TOL * s->size[i] - s->had[i];
  s->rows.kind[i] = leaves ? SHARE_ACTIVE : SHARE_FIXED;
  s->let_go[i] = leaves && s->pull == 0;
  return leaves;
}

static bool settle_contact(lcp_share *s, const lcp_block *b) {
  const int i = b->start;
  if (s->rows.kind[i] == SHARE_FIXED) {
    if (s->w[i] >= -LCP_SHARE_ROW_TOL * s->size[i]) {
      close_contact(s, b); /* slip speeds follow the motion */
      return false;
    }
    open_contact(s, b);
    return true;
  }
  if (s->z[i] < -LCP_SHARE_ROW_TOL * lcp_share_scale(s, i)) {
    close_contact(s, b);
    return true;
  }
  s->z[i] = fmax(s->z[i], 0.0);
  if (b->set == LCP_CONE) {
    return settle_cone(s, b);
  }
  bool changed = false;
  for (int k = 1; k < b->size; k++) {
    changed = settle_sign(s, i + k, lcp_share_scale(s, i)) || changed;
  }
  return changed;
}

/* A row of a box: inside, or at the bound that it presses against. */
static bool settle_box(lcp_share *s, int i) {
  const double lo = s->p->lo[i], hi = s->p->hi[i];
  const double slack = LCP_SHARE_ROW_TOL * lcp_share_scale(s, i),
               still = LCP_SHARE_ROW_TOL * s->size[i];
  if (s->rows.kind[i] == SHARE_ACTIVE) {
    const bool out = s->z[i] < lo - slack || s->z[i] > hi + slack;
    s->z[i] = fmin(fmax(s->z[i], lo), hi);
    s->rows.kind[i] = out ? SHARE_FIXED : SHARE_ACTIVE;
    return out;
  }
  const bool leaves = (s->w[i] < -still && s->z[i] < hi) || (s->w[i] > still && s->z[i] > lo);
  s->rows.kind[i] = leaves ? SHARE_ACTIVE : SHARE_FIXED;
  return leaves;
}

/* Brings the active rows into agreement with z and w; true where they changed. */
bool lcp_share_settle(lcp_share *s) {
  bool changed = false;
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    const int contact = (b->size > 0) ? s->owner[b->start] : -1;
    if (b->soft > 0) {
      changed = (s->rests[contact] ? settle_resting(s, b) : settle_contact(s, b)) || changed;
      continue;
    }
    for (int i = b->start; i < b->start + b->size && (contact < 0 || !s->rests[contact]); i++) {
      if (b->set == LCP_BOX) {
        changed = settle_box(s, i) || changed;
      } else if (b->set == LCP_ORTHANT) {
        changed = settle_sign(s, i, lcp_share_scale(s, i)) || changed;
      }
    }
  }
  return changed;
}

/* Row i of block b in the solver's answer: active, or at the bound nearest to it. */
static void begin_row(lcp_share *s, const lcp_block *b, int i) {
  const double near = LCP_SHARE_TOUCHING * lcp_share_scale(s, i);
  const bool inside =
      b->set == LCP_BOX && s->z[i] > s->p->lo[i] + near && s->z[i] < s->p->hi[i] - near;
  const bool positive = b->set == LCP_ORTHANT && s->z[i] > near;
  s->rows.kind[i] = (b->set == LCP_FREE || inside || positive) ? SHARE_ACTIVE : SHARE_FIXED;
  if (b->set == LCP_BOX && !inside) {
    const bool low = s->z[i] - s->p->lo[i] <= s->p->hi[i] - s->z[i];
    s->z[i] = low ? s->p->lo[i] : s->p->hi[i];
  } else if (b->set == LCP_ORTHANT && !positive) {
    s->z[i] = (b->soft > 0 && i > b->start) ? fmax(s->z[i], 0.0) : 0;
  }
}

/* The active rows of the solver's answer. */
void lcp_share_begin_rows(lcp_share *s) {
  share_rows *r = &s->rows;
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    const int contact = (b->size > 0) ? s->owner[b->start] : -1;
    for (int i = b->start; i < b->start + b->size; i++) {
      if (contact >= 0 && s->rests[contact]) {
        r->kind[i] = SHARE_FIXED;
      } else {
        begin_row(s, b, i);
      }
    }
  }
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    const bool in_touch =
        s->counted ? lcp_share_touches(s, b->start) : lcp_share_carries(s, b->start);
    if (s->rests[k]) {
      r->kind[b->start] = in_touch ? SHARE_ACTIVE : SHARE_FIXED;
      s->lower[b->start] = carried(s, b);
    } else if (in_touch) {
      open_contact(s, b);
    } else {
      close_contact(s, b);
    }
  }
}
