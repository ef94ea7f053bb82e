/* What is remembered of a contact takes the room that the contacts of its scene need, and moves whole when they come to need more. */
#include "tests/support/check.h"

#include "formulations/contact_memory.h"
#include "tests/support/rig.h"

#include <math.h>
#include <string.h>

enum { WITHOUT = 1, TORSION, ROLLING };
enum { HEAD = PAST_IMPULSE };

/* Numbers of an entry of a law after a step of a box on its corners, in which corner 3 has torsion or rolling too. */
static int entry_of(const char *form, const char *options, int kinds) {
  rig *r = rig_box(3, 0.005, 0.4, 0.1);
  r->contact[3].torsion = (kinds >= TORSION) ? 0.01 : 0;
  r->contact[3].rolling = (kinds >= ROLLING) ? 0.01 : 0;
  formulation_run *run = rig_open(form, options);
  rig_step(r, run);
  contact_past past = {0};
  base_error err;
  check_ok(formulation_keep(run, &past, &err), &err);
  assert_int_equal(past.n, 4);
  const contact_layout l = past.layout;
  contact_memory_drop(&past);
  rig_close(run);
  free(r);
  return l.head + l.impulse + l.pull + l.own;
}

static void entries_hold_what_contacts_have(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
    int numbers[3];
  } laws[] = {
      {"normal",
       "",
       {HEAD + 1 + 2, HEAD + 1 + 2, HEAD + 1 + 2}}, /* the unknown and how many there are */
      {"coulomb", "", {HEAD + 3, HEAD + 4, HEAD + 6}},
      {"boxed", "", {HEAD + 3, HEAD + 4, HEAD + 6}},
      {"boxed", "bristle=1e5", {HEAD + 3 + 3, HEAD + 4 + 6, HEAD + 6 + 9}},
      {"regularized", "pose=cone", {HEAD + 3 + 3 + 6, HEAD + 4 + 6 + 11, HEAD + 6 + 9 + 16}},
      {"velocity", "facets=4", {HEAD + 3 + 7, HEAD + 4 + 10, HEAD + 6 + 15}},
      {"position", "facets=8", {HEAD + 3 + 11, HEAD + 4 + 14, HEAD + 6 + 23}},
  };
  for (int f = 0; f < BASE_COUNT(laws); f++) {
    for (int kinds = WITHOUT; kinds <= ROLLING; kinds++) {
      assert_int_equal(entry_of(laws[f].form, laws[f].opt, kinds), laws[f].numbers[kinds - 1]);
    }
  }
}

static contact_set set_of(const uint64_t *ids, const contact_rows *rows, int n) {
  return (contact_set){.n_contact = n, .id = ids, .rows = rows, .h = 0.01};
}

static void begin(contact_memory *m, const contact_set *c) {
  base_error err;
  const contact_layout need = contact_memory_need(contact_memory_kinds(c), true, 2);
  check_ok(contact_memory_begin(m, need, c, &err), &err);
}

/* Every number of contact i, told apart. */
static void fill(contact_memory *m, int i) {
  double *now = contact_memory_now(m, i);
  for (int k = 0; k < m->stride; k++) {
    now[k] = 100 * (i + 1) + k;
  }
}

/* A contact with rolling comes and goes: each part of the others' entries goes on in its place, behind it there are zeros, and
 * entries keep their length. */
static void entries_grow_part_by_part(void **state) {
  (void)state;
  static const uint64_t ids[] = {10, 20, 30};
  static const contact_rows rows[] = {{2, 0, 0}, {2, 0, 0}, {2, 1, 2}};
  const contact_set few = set_of(ids, rows, 2), all = set_of(ids, rows, 3);
  contact_memory m = {0};
  begin(&m, &few);
  assert_int_equal(m.stride, HEAD + 3 + 3 + 2);
  fill(&m, 0);
  fill(&m, 1);
  begin(&m, &all);
  assert_int_equal(m.stride, HEAD + 6 + 9 + 2);
  const double want[] = {200, 201, 202, 203, 204, 205, 206, 207, 208, 209, 210, 0,  0,
                         0,   211, 212, 213, 0,   0,   0,   0,   0,   0,   214, 215};
  assert_memory_equal(contact_memory_old(&m, 1), want, sizeof want);
  assert_null(contact_memory_old(&m, 2));
  fill(&m, 0);
  begin(&m, &few);
  begin(&m, &few);
  begin(&m, &all);
  assert_int_equal(m.stride, HEAD + 6 + 9 + 2);
  contact_memory_close(&m);
}

static bool is_even(const void *of, uint64_t id) {
  (void)of;
  return id % 2 == 0;
}

