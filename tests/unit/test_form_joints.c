/* Rows of contacts that joints leave hardly any motion: where they come from is known, and they keep the digits of what is left. */
#include "tests/support/check.h"

#include "formulations/assembly.h"
#include "tests/support/rig.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16 };

static const double lever =
    0x1p-18; /* m, beside rods of 1 m: nothing is rounded in the rows of J, */
static const double digits =
    DBL_EPSILON / 0x1p-18; /* but what joints leave of two of them is a difference of such */

/* C' and r' of the rows of all contacts. */
typedef struct reduced {
  int n;
  double C[MOST * MOST], r[MOST];
} reduced;

/* drift: of the joint rows, or NULL. */
static void reduce(rig *r, const double *drift, reduced *out) {
  base_error err = {0};
  form_assembly a = {0};
  contact_memory memory = {0};
  const form_rule rule = {.level = FORM_LEVEL_VELOCITY, .activation = FORM_CLOSED};
  const int first = rig_set(r)->row_start[r->n_contact];
  for (int k = first; k < r->set.n_row && drift != NULL; k++) {
    r->drift[k] = drift[k - first];
  }
  check_ok(contact_memory_begin(&memory, (contact_layout){.head = 1}, &r->set, &err), &err);
  check_ok(form_assembly_begin(&a, &r->set, FORM_ROWS_TANGENT, &rule, &memory, &err), &err);
  check_ok(form_assembly_eliminate(&a, &err), &err);
  assert_int_equal(a.n_contact, r->n_contact);
  assert_int_equal(a.n_row, first);
  out->n = a.n_row;
  assert_true(out->n <= MOST);
  form_assembly_dense(&a, out->C);
  memcpy(out->r, a.r, (size_t)out->n * sizeof *a.r);
  form_assembly_close(&a);
  contact_memory_close(&memory);
}

/* Of `row`: the sum of share[k] times row of[k]. */
typedef struct known_row {
  int row, beside, n, of[4]; /* beside: another such row, or itself */
  double share[4], drift;
} known_row;

/* C' has the row and column that it should have, r' the velocity. */
static void check_row(const reduced *x, const known_row *k) {
  for (int j = 0; j <= x->n; j++) {
    const double *column = (j < x->n) ? x->C + (ptrdiff_t)j * x->n : x->r;
    double want = (j < x->n) ? 0 : k->drift, size = fabs(want);
    for (int m = 0; m < k->n; m++) {
      want += k->share[m] * column[k->of[m]];
      size += fabs(k->share[m] * column[k->of[m]]);
    }
    const bool two = j == k->beside && j != k->row;
    check_close(column[k->row] / size, want / size, two ? digits : 1e-13);
    if (j < x->n) {
      assert_true(column[k->row] == x->C[(ptrdiff_t)k->row * x->n + j]);
    }
  }
}

static void give_motion(rig *r) {
  const int n = (r->dim == 2) ? 3 : 6;
  for (int d = 0; d < n * r->n_body; d++) {
    r->v[d] = 0.1 * ((7 * d + 3) % 11 - 5);
  }
  r->gravity[r->dim - 1] = -9.81;
}

/* Rods of 0.1 to 6 kg end to end on a floor, pinned. The first two also touch, beside their pin by the lever on one and by half of it on
 * the other, with a normal up: u_0 = lever omega_1 + lever / 2 omega_2, and what the ends of a rod do on the floor tells omega. */
static void ends_that_a_pin_joins(void **state) {
  (void)state;
  const double mass[3] = {0.1, 6, 0.7};
  for (int dim = 2; dim <= 3; dim++) {
    const double left[3] = {-0.5, 0, 0}, right[3] = {0.5, 0, 0};
    const double beyond[3] = {0.5 + lever, 0, 0}, before[3] = {-0.5 - 0.5 * lever, 0, 0};
    const double up[3] = {0, dim == 2, dim == 3};
    rig *r = rig_new(dim, 0.01);
    for (int b = 0; b < 3; b++) {
      (void)rig_body(r, mass[b], 0.01, mass[b] / 12, mass[b] / 12);
      r->x[b][0] = b;
    }
    (void)rig_touch(r, 0, 1, beyond, before, up, 0);
    for (int b = 0; b < 3; b++) {
      (void)rig_touch(r, b, -1, left, (double[3]){b - 0.5, 0, 0}, up, 0);
      (void)rig_touch(r, b, -1, right, (double[3]){b + 0.5, 0, 0}, up, 0);
    }
    for (int b = 1; b < 3; b++) {
      rig_pin(r, b, b - 1, left, right);
    }
    give_motion(r);
    reduced x;
    reduce(r, NULL, &x);
    check_row(&x, &(known_row){.row = 0,
                               .n = 4,
                               .of = {1, 2, 3, 4},
                               .share = {-lever, lever, -0.5 * lever, 0.5 * lever}});
    free(r);
  }
}

/* Two rods on pins of their own, one above the other, which touch beside these: along both rows of the contact by levers of their own, on a belt.
 * Each has its other end on a floor, and the pins are driven. Joints of two components take what the contact moves. */
static void rods_on_pins_of_their_own(void **state) {
  (void)state;
  const double belt = 0.25, pin[3] = {-0.5, 0, 0}, end[3] = {0.5, 0, 0}, up[3] = {0, 1, 0};
  const double on_a[3] = {-0.5 + lever, 0.5 * lever, 0}, on_b[3] = {-0.5 - 2 * lever, lever, 0};
  rig *r = rig_new(2, 0.01);
  (void)rig_body(r, 2, 0.2, 0.2, 0.2);
  (void)rig_body(r, 0.3, 0.2, 0.2, 0.05);
  rig_touch(r, 0, 1, on_a, on_b, up, 0.5)->belt = belt;
  for (int b = 0; b < 2; b++) {
    (void)rig_touch(r, b, -1, end, end, up, 0);
    rig_pin(r, b, -1, pin, pin);
  }
  give_motion(r);
  /* J_b v = -moved: rows 2 and 3 are omega of the two less the second and the fourth of these; an offset (x, y) moves by omega (-y, x),
   * and the tangent is along x */
  const double moved[4] = {0.3, -0.2, 0.15, 0.4};
  reduced x;
  reduce(r, moved, &x);
  const known_row normal = {.row = 0,
                            .beside = 1,
                            .n = 2,
                            .of = {2, 3},
                            .share = {lever, 2 * lever},
                            .drift = moved[3] - moved[1] + lever * moved[1] + 2 * lever * moved[3]};
  const known_row tangent = {.row = 1,
                             .n = 2,
                             .of = {2, 3},
                             .share = {-0.5 * lever, lever},
                             .drift = moved[2] - moved[0] - 0.5 * lever * moved[1] +
                                      lever * moved[3] - belt};
  check_row(&x, &normal);
  check_row(&x, &tangent);
  free(r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ends_that_a_pin_joins),
      cmocka_unit_test(rods_on_pins_of_their_own),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
