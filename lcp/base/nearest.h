/* base/nearest.h - "did you mean": the known name nearest to one that is not known.
 *
 * Distance is the number of letters inserted, left out, replaced or swapped with their neighbour (Damerau
 * 1964, restricted: no letter takes part twice), upper and lower case alike. A name that begins with the
 * word, or with which the word begins, counts as little more than one letter off. Nothing is proposed
 * that is further than a third of the word, so that nonsense gets no answer. */
#pragma once

#include <stddef.h>

enum { BASE_NEAREST_WORD = 64, BASE_NEAREST_HINT = BASE_NEAREST_WORD + 24 };

typedef struct base_nearest {
  char word[BASE_NEAREST_WORD]; /* its beginning, where it is longer */
  char best[BASE_NEAREST_WORD]; /* "": none offered yet is near */
  int distance;                 /* of best */
} base_nearest;

/* The first `len` letters of text. */
base_nearest base_nearest_to(const char *text, size_t len);
void base_nearest_offer(base_nearest *n, const char *name);
void base_nearest_offer_words(base_nearest *n, const char *words); /* "a|b|c" */

/* "; did you mean 'lemke'?" for the end of a message, or "". */
const char *base_nearest_hint(const base_nearest *n, char buf[BASE_NEAREST_HINT]);

/* All in one for names in a list "a|b|c". */
const char *base_nearest_word(const char *text, const char *words, char buf[BASE_NEAREST_HINT]);
