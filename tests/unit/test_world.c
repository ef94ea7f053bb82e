/* Worlds: free motion, what effects cost, memory, and what cannot be opened. */
#include "problems/vec.h"
#include "tests/support/contact_velocity.h"
#include "tests/support/small_world.h"

#include <string.h>

static base_error err;

static void step_free(world *w, double h, int n) {
  contact_set c;
  for (int i = 0; i < n; i++) {
    check_ok(world_contacts(w, h, -1.0, &c, &err), &err);
    check_ok(contact_set_check(&c, &err), &err);
    check_ok(world_advance(w, c.v_free, NULL, &err), &err);
  }
}

/* z_N = v0 T - g T^2/2 - g h T/2 exactly for semi-implicit Euler. */
static void free_flight_hits_the_exact_discrete_answer(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    scene_spec s;
    world *w;
    spec_init(&s);
    s.dim = dim;
    s.gravity[dim - 1] = -9.81;
    s.duration = 1.0;
    spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
    b->vel[0] = 3.0;
    b->vel[dim - 1] = 5.0;
    b->omega[2] = 2.0;
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    step_free(w, 0.01, 100);
    check_close(observe(w, dim == 2 ? "ball.y" : "ball.z"), 5.0 - 9.81 / 2 - 9.81 * 0.01 / 2,
                1e-12);
    check_close(observe(w, "ball.x"), 3.0, 1e-12);
    check_close(observe(w, dim == 2 ? "ball.omega" : "ball.omega.z"), 2.0, 1e-12);
    check_close(world_time(w), 1.0, 1e-12);
    assert_true(world_min_gap(w) == HUGE_VAL);
    world_close(w);
    spec_free(&s);
  }
}

/* What each effect costs in dofs and rows, for a box of four corners on a floor. */
static void counts(int dim, unsigned effects, int n_dof, int n_contact, int n_row) {
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = dim;
  s.gravity[dim - 1] = -9.81;
  s.duration = 1.0;
  s.friction.dflt = 0.5;
  s.rolling.dflt = 0.01;
  s.torsion.dflt = 0.01;
  spec_body *b = add_body(&s, "box", SPEC_BOX, 0.1);
  b->pos[dim - 1] = 0.1;
  b->omega[2] = 1.0;
  add_floor(&s, dim);
  check_ok(world_open(&w, &s, effects, &err), &err);
  check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
  check_ok(contact_set_check(&c, &err), &err);
  assert_int_equal(c.n_dof, n_dof);
  assert_int_equal(c.n_contact, n_contact);
  assert_int_equal(c.n_row, n_row);
  assert_true((c.mu_torsion != NULL) == ((effects & EFFECT_TORSION) != 0));
  check_close(observe(w, "box.omega.z"), (effects & EFFECT_ROTATION) != 0 ? 1.0 : 0.0, 0.0);
  world_close(w);
  spec_free(&s);
}

static void undeclared_effects_cost_nothing(void **state) {
  (void)state;
  const unsigned base = EFFECT_GRAVITY | EFFECT_CONTACT;
  counts(2, base, 2, 2, 2);
  counts(2, base | EFFECT_ROTATION, 3, 2, 2);
  counts(2, base | EFFECT_FRICTION, 2, 2, 4);
  counts(2, base | EFFECT_ROTATION | EFFECT_FRICTION | EFFECT_ROLLING, 3, 2, 6);
  counts(2, EFFECT_GRAVITY | EFFECT_ROTATION, 3, 0, 0);
  counts(3, base | EFFECT_SPATIAL, 3, 4, 4);
  counts(3, base, 2, 4, 4);
  counts(3, base | EFFECT_FRICTION, 2, 4, 8);
  counts(3, base | EFFECT_SPATIAL | EFFECT_ROTATION, 6, 4, 4);
  counts(3, base | EFFECT_SPATIAL | EFFECT_FRICTION, 3, 4, 12);
  counts(3, base | EFFECT_SPATIAL | EFFECT_ROTATION | EFFECT_FRICTION, 6, 4, 12);
  counts(3, base | EFFECT_SPATIAL | EFFECT_ROTATION | EFFECT_FRICTION | EFFECT_TORSION, 6, 4, 16);
  counts(3,
         base | EFFECT_SPATIAL | EFFECT_ROTATION | EFFECT_FRICTION | EFFECT_TORSION |
             EFFECT_ROLLING,
         6, 4, 24);
}

