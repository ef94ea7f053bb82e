#include "harness/check/check_run.h"

#include <fnmatch.h>
#include <math.h>
#include <string.h>

bool check_selected(const check_plan *plan, const char *id) {
  return fnmatch(plan->id_glob, id, 0) == 0;
}

static void not_run(const check_plan *plan, check_verdict verdict, const char *id,
                    const char *reason) {
  check_outcome o = {.verdict = verdict,
                     .check = "run",
                     .got = (double)NAN,
                     .expected = (double)NAN,
                     .tolerance = (double)NAN};
  (void)snprintf(o.id, sizeof o.id, "%s", id);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  check_report_add(plan->report, &o);
}

void check_skip(const check_plan *plan, const char *id, const char *reason) {
  not_run(plan, CHECK_SKIPPED, id, reason);
}

void check_refuse(const check_plan *plan, const char *id, const char *reason) {
  not_run(plan, CHECK_FAILED, id, reason);
}

/* ---- isolation --------------------------------------------------------------------------------*/

typedef struct relay {
  void (*body)(void *ctx, isolate_channel *c);
  void *ctx;
  check_report *report;
} relay;

static void relay_body(void *ctx, isolate_channel *c) {
  const relay *r = ctx;
  r->body(r->ctx, c);
}

static void relay_item(void *ctx, const void *item) {
  const relay *r = ctx;
  check_report_add(r->report, item);
}

static void describe_end(const isolate_end *end, const isolate_limits *l, check_outcome *o) {
  switch (end->how) {
  case ISOLATE_TIMEOUT:
    (void)snprintf(o->reason, sizeof o->reason, "timeout after %g s", l->wall);
    break;
  case ISOLATE_SIGNAL:
    (void)snprintf(o->reason, sizeof o->reason, "crash by signal %d: %.120s", end->signal,
                   end->log);
    break;
  case ISOLATE_OOM:
    (void)snprintf(o->reason, sizeof o->reason, "out of memory");
    break;
  case ISOLATE_FLOOD:
    (void)snprintf(o->reason, sizeof o->reason, "killed for flooding its output");
    break;
  case ISOLATE_EXIT:
    (void)snprintf(o->reason, sizeof o->reason, "exit(%d) without a result: %.120s", end->exit_code,
                   end->log);
    break;
  case ISOLATE_INTERRUPTED:
  case ISOLATE_DONE:
    (void)snprintf(o->reason, sizeof o->reason, "interrupted");
    break;
  }
  for (char *c = o->reason; *c != '\0'; c++) {
    if (*c == '\n') {
      *c = ' ';
    }
  }
}

base_status check_isolated(const check_plan *plan, const check_outcome *blank,
                           void (*body)(void *ctx, isolate_channel *c), void *ctx,
                           base_error *err) {
  relay r = {body, ctx, plan->report};
  const isolate_work work = {sizeof(check_outcome), relay_body, relay_item, &r};
  isolate_end end;
  BASE_TRY(isolate_run(&work, &plan->limits, &end, err));
  if (end.how != ISOLATE_DONE) {
    check_outcome o = *blank;
    const formulation *f = formulation_find(blank->formulation);
    const bool slow = end.how == ISOLATE_TIMEOUT && f != NULL && (f->model & FORM_NO_LCP) != 0;
    /* an integrator that needs longer than the limit has claimed nothing */
    o.verdict = (end.how == ISOLATE_INTERRUPTED || slow) ? CHECK_SKIPPED : CHECK_FAILED;
    describe_end(&end, &plan->limits, &o);
    check_report_add(plan->report, &o);
  }
  return BASE_OK;
}
