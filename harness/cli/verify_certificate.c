#include "harness/cli/verify_certificate.h"

#include "harness/cli/cli.h"
#include "harness/measure/problem_source.h"
#include "harness/measure/solve_once.h"
#include "harness/util/json_out.h"
#include "lcp/lcp_certificate.h"

static bool print(const problem_source *src, const lcp_certificate_file *f,
                  const lcp_certificate_verdict *v) {
  json_t *o = json_object();
  json_out_text(o, "problem", src->name);
  json_out_int(o, "n", src->p->M.n);
  json_out_text(o, "certificate", certificate_name(f->kind));
  json_out_bool(o, "holds", v->holds);
  json_out_bool(o, "exact", v->exact);
  json_out_real(o, "residual", v->residual);
  json_out_text(o, "why", v->why);
  return json_out_print(o, stdout);
}

int verify_certificate(const char *problem, const char *q, int facets, const char *path) {
  base_error err = {0};
  problem_source src = {0};
  lcp_certificate_file f = {0};
  lcp_certificate_verdict v;
  int code = CLI_INTERNAL;
  base_status done = problem_source_open(problem, q, facets, &src, &err);
  if (done == BASE_OK) {
    done = lcp_certificate_read(path, &f, &err);
  }
  if (done == BASE_OK) {
    done = lcp_certificate_file_verify(src.p, &f, &v, &err);
  }
  if (done == BASE_OK) {
    code = !print(&src, &f, &v) ? CLI_INTERNAL : v.holds ? CLI_OK : CLI_HONEST;
  }
  lcp_certificate_free(&f);
  problem_source_close(&src);
  return (done == BASE_OK) ? code : cli_report(&err);
}
