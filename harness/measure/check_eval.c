#include "harness/measure/check_eval.h"

#include <stdio.h>
#include <string.h>

static double check_tolerance(const spec_check *c, const check_context *ctx, double expected) {
  const spec_tolerance *t = &c->tol;
  const double h = ctx->h;
  double tol = t->abs + t->h * h + t->h2 * h * h + t->rel * fabs(expected);
  if (t->inv_h != 0.0) {
    tol += t->inv_h / h;
  }
  if (ctx->regularised) {
    tol += t->reg_h * h + t->reg_v * ctx->v_slip + t->reg_d * ctx->deflection;
  }
  return tol;
}

void check_label(const spec_check *c, char *buf, size_t cap) {
  size_t used = (size_t)snprintf(buf, cap, "%s", spec_check_name(c->kind));
  if (c->var[0] != '\0' && used < cap) {
    used += (size_t)snprintf(buf + used, cap - used, " %s", c->var);
  }
  if (c->has_dir && used < cap) {
    used += (size_t)snprintf(buf + used, cap - used, "[%.3g,%.3g,%.3g]", c->dir[0], c->dir[1],
                             c->dir[2]);
  }
  for (int i = 0; i < c->n_pair && used < cap; i++) {
    used += (size_t)snprintf(buf + used, cap - used, "%s%s/%s", i == 0 ? " " : "+", c->pair[i].a,
                             c->pair[i].b);
  }
  if (c->n_pair > 0 && c->kind != CHECK_EVENT_TIME && used < cap) {
    (void)snprintf(buf + used, cap - used, " %s", c->tangential ? "tangential" : "normal");
  }
}

/* ---- outcomes -------------------------------------------------------------------------------- */

static void unknown(check_result *out, const char *reason) {
  out->known = false;
  out->ok = false;
  (void)snprintf(out->reason, sizeof out->reason, "%s", reason);
}

/* |got - expected| within tolerance; NaN fails. */
static void near(const spec_check *c, const check_context *ctx, double got, double expected,
                 check_result *out) {
  out->got = got;
  out->expected = expected;
  out->error = fabs(got - expected);
  out->tolerance = check_tolerance(c, ctx, expected);
  out->ok = out->error <= out->tolerance;
}

/* A one-sided bound: got <= tolerance. */
static void below(const spec_check *c, const check_context *ctx, double got, check_result *out) {
  out->got = got;
  out->expected = 0.0;
  out->error = fmax(got, 0.0);
  out->tolerance = check_tolerance(c, ctx, 0.0);
  out->ok = got <= out->tolerance;
}

/* ---- windows --------------------------------------------------------------------------------- */

static double window_end(const spec_check *c, const series *s) {
  return (c->t1 > 0.0 && c->t1 < HUGE_VAL) ? c->t1 : s->column[SERIES_TIME][s->n_row - 1];
}

/* Extremes of a column over [t0, t1], ends interpolated; false if the record is too short. */
static bool extremes(const series *s, int column, double t0, double t1, double *min, double *max) {
  double a;
  double b;
  if (!series_at(s, column, t0, &a) || !series_at(s, column, t1, &b)) {
    return false;
  }
  *min = fmin(a, b);
  *max = fmax(a, b);
  const double *time = s->column[SERIES_TIME];
  for (int k = 0; k < s->n_row; k++) {
    if (time[k] >= t0 && time[k] <= t1) {
      *min = fmin(*min, s->column[column][k]);
      *max = fmax(*max, s->column[column][k]);
    }
  }
  return true;
}

/* Time average over (t0, t1] of a force column (row k holds the force of the step ending there). */
static bool average(const series *s, int column, double t0, double t1, double *mean) {
  const double *time = s->column[SERIES_TIME];
  const double slack = 1e-9 * (1.0 + t1);
  double sum = 0.0;
  double span = 0.0;
  for (int k = 1; k < s->n_row; k++) {
    if (time[k] > t0 + slack && time[k] <= t1 + slack) {
      const double dt = time[k] - time[k - 1];
      sum += s->column[column][k] * dt;
      span += dt;
    }
  }
  *mean = (span > 0.0) ? sum / span : 0.0;
  return span > 0.0 && time[s->n_row - 1] >= t1 - slack - (time[1] - time[0]);
}