/* Contacts move from one list to another and back, in order, with all that is remembered of them, though one list has room for rolling and the
 * other not. */
static void entries_move_by_contact(void **state) {
  (void)state;
  static const uint64_t ids[] = {10, 11, 20, 21, 30}, others[] = {15, 25};
  static const contact_rows rows[5] = {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}};
  static const contact_rows rolling[] = {{2, 1, 2}, {2, 0, 0}};
  const contact_set c = set_of(ids, rows, 5), d = set_of(others, rolling, 2);
  contact_memory m = {0}, n = {0};
  contact_past from = {0}, to = {0}, whole = {0};
  base_error err;
  begin(&m, &c);
  begin(&n, &d);
  for (int i = 0; i < 5; i++) {
    fill(&m, i);
    contact_memory_now(&m, i)[PAST_ENERGY] = i + 1;
  }
  contact_memory_now(&n, 1)[PAST_ENERGY] = 100;
  check_ok(contact_memory_keep(&m, &from, &err), &err);
  check_ok(contact_memory_copy(&from, &whole, &err), &err);
  check_ok(contact_memory_keep(&n, &to, &err), &err);
  check_ok(contact_memory_move(&from, &to, is_even, NULL, &err), &err);
  assert_int_equal(from.n, 2);
  assert_int_equal(to.n, 5);
  assert_true(contact_memory_energy(&from) == 2 + 4);
  assert_true(contact_memory_energy(&to) == 100 + 1 + 3 + 5);
  check_ok(contact_memory_move(&to, &from, is_even, NULL, &err), &err);
  assert_int_equal(to.n, 2);
  check_ok(contact_memory_recall(&m, &whole, &err), &err);
  contact_memory back = {0};
  check_ok(contact_memory_recall(&back, &from, &err), &err);
  assert_int_equal(back.n, 5);
  for (int i = 0; i < 5; i++) {
    const double *was = contact_memory_now(&m, i), *is = contact_memory_now(&back, i);
    assert_true(back.id[i] == ids[i]);
    assert_memory_equal(is, was, (HEAD + 3) * sizeof *is);
    assert_memory_equal(is + contact_memory_pulls(&back), was + contact_memory_pulls(&m),
                        3 * sizeof *is);
    assert_memory_equal(is + contact_memory_own(&back), was + contact_memory_own(&m),
                        2 * sizeof *is);
  }
  contact_memory_drop(&from);
  contact_memory_drop(&to);
  contact_memory_drop(&whole);
  contact_memory_close(&m);
  contact_memory_close(&n);
  contact_memory_close(&back);
}

static bool is_any(const void *of, uint64_t id) {
  (void)of;
  return id > 0;
}

/* Impulses that move to a list of a step twice as long are twice as large, forces stay. */
static void impulses_are_those_of_the_step(void **state) {
  (void)state;
  static const uint64_t one[] = {10}, other[] = {20};
  static const contact_rows rows[] = {{2, 0, 0}};
  const contact_set c = set_of(one, rows, 1);
  contact_set d = set_of(other, rows, 1);
  contact_memory m = {0}, n = {0}, back = {0};
  contact_past from = {0}, to = {0};
  base_error err;
  d.h = 2 * c.h;
  begin(&m, &c);
  begin(&n, &d);
  fill(&m, 0);
  check_ok(contact_memory_keep(&m, &from, &err), &err);
  check_ok(contact_memory_keep(&n, &to, &err), &err);
  check_ok(contact_memory_move(&from, &to, is_any, NULL, &err), &err);
  check_ok(contact_memory_recall(&back, &to, &err), &err);
  const double *was = contact_memory_now(&m, 0), *is = contact_memory_now(&back, 0);
  for (int k = 0; k < m.stride; k++) {
    const bool impulse = k >= PAST_IMPULSE && k < contact_memory_pulls(&m);
    assert_true(is[k] == (impulse ? 2 : 1) * was[k]);
  }
  contact_memory_drop(&from);
  contact_memory_drop(&to);
  contact_memory_close(&m);
  contact_memory_close(&n);
  contact_memory_close(&back);
}

static void note(void *of, uint64_t id, double by) {
  double *told = of;
  told[id / 10 - 1] = by;
}

