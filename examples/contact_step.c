/* contact_step.c - a cube of 2 kg and 0.2 m on the ground, pushed sideways: with friction 0.5 it sticks under a small push and
 * slides under a large one. Exit code 0: both as theory has it.
 *
 *   cc contact_step.c $(pkg-config --cflags --libs lcpbench) -lm && ./a.out
 */
#include <lcpbench/lcpbench.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FEET = 4 };

/* Sideways velocity after one step of h seconds under `push` newtons; NaN where there is no answer. */
static double slides(double push, double h) {
  const double mass = 2, side = 0.2, g = 9.81;
  const double inertia = mass * side * side / 6;
  const double inverse_mass = 1 / mass;
  const double inverse_inertia[] = {1 / inertia, 0, 0, 0, 1 / inertia, 0, 0, 0, 1 / inertia};
  const double centre[] = {0, 0, side / 2};
  const double point[] = {-0.1, -0.1, 0, 0.1, -0.1, 0, -0.1, 0.1, 0, 0.1, 0.1, 0};
  const double normal[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const double mu[] = {0.5, 0.5, 0.5, 0.5};
  const int body[] = {0, -1, 0, -1, 0, -1, 0, -1}; /* the cube against the fixed world */
  const lcp_contacts contacts = {.n_body = 1,
                                 .inverse_mass = &inverse_mass,
                                 .inverse_inertia = inverse_inertia,
                                 .position = centre,
                                 .n_contact = FEET,
                                 .body = body,
                                 .point = point,
                                 .normal = normal,
                                 .mu = mu};
  double velocity[6] = {push / mass * h, 0, -g * h}; /* all other forces of the step are in it */
  double impulse[3 * FEET] = {0};
  lcp_report report;
  if (lcp_contact_step(&contacts, NULL, velocity, impulse, &report) != LCP_OK) {
    fprintf(stderr, "%s\n", lcp_last_error());
    return NAN;
  }
  double weight = 0;
  for (int k = 0; k < FEET; k++) {
    weight += impulse[3 * k + 2];
  }
  printf("push %4.1f N: v = %.6f m/s, the ground carries %.2f N (%s by %s)\n", push, velocity[0],
         weight / h, report.status, report.solver);
  return velocity[0];
}

int main(void) {
  const double h = 0.01;
  const double sticking = slides(5, h), sliding = slides(14.81, h); /* friction holds 9.81 N */
  return fabs(sticking) < 1e-9 && fabs(sliding - h * 5 / 2) < 1e-9 ? 0 : 1;
}