/* Torque-free asymmetric body: implicit midpoint keeps energy and |L| for every h. */
static void free_spin_keeps_energy_and_momentum(void **state) {
  (void)state;
  const double steps[] = {1e-4, 1e-2, 0.1};
  for (int i = 0; i < BASE_COUNT(steps); i++) {
    scene_spec s;
    world *w;
    double L[3];
    spec_init(&s);
    s.dim = 3;
    s.duration = 1.0;
    spec_body *b = add_body(&s, "body", SPEC_BOX, 0.1);
    b->omega[0] = 0.01;
    b->omega[1] = 5.0;
    b->omega[2] = 0.01;
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    const double E = world_energy(w);
    world_angular_momentum(w, L);
    const double L0 = v3_norm(L);
    step_free(w, steps[i], 1000);
    world_angular_momentum(w, L);
    check_close(world_energy(w) / E, 1.0, 1e-12);
    check_close(v3_norm(L) / L0, 1.0, 1e-12);
    world_close(w);
    spec_free(&s);
  }
}

/* A tower of yawed boxes on the floor, spinning: many contacts, changing features. */
static void busy_scene(scene_spec *s) {
  spec_init(s);
  s->dim = 3;
  s->gravity[2] = -9.81;
  s->duration = 1.0;
  s->friction.dflt = 0.5;
  for (int i = 0; i < 8; i++) {
    char name[] = {'b', (char)('0' + i), '\0'};
    spec_body *b = add_body(s, name, SPEC_BOX, 0.1);
    b->pos[2] = 0.1 + 0.2 * i;
    b->quat[0] = cos(0.2 * i);
    b->quat[3] = sin(0.2 * i);
    b->omega[2] = 0.5 * i;
  }
  add_floor(s, 3);
}

/* Every contact takes a little: something like friction, without a solver. */
static void step_busy(world *w, int n, double *v, double *scratch, double *impulse) {
  contact_set c;
  for (int i = 0; i < n; i++) {
    check_ok(world_contacts(w, 0.001, -1.0, &c, &err), &err);
    for (int k = 0; k < c.n_row; k++) {
      impulse[k] = 1e-3 * (k % 3 == 0);
    }
    contact_velocity(&c, impulse, v, scratch);
    check_ok(world_advance(w, v, impulse, &err), &err);
  }
}

static void steps_do_not_allocate_and_repeat_bit_for_bit(void **state) {
  (void)state;
  double v[48], scratch[48], impulse[1024], q[2][56], u[2][48];
  for (int run = 0; run < 2; run++) {
    scene_spec s;
    world *w;
    busy_scene(&s);
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    step_busy(w, 20, v, scratch, impulse);
    const long before = check_heap_calls;
    step_busy(w, 50, v, scratch, impulse);
    assert_int_equal(check_heap_calls - before, 0);
    assert_int_equal(world_n_config(w), 56);
    world_get_state(w, q[run], u[run]);
    world_close(w);
    spec_free(&s);
  }
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(u[0], u[1], sizeof u[0]);
}

/* A world over the spec that it was given allocates what another does but for the copy, goes on to the same bits, and leaves the spec
 * as it was. */
static void a_borrowed_spec_is_not_copied(void **state) {
  (void)state;
  scene_spec s, copy;
  world *own, *over;
  double v[48], scratch[48], impulse[1024], q[2][56], u[2][48];
  busy_scene(&s);
  long before = check_heap_calls;
  check_ok(spec_copy(&s, &copy, &err), &err);
  const long copying = check_heap_calls - before;
  assert_true(copying > 0);
  before = check_heap_calls;
  check_ok(world_open(&own, &s, ~0u, &err), &err);
  const long owning = check_heap_calls - before;
  before = check_heap_calls;
  check_ok(world_open_over(&over, &s, ~0u, &err), &err);
  assert_int_equal(check_heap_calls - before, owning - copying);
  step_busy(own, 20, v, scratch, impulse);
  step_busy(over, 20, v, scratch, impulse);
  world_get_state(own, q[0], u[0]);
  world_get_state(over, q[1], u[1]);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(u[0], u[1], sizeof u[0]);
  world_close(own);
  world_close(over);
  assert_int_equal(s.n_body, copy.n_body);
  assert_string_equal(s.body[7].name, "b7");
  assert_memory_equal(s.body[7].pos, copy.body[7].pos, sizeof copy.body[7].pos);
  spec_free(&copy);
  spec_free(&s);
}

