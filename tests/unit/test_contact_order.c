/* Contacts in another order are the same contacts: the same motion for the same impulses, and every
 * answer back where it belongs. */
#include "tests/support/check.h"

#include "harness/measure/contact_order.h"
#include "lcp/base/rng.h"
#include "problems/read/scene_file.h"
#include "problems/world/world.h"
#include "tests/support/contact_velocity.h"

#include <stdlib.h>
#include <string.h>

static void texts_are_read(void **state) {
  (void)state;
  uint64_t seed;
  base_error err;
  check_ok(contact_order_parse("given", &seed, &err), &err);
  assert_true(seed == 0);
  check_ok(contact_order_parse("random:12", &seed, &err), &err);
  assert_true(seed == 12);
  static const char *const bad[] = {"",         "random",     "random:", "random:0",
                                    "random:x", "random:1.5", "Random:1"};
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    assert_int_equal(contact_order_parse(bad[i], &seed, &err), BASE_EINVAL);
  }
}

/* Same v_next from the permuted impulses, row by row the same relative velocities. */
static void check_permuted(const contact_set *c, contact_order *o, const contact_set *p) {
  base_error err;
  base_rng rng = base_rng_seeded(o->seed);
  double *impulse = malloc((size_t)c->n_row * sizeof *impulse);
  double *bias = malloc((size_t)c->n_contact * sizeof *bias);
  unsigned char *mode = malloc((size_t)c->n_contact);
  double *v = calloc(3 * (size_t)c->n_dof + 1, sizeof *v);
  assert_true(impulse != NULL && bias != NULL && mode != NULL && v != NULL);
  for (int i = 0; i < c->n_row; i++) {
    impulse[i] = base_rng_uniform(&rng);
  }
  for (int i = 0; i < c->n_contact; i++) {
    bias[i] = i;
    mode[i] = (unsigned char)i;
  }
  check_ok(contact_set_check(p, &err), &err);
  formulation_answer a = {.impulse = impulse, .bias = bias, .mode = mode};
  contact_velocity(p, a.impulse, v, v + 2 * c->n_dof);
  contact_order_restore(o, c, &a);
  contact_velocity(c, a.impulse, v + c->n_dof, v + 2 * c->n_dof);
  for (int i = 0; i < c->n_dof; i++) {
    check_close(v[i], v[c->n_dof + i], 1e-12);
  }
  for (int i = 0; i < c->n_contact; i++) { /* bias tells where in p it came from */
    const int at = (int)a.bias[i];
    assert_int_equal(a.mode[i], (unsigned char)at);
    assert_true(p->gap[at] == c->gap[i] && p->mu_static[at] == c->mu_static[i]);
    assert_memory_equal(p->frame + 9 * (size_t)at, c->frame + 9 * (size_t)i, 9 * sizeof *c->frame);
    assert_memory_equal(p->body + 2 * (size_t)at, c->body + 2 * (size_t)i, 2 * sizeof *c->body);
    assert_memory_equal(p->u_before + p->row_start[at], c->u_before + c->row_start[i],
                        (size_t)(c->row_start[i + 1] - c->row_start[i]) * sizeof *c->u_before);
  }
  for (int k = 1; k < c->n_contact;
       k++) { /* what belongs to two shapes does so in this order, too, and stays together */
    const int i = o->from[k - 1], j = o->from[k];
    assert_true((contact_shapes_of(c->id[i]) == contact_shapes_of(c->id[j])) ==
                (contact_shapes_of(p->id[k - 1]) == contact_shapes_of(p->id[k])));
  }
  free(impulse);
  free(bias);
  free(mode);
  free(v);
}

/* How many of three orders begin with another contact. */
static int check_orders(const contact_set *c) {
  const contact_set *p;
  base_error err;
  int moved = 0;
  for (uint64_t seed = 1; seed < 4; seed++) {
    contact_order o = {.seed = seed};
    for (int again = 0; again < 2; again++) { /* memory of the step before is used again */
      check_ok(contact_order_apply(&o, c, &p, &err), &err);
      check_permuted(c, &o, p);
    }
    moved += (o.from[0] != 0) ? 1 : 0;
    contact_order_close(&o);
  }
  contact_order given = {.seed = 0};
  check_ok(contact_order_apply(&given, c, &p, &err), &err);
  assert_ptr_equal(p, c);
  return moved;
}

/* A stack; an impact with torsion and rolling; a chain with joints; a foot with redundant contacts. */
static void contacts_are_the_same(void **state) {
  (void)state;
  static const char *const scenes[] = {"stack:n=4", "billiard", "chain", "wall",
                                       "walking_foot:multiplicity=3"};
  int moved = 0;
  for (int k = 0; k < BASE_COUNT(scenes); k++) {
    scene_spec spec;
    world *w;
    base_error err;
    contact_set c;
    spec_init(&spec);
    check_ok(scene_load(scenes[k], &spec, &err), &err);
    check_ok(world_open(&w, &spec, spec.effects, &err), &err);
    check_ok(world_contacts(w, 0.01, 0.1, &c, &err), &err);
    moved += check_orders(&c);
    world_close(w);
    spec_free(&spec);
  }
  assert_true(moved > 5); /* of 15 */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(texts_are_read),
      cmocka_unit_test(contacts_are_the_same),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
