/* Joints in the event-driven formulation: what their turning adds to accelerations, against
 * differences; every kind conserves what it must and stays closed; linkages and impacts through
 * joints against closed forms and equations of motion of their own. */
#include "formulations/formulation.h"
#include "problems/vec.h"
#include "tests/support/small_world.h"
#include "tests/support/tableau.h"

static base_error err;
static const unsigned all = ~(unsigned)(EFFECT_ROLLING | EFFECT_TORSION);

static base_status solve(void *ctx, const lcp_problem *p, double *z, lcp_outcome *claimed,
                         base_error *e) {
  (void)ctx;
  (void)e;
  *claimed = (p->M.n > 0) ? tableau_solve(p, z) : LCP_SOLVED;
  return BASE_OK;
}

static spec_joint *add_joint(scene_spec *s, spec_joint_kind kind, int a, int b, const double *at,
                             const double *axis) {
  spec_joint *j;
  check_ok(spec_add_joint(s, "j", &j, &err), &err);
  j->kind = kind;
  j->body = a;
  j->other = b;
  v3_copy(at, j->anchor);
  v3_copy(axis, j->axis);
  return j;
}

/* Most that a contact of the answer rubs beyond its cone or pulls [N s]. */
static double out_of_cone(const formulation_answer *a) {
  const contact_set *c = a->set;
  double worst = 0.0;
  for (int g = 0; g < c->n_contact; g++) {
    const double *f = a->impulse + c->row_start[g];
    const int n = c->rows[g].tangent;
    const double friction = (n == 2) ? hypot(f[1], f[2]) : (n == 1 ? fabs(f[1]) : 0.0);
    worst = fmax(worst, fmax(-f[0], friction - c->mu_static[g] * f[0]));
  }
  return worst;
}

static void run(world *w, double duration, int steps) {
  const formulation *f = formulation_find("event");
  const formulation_solver solver = {.solve = solve};
  formulation_run *r;
  formulation_answer a;
  unsigned char opt[256];
  base_fields_default(f->fields, f->n_fields, opt);
  check_ok(formulation_open(&r, f, opt, &err), &err);
  for (int k = 0; k < steps; k++) {
    check_ok(formulation_step(r, w, duration / steps, &solver, &a, &err), &err);
    assert_true(a.solved);
    assert_true(out_of_cone(&a) <= 1e-7);
  }
  formulation_close(r);
}

static double joint_error(world *w) {
  contact_set c;
  double worst = 0.0;
  check_ok(world_contacts(w, 1e-6, 0.0, &c, &err), &err);
  for (int r = c.row_start[c.n_contact]; r < c.n_row; r++) {
    worst = fmax(worst, fabs(c.joint_error[r - c.row_start[c.n_contact]]));
    worst = fmax(worst, fabs(c.u_before[r]));
  }
  return worst;
}

/* Two spinning bodies, apart and turned, held by one joint of the kind; nothing else acts. */
static void open_pair(scene_spec *s, int dim, spec_joint_kind kind) {
  const double x = sqrt(0.5), at[3] = {0.5, 0.2, (dim == 3) ? 0.1 : 0.0};
  const double axis[3] = {0.6, 0.8, 0.0};
  spec_init(s);
  s->dim = dim;
  s->duration = 1.0;
  spec_body *a = add_body(s, "a", SPEC_BOX, 0.1);
  a->vel[0] = 0.3;
  a->omega[2] = 2.0;
  a->omega[0] = (dim == 3) ? -1.0 : 0.0;
  spec_body *b = add_body(s, "b", SPEC_BOX, 0.1);
  b->pos[0] = 1.0;
  b->mass = 3.0;
  b->vel[1] = 1.0;
  b->omega[2] = -1.5;
  b->omega[1] = (dim == 3) ? 0.7 : 0.0;
  b->angle = 0.3;
  check_ok(spec_add_no_collision(s, "a", "b", &err), &err);
  if (dim == 3) {
    b->quat[0] = b->quat[3] = x;
  }
  spec_joint *j = add_joint(s, kind, 0, 1, at, axis);
  v3_copy((const double[]){0.9, -0.1, 0.0}, j->other_anchor);
}

