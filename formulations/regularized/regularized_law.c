/* regularized_law.c - friction parts: stiffness, transported state, the law, memory. */
#include "formulations/bristle.h"
#include "formulations/regularized/regularized.h"

#include <float.h>
#include <string.h>

/* k, c and G = h^2 k + h c. With a fixed ratio, G = ratio m_t and c = 2 zeta sqrt(k m_t). Torsion
 * and rolling turn the stiffness of the contact into that of a spring at arm `mu` [m]. Contacts that share a
 * stiffness have a part of it each. */
static void set_stiffness(const reg_options *o, double h, bool boost, reg_part *p) {
  const double arm = (p->kind == 0) ? 1 : p->mu_static;
  const bool viscous = o->model == REG_VISCOUS;
  const double m = p->share * p->m, fixed = p->share * arm * arm;
  if (o->stiffness == 0) {
    const double root = viscous ? 0 : sqrt(o->zeta * o->zeta + o->ratio) - o->zeta;
    p->k = root * root * m / (h * h);
    p->c = (viscous ? o->ratio : 2 * o->zeta * root) * m / h;
  } else {
    p->k = viscous ? 0 : o->k * fixed;
    p->c = o->c * fixed;
  }
  p->G = h * h * p->k + h * p->c;
  p->pull = h * p->k;
  if (boost && p->G > 0 && p->G < o->ratio * m) {
    const double up = o->ratio * m / p->G;
    p->k *= up;
    p->c *= up;
    p->G *= up;
    p->pull *= up;
  }
}

/* The direction of row m of a part in the rows of its kind in the set. */
static void axis_of(const regularized *s, const reg_part *p, int m, double axis[2]) {
  int first;
  (void)form_bristle_rows(s->a.set->rows[s->a.group[p->contact]], p->kind, &first);
  axis[0] = m == 0;
  axis[1] = m == 1;
  if (s->a.turned[p->contact]) {
    const form_direction *d = &s->a.direction[p->row + m];
    const int at = d->row - first;
    axis[at] = d->c[0];
    axis[1 - at] = (d->n == 2) ? d->c[1] : 0;
  }
}

/* A vector of the part's own rows from one over the rows of its kind in the set, and back. */
static void to_part(const regularized *s, const reg_part *p, const double in[2], double *out) {
  for (int m = 0; m < p->dim; m++) {
    double axis[2];
    axis_of(s, p, m, axis);
    out[m] = axis[0] * in[0] + axis[1] * in[1];
  }
}

static void from_part(const regularized *s, const reg_part *p, const double *in, double out[2]) {
  out[0] = 0;
  out[1] = 0;
  for (int m = 0; m < p->dim; m++) {
    double axis[2];
    axis_of(s, p, m, axis);
    out[0] += axis[0] * in[m];
    out[1] += axis[1] * in[m];
  }
}

bool reg_is_lugre(const regularized *s, const reg_part *p) {
  return s->opt.model == REG_LUGRE && p->kind == 0;
}

/* Slower than this share of the largest free velocity of the step is no sliding to begin with. */
static const double slow = 0.01;

/* The normal impulse that would stop the approach of the part's contact if nothing else did [N s]. */
static double alone(const regularized *s, const reg_part *p) {
  const form_assembly *a = &s->a;
  const int i = p->contact;
  const double own = form_own_block(a, i)[0];
  const double approach = fmax(0.0, -(a->r[a->row[i]] + a->bias[a->group[i]]));
  return (own > 0) ? approach / own : 0;
}

static double bound_of(const reg_part *p, double lambda_n) {
  return (p->sliding ? p->mu_kinetic : p->mu_static) * ((lambda_n > 0) ? lambda_n : 0);
}

/* Where the first solve of a cold step begins, from the state alone: a contact that slides before the step slips, unless
 * friction could stop it, with the normal impulse that would stop its approach if nothing else did; everything else sticks. */
