/* lcp_share_rows.c - which rows are active, and how: facets, cones, boxes. */
#include "lcp/share/lcp_share_facets.h"

#include <float.h>

/* ---- facets ---------------------------------------------------------------------------------- */

/* A part without friction impulse: its slip speed is the least that its facets allow, and the facet that allows no
 * less is the one against the motion. `moves`: these two enter the system where that speed is above `still` of what it is
 * made of, else they are slack. */
static void settle_speed(lcp_share *s, share_facets f, bool moves, double still) {
  const double unit = lcp_share_speed_unit(s, f);
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
  s->stale = s->stale || least != had;
  const bool slips = moves && against >= 0 && unit * least > still * s->size[against];
  s->rows.kind[f.speed] = slips ? SHARE_ACTIVE : SHARE_FIXED;
  if (slips) {
    s->rows.kind[against] = SHARE_ACTIVE;
  } else if (moves) {
    s->z[f.speed] = 0;
  }
}

/* ---- cones ----------------------------------------------------------------------------------- */

/* Friction of the part at `row` against the unit vector d, linearised in d = w_t/|w_t| at the present point: mu z_n along d, and
 * across it d turns with the motion, by `turn` for 1 m/s. Both rows are scaled as one that sticks: HUGE_VAL sticks across d. */
static void slip_along(lcp_share *s, int row, int dim, double mu, const double *d, double turn) {
  share_rows *r = &s->rows;
  const double own = (s->diagonal[row] > 0) ? s->diagonal[row] : 1;
  const double sticks = (dim == 1) ? 0 : ((turn < HUGE_VAL) ? own * turn / (1 + own * turn) : 1);
  for (int k = 0; k < dim; k++) {
    r->kind[row + k] = SHARE_SLIP;
    r->pull[row + k] = own * mu * d[k];
    for (int m = 0; m < 2; m++) {
      const double across = ((k == m) ? 1.0 : 0.0) - d[k] * d[m];
      r->own[2 * (row + k) + m] = own * (d[k] * d[m] + (1 - sticks) * across);
      r->gain[2 * (row + k) + m] = sticks * across;
    }
  }
}

/* A part of a cone at the present point. */
typedef struct share_part {
  int row, dim;
  double mu, normal, u[2], speed, force;
  bool moves;
} share_part;

