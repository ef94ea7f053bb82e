/* regularized_law.c - friction parts: stiffness, transported state, the law, memory. */
#include "formulations/regularized/regularized.h"

#include <string.h>

/* A memory entry: closed, lambda_n, then for each kind of part the numbers below. */
enum { PAST_MODE, PAST_SLIDING, PAST_R, PAST_S, PAST_D = PAST_S + 3, PAST_PART = PAST_D + 3 };
enum { PAST_PARTS = 2, REG_STRIDE = PAST_PARTS + REG_KINDS * PAST_PART };

/* Largest eigenvalue of the dim x dim block of C at rows `at` of contact i. */
static double mobility(const form_assembly *a, int i, int at, int dim) {
  const int n = form_rows_of(a, i);
  const double *block = form_own_block(a, i);
  const double p = block[at * n + at];
  if (dim == 1) {
    return p;
  }
  const double q = block[at * n + at + 1];
  const double r = block[(at + 1) * n + at + 1];
  return 0.5 * (p + r) + sqrt(0.25 * (p - r) * (p - r) + q * q);
}

/* k, c and G = h^2 k + h c. With a fixed ratio, G = ratio m_t and c = 2 zeta sqrt(k m_t). Torsion
 * and rolling turn the stiffness of the contact into that of a spring at arm `mu` [m]. */
static void set_stiffness(const reg_options *o, double h, bool boost, reg_part *p) {
  const double arm = (p->kind == 0) ? 1 : p->mu_static;
  const bool viscous = o->model == REG_VISCOUS;
  if (o->stiffness == 0) {
    const double root = viscous ? 0 : sqrt(o->zeta * o->zeta + o->ratio) - o->zeta;
    p->k = root * root * p->m / (h * h);
    p->c = (viscous ? o->ratio : 2 * o->zeta * root) * p->m / h;
  } else {
    p->k = viscous ? 0 : o->k * arm * arm;
    p->c = o->c * arm * arm;
  }
  p->G = h * h * p->k + h * p->c;
  p->pull = h * p->k;
  if (boost && p->G > 0 && p->G < o->ratio * p->m) {
    const double up = o->ratio * p->m / p->G;
    p->k *= up;
    p->c *= up;
    p->G *= up;
    p->pull *= up;
  }
}

/* How a tangential world vector is carried into the frame of this step: projected onto the tangent plane,
 * brought back to its length, turned about the normal by the mean spin of the two bodies
 * (MATHEMATICS 2.3.11). */
typedef struct turn {
  double cosine, sine;
} turn;

static turn turn_of(const contact_set *c, int g) {
  if (c->spin == NULL) {
    return (turn){.cosine = 1};
  }
  const double *n = c->frame + 9 * (ptrdiff_t)g;
  const double *w = c->spin + 3 * (ptrdiff_t)g;
  const double angle = c->h * (n[0] * w[0] + n[1] * w[1] + n[2] * w[2]);
  return (turn){.cosine = cos(angle), .sine = sin(angle)};
}

static void to_frame(const contact_set *c, int g, turn by, const double *vector, double *out) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  const double x = t1[0] * vector[0] + t1[1] * vector[1] + t1[2] * vector[2];
  const double y = t2[0] * vector[0] + t2[1] * vector[1] + t2[2] * vector[2];
  const double length = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  const double now = sqrt(x * x + y * y);
  const double scale = (now > 0) ? length / now : 0;
  out[0] = scale * (by.cosine * x - by.sine * y);
  out[1] = scale * (by.sine * x + by.cosine * y);
}

/* A tangential vector as it is remembered: in the world, or one number. */
static void carry(const contact_set *c, int g, int dim, const double *in, double *vector) {
  const double *t1 = c->frame + 9 * (ptrdiff_t)g + 3;
  const double *t2 = t1 + 3;
  if (dim == 1) {
    vector[0] = in[0];
    return;
  }
  for (int k = 0; k < 3; k++) {
    vector[k] = in[0] * t1[k] + in[1] * t2[k];
  }
}

/* A planar tangent or a torsion is one number. A planar t1 turns with the normal by itself. */
static void restore(const regularized *s, int g, reg_part *p) {
  const double *past = contact_memory_old(&s->memory, g);
  p->mode = REG_STICK;
  p->r = 1;
  if (past == NULL) {
    return;
  }
  const double *m = past + PAST_PARTS + (ptrdiff_t)PAST_PART * p->kind;
  p->mode = (unsigned char)m[PAST_MODE];
  p->sliding = (unsigned char)m[PAST_SLIDING];
  p->r = m[PAST_R];
  if (p->dim == 1) {
    p->s[0] = m[PAST_S];
    p->d[0] = m[PAST_D];
  } else {
    const turn by = turn_of(s->a.set, g);
    to_frame(s->a.set, g, by, m + PAST_S, p->s);
    if (p->mode != REG_STICK) {
      to_frame(s->a.set, g, by, m + PAST_D, p->d);
    }
  }
  if (p->mode == REG_SECANT) {
    p->mode = REG_SLIP;
  }
}