static void guess(const regularized *s, reg_part *p) {
  const form_assembly *a = &s->a;
  const int i = p->contact, g = a->group[i];
  double before[REG_ROWS_MAX], tau[2] = {0, 0};
  const double lambda_n = alone(s, p);
  const double bound = bound_of(p, lambda_n);
  form_to_rows(a, i, a->set->u_before + a->set->row_start[g], before);
  for (int m = 0; m < p->dim; m++) {
    p->v[m] = ((m == 1) ? p->axis2 : 1) * before[p->row - a->row[i] + m];
    tau[m] = p->pull * p->s[m] + p->G * p->v[m];
  }
  const double size = hypot(tau[0], tau[1]);
  const double speed = hypot(p->v[0], p->v[1]);
  const bool slides = speed > slow * s->fastest && p->m * speed > bound;
  p->mode = REG_STICK;
  p->r = 1;
  if (reg_is_lugre(s, p)) {
    p->r = (lambda_n > 0) ? reg_lugre_steady(&s->opt, a->set->h, p, lambda_n) : 1;
  } else if (slides && size > bound) {
    p->mode = REG_SLIP;
    p->r = bound / size;
    p->d[0] = tau[0] / size;
    p->d[1] = tau[1] / size;
  }
}

/* An impulse along axis m is this many units of the circular law. */
static double axis_unit(const reg_part *p, int m) {
  return (m == 1) ? p->axis2 : 1;
}

static double stiffness_of(const regularized *s, const reg_part *p) {
  return reg_is_lugre(s, p) ? p->share * s->opt.sigma0 : p->k;
}

/* Where an entry has what is remembered of a kind of part. */
static int own_of(const regularized *s, int kind) {
  return contact_memory_own(&s->memory) + REG_PAST_PARTS + REG_PAST_PART * kind;
}

/* The last step was this formulation's. */
static bool is_own(const regularized *s, const double *past) {
  return past[contact_memory_own(&s->memory) + REG_PAST_OWN] > 0;
}

/* Modes of the last step, with their directions and factors. */
static void restore_mode(const regularized *s, int g, const double *past, reg_part *p) {
  const double *m = past + own_of(s, p->kind);
  int first;
  p->mode = (unsigned char)m[REG_PAST_MODE];
  p->r = m[REG_PAST_R];
  if (form_bristle_rows(s->a.set->rows[g], p->kind, &first) == 1) {
    p->d[0] = m[REG_PAST_D];
  } else if (p->mode != REG_STICK) {
    double vector[2];
    form_bristle_to_frame(s->a.set, g, form_bristle_turn_of(s->a.set, g), m + REG_PAST_D, vector);
    to_part(s, p, vector, p->d);
  }
  if (p->mode == REG_SECANT) {
    p->mode = REG_SLIP;
  }
}

/* What a slip pulled with is its bound, which an impact in a short step makes as large as it likes. In a longer step it is no more
 * than what this step's load could hold, or than its impulse as a force of this step: kept whole, a force of 1e5 N deflects the
 * softer springs of the longer step by metres, and friction pushes the slip on. */
static void relax(const regularized *s, reg_part *p, double k) {
  const double h = s->a.set->h, h_old = s->memory.h_old;
  const double pulls = k * hypot(p->s[0], p->s[1]);
  if (h > h_old && pulls > 0) {
    const double most = fmax(bound_of(p, alone(s, p)) / h, pulls * h_old / h);
    for (int m = 0; m < p->dim && pulls > most; m++) {
      p->s[m] *= most / pulls;
    }
  }
}

/* The state of the model: deflections from the forces of the springs, which a planar tangent or a torsion has as one number, and
 * which of two coefficients holds. Then the modes: from the last step with start=previous, if that step was this
 * formulation's, or guessed. */
static void restore(const regularized *s, int g, reg_part *p) {
  const double *past = contact_memory_old(&s->memory, g);
  const double k = stiffness_of(s, p);
  const bool warm = s->start == FORM_PREVIOUS;
  p->mode = REG_STICK;
  p->r = 1;
  if (past != NULL && k > 0 && past[PAST_CLOSED] > 0) {
    double force[2], along[2];
    form_bristle_pull(s->a.set, g, p->kind, &s->memory, force);
    to_part(s, p, force, along);
    for (int m = 0; m < p->dim; m++) {
      p->s[m] = along[m] / (k * axis_unit(p, m));
    }
  }
  const int slides = (p->kind == 0) ? contact_memory_slides(&s->memory, s->a.set, g) : 0;
  p->sliding = p->slid = slides > 0;
  p->holds = slides < 0;
  if (past != NULL && is_own(s, past) && s->opt.stiffness == 0 && !reg_is_lugre(s, p) &&
      past[own_of(s, p->kind) + REG_PAST_MODE] == REG_SLIP) {
    relax(s, p, k);
  }
  if (!warm || (past != NULL && past[PAST_CLOSED] > 0 && !is_own(s, past))) {
    guess(s, p);
  } else if (past != NULL) {
    restore_mode(s, g, past, p);
  }
}

