#include "harness/check/check_report.h"

#include "lcp/base/fields.h"

static const char *const words[] = {"passed", "failed", "skipped"};

void check_report_open(check_report *r, bool json, bool verbose) {
  *r = (check_report){.json = json, .verbose = verbose, .all = json ? json_array() : NULL};
}

static void print_number(const char *name, double x) {
  char number[32];
  if (!isnan(x)) {
    base_real_print(x, number, sizeof number);
    (void)printf(" %s=%s", name, number);
  }
}

static void print_line(const check_outcome *o) {
  (void)printf("%s %s %s %s [%s]", o->verdict == CHECK_FAILED ? "FAILED" : words[o->verdict], o->id,
               o->formulation[0] != '\0' ? o->formulation : "-",
               o->solver[0] != '\0' ? o->solver : "-", o->check);
  if (o->step > 0.0) {
    print_number("h", o->step);
  }
  print_number("got", o->got);
  print_number("expected", o->expected);
  print_number("tolerance", o->tolerance);
  (void)printf("%s%s\n", o->reason[0] != '\0' ? " : " : "", o->reason);
}

void check_report_add(check_report *r, const check_outcome *o) {
  r->count[o->verdict]++;
  if (!r->json) {
    if (o->verdict == CHECK_FAILED || r->verbose) {
      print_line(o);
    }
    return;
  }
  json_t *j = json_object();
  json_out_text(j, "id", o->id);
  json_out_text(j, "formulation", o->formulation);
  json_out_text(j, "solver", o->solver);
  json_out_text(j, "check", o->check);
  json_out_text(j, "result", words[o->verdict]);
  json_out_real(j, "step_s", o->step > 0.0 ? o->step : HUGE_VAL);
  json_out_real(j, "got", o->got);
  json_out_real(j, "expected", o->expected);
  json_out_real(j, "tolerance", o->tolerance);
  json_out_text(j, "reason", o->reason);
  (void)json_array_append_new(r->all, j);
}

bool check_report_close(check_report *r) {
  if (r->json) {
    json_t *o = json_object();
    (void)json_object_set_new(o, "checks", r->all);
    for (int v = 0; v < 3; v++) {
      json_out_int(o, words[v], r->count[v]);
    }
    return json_out_print(o, stdout);
  }
  return printf("%d passed, %d failed, %d skipped\n", r->count[CHECK_PASSED],
                r->count[CHECK_FAILED], r->count[CHECK_SKIPPED]) > 0 &&
         fflush(stdout) == 0;
}
