/* regularized_lugre.c - the LuGre law (Canudas de Wit, Olsson, Astrom & Lischinsky 1995) in the frame
 * of regularized.h (MATHEMATICS 2.3.4):
 *
 *   z' = v - sigma0 |v| z/g,   f = -(sigma0 z + sigma1 z' + sigma2 v),
 *   g = f_n (mu_k + (mu_s - mu_k) exp(-(|v|/v_S)^2))
 *
 * implicit in z and v, with eta = 1/(1 + h sigma0 |v|/g) of the last iterate:
 *
 *   z+ = eta (z + h v),   lambda_t = -kappa z - Gamma v,
 *   kappa = h eta sigma0 - sigma1 (1 - eta),   Gamma = h (eta (h sigma0 + sigma1) + sigma2)
 *
 * so that a part always sticks with the stiffness Gamma, there are no slip columns, and the loop is
 * over eta. |lambda_t| is clipped to mu_s lambda_n (a vanishing load leaves -sigma1 z otherwise). */
#include "formulations/regularized/regularized.h"

static void set_coefficients(const reg_options *o, double h, reg_part *p) {
  p->pull = p->share * (h * p->eta * o->sigma0 - o->sigma1 * (1 - p->eta));
  p->G = p->share * h * (p->eta * (h * o->sigma0 + o->sigma1) + o->sigma2);
}

double reg_lugre_steady(const reg_options *o, double h, const reg_part *p, double lambda_n) {
  const double speed = (p->dim == 1) ? fabs(p->v[0]) : sqrt(p->v[0] * p->v[0] + p->v[1] * p->v[1]);
  const double x = speed / o->v_stribeck;
  const double mu = p->mu_kinetic + (p->mu_static - p->mu_kinetic) * exp(-x * x);
  const double g = mu * fmax(lambda_n, 0.0) / h; /* [N] */
  return (g > 0) ? 1 / (1 + h * p->share * o->sigma0 * speed / g) : 0;
}

void reg_lugre_begin(const reg_options *o, double h, reg_part *p) {
  p->k = p->share * o->sigma0;
  p->c = p->share * o->sigma1;
  set_coefficients(o, h, p);
}

/* tau = kappa z + Gamma v with eta of this iterate. */
void reg_lugre_trial(const reg_options *o, double h, reg_part *p, double lambda_n,
                     const double *u) {
  reg_part now = *p;
  for (int m = 0; m < p->dim; m++) {
    now.v[m] = u[m];
  }
  now.eta = reg_lugre_steady(o, h, &now, lambda_n);
  p->next_eta = now.eta;
  set_coefficients(o, h, &now);
  for (int m = 0; m < p->dim; m++) {
    p->v[m] = u[m];
    p->tau[m] = now.pull * p->s[m] + now.G * u[m];
  }
}

void reg_lugre_next(const reg_options *o, double h, double way, reg_part *p) {
  const double whole = fmin(1, 2 * way);
  p->eta = (1 - way) * p->eta + way * p->next_eta;
  p->r = (1 - whole) * p->r + whole * p->next_r;
  p->mode = (p->r < 1) ? REG_SECANT : REG_STICK;
  set_coefficients(o, h, p);
}

double reg_lugre_state(const reg_part *p, double h, int m) {
  return p->next_eta * (p->s[m] + h * p->v[m]);
}
