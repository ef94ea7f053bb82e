/* No reader: one planted fault per first letter of the input, capital letters in our own code, small ones inside a
 * library. scripts/fuzz must stop at the former and go on after the latter; it tries both before it trusts itself. */
#include "tests/fuzz/fuzz_file.h"

#include <hdf5.h>
#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

static char *volatile kept;

/* Out of the optimiser's sight: what is planted must happen. */
static size_t hidden(size_t n) {
  static volatile size_t zero = 0;
  return n + zero;
}

static void beyond_the_end(void) {
  char *p = malloc(hidden(8));
  kept = p;
  if (p != NULL) {
    p[hidden(8)] = 1;
  }
  free(p);
}

static void library_writes_beyond_our_end(void) {
  json_t *word = json_string("longer than eight bytes");
  char *small = malloc(hidden(8));
  (void)json_dumpb(word, small, hidden(64), JSON_ENCODE_ANY);
  free(small);
  json_decref(word);
}

static void never_ends(void) {
  while (hidden(1) == 1) {
  }
}

static int recurses(int n) {
  volatile char frame[1024];
  frame[0] = (char)n;
  return (hidden(1) == 1) ? recurses(n + 1) + frame[0] : 0;
}

static void library_memory_never_given_back(void) {
  json_t *lost = json_array();
  kept = (char *)lost;
  kept = NULL;
}

/* Lists in lists, `width` times the same one: two such are compared in width^depth steps, depth calls deep. */
static json_t *nested(int depth, int width) {
  json_t *list = json_array();
  for (int d = 0; d < depth; d++) {
    json_t *outer = json_array();
    for (int w = 0; w < width; w++) {
      (void)json_array_append(outer, list);
    }
    json_decref(list);
    list = outer;
  }
  return list;
}

static void jansson_compares(int depth, int width) {
  json_t *a = nested(depth, width);
  json_t *b = nested(depth, width);
  (void)json_equal(a, b);
}

static void null_inside_jansson(void) {
  (void)json_loadb((const char *)hidden(8), 64, 0, NULL);
}

static void plant(char letter) {
  switch (letter) {
  case 'O':
    beyond_the_end();
    break;
  case 'W':
    library_writes_beyond_our_end();
    break;
  case 'A':
    kept = malloc(hidden((size_t)8 << 30));
    free(kept);
    break;
  case 'L':
    kept = malloc(hidden(100));
    kept = NULL;
    break;
  case 'J':
    library_memory_never_given_back();
    break;
  case 'U':
    kept = (char *)(size_t)(INT_MAX + (int)hidden(1));
    kept = NULL;
    break;
  case 'T':
    never_ends();
    break;
  case 'R':
    (void)recurses(0);
    break;
  case 'a':
    kept = H5allocate_memory(hidden((size_t)8 << 30), false);
    (void)H5free_memory(kept);
    break;
  case 'l':
    kept = H5allocate_memory(hidden(100), false);
    kept = NULL;
    break;
  case 'c':
    null_inside_jansson();
    break;
  case 't':
    jansson_compares(60, 2);
    break;
  case 'r':
    jansson_compares(1000000, 1);
    break;
  default:
    break;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size > 0) {
    plant((char)data[0]);
  }
  return 0;
}
