/* Every scene of tests/cases: it opens, its sets are sound, its Jacobians are the
 * derivatives of its gaps, and every quantity its checks ask for can be observed. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "problems/read/scene_file.h"
#include "problems/vec.h"
#include "problems/world/world.h"
#include "tests/support/files.h"

#include <stdio.h>
#include <string.h>

static base_error err;
static scene_file file;

static int load_cases(void **state) {
  (void)state;
  if (scene_file_read(tests_file("cases/cases.json"), &file, &err) != BASE_OK) {
    print_error("%s\n", err.text);
    return -1;
  }
  return 0;
}

static int free_cases(void **state) {
  (void)state;
  scene_file_free(&file);
  return 0;
}

static int find_contact(const contact_set *c, uint64_t id) {
  for (int i = 0; i < c->n_contact; i++) {
    if (c->id[i] == id) {
      return i;
    }
  }
  return -1;
}

/* Moves with a random velocity for a short step: gaps must change by h u_n. */
static int check_rates(world *w, const contact_set *c, base_rng *r) {
  double *v = malloc(sizeof *v * (size_t)(c->n_dof + 1));
  double *u = malloc(sizeof *u * (size_t)(c->n_row + 1));
  double *gap = malloc(sizeof *gap * (size_t)(c->n_contact + 1));
  double *un = malloc(sizeof *un * (size_t)(c->n_contact + 1));
  uint64_t *id = malloc(sizeof *id * (size_t)(c->n_contact + 1));
  const double h = c->h;
  for (int i = 0; i < c->n_dof; i++) {
    v[i] = base_rng_between(r, -1, 1);
  }
  contact_relative_velocity(c, v, c->u_drift, u);
  for (int i = 0; i < c->n_contact; i++) {
    gap[i] = c->gap[i];
    id[i] = c->id[i];
    un[i] = u[c->row_start[i]];
  }
  const int n = c->n_contact;
  contact_set next;
  check_ok(world_advance(w, v, NULL, &err), &err);
  check_ok(world_contacts(w, h, 0.05, &next, &err), &err);
  int checked = 0;
  for (int i = 0; i < n; i++) {
    const int k = find_contact(&next, id[i]);
    if (k >= 0) {
      check_close((next.gap[k] - gap[i]) / h, un[i], 2e-4);
      checked++;
    }
  }
  free(v);
  free(u);
  free(gap);
  free(un);
  free(id);
  return checked;
}

static void every_scene_opens_with_sound_sets_and_exact_rates(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(3);
  long checked = 0;
  for (int i = 0; i < file.n_scene; i++) {
    const scene_spec *s = &file.scene[i];
    world *w;
    contact_set c;
    check_ok(world_open(&w, s, s->effects, &err), &err);
    check_ok(world_contacts(w, s->h[0], -1.0, &c, &err), &err);
    check_ok(contact_set_check(&c, &err), &err);
    check_ok(world_contacts(w, 1e-7, 0.05, &c, &err), &err);
    check_ok(contact_set_check(&c, &err), &err);
    if (strncmp(s->id, "C10", 3) != 0) { /* 1 km/s: differences of 1e-7 s see curvature */
      checked += check_rates(w, &c, &r);
    }
    world_close(w);
  }
  assert_true(checked > 500);
}

static void every_checked_quantity_can_be_observed(void **state) {
  (void)state;
  for (int i = 0; i < file.n_scene; i++) {
    const scene_spec *s = &file.scene[i];
    world *w;
    check_ok(world_open(&w, s, s->effects, &err), &err);
    for (int k = 0; k < s->n_check; k++) {
      double value = HUGE_VAL;
      if (s->check[k].var[0] != '\0' &&
          !world_observe(w, s->check[k].var, s->check[k].has_dir ? s->check[k].dir : NULL,
                         &value)) {
        fail_msg("%s: no quantity %s", s->id, s->check[k].var);
      }
    }
    world_close(w);
  }
}

/* Bodies that rest on each other are in the set: tower C02 has two contacts an interface. */
static void resting_stacks_list_every_interface(void **state) {
  (void)state;
  int seen = 0;
  for (int i = 0; i < file.n_scene; i++) {
    const scene_spec *s = &file.scene[i];
    if (strncmp(s->id, "C02", 3) != 0 && strncmp(s->id, "B14", 3) != 0) {
      continue;
    }
    world *w;
    contact_set c;
    check_ok(world_open(&w, s, s->effects, &err), &err);
    check_ok(world_contacts(w, 0.01, -1.0, &c, &err), &err);
    assert_int_equal(c.n_contact, s->n_body * (s->dim == 2 ? 2 : 4));
    for (int k = 0; k < c.n_contact; k++) {
      assert_true(c.gap[k] <= c.tol && c.gap[k] >= -c.tol);
    }
    world_close(w);
    seen++;
  }
  assert_true(seen >= 3);
}

/* Advancing by the free velocity in the vector form agrees with set_state. */
static void state_vectors_reproduce_the_motion(void **state) {
  (void)state;
  for (int i = 0; i < file.n_scene; i++) {
    const scene_spec *s = &file.scene[i];
    world *w;
    contact_set c;
    check_ok(world_open(&w, s, s->effects, &err), &err);
    const int n = world_n_config(w), m = world_n_dof(w);
    double *q = malloc(sizeof *q * (size_t)(3 * n + m + 1)), *v = q + 3 * n;
    double *q1 = q + n, *rate = q + 2 * n;
    const double h = 1e-6;
    world_get_state(w, q, v);
    world_config_rate(w, q, v, rate);
    check_ok(world_contacts(w, h, 0.0, &c, &err), &err);
    check_ok(world_advance(w, v, NULL, &err), &err);
    world_get_state(w, q1, v);
    for (int k = 0; k < n; k++) {
      check_close((q1[k] - q[k]) / h, rate[k], 1e-1 + 1e-3 * fabs(rate[k]));
    }
    world_set_state(w, 0.0, q, v);
    world_get_state(w, q1, v);
    for (int k = 0; k < n; k++) {
      check_close(q1[k], q[k], 1e-15);
    }
    world_close(w);
    free(q);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scene_opens_with_sound_sets_and_exact_rates),
      cmocka_unit_test(every_checked_quantity_can_be_observed),
      cmocka_unit_test(resting_stacks_list_every_interface),
      cmocka_unit_test(state_vectors_reproduce_the_motion),
  };
  return cmocka_run_group_tests(tests, load_cases, free_cases);
}