static bool has_impact(const regularized *s) {
  const contact_set *c = s->a.set;
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i];
    const double u = c->u_before[c->row_start[g]];
    const double gain = fmax(0.0, u - s->a.r_normal[g]);
    if (-u > s->opt.rest * gain && -u * c->h > c->tol) {
      return true;
    }
  }
  return false;
}

bool reg_is_lugre(const regularized *s, const reg_part *p) {
  return s->opt.model == REG_LUGRE && p->kind == 0;
}

static void add_part(regularized *s, int i, int kind, int row, int dim, bool boost) {
  const contact_set *c = s->a.set;
  const int g = s->a.group[i];
  reg_part *p = &s->part[s->n_part];
  *p = (reg_part){.contact = i, .kind = kind, .row = row, .dim = dim};
  if (kind == 0) {
    p->mu_static = c->mu_static[g];
    p->mu_kinetic = c->mu_kinetic[g];
  } else {
    p->mu_static = (kind == 1) ? c->mu_torsion[g] : c->mu_rolling[g];
    p->mu_kinetic = p->mu_static;
  }
  const double inverse = mobility(&s->a, i, row - s->a.row[i], dim);
  if (!(inverse > 0) || !(p->mu_static > 0)) {
    return; /* nothing can move, or nothing holds */
  }
  p->m = 1 / inverse;
  p->axis2 = (kind == 0 && dim == 2) ? s->opt.ellipse : 1;
  set_stiffness(&s->opt, c->h, boost, p);
  restore(s, g, p);
  if (reg_is_lugre(s, p)) {
    p->eta = p->r;
    p->r = 1;
    p->mode = REG_STICK;
    reg_lugre_begin(&s->opt, c->h, p);
  }
  s->n_part++;
}

void reg_parts_build(regularized *s) {
  const bool boost = s->opt.impact == 1 && has_impact(s);
  s->n_part = 0;
  for (int i = 0; i < s->a.n_contact; i++) {
    const contact_rows rows = s->a.set->rows[s->a.group[i]];
    const int first = s->a.row[i] + 1;
    s->part_start[i] = s->n_part;
    if (rows.tangent > 0) {
      add_part(s, i, 0, first, rows.tangent, boost);
    }
    if (rows.torsion > 0) {
      add_part(s, i, 1, first + rows.tangent, 1, boost);
    }
    if (rows.rolling > 0) {
      add_part(s, i, 2, first + rows.tangent + rows.torsion, rows.rolling, boost);
    }
  }
  s->part_start[s->a.n_contact] = s->n_part;
}

static double norm_of(const double *x, int n) {
  return (n == 1) ? fabs(x[0]) : sqrt(x[0] * x[0] + x[1] * x[1]);
}

/* An impulse along axis m is this many units of the circular law. */
static double axis_unit(const reg_part *p, int m) {
  return (m == 1) ? p->axis2 : 1;
}

/* h tau from the end velocity, or where lambda follows it with full accuracy (a stiff spring times
 * a small velocity would lose digits) from lambda. */
static void trial(const regularized *s, reg_part *p, const double *lambda, const double *u) {
  double v[2] = {u[p->row], 0};
  if (p->dim == 2) {
    v[1] = p->axis2 * u[p->row + 1];
  }
  if (reg_is_lugre(s, p)) {
    reg_lugre_trial(&s->opt, s->a.set->h, p, lambda[s->a.row[p->contact]], v);
    return;
  }
  for (int m = 0; m < p->dim; m++) {
    p->tau[m] = p->pull * p->s[m] + p->G * v[m];
  }
  if (p->mode == REG_STICK || (p->mode == REG_SECANT && p->r > 0)) {
    const double r = (p->mode == REG_STICK) ? 1 : p->r;
    for (int m = 0; m < p->dim; m++) {
      p->tau[m] = -lambda[p->row + m] / (r * axis_unit(p, m));
    }
  }
}

static double bound_of(const reg_part *p, double lambda_n) {
  return (p->sliding ? p->mu_kinetic : p->mu_static) * ((lambda_n > 0) ? lambda_n : 0);
}

/* Static friction holds up to mu_s; once it slides it takes mu_k to hold again (MATHEMATICS 2.3.6). At
 * most one change to and fro in a step. */
static void choose_coefficient(const regularized *s, reg_part *p, double lambda_n) {
  if (reg_is_lugre(s, p)) {
    return; /* mu_k and mu_s are both in its g */
  }
  const bool slides = p->size > bound_of(p, lambda_n);
  if (slides != (p->sliding != 0) && p->flips < 2) {
    p->sliding = slides;
    p->flips = (unsigned char)(p->flips + (p->mu_static > p->mu_kinetic));
  }
}

/* The larger of two, the first where the other is no number: fmax as one instruction. */
static inline double most(double a, double b) {
  return (b > a) ? b : a;
}