/* u_curve of the joint rows = (u(+d) - u(-d))/(2 d) h at fixed velocities, up to the part along the
 * other rows of the joint, which is none once their velocities are. */
static void curvature_is_the_rate_of_the_rows(void **state) {
  (void)state;
  const double d = 1e-5, h = 1e-3;
  for (int dim = 2; dim <= 3; dim++) {
    for (int kind = SPEC_BALL; kind <= SPEC_DISTANCE; kind++) {
      scene_spec s;
      world *w;
      contact_set c;
      double config[14], v[12], rate[14], moved[14], u[2][6], curve[6];
      open_pair(&s, dim, (spec_joint_kind)kind);
      check_ok(world_open(&w, &s, all, &err), &err);
      run(w, 0.1, 1);
      world_get_state(w, config, v);
      world_config_rate(w, config, v, rate);
      check_ok(world_contacts_curved(w, h, 0.0, &c, &err), &err);
      const int n = c.n_row;
      assert_true(c.n_contact == 0 && n > 0);
      memcpy(curve, c.u_curve, (size_t)n * sizeof *curve);
      for (int side = 0; side < 2; side++) {
        for (int i = 0; i < world_n_config(w); i++) {
          moved[i] = config[i] + (2 * side - 1) * d * rate[i];
        }
        world_set_state(w, world_time(w), moved, v);
        check_ok(world_contacts(w, h, 0.0, &c, &err), &err);
        memcpy(u[side], c.u_before, (size_t)n * sizeof *u[side]);
      }
      for (int r = 0; r < n; r++) {
        check_close(curve[r] / h, (u[1][r] - u[0][r]) / (2 * d), 1e-7);
      }
      world_close(w);
      spec_free(&s);
    }
  }
}

/* Free in space, every kind keeps energy and both momenta, and stays closed. */
static void every_joint_conserves(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    for (int kind = SPEC_BALL; kind <= SPEC_DISTANCE; kind++) {
      scene_spec s;
      world *w;
      double p0[3], L0[3], p[3], L[3];
      open_pair(&s, dim, (spec_joint_kind)kind);
      check_ok(world_open(&w, &s, all, &err), &err);
      world_momentum(w, p0);
      world_angular_momentum(w, L0);
      run(w, 1e-9, 1); /* velocities that the joint forbids are gone, momenta stay */
      const double E0 = world_energy(w);
      run(w, 2.0, 10);
      world_momentum(w, p);
      world_angular_momentum(w, L);
      for (int k = 0; k < 3; k++) {
        check_close(p[k], p0[k], 1e-12);
        check_close(L[k], L0[k], 1e-8);
      }
      check_close(world_energy(w), E0, 1e-8);
      check_close(joint_error(w), 0.0, 2e-15);
      world_close(w);
      spec_free(&s);
    }
  }
}

/* A parallelogram of rods in space, each joint a hinge: 20 rows on 18 coordinates that move in one way, so
 * three rows say what others say. Sides of length l swing alike, the coupler only translates:
 * (2 m l^2/3 + m l^2) theta'' = -2 m g l cos theta, theta from the horizontal. */