static double norm_of(const double *x, int n) {
  return (n == 1) ? fabs(x[0]) : sqrt(x[0] * x[0] + x[1] * x[1]);
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
  double inverse = form_mobility(&s->a, i, row - s->a.row[i], dim);
  if (!(inverse > 0) && kind == 0 && norm_of(s->a.r + row, dim) > 0) {
    inverse = form_own_block(&s->a, i)[0]; /* cannot move, and rubs on what moves past it */
  }
  if (!(inverse > 0) || !(p->mu_static > 0)) {
    return; /* nothing can move, or nothing holds */
  }
  p->m = 1 / inverse;
  p->share = 1.0 / s->sharers[i];
  p->axis2 = (kind == 0 && dim == 2) ? s->opt.ellipse : 1;
  if (kind == 0 && dim == 1 &&
      c->rows[g].tangent == 2) { /* the ellipse along the line that is left */
    double axis[2];
    axis_of(s, p, 0, axis);
    const double along = 1 / hypot(axis[0], axis[1] / s->opt.ellipse);
    p->mu_static *= along;
    p->mu_kinetic *= along;
  }
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

/* A stiffness in proportion to the mass is that of a pair of bodies; one in N/m is that of a contact. */
static form_bristle_shared shared_by(const reg_options *o) {
  if (o->distribution == FORM_EXTREME) {
    return FORM_BRISTLE_EACH;
  }
  const bool by_mass = o->stiffness == 0 && o->model != REG_LUGRE;
  return by_mass ? FORM_BRISTLE_PAIR : FORM_BRISTLE_COPIES;
}

void reg_parts_build(regularized *s) {
  const bool boost = s->opt.impact == 1 && form_has_impact(&s->a, s->opt.repair.rest);
  s->n_part = 0;
  s->fastest = 0;
  form_bristle_sharers(s->a.set, s->a.n_contact, s->a.group, shared_by(&s->opt), s->bodies,
                       s->sharers);
  for (int r = 0; r < s->a.row[s->a.n_contact]; r++) {
    s->fastest = fmax(s->fastest, fabs(s->a.r[r]));
  }
  for (int i = 0; i < s->a.n_contact; i++) {
    const contact_rows rows = s->a.rows[i];
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
  for (int m = 0; m < p->dim && s->opt.pose == REG_CONE; m++) {
    p->tau[m] = p->G * v[m] - lambda[p->row + m]; /* exact where it sticks */
  }
  if (s->opt.pose == REG_CONE) {
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

/* Static friction holds up to mu_s; once it slides it takes mu_k to hold again (MATHEMATICS 2.3.6), but where the slide turned round. At
 * most one change to and fro in a step. */
static void choose_coefficient(const regularized *s, reg_part *p, double lambda_n) {
  if (p->holds || reg_is_lugre(s, p) || s->opt.modes == REG_ONCE) {
    return; /* mu_k and mu_s are both in its g; or what slides was decided before the solve */
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

/* With the default tolerance, an error in the law may change velocities by 1e-6 of the fastest one: what is nothing beside the
 * largest impulse throws a light body under a heavy one. */
static const double of_speed = 1e-3;

double reg_law_residual(regularized *s, const double *lambda, const double *u) {
  double largest = 0;
  double worst = 0;
  double fastest = 0; /* change of velocity that the error of a part would bring [m/s] */
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
        const double missing = fabs(l + scale * p->tau[m]);
        worst = most(worst, missing * inverse);
        fastest = most(fastest, missing / p->m);
        largest = most(largest, fabs(l) * inverse);
      }
      p->next_r = scale;
      p->load = bound * inverse;
    }
  }
  s->largest = largest;
  const double error = (largest > 0) ? worst / largest : 0;
  return (fastest > 0) ? most(error, of_speed * fastest / (s->fastest + DBL_MIN)) : error;
}

/* Carries and asks for nothing that the tolerance can see: its direction is noise (MATHEMATICS 2.5). */
bool reg_is_idle(const regularized *s, const reg_part *p) {
  const double least = s->opt.tol * s->largest;
  return p->load <= least && p->size <= least;
}

/* A vector over the part's rows as it is remembered. */
static void remember(const regularized *s, const reg_part *p, const double *in, double *vector) {
  const int g = s->a.group[p->contact];
  double whole[2];
  int first;
  from_part(s, p, in, whole);
  form_bristle_remember(s->a.set, g, form_bristle_rows(s->a.set->rows[g], p->kind, &first), whole,
                        vector);
}

static void store(regularized *s, const reg_part *p, const double *next) {
  const int g = s->a.group[p->contact];
  double *now = contact_memory_now(&s->memory, g);
  double *m = now + own_of(s, p->kind);
  double force[2] = {0, 0};
  m[REG_PAST_MODE] = (p->next_r < 1 && !reg_is_idle(s, p)) ? REG_SLIP : REG_STICK;
  m[REG_PAST_R] = reg_is_lugre(s, p) ? p->next_eta : p->next_r;
  for (int k = 0; k < p->dim; k++) {
    force[k] = stiffness_of(s, p) * next[k] * axis_unit(p, k);
  }
  remember(s, p, force,
           now + contact_memory_pulls(&s->memory) + (ptrdiff_t)PAST_PULL_NUMBERS * p->kind);
  if (m[REG_PAST_MODE] == REG_SLIP && p->size > 0) {
    const double d[2] = {p->tau[0] / p->size, p->tau[1] / p->size};
    remember(s, p, d, m + REG_PAST_D);
  }
}

/* Law impulse and next state of one part; lambda gets the impulse. */
static void settle(regularized *s, const reg_part *p, double ln, double *lambda, double *next) {
  if (s->opt.modes == REG_ONCE) {
    reg_once_settle(s, p, lambda, next);
    return;
  }
  const double h = s->a.set->h;
  const double creep = h * p->k + p->c;
  /* what the tolerance cannot see stays as it was solved, and so does what was solved with its bound */
  const bool idle = reg_is_idle(s, p) || s->opt.pose == REG_CONE;
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

/* A contact that separated has no spring. */
static void report(regularized *s, const reg_part *p, double ln, bool separated) {
  formulation_answer *out = &s->answer;
  const double bound = bound_of(p, ln);
  const double h = s->a.set->h;
  if (!separated) {
    out->stiffness_ratio = fmin(out->stiffness_ratio, p->G / (p->share * p->m));
  }
  const bool slips = ((s->opt.modes == REG_ONCE) ? p->r : p->next_r) < 1;
  s->a.mode[s->a.group[p->contact]] = (unsigned char)((ln > 0) ? 1 + slips : 0);
  if (p->k > 0) {
    out->deflection = fmax(out->deflection, bound / (h * p->k));
  } else if (p->c > 0) {
    out->v_slip = fmax(out->v_slip, bound / (h * p->c));
  }
}

void reg_commit(regularized *s, double *lambda) {
  const contact_set *c = s->a.set;
  for (int i = 0; i < s->a.n_contact; i++) {
    double *now = contact_memory_now(&s->memory, s->a.group[i]);
    now[contact_memory_own(&s->memory) + REG_PAST_OWN] = 1;
    now[PAST_SPRUNG] = s->opt.model != REG_VISCOUS;
    now[PAST_ENERGY] = 0;
    memset(now + contact_memory_pulls(&s->memory), 0, (size_t)s->memory.layout.pull * sizeof *now);
    s->a.mode[s->a.group[i]] = (lambda[s->a.row[i]] > 0) ? 2 : 0; /* no friction: slides */
  }
  for (int k = 0; k < s->n_part; k++) {
    const reg_part *p = &s->part[k];
    const double ln = lambda[s->a.row[p->contact]];
    double next[2] = {0, 0};
    settle(s, p, ln, lambda, next);
    const bool separated = !(ln > 0) && c->gap[s->a.group[p->contact]] > 10 * c->tol;
    if (!separated) { /* else forgotten */
      const double energy = 0.5 * p->k * (next[0] * next[0] + next[1] * next[1]);
      s->answer.spring_energy += energy;
      contact_memory_now(&s->memory, s->a.group[p->contact])[PAST_ENERGY] += energy;
      store(s, p, next);
    }
    if (p->kind == 0) {
      report(s, p, ln, separated);
    }
  }
  for (int i = 0; i < s->a.n_contact; i++) {
    double *now = contact_memory_now(&s->memory, s->a.group[i]);
    form_to_set(&s->a, i, lambda + s->a.row[i], now + PAST_IMPULSE);
  }
}

/* The friction between two shapes in the step. */
typedef struct two_shapes {
  int n;              /* parts */
  bool fell;          /* one of them held before, and slides */
  double took, could; /* impulses; by static friction of all [N s] */
  double slip;        /* the most that it grew by [m/s] */
  double inverse;     /* what an impulse on all of them changes that by [1/kg] */
} two_shapes;

/* An impulse on contacts all around turns no body: 1/m of both, or less, where there are joints. */
static double moved_by(const regularized *s, const reg_part *p) {
  const contact_set *c = s->a.set;
  double inverse = 0;
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * (ptrdiff_t)s->a.group[p->contact] + side];
    inverse += (contact_dofs(c, b) > 0) ? 1 / c->mass[c->mass_start[b]] : 0;
  }
  return fmin(inverse, 1 / p->m);
}

static void add_to_two(regularized *s, const reg_part *p, two_shapes *t) {
  const int g = s->a.group[p->contact];
  const double *now = contact_memory_now(&s->memory, g);
  const bool held = !p->slid && contact_memory_closed(&s->memory, g);
  double l[2] = {0, 0};
  double before[REG_ROWS_MAX];
  for (int m = 0; m < p->dim; m++) {
    l[m] = s->lambda[p->row + m] / axis_unit(p, m);
  }
  form_to_rows(&s->a, p->contact, s->a.set->u_before + s->a.set->row_start[g], before);
  const double slip = norm_of(before + p->row - s->a.row[p->contact], p->dim);
  t->n++;
  t->fell = t->fell || (now[PAST_SLIDES] > 0 && held && p->mu_kinetic < p->mu_static);
  t->took += norm_of(l, p->dim);
  t->could += p->mu_static * fmax(s->lambda[s->a.row[p->contact]], 0);
  t->slip = fmax(t->slip, form_slip_speed(&s->a, p->contact) - slip);
  t->inverse = fmax(t->inverse, moved_by(s, p));
}

/* Did contacts of two shapes begin to slide that all of them together could have held? Equal bristles take equal shares: those with less normal
 * force give way, and leave theirs to the others. */
static bool gave_way(const two_shapes *t) {
  static const double sure = 1e-3;
  return t->n > 1 && t->fell && t->took + t->slip / t->inverse < (1 - sure) * t->could;
}

static bool any_gave_way(regularized *s) {
  two_shapes t = {0};
  uint64_t last = 0;
  bool any = false;
  for (int k = 0; k < s->n_part && !any; k++) {
    const reg_part *p = &s->part[k];
    const uint64_t now = contact_shapes_of(s->a.set->id[s->a.group[p->contact]]);
    if (p->kind != 0) {
      continue;
    }
    if (now != last) {
      any = gave_way(&t);
      t = (two_shapes){0};
      last = now;
    }
    add_to_two(s, p, &t);
  }
  return any || gave_way(&t);
}

/* Is static friction of some part more than kinetic? */
static bool has_two(const regularized *s) {
  bool two = false;
  for (int k = 0; k < s->n_part && !two; k++) {
    two = s->part[k].mu_kinetic < s->part[k].mu_static;
  }
  return two;
}

void reg_note_slides(regularized *s) {
  const bool two = has_two(s);
  const form_slip slip = two ? form_slip_of(&s->a, s->opt.repair.rest) : (form_slip){0};
  for (int k = 0; k < s->n_part; k++) {
    const reg_part *p = &s->part[k];
    const bool slides = p->sliding || (p->holds && p->next_r < 1);
    if (p->kind == 0 && slides && s->a.mode[s->a.group[p->contact]] != 0) {
      form_note_slide(&s->a, p->contact, &slip, &s->memory);
    }
  }
  s->answer.gave_way = two && any_gave_way(s);
}

contact_layout reg_layout(const contact_set *c) {
  const int kinds = contact_memory_kinds(c);
  return contact_memory_need(kinds, true, REG_PAST_PARTS + kinds * REG_PAST_PART);
}
