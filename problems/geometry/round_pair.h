/* problems/geometry/round_pair.h - how far two centrally symmetric bodies are apart, at least one of them a disc or
 * a cylinder: the search of gap_round.c. */
#pragma once

#include "problems/geometry/shapes.h"

#include <stdbool.h>

/* Disc or cylinder, box, or segment. */
typedef struct round_solid {
  bool disc;
  double c[3], e[3][3]; /* axes; a disc's own is e[2] */
  double h[3];          /* box; segment: h[0] alone; disc: h[2] alone */
  double r;             /* disc: radius */
  double sweep;         /* radius about a segment */
} round_solid;

/* Two of them, and the best normal so far. */
typedef struct round_pair {
  round_solid a, b;
  double d[3], size; /* c_a - c_b; a length of the round_pair [m] */
  double best, n[3]; /* largest separation of the cores so far, and its normal */
} round_pair;

round_solid round_place(const piece *p, const pose *at);

/* The part of n across the axis of a disc; its length. */
double round_across(const round_solid *s, const double *n, double *out);

/* Point of the core, from its centre, that is furthest along n. Where several are, the middle one:
 * `flat` is the sine below which n counts as at right angles. */
void round_support(const round_solid *s, const double *n, double flat, double *out);

/* Vertex i of a box (0..7) or end of a segment (0, 1), and how many there are; discs have none. */
void round_vertex(const round_solid *s, int i, double *x);
int round_vertices(const round_solid *s);

/* u cos + v sin at an angle, and its derivative. */
void round_circle(const double *u, const double *v, double angle, double *n, double *slope);

/* Keeps n (unit, from b to a) if it separates the cores better than the best so far. */
void round_try(round_pair *p, const double *n);
/* Tries all that can be the best: p->best is then the signed distance of the cores. */
void round_search(round_pair *p);
