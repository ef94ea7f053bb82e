/* base/gather.h: lists of parts become one, in the order of the parts, whoever did them; what is begun again starts empty. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/base/gather.h"

enum { PARTS = 300, MOST = 4 };

static base_error err;

typedef struct entry {
  int part, number;
} entry;

static int length_of(int part, int round) {
  return (part % 7 == round) ? 0 : (part * 37 + round) % 200;
}

typedef struct work {
  base_gather *to;
  int round;
} work;

static void find(void *of, int part, int hand) {
  const work *w = of;
  (void)hand;
  for (int k = 0; k < length_of(part, w->round); k++) {
    entry *e = base_gather_add(w->to, part);
    *e = (entry){part, k + w->round};
  }
}

static void check_joined(const base_gather *g, int parts, int round) {
  int n = 0, at = 0;
  check_ok(base_gather_count(g, "entries", &n, &err), &err);
  entry *all = malloc((size_t)n * sizeof *all + 1);
  base_gather_join(g, all);
  for (int part = 0; part < parts; part++) {
    for (int k = 0; k < length_of(part, round); k++, at++) {
      assert_true(at < n);
      assert_int_equal(all[at].part, part);
      assert_int_equal(all[at].number, k + round);
    }
  }
  assert_int_equal(at, n);
  free(all);
}

static void lists_follow_each_other(void **state) {
  (void)state;
  for (int threads = 1; threads <= MOST; threads++) {
    base_gather g = {0};
    base_crew *crew;
    check_ok(base_crew_open(&crew, threads, &err), &err);
    (void)base_crew_take_up(crew);
    for (int round = 0; round < 5; round++) {
      const int parts =
          (round == 3) ? 2 : PARTS / (5 - round); /* fewer, and more than ever before */
      work w = {&g, round};
      check_ok(base_gather_begin(&g, parts, sizeof(entry), &err), &err);
      base_share(parts, find, &w);
      check_joined(&g, parts, round);
    }
    (void)base_crew_take_up(NULL);
    base_crew_close(crew);
    base_gather_close(&g);
  }
}

static void nothing_is_nothing(void **state) {
  (void)state;
  base_gather g = {0};
  int n = -1;
  check_ok(base_gather_begin(&g, 0, sizeof(entry), &err), &err);
  check_ok(base_gather_count(&g, "entries", &n, &err), &err);
  assert_int_equal(n, 0);
  base_gather_join(&g, NULL);
  base_gather_close(&g);
}

/* A list that had no room for one more is told, with what was looked for, also where there was room again later. */
static void what_found_no_room_is_told(void **state) {
  (void)state;
  base_gather g = {0};
  int n = 0;
  check_ok(base_gather_begin(&g, 2, sizeof(entry), &err), &err);
  check_heap_fail_at = 1;
  assert_null(base_gather_add(&g, 1));
  assert_non_null(base_gather_add(&g, 0));
  assert_non_null(base_gather_add(&g, 1));
  assert_int_equal(base_gather_count(&g, "entries", &n, &err), BASE_ENOMEM);
  assert_non_null(strstr(err.text, "entries"));
  check_ok(base_gather_begin(&g, 2, sizeof(entry), &err), &err);
  check_ok(base_gather_count(&g, "entries", &n, &err), &err);
  assert_int_equal(n, 0);
  base_gather_close(&g);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lists_follow_each_other),
      cmocka_unit_test(nothing_is_nothing),
      cmocka_unit_test(what_found_no_room_is_told),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
