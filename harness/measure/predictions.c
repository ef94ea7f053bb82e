#include "harness/measure/predictions.h"

#include <stdio.h>
#include <string.h>

static const char *stands_for(const formulation_choice *form) {
  const char *as = form->form->stands_for;
  return (as != NULL) ? as : "";
}

/* The k-th formulation of a run; NULL past the last. */
static const formulation_choice *form_of(const sim_request *q, int k) {
  if (q->combinations == NULL) {
    return (k == 0) ? q->form : NULL;
  }
  return (k < q->combinations->n) ? &q->combinations->span[k].form : NULL;
}

static bool in_time(const sim_request *q, const spec_check *c) {
  const double end = q->duration * (1.0 + 1e-9);
  const double last = (c->t1 > 0.0 && c->t1 < HUGE_VAL) ? fmax(c->t, c->t1) : c->t;
  if (c->kind == CHECK_STATE_AFTER_STEPS && q->step != NULL) {
    return false; /* of even steps */
  }
  return last <= end && (c->kind != CHECK_EVENT_TIME || c->value <= end);
}

static bool declared(const sim_request *q) {
  return (q->spec->effects & ~q->effects) == 0 || q->judged;
}

bool prediction_applies(const sim_request *q, int i) {
  const spec_check *c = &q->spec->check[i];
  const formulation_choice *form;
  bool applies = declared(q) && in_time(q, c);
  for (int k = 0; applies && (form = form_of(q, k)) != NULL; k++) {
    applies =
        spec_check_applies(c, form->form->name, stands_for(form), formulation_choice_facets(form));
  }
  return applies;
}

check_context prediction_context(const sim_request *q, const series *record, const sim_result *r) {
  const formulation_choice *form;
  bool regularised = false;
  for (int k = 0; (form = form_of(q, k)) != NULL; k++) {
    regularised = regularised || strcmp(stands_for(form), "regularized") == 0;
  }
  return (check_context){.record = record,
                         .h = q->h,
                         .regularised = regularised,
                         .v_slip = r->v_slip,
                         .deflection = r->deflection,
                         .finite = r->finite};
}

static bool kinematic(spec_check_kind k) {
  return k == CHECK_STATE || k == CHECK_STATE_AFTER_STEPS || k == CHECK_WINDOW_MAX ||
         k == CHECK_WINDOW_MIN || k == CHECK_MAX_DRIFT;
}

/* The check of each kind that misses by most. */
typedef struct missed_kind {
  const spec_check *worst;
  double times; /* error over tolerance; HUGE_VAL where it cannot be evaluated */
  bool rest;    /* it ought to be 0 */
} missed_kind;

static void note_missed(const spec_check *c, const check_result *one, missed_kind *kind) {
  const double times =
      (one->known && one->tolerance > 0.0) ? one->error / one->tolerance : HUGE_VAL;
  if (kind->worst == NULL || times > kind->times) {
    *kind = (missed_kind){c, times, one->expected == 0.0};
  }
}

static void print_missed(const missed_kind kind[CHECK_COUNT], char *buf, size_t cap) {
  size_t used = 0;
  for (int k = 0; k < CHECK_COUNT && used < cap; k++) {
    if (kind[k].worst != NULL) {
      char label[80];
      check_label(kind[k].worst, label, sizeof label);
      used += (size_t)snprintf(buf + used, cap - used, "%s%s%s %.2gx", used > 0 ? ", " : "", label,
                               kind[k].rest ? " = 0" : "", kind[k].times);
    }
  }
}

/* The check that all formulations are measured by: the first kinematic one that is the truth for the
 * exact cone, else the first made for no number of facets, else the first that applies. */
static const spec_check *reference_of(const sim_request *q) {
  for (int pass = 0; declared(q) && pass < 3; pass++) {
    for (int i = 0; i < q->spec->n_check; i++) {
      const spec_check *c = &q->spec->check[i];
      const bool fits = (pass == 0)   ? c->nd == 0 && spec_check_applies(c, "coulomb", "coulomb", 0)
                        : (pass == 1) ? c->nd == 0
                                      : prediction_applies(q, i);
      if (fits && kinematic(c->kind) && in_time(q, c)) {
        return c;
      }
    }
  }
  return NULL;
}

bool prediction_exists(const sim_request *q) {
  return reference_of(q) != NULL;
}

static void measure(const sim_request *q, const check_context *ctx, prediction_summary *out) {
  const spec_check *c = reference_of(q);
  check_result one;
  if (c == NULL) {
    return;
  }
  check_evaluate(c, ctx, &one);
  if (one.known) {
    out->has_ref = true;
    out->error = one.error;
    out->predicted = one.expected;
    out->tolerance = one.tolerance;
    out->source = c->source;
    check_label(c, out->quantity, sizeof out->quantity);
  }
}

/* Where no prediction holds, runs are compared with each other by what they end with. */
static void note_end(const sim_request *q, const series *record, prediction_summary *out) {
  spec_check c = {0};
  if (q->spec->n_observe == 0) {
    return;
  }
  memcpy(c.var, q->spec->observe[0], sizeof c.var);
  const series_var *v = series_find_var(record, &c);
  out->has_end = v != NULL && series_at(record, v->column, q->duration, &out->end);
}

void predictions_summarise(const sim_request *q, const series *record, const sim_result *r,
                           prediction_summary *out) {
  *out = (prediction_summary){0};
  const check_context ctx = prediction_context(q, record, r);
  missed_kind missed[CHECK_COUNT] = {{0}};
  bool unknown = false; /* a check that could not be evaluated: the worst is not known either */
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    check_result one;
    if (!prediction_applies(q, i)) {
      continue;
    }
    check_evaluate(c, &ctx, &one);
    out->n++;
    if (!one.ok) {
      out->n_missed++;
      note_missed(c, &one, &missed[c->kind]);
    }
    unknown = unknown || !one.known;
    if (one.known && one.tolerance > 0.0) {
      out->worst = fmax(out->worst, one.error / one.tolerance);
    }
  }
  out->worst = unknown ? (double)NAN : out->worst;
  print_missed(missed, out->missed, sizeof out->missed);
  measure(q, &ctx, out);
  note_end(q, record, out);
}
