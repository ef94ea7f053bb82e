/* plugin_pgs.c - projected Gauss-Seidel as a plug-in of lcpbench: z_i <- max(0, z_i - omega w_i / M_ii), row by row.
 *
 *   cc -shared -fPIC -O2 plugin_pgs.c $(pkg-config --cflags lcpbench) -o plugin_pgs.so
 *   lcpbench conform plugin_pgs.so
 */
#include <lcpbench/lcp_plugin.h>
#include <stdio.h>

static const lcp_plugin_option options[] = {
    {"omega", "1", "real", 1.0, 0.1, 1.9, NULL, "relaxation of each row's step"},
};

static int prepare(void *work, const lcp_plugin_problem *p, const double *option, char *message) {
  (void)work, (void)option;
  for (int i = 0; i < p->n; i++) {
    const double d = p->dense[(size_t)i * (size_t)p->n + (size_t)i];
    if (!(d > 0)) {
      snprintf(message, LCP_PLUGIN_MESSAGE, "diagonal entry %d is %g: need > 0", i, d);
      return LCP_PLUGIN_UNSUPPORTED;
    }
  }
  return LCP_PLUGIN_READY;
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  (void)work;
  const size_t n = (size_t)p->n;
  while (!call->stop(call->host, result->iterations, z)) {
    for (size_t i = 0; i < n; i++) {
      double w = p->q[i];
      for (size_t j = 0; j < n; j++) {
        w += p->dense[j * n + i] * z[j];
      }
      z[i] -= call->option[0] * w / p->dense[i * n + i];
      z[i] = z[i] > 0 ? z[i] : 0;
    }
    result->iterations++;
  }
  return LCP_PLUGIN_AS_STOPPED;
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "my_pgs",
    .title = "Projected Gauss-Seidel, as a plug-in",
    .words = "Sweeps row by row, each row made right with the others held.",
    .when = "As a pattern for a solver of one's own.",
    .sets = LCP_PLUGIN_ORTHANT,
    .storages = LCP_PLUGIN_DENSE,
    .warm = 1,
    .options = options,
    .n_option = 1,
    .prepare = prepare,
    .solve = solve,
};
