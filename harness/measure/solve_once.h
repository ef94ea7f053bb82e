/* harness/measure/solve_once.h - one problem, one solver, one verdict. */
#pragma once

#include "harness/measure/registry.h"
#include "harness/measure/verdict.h"
#include "lcp/lcp_certificate.h"
#include "lcp/lcp_instance.h"

typedef struct solve_record {
  run_status status;
  bool verified;            /* rho <= tolerance of the solver's kind */
  bool has_claim;           /* the solver ran and returned an outcome */
  lcp_result claim;         /* certificate views are gone once the instance is closed: kind only */
  bool certificate_checked; /* there is one, of a problem whose certificates can be checked */
  bool certificate_written; /* to the file that was asked for */
  lcp_certificate_verdict certificate;
  lcp_verdict verdict;
  lcp_times time; /* [s] */
  lcp_storage storage;
  size_t bytes;   /* workspace [B] */
  uint64_t hash;  /* FNV-1a of z */
  char note[240]; /* why it is unsupported, or what a library said */
} solve_record;

/* Solves p from z[n] (the start point; replaced by the answer). An unsupported combination is a
 * status, an error return is misuse or machine trouble. */
base_status solve_once(const lcp_problem *p, const solver_choice *s, double *z, solve_record *out,
                       base_error *err);

/* The same, and what the solver can prove is written to `certificate` (NULL: nowhere); where it proved nothing there is no
 * file. trace: its history (NULL: none). */
base_status solve_certified(const lcp_problem *p, const solver_choice *s, double *z,
                            const char *certificate, lcp_trace *trace, solve_record *out,
                            base_error *err);

/* Judges the answer z[n] that goes with out->claim: verdict, status, hash. k: the instance that
 * solved, for what it used; NULL: none (a stored answer). */
base_status solve_judge(const lcp_problem *p, const solver_choice *s, const lcp_instance *k,
                        const double *z, solve_record *out, base_error *err);
void solve_unsupported(const base_error *why, solve_record *out);

const char *storage_name(lcp_storage s);
const char *certificate_name(lcp_certificate_kind k);
long lcp_matrix_entries(const lcp_matrix *m); /* stored entries; n*n dense; jac + S factored */