double reg_law_residual(regularized *s, const double *lambda, const double *u) {
  double largest = 0;
  double worst = 0;
  for (int i = 0; i < s->a.n_contact; i++) {
    const double ln = lambda[s->a.row[i]];
    largest = most(largest, fabs(ln));
    for (int k = s->part_start[i]; k < s->part_start[i + 1]; k++) {
      reg_part *p = &s->part[k];
      trial(s, p, lambda, u);
      p->size = norm_of(p->tau, p->dim);
      choose_coefficient(s, p, ln);
      const double bound = bound_of(p, ln);
      const double scale = (p->size > bound) ? bound / p->size : 1;
      const double inverse = (p->kind == 0) ? 1 : 1 / p->mu_static;
      for (int m = 0; m < p->dim; m++) {
        const double l = lambda[p->row + m] / axis_unit(p, m);
        worst = most(worst, fabs(l + scale * p->tau[m]) * inverse);
        largest = most(largest, fabs(l) * inverse);
      }
      p->next_r = scale;
      p->load = bound * inverse;
    }
  }
  s->largest = largest;
  return (largest > 0) ? worst / largest : 0;
}

/* Carries and asks for nothing that the tolerance can see: its direction is noise (MATHEMATICS 2.5). */
bool reg_is_idle(const regularized *s, const reg_part *p) {
  const double least = s->opt.tol * s->largest;
  return p->load <= least && p->size <= least;
}

static void store(regularized *s, const reg_part *p, const double *next) {
  const int g = s->a.group[p->contact];
  double *m = contact_memory_now(&s->memory, g) + PAST_PARTS + (ptrdiff_t)PAST_PART * p->kind;
  m[PAST_MODE] = (p->next_r < 1 && !reg_is_idle(s, p)) ? REG_SLIP : REG_STICK;
  m[PAST_SLIDING] = p->sliding;
  m[PAST_R] = reg_is_lugre(s, p) ? p->next_eta : p->next_r;
  carry(s->a.set, g, p->dim, next, m + PAST_S);
  if (m[PAST_MODE] == REG_SLIP && p->size > 0) {
    const double d[2] = {p->tau[0] / p->size, p->tau[1] / p->size};
    carry(s->a.set, g, p->dim, d, m + PAST_D);
  }
}

/* Law impulse and next state of one part; lambda gets the impulse. */
static void settle(regularized *s, const reg_part *p, double ln, double *lambda, double *next) {
  const double h = s->a.set->h;
  const double creep = h * p->k + p->c;
  const bool idle = reg_is_idle(s, p); /* what the tolerance cannot see stays as it was solved */
  for (int m = 0; m < p->dim; m++) {
    const double unit = axis_unit(p, m);
    const double l = idle ? lambda[p->row + m] / unit : -p->next_r * p->tau[m];
    lambda[p->row + m] = l * unit;
    if (reg_is_lugre(s, p)) {
      next[m] = (ln > 0) ? reg_lugre_state(p, h, m) : 0;
    } else if (p->next_r < 1) {
      next[m] = (creep > 0) ? (-l + p->c * p->s[m]) / creep : 0;
    } else if (p->G > 0) { /* s + h v_t with v_t = -(l + h k s)/G */
      next[m] = p->s[m] - h * (l + p->pull * p->s[m]) / p->G;
    }
  }
}

static void report(regularized *s, const reg_part *p, double ln) {
  formulation_answer *out = &s->answer;
  const double bound = bound_of(p, ln);
  const double h = s->a.set->h;
  out->stiffness_ratio = fmin(out->stiffness_ratio, p->G / p->m);
  s->a.mode[s->a.group[p->contact]] = (unsigned char)((ln > 0) ? 1 + (p->next_r < 1) : 0);
  if (p->k > 0) {
    out->deflection = fmax(out->deflection, bound / (h * p->k));
  } else if (p->c > 0) {
    out->v_slip = fmax(out->v_slip, bound / (h * p->c));
  }
}

void reg_commit(regularized *s, double *lambda) {
  const contact_set *c = s->a.set;
  for (int i = 0; i < s->a.n_contact; i++) {
    contact_memory_now(&s->memory, s->a.group[i])[1] = lambda[s->a.row[i]];
    s->a.mode[s->a.group[i]] = (lambda[s->a.row[i]] > 0) ? 2 : 0; /* no friction: slides */
  }
  for (int k = 0; k < s->n_part; k++) {
    const reg_part *p = &s->part[k];
    const double ln = lambda[s->a.row[p->contact]];
    double next[2] = {0, 0};
    settle(s, p, ln, lambda, next);
    if (ln > 0 || c->gap[s->a.group[p->contact]] <= 10 * c->tol) { /* else separated: forgotten */
      s->answer.spring_energy += 0.5 * p->k * (next[0] * next[0] + next[1] * next[1]);
      store(s, p, next);
    }
    if (p->kind == 0) {
      report(s, p, ln);
    }
  }
}

int reg_stride(void) {
  return REG_STRIDE;
}
