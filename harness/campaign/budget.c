#include "harness/campaign/budget.h"

#include "harness/campaign/outlook.h"
#include "harness/campaign/runner.h"

#include <math.h>
#include <stdlib.h>

static void foretell(const plan *p, const outlook *earlier, cover_hint *hint) {
  const campaign *c = p->campaign;
  for (int i = 0; i < p->n_cell; i++) {
    const outlook_cell of = outlook_ask(earlier, p, &p->cell[i]);
    const double later = (c->sampling.processes - 1) * of.later;
    const double whole = of.first + (c->sampling.processes > 1 ? later : 0.0);
    const double usual = c->sampling.processes * fmin(c->limits.time, c->sampling.budget);
    hint[i] = (cover_hint){(whole < HUGE_VAL) ? whole : usual, of.refused};
  }
}

static base_status ask_rows(const plan *p, const char *like, cover_hint *hint, base_error *err) {
  record_table rows = {0};
  outlook earlier = {0};
  base_status done = (like != NULL) ? runner_read_rows(like, &rows, err) : BASE_OK;
  if (done == BASE_OK) {
    done = outlook_open(&earlier, &rows, 1, err);
  }
  if (done == BASE_OK) {
    foretell(p, &earlier, hint);
  }
  outlook_close(&earlier);
  record_table_free(&rows);
  return done;
}

base_status budget_order(plan *p, const char *text, const char *like, cover *out, base_error *err) {
  const plan_filter all = {0};
  campaign c;
  plan quick;
  *out = (cover){0};
  cover_hint *hint = calloc((size_t)p->n_cell + 1, sizeof *hint);
  if (hint == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d cells", p->n_cell);
  }
  base_status done = ask_rows(p, like, hint, err);
  if (done == BASE_OK) {
    done = campaign_read(text, true, &c, err);
    if (done == BASE_OK) {
      done = plan_make(&c, &all, &quick, err);
      if (done == BASE_OK) {
        done = cover_make(p, &quick, hint, out, err);
        plan_free(&quick);
      }
      campaign_free(&c);
    }
  }
  if (done == BASE_OK) {
    cover_order(out, p);
  }
  free(hint);
  return done;
}