static void a_redundant_loop_swings(void **state) {
  (void)state;
  const double l = 0.5, m = 2.0, start = -0.8, out[3] = {0, 1, 0};
  const double x = l * cos(start), z = l * sin(start);
  scene_spec s;
  world *w;
  spec_init(&s);
  s.dim = 3;
  s.duration = 1.0;
  s.gravity[2] = -9.81;
  s.friction.dflt = 0.0;
  const double centre[3][3] = {{x / 2, 0, z / 2}, {1 + x / 2, 0, z / 2}, {0.5 + x, 0, z}};
  for (int i = 0; i < 3; i++) {
    spec_body *b = add_body(&s, (const char *[]){"left", "right", "coupler"}[i], SPEC_BOX, 1e-3);
    v3_copy(centre[i], b->pos);
    b->inertia[0] = b->inertia[1] = b->inertia[2] = m * l * l / 12;
  }
  add_joint(&s, SPEC_HINGE, 0, -1, (const double[]){0, 0, 0}, out);
  add_joint(&s, SPEC_HINGE, 1, -1, (const double[]){1, 0, 0}, out);
  add_joint(&s, SPEC_HINGE, 0, 2, (const double[]){x, 0, z}, out);
  add_joint(&s, SPEC_HINGE, 1, 2, (const double[]){1 + x, 0, z}, out);
  check_ok(world_open(&w, &s, all, &err), &err);
  run(w, 1.2, 12);
  double th = start, om = 0.0;
  const double k = -2 * 9.81 / (5.0 / 3.0 * l), dt = 1.2 / 20000;
  for (int i = 0; i < 20000; i++) { /* Runge-Kutta of order 4 */
    const double a1 = k * cos(th), a2 = k * cos(th + dt / 2 * om);
    const double a3 = k * cos(th + dt / 2 * om + dt * dt / 4 * a1);
    const double a4 = k * cos(th + dt * om + dt * dt / 2 * a2);
    th += dt * om + dt * dt / 6 * (a1 + a2 + a3);
    om += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  check_close(observe(w, "coupler.x"), 0.5 + l * cos(th), 1e-8);
  check_close(observe(w, "coupler.z"), l * sin(th), 1e-8);
  check_close(observe(w, "coupler.omega"), 0.0, 1e-9);
  check_close(joint_error(w), 0.0, 1e-14);
  world_close(w);
  spec_free(&s);
}

/* Steady precession of a ball whose arm, at the angle alpha to the vertical, goes round at the rate W,
 * the ball turning with it: its own angular momentum I W about the vertical is constant, so that
 * m L^2 sin(alpha) cos(alpha) W^2 = m g L sin(alpha). */
static void a_conical_pendulum_precesses(void **state) {
  (void)state;
  const double L = 0.5, alpha = 0.8, W = sqrt(9.81 / (L * cos(alpha)));
  scene_spec s;
  world *w;
  spec_init(&s);
  s.dim = 3;
  s.duration = 1.0;
  s.gravity[2] = -9.81;
  spec_body *b = add_body(&s, "bob", SPEC_SPHERE, 0.1);
  b->inertia[0] = b->inertia[1] = b->inertia[2] = 0.02;
  b->pos[0] = L * sin(alpha);
  b->pos[2] = -L * cos(alpha);
  b->vel[1] = W * L * sin(alpha);
  b->omega[2] = W;
  add_joint(&s, SPEC_BALL, 0, -1, (const double[]){0, 0, 0}, (const double[]){0, 0, 1});
  check_ok(world_open(&w, &s, all, &err), &err);
  run(w, 2.0, 20);
  check_close(observe(w, "bob.x"), L * sin(alpha) * cos(2 * W), 1e-8);
  check_close(observe(w, "bob.y"), L * sin(alpha) * sin(2 * W), 1e-8);
  check_close(observe(w, "bob.z"), -L * cos(alpha), 1e-8);
  world_close(w);
  spec_free(&s);
}

/* A bead on a line that turns with a free bar: r'' = r w^2 relative, angular momentum kept. Of two bodies
 * of masses m and M with moments I and J: with mu = m M/(m + M), L = (I + J + mu r^2) w and
 * E = mu r'^2/2 + L^2/(2 (I + J + mu r^2)); r' follows from r. */
static void a_bead_slides_along_a_turning_bar(void **state) {
  (void)state;
  const double r0 = 0.6, w0 = 3.0, m = 2.0, M = 2.0, moments = 1.0, mu = m * M / (m + M);
  scene_spec s;
  world *w;
  spec_init(&s);
  s.dim = 2;
  s.duration = 1.0;
  spec_body *a = add_body(&s, "bead", SPEC_BOX, 0.01);
  a->pos[0] = r0;
  a->vel[1] = w0 * r0;
  a->inertia[0] = 0.5;
  a->omega[2] = w0;
  spec_body *b = add_body(&s, "bar", SPEC_BOX, 0.01);
  b->inertia[0] = 0.5;
  b->omega[2] = w0;
  add_joint(&s, SPEC_SLIDER, 0, 1, (const double[]){r0, 0, 0}, (const double[]){1, 0, 0});
  check_ok(world_open(&w, &s, all, &err), &err);
  run(w, 1.0, 10);
  const double x = observe(w, "bead.x") - observe(w, "bar.x");
  const double y = observe(w, "bead.y") - observe(w, "bar.y");
  const double vx = observe(w, "bead.vx") - observe(w, "bar.vx");
  const double vy = observe(w, "bead.vy") - observe(w, "bar.vy");
  const double r = hypot(x, y), rate = (x * vx + y * vy) / r, L = (moments + mu * r0 * r0) * w0;
  const double now = moments + mu * r * r;
  assert_true(r > 1.5); /* it has gone far out */
  check_close(observe(w, "bar.omega.z"), L / now, 1e-8);
  check_close(rate * rate, L * L / mu * (1 / (moments + mu * r0 * r0) - 1 / now), 1e-7);
  world_close(w);
  spec_free(&s);
}

/* A ball hits the free end of the lower of two equal rods that hang from a pin, all at rest. Impulse P on
 * it, h between the rods: angular momentum of the lower about the hinge, of both about the pin, and
 * Newton's law for the speeds. With I = m l^2/3 about an end, rods of length l:
 *   upper about the pin:     I w1 = H l,        lower about its centre: m (l w1 + l w2/2) = P - H,
 *   (m l^2/12) w2 = (P + H) l/2,                ball: m_b (v - v0) = -P, l w1 + l w2 - v = e v0. */
static void an_impact_goes_through_joints(void **state) {
  (void)state;
  const double l = 1.0, m = 2.0, mb = 1.0, v0 = 3.0, e = 0.5, none[3] = {0};
  scene_spec s;
  world *w;
  spec_init(&s);
  s.dim = 2;
  s.duration = 1.0;
  s.restitution.dflt = e;
  const double at[3][3] = {{0, -0.5, 0}, {0, -1.5, 0}, {-0.2, -2.0, 0}};
  for (int i = 0; i < 3; i++) {
    spec_body *b = add_body(&s, (const char *[]){"upper", "lower", "ball"}[i],
                            (i == 2) ? SPEC_SPHERE : SPEC_BOX, (i == 2) ? 0.1 : 0.05);
    v3_copy(at[i], b->pos);
    b->mass = (i == 2) ? mb : m;
    b->inertia[0] = m * l * l / 12;
    b->shape.half[1] = 0.52; /* the ball meets the flat side at the height of the end */
    b->vel[0] = (i == 2) ? v0 : 0.0;
  }
  check_ok(spec_add_no_collision(&s, "upper", "lower", &err), &err);
  add_joint(&s, SPEC_BALL, 0, -1, none, none);
  add_joint(&s, SPEC_BALL, 1, 0, (const double[]){0, -1, 0}, none);
  check_ok(world_open(&w, &s, all, &err), &err);
  run(w, 0.05 / v0 + 1e-9, 1);
  /* rates per unit of P: H = m l w1/3, w2 = 6 (P + H)/(m l), m l (w1 + w2/2) = P - H */
  const double per1 = -2.0 / (1.0 + 1.0 / 3.0 + 1.0) / (m * l);
  const double per2 = 6.0 / (m * l) * (1.0 + m * l * per1 / 3.0);
  const double P = (1 + e) * v0 / (l * per1 + l * per2 + 1 / mb);
  check_close(observe(w, "upper.omega.z"), per1 * P, 1e-7);
  check_close(observe(w, "lower.omega.z"), per2 * P, 1e-7);
  check_close(observe(w, "ball.vx"), v0 - P / mb, 1e-7);
  world_close(w);
  spec_free(&s);
}

/* A bar with round ends of radius r lies on the floor; a ball joint holds it at the centre of one end, above the floor by r. Turned about
 * the vertical by p and about itself by q, it slips at the other end, L away, by v = L p + r q across the bar; along the bar it cannot
 * move, so that a force along the line from the contact to the joint does nothing, and friction is no more determined by the motion
 * than the normal force. With P the impulse of friction, I p' = -L P', J q' = -r P' (J about the bar, I across it through the joint)
 * and L N = m g L/2 - J p q about the third axis; P' = mu N until v = 0, from where on it rolls. */
static void a_pinned_bar_slips_until_it_rolls(void **state) {
  (void)state;
  const double L = 0.4, r = 0.05, m = 2.0, g = 9.81, none[3] = {0};
  const double J = 0.004, I = 0.03 + m * L * L / 4, rate = L * L / I + r * r / J;
  for (int k = 0; k < 12; k++) {
    const double mu = (double[]){0.05, 0.3, 1.0, 1.7}[k % 4],
                 p0 = (double[]){1.0, -2.0, 0.3}[k / 4];
    const double along = 0.5 * (k % 3), at[3] = {-0.5 * L * cos(along), -0.5 * L * sin(along), r};
    scene_spec s;
    world *w;
    spec_init(&s);
    s.dim = 3;
    s.duration = 1.0;
    s.gravity[2] = -g;
    s.friction.dflt = mu;
    add_floor(&s, 3);
    spec_body *b = add_body(&s, "bar", SPEC_ROD, r);
    b->shape.half[0] = 0.5 * L;
    b->inertia[0] = J;
    b->inertia[1] = b->inertia[2] = 0.03;
    b->pos[2] = r;
    b->quat[0] = cos(0.5 * along);
    b->quat[3] = sin(0.5 * along);
    b->vel[0] = -p0 * 0.5 * L * sin(along);
    b->vel[1] = p0 * 0.5 * L * cos(along);
    b->omega[2] = p0;
    add_joint(&s, SPEC_BALL, 0, -1, at, none);
    check_ok(world_open(&w, &s, all, &err), &err);
    run(w, 0.2, 40);
    /* the angle turned, by the same equations in steps of the midpoint rule */
    double P = 0.0, angle = along;
    const double stop = fabs(L * p0) / rate, sign = (p0 > 0.0) ? 1.0 : -1.0, dt = 0.2 / 40000;
    for (int n = 0; n < 40000; n++) {
      double half = P;
      for (int stage = 0; stage < 2; stage++) {
        const double p = p0 - sign * L * half / I, q = -sign * r * half / J;
        const double pushed = P + (0.5 + 0.5 * stage) * dt * mu * (0.5 * m * g - J * p * q / L);
        half = fmin(pushed, stop);
      }
      angle += dt * (p0 - sign * L * 0.5 * (P + half) / I);
      P = half;
    }
    const double p = p0 - sign * L * P / I, q = -sign * r * P / J;
    check_close(observe(w, "bar.omega.z"), p, 1e-7);
    check_close(observe(w, "bar.omega.x"), q * cos(angle), 1e-5);
    check_close(observe(w, "bar.x"), at[0] + 0.5 * L * cos(angle), 1e-6);
    check_close(observe(w, "bar.y"), at[1] + 0.5 * L * sin(angle), 1e-6);
    check_close(observe(w, "bar.z"), r, 1e-9);
    world_close(w);
    spec_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(curvature_is_the_rate_of_the_rows),
      cmocka_unit_test(every_joint_conserves),
      cmocka_unit_test(a_redundant_loop_swings),
      cmocka_unit_test(a_conical_pendulum_precesses),
      cmocka_unit_test(a_bead_slides_along_a_turning_bar),
      cmocka_unit_test(an_impact_goes_through_joints),
      cmocka_unit_test(a_pinned_bar_slips_until_it_rolls),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