/* A contact differs by what its springs pull with over the step, and by its normal impulse where bounds lag; one that is new by everything. */
static void what_changes_is_told(void **state) {
  (void)state;
  static const uint64_t ids[] = {10, 20, 30};
  static const contact_rows rows[] = {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}};
  const contact_set few = set_of(ids, rows, 2), all = set_of(ids, rows, 3);
  contact_memory m = {0};
  begin(&m, &few);
  fill(&m, 0);
  fill(&m, 1);
  begin(&m, &all);
  for (int i = 0; i < 3; i++) {
    fill(&m, i);
  }
  contact_memory_now(&m, 0)[PAST_IMPULSE] += 0.25;
  contact_memory_now(&m, 0)[PAST_IMPULSE + 1] += 7; /* friction in the last step bounds nothing */
  contact_memory_now(&m, 1)[contact_memory_pulls(&m) + 2] -= 50;
  double told[3];
  contact_memory_changes(&m, false, note, told);
  assert_true(told[0] == 0 && told[1] == 0.01 * 50 && told[2] == HUGE_VAL);
  contact_memory_changes(&m, true, note, told);
  assert_true(told[0] == 0.25 && told[1] == 0.01 * 50 && told[2] == HUGE_VAL);
  contact_memory_close(&m);
}

/* Another formulation goes on with head, impulses and pulls, whatever it needs itself. */
static void what_is_common_is_taken_over(void **state) {
  (void)state;
  static const uint64_t ids[] = {10, 20};
  static const contact_rows rows[] = {{2, 0, 0}, {2, 0, 0}};
  const contact_set c = set_of(ids, rows, 2);
  contact_memory m = {0}, next = {0};
  contact_past past = {0};
  base_error err;
  begin(&m, &c);
  fill(&m, 0);
  fill(&m, 1);
  check_ok(contact_memory_keep(&m, &past, &err), &err);
  contact_memory_strip(&past);
  check_ok(contact_memory_recall(&next, &past, &err), &err);
  check_ok(contact_memory_begin(&next, contact_memory_need(1, false, 5), &c, &err), &err);
  assert_int_equal(next.stride, HEAD + 3 + 3 + 5);
  for (int i = 0; i < 2; i++) {
    const double zero[5] = {0};
    assert_memory_equal(contact_memory_old(&next, i), contact_memory_now(&m, i),
                        (HEAD + 3 + 3) * sizeof(double));
    assert_memory_equal(contact_memory_old(&next, i) + contact_memory_own(&next), zero,
                        sizeof zero);
  }
  contact_memory_drop(&past);
  contact_memory_close(&m);
  contact_memory_close(&next);
}

/* One run has its memory laid out for rolling from the start, by a contact that opens; the other one never: a box slides to the
 * same bits. */
static void the_layout_does_not_show(void **state) {
  (void)state;
  static const struct {
    const char *form, *opt;
  } laws[] = {{"coulomb", ""},     {"boxed", "bristle=1e5"},
              {"regularized", ""}, {"regularized", "pose=cone"},
              {"velocity", ""},    {"position", ""}};
  for (int f = 0; f < BASE_COUNT(laws); f++) {
    rig *narrow = rig_box(3, 0.005, 0.4, 0.1);
    narrow->v[0] = 3.0;
    narrow->v[5] = 2.0;
    rig *wide = malloc(sizeof *wide);
    memcpy(wide, narrow, sizeof *wide);
    formulation_run *a = rig_open(laws[f].form, laws[f].opt);
    formulation_run *b = rig_open(laws[f].form, laws[f].opt);
    rig *rolls = rig_box(3, 0.005, 0.4, 0.1);
    rolls->contact[0].rolling = 0.01;
    rig_step(rolls, b);
    contact_past past = {0};
    base_error err;
    check_ok(formulation_keep(b, &past, &err), &err);
    past.n = 0; /* none of its contacts is met again */
    past.h = 0;
    check_ok(formulation_recall(b, &past, &err), &err);
    double size = 0;
    for (int k = 0; k < 20; k++) {
      rig_step(narrow, a);
      rig_step(wide, b);
      const size_t rows = (size_t)narrow->set.n_row;
      assert_memory_equal(narrow->v, wide->v, 6 * sizeof(double));
      assert_memory_equal(narrow->answer.impulse, wide->answer.impulse, rows * sizeof(double));
      for (size_t i = 0; i < rows; i++) {
        size += fabs(narrow->answer.impulse[i]);
      }
    }
    assert_true(size > 0);
    contact_memory_drop(&past);
    rig_close(a);
    rig_close(b);
    free(narrow);
    free(wide);
    free(rolls);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(entries_hold_what_contacts_have),
      cmocka_unit_test(entries_grow_part_by_part),
      cmocka_unit_test(entries_move_by_contact),
      cmocka_unit_test(what_changes_is_told),
      cmocka_unit_test(impulses_are_those_of_the_step),
      cmocka_unit_test(what_is_common_is_taken_over),
      cmocka_unit_test(the_layout_does_not_show),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