/* Every heap call of opening and of the first step fails in turn: always ENOMEM, never a crash. */
static void running_out_of_memory_is_reported(void **state) {
  (void)state;
  scene_spec s;
  busy_scene(&s);
  int failures = 0;
  for (long k = 1;; k++) {
    world *w = NULL;
    contact_set c;
    check_heap_fail_at = k;
    base_status status = world_open(&w, &s, ~0u, &err);
    if (status == BASE_OK) {
      status = world_contacts(w, 0.001, -1.0, &c, &err);
    }
    const bool survived = check_heap_fail_at > 0; /* fewer than k calls were made */
    check_heap_fail_at = 0;
    world_close(w);
    if (survived) {
      assert_int_equal(status, BASE_OK);
      break;
    }
    assert_int_equal(status, BASE_ENOMEM);
    failures++;
  }
  assert_true(failures > 30);
  spec_free(&s);
}

/* A ball of radius 0.1 at 2 m/s, 15 mm above the floor: in 10 ms it passes by h v = 20 mm and gravity's share; 5 mm away
 * or closed it does not count, nor does what leaves. */
static void only_a_gap_that_closes_inside_a_step_approaches(void **state) {
  (void)state;
  static const struct {
    double height, speed, approach;
  } cases[] = {{0.115, -2.0, 0.01 * (2.0 + 9.81 * 0.01)},
               {0.125, -2.0, 0.0},
               {0.1, -2.0, 0.0},
               {0.09, -2.0, 0.0},
               {0.101, 2.0, 0.0}};
  for (int i = 0; i < BASE_COUNT(cases); i++) {
    scene_spec s;
    world *w;
    contact_set c;
    spec_init(&s);
    s.dim = 3;
    s.gravity[2] = -9.81;
    s.duration = 1.0;
    spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
    b->pos[2] = cases[i].height;
    b->vel[2] = cases[i].speed;
    add_floor(&s, 3);
    check_ok(world_open(&w, &s, ~0u, &err), &err);
    check_ok(world_contacts(w, 0.01, 1.0, &c, &err), &err);
    check_close(contact_approach(&c), cases[i].approach, 1e-12);
    world_close(w);
    spec_free(&s);
  }
}

static void open_reports_what_it_cannot_do(void **state) {
  (void)state;
  scene_spec s;
  world *w;
  contact_set c;
  spec_init(&s);
  s.dim = 3;
  s.duration = 1.0;
  add_body(&s, "coin", SPEC_DISC3D, 0.1);
  check_ok(world_open(&w, &s, ~(unsigned)EFFECT_CONTACT, &err), &err);
  assert_int_equal(world_contacts(w, 0.0, -1.0, &c, &err), BASE_EINVAL);
  double x;
  assert_false(world_observe(w, "coin.weight", NULL, &x));
  assert_false(world_observe(w, "coin.pos.q", NULL, &x));
  assert_false(world_observe(w, "nobody.x", NULL, &x));
  world_close(w);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(free_flight_hits_the_exact_discrete_answer),
      cmocka_unit_test(undeclared_effects_cost_nothing),
      cmocka_unit_test(free_spin_keeps_energy_and_momentum),
      cmocka_unit_test(steps_do_not_allocate_and_repeat_bit_for_bit),
      cmocka_unit_test(a_borrowed_spec_is_not_copied),
      cmocka_unit_test(running_out_of_memory_is_reported),
      cmocka_unit_test(only_a_gap_that_closes_inside_a_step_approaches),
      cmocka_unit_test(open_reports_what_it_cannot_do),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
