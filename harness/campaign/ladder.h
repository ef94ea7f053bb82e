/* harness/campaign/ladder.h - problems of one family, NAME:key=value,..., that differ in numbers: how the time of an evaluation
 * grows along each of these, from rows of other rungs.
 *
 * For each number x of the problem that is asked for the slope of log t over log x is fitted by least squares to the rows that
 * have it. Where all rows have the same x, a whole number is taken for a size, in which the time grows in proportion, and any
 * other one for a coefficient, which changes nothing. A duration is no rung: steps are counted. */
#pragma once

#include <stdbool.h>

enum { LADDER_NUMBERS = 12 };

typedef struct ladder_number {
  const char *key; /* not ended by a zero */
  int length;
  double asked;
  bool whole;
  double n, x, y, xx, xy, low, high; /* of log x and log t: count, sums, range of log x */
} ladder_number;

typedef struct ladder {
  int n;
  ladder_number number[LADDER_NUMBERS];
} ladder;

/* Are both texts calls of the same family? Sequences are of one family where all behind the first @ is the same. */
bool ladder_same_family(const char *a, const char *b);
/* The number behind key in a problem's options, or `missing`. */
double ladder_value(const char *problem, const char *key, double missing);

/* problem has to outlive l; numbers beyond LADDER_NUMBERS are left out. */
void ladder_begin(ladder *l, const char *problem);
/* One more row of the family, of t > 0 seconds. */
void ladder_add(ladder *l, const char *problem, double t);
/* Time of the problem asked for over that of another one of the family. */
double ladder_growth(const ladder *l, const char *problem);
/* How far it is from there in the logarithms of all numbers. */
double ladder_distance(const ladder *l, const char *problem);
