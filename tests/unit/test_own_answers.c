/* The answers of a solver by contact: started from where the formulation starts from what was chosen, and nowhere else. */
#include "tests/support/check.h"

#include "harness/measure/own_answers.h"

#include <string.h>

/* A set of three contacts, of which only ids and count are read. */
static contact_set set_of(uint64_t *ids, int n) {
  return (contact_set){.n_contact = n, .id = ids, .h = 0.01};
}

static void note(own_answers *o, const formulation_rows *rows, const double *own,
                 const double *chosen) {
  base_error err;
  check_ok(own_answers_note(o, rows, own, chosen, &err), &err);
}

/* Contacts 10, 20 and 30 with two unknowns each, all three loaded by the choice, two by the solver. */
static void starts_follow_contacts(void **state) {
  (void)state;
  uint64_t before[] = {10, 20, 30};
  uint64_t after[] = {20, 25, 30};
  const int first[] = {0, 2, 4, 6};
  const int group[] = {0, 1, 2};
  contact_set old = set_of(before, 3);
  contact_set new = set_of(after, 3);
  formulation_rows rows = {&old, 3, first, group};
  own_answers o = {0};
  own_answers_step(&o);
  note(&o, &rows, (double[]){3, 0, 0, 0, 3, 1}, (double[]){2, 0, 2, 0, 2, 1});
  double z[] = {2, 0, 7, 0, 2, 1};
  rows.set = &new;
  own_answers_step(&o);
  own_answers_start(&o, &rows, z);
  assert_memory_equal(z, ((double[]){0, 0, 7, 0, 3, 1}), sizeof z); /* 20 and 30; 25 is new */

  double slides[] = {2, 1, 0, 0, 2, 0}; /* other supports than were chosen */
  double had[6];
  memcpy(had, slides, sizeof had);
  own_answers_start(&o, &rows, slides);
  assert_memory_equal(slides, had, sizeof had);
  own_answers_close(&o);
}

/* What a later solve of the step leaves takes the place of the first one's; larger blocks are not kept, other ones not started from. */
static void the_last_solve_counts(void **state) {
  (void)state;
  uint64_t ids[] = {10, 20};
  const int pairs[] = {0, 2, 4};
  const int singles[] = {0, 1, 2};
  const int wide[] = {0, 3, 6};
  const int group[] = {0, 1};
  contact_set c = set_of(ids, 2);
  formulation_rows rows = {&c, 2, pairs, group};
  own_answers o = {0};
  own_answers_step(&o);
  note(&o, &rows, (double[]){3, 0, 0, 0}, (double[]){2, 0, 2, 0});
  note(&o, &rows, (double[]){0, 0, 5, 0}, (double[]){2, 0, 2, 0});
  double z[] = {2, 0, 2, 0};
  own_answers_start(&o, &rows, z);
  assert_memory_equal(z, ((double[]){0, 0, 5, 0}), sizeof z);

  formulation_rows other = {&c, 2, singles, group};
  double alone[] = {2, 2};
  own_answers_start(&o, &other, alone);
  assert_true(alone[0] == 2 && alone[1] == 2);

  other.first = wide;
  note(&o, &other, (double[]){1, 0, 0, 0, 0, 0}, (double[]){1, 0, 0, 1, 0, 0});
  double large[] = {1, 0, 0, 1, 0, 0};
  own_answers_start(&o, &other, large);
  assert_true(large[3] == 1);
  own_answers_close(&o);
}

/* Rows that are joints stay as the formulation starts them; a problem whose groups are rows needs no list of them. */
static void joints_and_rows_alone(void **state) {
  (void)state;
  uint64_t ids[] = {10, 20};
  const int group[] = {0, 1, 2}; /* 2: a joint */
  contact_set c = set_of(ids, 2);
  formulation_rows rows = {&c, 3, NULL, group};
  own_answers o = {0};
  double untouched[] = {4, 4, -1};
  own_answers_start(&o, &rows, untouched); /* before anything was noted */
  assert_true(untouched[0] == 4);
  own_answers_step(&o);
  note(&o, &rows, (double[]){8, 0, -1}, (double[]){4, 4, -1});
  double z[] = {4, 4, -2};
  own_answers_start(&o, &rows, z);
  assert_memory_equal(z, ((double[]){8, 0, -2}), sizeof z);
  own_answers_close(&o);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(starts_follow_contacts),
      cmocka_unit_test(the_last_solve_counts),
      cmocka_unit_test(joints_and_rows_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
