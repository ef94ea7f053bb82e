/* warm_start.c - the same matrix with a slowly changing right-hand side: a workspace is kept, and each solve starts at the last answer.
 * Exit code 0: every answer holds, and the warm loop took fewer iterations.
 *
 *   cc warm_start.c $(pkg-config --cflags --libs lcpbench) -lm && ./a.out [SOLVER]
 */
#include <lcpbench/lcpbench.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N = 200, STEPS = 50 };

/* Iterations of all steps; -1 where one of them has no answer. */
static long loop(lcp_problem *p, const char *solver, int warm) {
  double q[N], z[N] = {0};
  long iterations = 0;
  lcp_workspace *work = lcp_workspace_new(solver);
  for (int step = 0; step < STEPS && work != NULL; step++) {
    lcp_report report;
    for (int i = 0; i < N; i++) {
      q[i] = sin(0.1 * i + 0.002 * step);
    }
    if (!warm) {
      memset(z, 0, sizeof z);
    }
    if (lcp_problem_set_q(p, q) != LCP_OK || lcp_workspace_solve(work, p, z, &report) != LCP_OK) {
      iterations = -1;
      break;
    }
    iterations += report.iterations;
  }
  if (work == NULL || iterations < 0) {
    fprintf(stderr, "%s\n", lcp_last_error());
    iterations = -1;
  }
  lcp_workspace_free(work);
  return iterations;
}

int main(int argc, char **argv) {
  const char *solver = argc > 1 ? argv[1] : "pgs:tol=1e-9";
  int colptr[N + 1], rowind[3 * N], count = 0; /* a chain: 2 on the diagonal, -0.9 beside it */
  double val[3 * N], q[N] = {0};
  for (int j = 0; j < N; j++) {
    colptr[j] = count;
    for (int i = (j > 0 ? j - 1 : 0); i <= j + 1 && i < N; i++) {
      rowind[count] = i;
      val[count++] = (i == j) ? 2.0 : -0.9;
    }
  }
  colptr[N] = count;
  lcp_problem *p = lcp_problem_csc(N, colptr, rowind, val, q);
  if (p == NULL) {
    fprintf(stderr, "%s\n", lcp_last_error());
    return 1;
  }
  const long cold = loop(p, solver, 0), warm = loop(p, solver, 1);
  lcp_problem_free(p);
  printf("%d problems by %s: %ld iterations cold, %ld warm\n", STEPS, solver, cold, warm);
  return cold > 0 && warm >= 0 && warm < cold ? 0 : 1;
}
