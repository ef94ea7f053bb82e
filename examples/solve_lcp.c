/* solve_lcp.c - one LCP: solved, and judged from the data alone. Exit code 0: the answer holds.
 *
 *   cc solve_lcp.c $(pkg-config --cflags --libs lcpbench) && ./a.out [SOLVER]
 */
#include <lcpbench/lcpbench.h>
#include <stdio.h>

int main(int argc, char **argv) {
  const double M[] = {2, 1, 1, 2}; /* w = M z + q, z >= 0, w >= 0, z'w = 0: z = (4/3, 7/3) */
  const double q[] = {-5, -6};
  double z[] = {0, 0};
  lcp_report report;
  lcp_problem *p = lcp_problem_dense(2, M, 1, q);
  if (p == NULL || lcp_solve(p, argc > 1 ? argv[1] : "lemke", z, &report) != LCP_OK) {
    fprintf(stderr, "%s\n", lcp_last_error());
    lcp_problem_free(p);
    return 1;
  }
  printf("z = %.6f %.6f, %s by %s, rho %.1e, %ld iterations\n", z[0], z[1], report.status,
         report.solver, report.rho, report.iterations);

  z[0] += 1e-3; /* and an answer that is not one */
  if (lcp_verify(p, z, 1e-9, &report) == LCP_UNSOLVED) {
    printf("moved by 1e-3: %s\n", lcp_last_error());
  }
  lcp_problem_free(p);
  return report.verified ? 1 : 0;
}
