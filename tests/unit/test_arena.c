#include "tests/support/check.h"

#include "lcp/base/arena.h"
#include "lcp/base/status.h"

#include <string.h>

static void measuring_and_taking_agree(void **state) {
  (void)state;
  base_arena m = base_arena_measuring();
  assert_null(BASE_ARRAY(&m, double, 3));
  assert_null(BASE_ARRAY(&m, char, 65));
  assert_int_equal(m.used, 64 + 128);
  void *mem = base_alloc(m.used);
  base_arena a = base_arena_over(mem, m.used);
  assert_ptr_equal(BASE_ARRAY(&a, double, 3), mem);
  assert_non_null(BASE_ARRAY(&a, char, 65));
  assert_false(a.overflow);
  assert_null(BASE_ARRAY(&a, char, 1));
  assert_true(a.overflow);
  free(mem);
}

static void counts_that_wrap_round_overflow(void **state) {
  (void)state;
  base_arena m = base_arena_measuring();
  assert_null(BASE_ARRAY(&m, double, SIZE_MAX / 4));
  assert_true(m.overflow);
}

static void blocks_of_every_size_are_usable(void **state) {
  (void)state;
  static const size_t sizes[] = {
      0, 1, 64, 65, ((size_t)8 << 20) - 1, (size_t)8 << 20, ((size_t)9 << 20) + 1};
  for (int i = 0; i < BASE_COUNT(sizes); i++) {
    unsigned char *mem = base_alloc(sizes[i]);
    assert_non_null(mem);
    assert_int_equal((uintptr_t)mem % BASE_ALIGN, 0);
    memset(mem, 1, sizes[i]);
    free(mem);
  }
  assert_null(base_alloc(SIZE_MAX));
  assert_null(base_alloc(SIZE_MAX - ((size_t)1 << 21)));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blocks_of_every_size_are_usable),
      cmocka_unit_test(measuring_and_taking_agree),
      cmocka_unit_test(counts_that_wrap_round_overflow),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