static double largest_increase(const double *x, int n) {
  double most = 0.0;
  for (int k = 1; k < n; k++) {
    most = fmax(most, x[k] - x[k - 1]);
  }
  return most;
}

static double largest(const double *x, int n) {
  double most = -HUGE_VAL;
  for (int k = 0; k < n; k++) {
    most = fmax(most, x[k]);
  }
  return most;
}

/* ---- kinds ----------------------------------------------------------------------------------- */

static void eval_state(const spec_check *c, const check_context *ctx, int column,
                       check_result *out) {
  const series *s = ctx->record;
  double value;
  double first;
  out->time = c->t;
  if (!series_at(s, column, c->t, &value) || !series_at(s, column, 0.0, &first)) {
    unknown(out, "the simulation ended before that time");
  } else if (c->kind == CHECK_MIN_CHANGE) {
    out->got = fabs(value - first);
    out->expected = c->value;
    out->error = fmax(0.0, c->value - out->got);
    out->ok = out->got >= c->value;
  } else {
    near(c, ctx, value, c->value, out);
  }
}

static void eval_after_steps(const spec_check *c, const check_context *ctx, int column,
                             check_result *out) {
  const series *s = ctx->record;
  if (c->n >= s->n_row) {
    unknown(out, "the simulation ended before that step");
    return;
  }
  out->time = s->column[SERIES_TIME][c->n];
  near(c, ctx, s->column[column][c->n], c->value + c->dvalue_dh * ctx->h * c->n, out);
}

static void eval_window(const spec_check *c, const check_context *ctx, int column,
                        check_result *out) {
  const series *s = ctx->record;
  double min;
  double max;
  double first;
  out->time = window_end(c, s);
  if (!extremes(s, column, c->t0, out->time, &min, &max) || !series_at(s, column, 0.0, &first)) {
    unknown(out, "the simulation ended before that window");
  } else if (c->kind == CHECK_MAX_DRIFT) {
    near(c, ctx, fmax(max - first, first - min), 0.0, out);
  } else {
    near(c, ctx, c->kind == CHECK_WINDOW_MAX ? max : min, c->value, out);
  }
}

static void eval_force(const spec_check *c, const check_context *ctx, check_result *out) {
  const series *s = ctx->record;
  double sum = 0.0;
  out->time = window_end(c, s);
  for (int i = 0; i < c->n_pair; i++) {
    const series_pair *p = series_find_pair(s, &c->pair[i]);
    double mean;
    if (p == NULL ||
        !average(s, c->tangential ? p->tangential : p->normal, c->t0, out->time, &mean)) {
      unknown(out, "the simulation ended before that window");
      return;
    }
    sum += mean;
  }
  near(c, ctx, sum, c->value, out);
}

/* Row of the event, or -1. */
static int event_row(const spec_check *c, const series *s, const double *x) {
  int last = -1;
  double side = 0.0; /* last nonzero value */
  for (int k = 0; k < s->n_row; k++) {
    switch (c->event) {
    case EVENT_STOP:
      if (fabs(x[k]) <= c->threshold) {
        return k;
      }
      break;
    case EVENT_START:
      if (fabs(x[k]) >= c->threshold) {
        return k;
      }
      break;
    case EVENT_SIGN_CHANGE:
      if (x[k] * side < 0.0) {
        return k;
      }
      side = (x[k] != 0.0) ? x[k] : side;
      break;
    case EVENT_FIRST_CONTACT:
      if (x[k] > 0.0) {
        return k;
      }
      break;
    case EVENT_LEAVE:
      last = (x[k] > 0.0) ? k : last;
      break;
    }
  }
  return last;
}

