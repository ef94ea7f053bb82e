#include "harness/measure/solve_once.h"

#include "harness/measure/sim_watch.h"

#include <stdio.h>

const char *storage_name(lcp_storage s) {
  switch (s) {
  case LCP_DENSE:
    return "dense";
  case LCP_CSC:
    return "csc";
  case LCP_FACTORED:
    break;
  }
  return "factored";
}

const char *certificate_name(lcp_certificate_kind k) {
  switch (k) {
  case LCP_CERT_BASIS:
    return "basis";
  case LCP_CERT_FARKAS:
    return "farkas";
  case LCP_CERT_RAY:
    return "ray";
  case LCP_CERT_NONE:
    break;
  }
  return NULL;
}

long lcp_matrix_entries(const lcp_matrix *m) {
  switch (m->storage) {
  case LCP_DENSE:
    return (long)m->n * m->n;
  case LCP_CSC:
    return m->csc.colptr[m->n];
  case LCP_FACTORED:
    break;
  }
  const lcp_factored *f = m->factored;
  return f->jac_start[f->n_group] + ((f->shift != NULL) ? f->shift->colptr[m->n] : 0);
}

void solve_unsupported(const base_error *why, solve_record *out) {
  out->status = RUN_UNSUPPORTED;
  (void)snprintf(out->note, sizeof out->note, "%.230s", why->text);
}

base_status solve_judge(const lcp_problem *p, const solver_choice *s, const lcp_instance *k,
                        const double *z, solve_record *out, base_error *err) {
  out->has_claim = true;
  if (k != NULL) {
    out->time = lcp_instance_times(k);
    out->storage = lcp_instance_storage(k);
    out->bytes = lcp_instance_bytes(k);
  }
  BASE_TRY(lcp_judge(p, z, &out->verdict, err));
  out->status = verdict_of(s->solver, s->opt, p, &out->claim, &out->verdict, &out->verified);
  out->hash = sim_hash(SIM_HASH_START, z, p->M.n);
  return BASE_OK;
}

static base_status run(lcp_instance *k, const lcp_problem *p, const solver_choice *s,
                       lcp_trace *trace, double *z, solve_record *out, base_error *err) {
  base_error why = {0};
  const base_status ready = lcp_instance_prepare(k, p, &why);
  if (ready == BASE_EUNSUPPORTED) {
    solve_unsupported(&why, out);
    return BASE_OK;
  }
  if (ready != BASE_OK) {
    *err = why;
    return ready;
  }
  BASE_TRY(lcp_instance_solve(k, trace, z, &out->claim, err));
  return solve_judge(p, s, k, z, out, err);
}

/* What `lcpbench verify` would say of the certificate, word for word. */
static base_status check_certificate(const lcp_problem *p, const double *z, solve_record *out,
                                     base_error *err) {
  const unsigned bounded = (1u << LCP_BOX) | (1u << LCP_CONE);
  if (!out->has_claim || out->claim.certificate.kind == LCP_CERT_NONE ||
      (lcp_problem_sets(p) & bounded) != 0) {
    return BASE_OK;
  }
  out->certificate_checked = true;
  return lcp_certificate_verify(p, &out->claim.certificate, z, &out->certificate, err);
}

static base_status write_certificate(const lcp_problem *p, const double *z, const char *path,
                                     solve_record *out, base_error *err) {
  if (!out->has_claim || out->claim.certificate.kind == LCP_CERT_NONE) {
    return BASE_OK;
  }
  out->certificate_written = true;
  return lcp_certificate_write(path, p->M.n, &out->claim.certificate, z, err);
}

base_status solve_once(const lcp_problem *p, const solver_choice *s, double *z, solve_record *out,
                       base_error *err) {
  return solve_certified(p, s, z, NULL, NULL, out, err);
}

base_status solve_certified(const lcp_problem *p, const solver_choice *s, double *z,
                            const char *certificate, lcp_trace *trace, solve_record *out,
                            base_error *err) {
  *out = (solve_record){.status = RUN_ERROR, .verdict.rho = HUGE_VAL};
  base_error why = {0};
  if (lcp_solver_admits(s->solver, p, &why) != BASE_OK) {
    solve_unsupported(&why, out);
    return BASE_OK;
  }
  const lcp_capacity cap = lcp_problem_capacity(p);
  lcp_instance *k;
  BASE_TRY(lcp_instance_open(&k, s->solver, &cap, s->opt, err));
  base_status done = run(k, p, s, trace, z, out, err);
  if (done == BASE_OK) {
    done = check_certificate(p, z, out, err);
  }
  if (done == BASE_OK && certificate != NULL) {
    done = write_certificate(p, z, certificate, out, err);
  }
  lcp_instance_close(k);
  out->claim.certificate.basis = NULL;
  out->claim.certificate.vector = NULL;
  return done;
}
