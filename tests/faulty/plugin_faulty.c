/* Plug-ins that misbehave on purpose, each in one way: compiled once for each FAULT. The good one is exact on the sign of q,
 * where M is diagonal, and sweeps elsewhere. */
#include "include/lcpbench/lcp_plugin.h"

#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TEXT_(x) #x
#define TEXT(x)  TEXT_(x)
#define IS(word) (strcmp(TEXT(FAULT), word) == 0)

static double entry(const lcp_plugin_problem *p, int i, int j) {
  return p->dense[(size_t)j * (size_t)p->n + (size_t)i];
}

static int sweep(const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  while (!call->stop(call->host, result->iterations, z)) {
    for (int i = 0; i < p->n; i++) {
      double w = p->q[i];
      for (int j = 0; j < p->n; j++) {
        w += entry(p, i, j) * z[j];
      }
      z[i] -= w / entry(p, i, i);
      z[i] = (z[i] > p->lo[i]) ? z[i] : p->lo[i];
      z[i] = (z[i] < p->hi[i]) ? z[i] : p->hi[i];
    }
    result->iterations++;
  }
  return LCP_PLUGIN_AS_STOPPED;
}

static size_t workspace(int n, size_t entries, int n_block, const double *option) {
  (void)entries, (void)n_block, (void)option;
  return (size_t)n * sizeof(double);
}

static int prepare(void *work, const lcp_plugin_problem *p, const double *option, char *message) {
  double *y = work;
  (void)option;
  for (int i = 0; i < p->n; i++) {
    y[i] = 1.0;
    if (!(entry(p, i, i) > 0)) {
      (void)snprintf(message, LCP_PLUGIN_MESSAGE, "diagonal entry %d is not above 0", i);
      return LCP_PLUGIN_UNSUPPORTED;
    }
  }
  return LCP_PLUGIN_READY;
}

static int misbehave(void *work, const lcp_plugin_problem *p, double *z) {
  if (IS("crash")) {
    (void)raise(SIGSEGV);
  }
  if (IS("hang")) {
    (void)signal(SIGTERM, SIG_IGN);
    for (;;) {
      (void)usleep(1000);
    }
  }
  if (IS("leak")) {
    /* else a test's malloc fills each block, which takes its seconds */
    (void)mallopt(M_PERTURB, 0);
    volatile char *lost = malloc((size_t)16 << 20); /* address space, hardly touched */
    if (lost == NULL) {
      return LCP_PLUGIN_NO_MEMORY;
    }
    lost[0] = 1;
  }
  if (IS("overrun")) {
    ((double *)work)[p->n] = 0.0;
  }
  if (IS("writer")) {
    double *q;
    memcpy(&q, &p->q, sizeof q); /* what a cast in a library does */
    q[0] = 0.0;
  }
  if (IS("liar")) {
    memset(z, 0, (size_t)p->n * sizeof *z);
    return LCP_PLUGIN_SOLVED;
  }
  return LCP_PLUGIN_AS_STOPPED;
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  static long count;
  const int code = misbehave(work, p, z);
  if (code != LCP_PLUGIN_AS_STOPPED) {
    return code;
  }
  if (IS("prover")) {
    result->farkas = work;
    return LCP_PLUGIN_INFEASIBLE;
  }
  const int done = sweep(p, call, z, result);
  if (IS("fickle")) {
    z[0] *= 1.0 + 1e-14 * (double)(++count % 97);
  }
  return done;
}

static const lcp_plugin_option options[] = {
    {"depth", "1", "int", 3, 1, 9, NULL, "a number that nothing depends on"},
    {"rule", "1", "choice", 1, 0, 0, "first|last", "a word that nothing depends on"},
};

#define NAME_(fault) "plugin_" #fault
#define NAME(fault)  NAME_(fault)
#define old_         (LCP_PLUGIN_ABI - 1)

const lcp_plugin lcp_plugin_descriptor = {
    .abi = (sizeof TEXT(FAULT) == sizeof "old" && TEXT(FAULT)[0] == 'o') ? old_ : LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = (sizeof TEXT(FAULT) == sizeof "taken" && TEXT(FAULT)[0] == 't') ? "lemke" : NAME(FAULT),
    .title = "Planted fault " TEXT(FAULT),
    .words = "Does one thing wrong.",
    .when = "In tests.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX,
    .storages = LCP_PLUGIN_DENSE,
    .warm = 1,
    .options = options,
    .n_option = 2,
    .workspace = workspace,
    .prepare = prepare,
    .solve = solve,
};
