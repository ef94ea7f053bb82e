/* base/crew.h: every part is done once, in order, whoever there is; parts wait for earlier ones; a part works alone. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"

#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>

enum { PARTS = 400, MOST = 6 };

typedef struct work {
  int count;   /* threads */
  bool single; /* one part, which has them all at its service */
  atomic_int done[PARTS], busy[MOST];
  atomic_int left, wrong;
} work;

static void mark(work *w, bool right) {
  atomic_fetch_add(&w->wrong, !right);
}

/* Waits for the part before it, which only ends when parts are begun in order; hands are of one thread at a time. */
static void chained(void *of, int part, int hand) {
  work *w = of;
  mark(w, hand >= 0 && hand < w->count && atomic_fetch_add(&w->busy[hand], 1) == 0);
  mark(w, base_crew_size() == (w->single ? w->count : 1));
  while (atomic_load(&w->left) < part) {
    (void)sched_yield();
  }
  atomic_fetch_add(&w->done[part], 1);
  atomic_fetch_add(&w->busy[hand], -1);
  atomic_fetch_add(&w->left, 1);
}

static void inner(void *of, int part, int hand) {
  work *w = of;
  (void)hand;
  atomic_fetch_add(&w->done[part], 1);
}

static void nested(void *of, int part, int hand) {
  (void)part;
  (void)hand;
  base_share(3, inner, of);
}

static void check_counts(const work *w, int parts, int each) {
  assert_int_equal(atomic_load(&w->wrong), 0);
  for (int k = 0; k < PARTS; k++) {
    assert_int_equal(atomic_load(&w->done[k]), (k < parts) ? each : 0);
  }
}

static void parts_are_done_once_and_in_order(void **state) {
  (void)state;
  base_error err = {0};
  for (int threads = 1; threads <= MOST; threads++) {
    base_crew *crew;
    check_ok(base_crew_open(&crew, threads, &err), &err);
    assert_int_equal(base_crew_size(), 1);
    assert_null(base_crew_take_up(crew));
    assert_int_equal(base_crew_size(), threads);
    for (int parts = 0; parts <= PARTS; parts = 3 * parts + 1) {
      work w = {.count = threads, .single = parts == 1};
      base_share(parts, chained, &w);
      check_counts(&w, parts, 1);
    }
    work w = {.count = threads};
    base_share(50, nested, &w);
    check_counts(&w, 3, 50);
    for (int k = 0; k < 2000; k++) { /* so short that helpers come late */
      work few = {.count = threads};
      base_share(2, inner, &few);
      assert_int_equal(atomic_load(&few.done[0]) + atomic_load(&few.done[1]), 2);
    }
    assert_ptr_equal(base_crew_take_up(NULL), crew);
    base_crew_close(crew);
  }
  base_crew_close(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(parts_are_done_once_and_in_order),
  };
  return cmocka_run_group_tests_name("crew", tests, NULL, NULL);
}