static share_part part_at(const lcp_share *s, const lcp_block *b, int k, int row) {
  share_part p = {.row = row, .dim = b->part_dim[k], .mu = b->part_mu[k], .normal = s->z[b->start]};
  for (int m = 0; m < p.dim; m++) {
    p.u[m] = lcp_share_speed(s, row + m);
  }
  p.speed = lcp_share_length(p.u, p.dim);
  p.force = lcp_share_length(s->z + row, p.dim);
  p.moves = p.speed > ((s->pull > 0) ? 64 * DBL_EPSILON : 100 * LCP_SHARE_ROW_TOL) * s->size[row];
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
    along -= s->z[p->row + m] * p->u[m];
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

static bool slip_part(lcp_share *s, const share_part *p) {
  const double *u = p->u, *l = s->z + p->row;
  const double most = p->mu * fmax(p->normal, 0.0);
  double d[2] = {0}, off = p->moves ? 0 : fabs(p->force - most);
  for (int m = 0; m < p->dim; m++) {
    d[m] = p->moves ? u[m] / p->speed : (p->force > 0 ? -l[m] / p->force : 0);
    off = fmax(off, p->moves ? fabs(l[m] + p->mu * p->normal * d[m]) : 0);
  }
  /* u is known to rounding of its terms, and d by as much over |u| */
  const double known = p->moves ? most * fmin(1, 4 * DBL_EPSILON * s->size[p->row] / p->speed) : 0;
  if (s->rows.kind[p->row] == SHARE_SLIP &&
      off <= LCP_SHARE_ROW_TOL * fmax(most, lcp_share_scale(s, p->row)) + known) {
    return false; /* the factor at hand is of this direction */
  }
  slip_along(s, p->row, p->dim, p->mu, d, p->moves ? most / p->speed : ((most > 0) ? HUGE_VAL : 0));
  return true;
}

/* One more row asks for another kind. It may have it unless only one row may change and one has. */
static bool may_change(lcp_share *s) {
  return s->asked++ == 0 || !s->one_by_one;
}

/* Stick or slip of every part from the present z and w; true where something is to be solved again. */
static bool settle_cone(lcp_share *s, const lcp_block *b) {
  bool changed = false;
  for (int k = 0, row = b->start + 1; k < b->n_part; row += b->part_dim[k++]) {
    const share_part p = part_at(s, b, k, row);
    const unsigned char kind = s->rows.kind[row];
    const bool slips = part_slips(s, &p);
    const bool turns = kind == (slips ? SHARE_ACTIVE : SHARE_SLIP);
    if (turns && !may_change(s)) {
      changed = true;
      continue;
    }
    changed = (slips ? slip_part(s, &p) : stick_part(s, &p)) || changed;
  }
  return changed;
}

/* ---- active rows ----------------------------------------------------------------------------- */

/* Contact block b touches: its rows enter the system as the present z and w ask. A slip below `still` is none: of an answer
 * LCP_SHARE_TOUCHING, between rounds what settle_sign asks by, since the two would undo each other. */
static void open_contact(lcp_share *s, const lcp_block *b, double still) {
  unsigned char *kind = s->rows.kind;
  kind[b->start] = SHARE_ACTIVE;
  if (b->set == LCP_CONE) {
    (void)settle_cone(s, b);
  }
  for (int k = 0; lcp_share_is_faceted(b) && k < b->n_part; k++) {
    const share_facets f = lcp_share_facets(b, k);
    double sum = 0;
    for (int i = f.first; i < f.first + f.count; i++) {
      sum += s->z[i];
    }
    if (sum <= LCP_SHARE_TOUCHING * lcp_share_scale(s, b->start) && s->p->q[f.speed] <= 0) {
      settle_speed(s, f, true, still);
      continue;
    }
    for (int i = f.first; i < f.first + f.count; i++) {
      kind[i] = (s->z[i] > LCP_SHARE_TOUCHING * sum) ? SHARE_ACTIVE : SHARE_FIXED;
      s->z[i] = (kind[i] == SHARE_ACTIVE) ? s->z[i] : 0;
    }
    const bool slips = lcp_share_speed_unit(s, f) * s->z[f.speed] > still * s->size[f.first];
    kind[f.speed] = slips ? SHARE_ACTIVE : SHARE_FIXED;
    s->z[f.speed] = slips ? s->z[f.speed] : 0;
  }
}

/* Contact block b carries nothing. */
static void close_contact(lcp_share *s, const lcp_block *b) {
  const int end = b->start + (lcp_share_is_faceted(b) ? b->size - b->n_part : b->size);
  for (int i = b->start; i < end; i++) {
    s->rows.kind[i] = SHARE_FIXED;
    s->z[i] = 0;
  }
  for (int k = 0; lcp_share_is_faceted(b) && k < b->n_part; k++) {
    const share_facets f = lcp_share_facets(b, k);
    s->rows.kind[f.speed] = SHARE_FIXED;
    if (s->p->q[f.speed] <= 0) {
      settle_speed(s, f, false, 0);
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

/* What the limit has decided of a normal row, delta alone does not take back: with delta it would be decided the other way for ever. */
static bool is_settled(const lcp_share *s, int i) {
  return s->pull > 0 && s->by_limit[i] == s->rows.kind[i] + 1;
}

/* Does the normal row of a contact of a resting island, which presses against what carries its friction, ask for the other kind? */
static bool resting_moves(const lcp_share *s, int i) {
  const bool settled = is_settled(s, i);
  if (s->rows.kind[i] == SHARE_ACTIVE) {
    return s->z[i] < s->lower[i] - LCP_SHARE_ROW_TOL * lcp_share_scale(s, i) && !settled;
  }
  /* what the answer had of a residual stays in its friction */
  const double pull = s->pull * s->rows.delta[i] * s->z[i];
  return s->w[i] + pull < -LCP_SHARE_ROW_TOL * s->size[i] - s->had[i] && !settled;
}

/* Returns whether the row asked for the other kind; it gets it unless only one row may change and one has. */
static bool settle_resting(lcp_share *s, int i) {
  unsigned char *kind = &s->rows.kind[i];
  const bool moves = resting_moves(s, i);
  if (*kind == SHARE_ACTIVE) {
    s->z[i] = fmax(s->z[i], s->lower[i]);
  }
  if (moves && may_change(s)) {
    *kind = (*kind == SHARE_ACTIVE) ? SHARE_FIXED : SHARE_ACTIVE;
    s->by_limit[i] = (unsigned char)((s->pull == 0) ? *kind + 1 : 0);
  }
  return moves;
}

/* The normal row of contact b asks for the other kind, and gets it unless only one row may change and one has. */
static void turn_contact(lcp_share *s, const lcp_block *b) {
  const int i = b->start;
  if (!may_change(s)) {
    return;
  }
  if (s->rows.kind[i] == SHARE_FIXED) {
    open_contact(s, b, LCP_SHARE_ROW_TOL);
  } else {
    close_contact(s, b);
  }
  s->by_limit[i] = (unsigned char)((s->pull == 0) ? s->rows.kind[i] + 1 : 0);
}

static bool settle_contact(lcp_share *s, const lcp_block *b) {
  const int i = b->start;
  if (s->rows.kind[i] == SHARE_FIXED) {
    if (s->w[i] >= -LCP_SHARE_ROW_TOL * s->size[i] || is_settled(s, i)) {
      close_contact(s, b); /* slip speeds follow the motion */
      return false;
    }
    turn_contact(s, b);
    return true;
  }
  if (s->z[i] < -LCP_SHARE_ROW_TOL * lcp_share_scale(s, i) && !is_settled(s, i)) {
    turn_contact(s, b);
    s->z[i] = fmax(s->z[i], 0.0);
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
  s->asked = 0;
  for (int k = 0; k < s->p->n_block; k++) {
    const lcp_block *b = &s->p->block[k];
    const int contact = (b->size > 0) ? s->owner[b->start] : -1;
    if (b->soft > 0) {
      changed = (s->rests[contact] ? settle_resting(s, b->start) : settle_contact(s, b)) || changed;
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
      s->lower[b->start] = lcp_share_carried(s, b, s->z);
    } else if (in_touch) {
      open_contact(s, b, LCP_SHARE_TOUCHING);
    } else {
      close_contact(s, b);
    }
  }
}

void lcp_share_recall_rows(lcp_share *s, const double *start) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    const int i = b->start;
    if (s->rows.kind[i] == SHARE_FIXED || !lcp_share_is_at_least(s, b, start)) {
      continue;
    }
    if (s->rests[k]) {
      s->rows.kind[i] = SHARE_FIXED;
      s->z[i] = s->lower[i];
    } else if (start[i] == 0) {
      close_contact(s, b);
    }
  }
}

/* Friction of the part of block b at `row` stays at its bound, in the direction that it has. */
static void hold_part(lcp_share *s, const lcp_block *b, int part, int row) {
  if (b->set != LCP_CONE) {
    s->rows.kind[lcp_share_facets(b, part).speed] = SHARE_ACTIVE;
    return;
  }
  const int dim = b->part_dim[part];
  const double force = lcp_share_length(s->z + row, dim);
  const double d[2] = {-s->z[row] / force, (dim == 2) ? -s->z[row + 1] / force : 0};
  slip_along(s, row, dim, b->part_mu[part], d, 0);
}

void lcp_share_begin_held(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    const double least = s->lower[b->start];
    if (!s->held[k]) {
      continue;
    }
    if (s->rests[k]) {
      s->rows.kind[b->start] = SHARE_FIXED;
      s->z[b->start] = least;
      continue;
    }
    for (int m = 0, row = b->start + 1; m < b->n_part; row += b->part_dim[m++]) {
      if (lcp_share_carried_by(s, b, m, row, s->z) >= (1 - LCP_SHARE_AT_BOUND) * least) {
        hold_part(s, b, m, row);
      }
    }
  }
}

void lcp_share_hold_bounds(lcp_share *s) {
  for (int k = 0; k < s->n_contact; k++) {
    const lcp_block *b = lcp_share_block(s, k);
    for (int m = 0; lcp_share_is_faceted(b) && m < b->n_part; m++) {
      const int speed = lcp_share_facets(b, m).speed;
      if (s->rows.kind[b->start] == SHARE_ACTIVE &&
          s->w[speed] <= LCP_SHARE_ROW_TOL * s->size[speed]) {
        s->rows.kind[speed] = SHARE_ACTIVE;
      }
    }
  }
}