static void eval_event(const spec_check *c, const check_context *ctx, check_result *out) {
  const series *s = ctx->record;
  int column = SERIES_ANY_FORCE;
  if (c->var[0] != '\0') {
    column = series_find_var(s, c)->column;
  } else if (c->n_pair > 0) {
    column = series_find_pair(s, &c->pair[0])->normal;
  }
  const int row = event_row(c, s, s->column[column]);
  if (row < 0) {
    near(c, ctx, HUGE_VAL, c->value, out);
    (void)snprintf(out->reason, sizeof out->reason, "the event did not happen");
    return;
  }
  out->time = s->column[SERIES_TIME][row];
  near(c, ctx, out->time, c->value, out);
}

static void eval_conserved(const spec_check *c, const check_context *ctx, check_result *out) {
  const series *s = ctx->record;
  const int last = s->n_row - 1;
  const double *energy = s->column[SERIES_ENERGY];
  const double *angular = s->column[SERIES_ANGULAR];
  double px;
  out->time = s->column[SERIES_TIME][last];
  switch (c->kind) {
  case CHECK_ENERGY_NONINCREASE:
    below(c, ctx, largest_increase(energy, s->n_row), out);
    break;
  case CHECK_ENERGY_GROWTH_REL:
    below(c, ctx, (largest(energy, s->n_row) - energy[0]) / fabs(energy[0]), out);
    break;
  case CHECK_ENERGY_DRIFT_REL:
    below(c, ctx, fabs(energy[last] - energy[0]) / fabs(energy[0]), out);
    break;
  case CHECK_ANGULAR_MOMENTUM_DRIFT_REL:
    below(c, ctx, fabs(angular[last] - angular[0]) / fabs(angular[0]), out);
    break;
  case CHECK_MOMENTUM_X:
    out->time = c->t;
    if (series_at(s, SERIES_MOMENTUM_X, c->t, &px)) {
      near(c, ctx, px, c->value, out);
    } else {
      unknown(out, "the simulation ended before that time");
    }
    break;
  case CHECK_MAX_SPEED:
    below(c, ctx, largest(s->column[SERIES_SPEED], s->n_row), out);
    break;
  case CHECK_MAX_PENETRATION:
    below(c, ctx, largest(s->column[SERIES_PENETRATION], s->n_row), out);
    break;
  case CHECK_STATIC_DEFLECTION: /* of a compliant contact: how deep the body has settled */
    near(c, ctx, s->column[SERIES_PENETRATION][last], c->value, out);
    break;
  case CHECK_FINITE:
    out->got = ctx->finite ? 1.0 : 0.0;
    out->expected = 1.0;
    out->error = 1.0 - out->got;
    out->ok = ctx->finite;
    break;
  default:
    unknown(out, "this kind of check is not evaluated on a simulation");
    break;
  }
}

void check_evaluate(const spec_check *c, const check_context *ctx, check_result *out) {
  *out = (check_result){.known = true};
  const series_var *v = (c->var[0] != '\0') ? series_find_var(ctx->record, c) : NULL;
  const bool needs_var = c->kind == CHECK_STATE || c->kind == CHECK_STATE_AFTER_STEPS ||
                         c->kind == CHECK_MIN_CHANGE || c->kind == CHECK_MAX_DRIFT ||
                         c->kind == CHECK_WINDOW_MAX || c->kind == CHECK_WINDOW_MIN;
  if (needs_var && v == NULL) {
    unknown(out, "the quantity was not recorded");
    return;
  }
  switch (c->kind) {
  case CHECK_STATE:
  case CHECK_MIN_CHANGE:
    eval_state(c, ctx, v->column, out);
    break;
  case CHECK_STATE_AFTER_STEPS:
    eval_after_steps(c, ctx, v->column, out);
    break;
  case CHECK_MAX_DRIFT:
  case CHECK_WINDOW_MAX:
  case CHECK_WINDOW_MIN:
    eval_window(c, ctx, v->column, out);
    break;
  case CHECK_CONTACT_FORCE:
  case CHECK_CONTACT_FORCE_SUM:
    eval_force(c, ctx, out);
    break;
  case CHECK_EVENT_TIME:
    eval_event(c, ctx, out);
    break;
  default:
    eval_conserved(c, ctx, out);
    break;
  }
}
