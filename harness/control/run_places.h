/* harness/control/run_places.h - where the bodies of a run began and are, and how far they came. */
#pragma once

#include "problems/world/world.h"

typedef struct run_places {
  int n;         /* bodies */
  double *start; /* 3 n [m]; owned, `end` behind it */
  double *end;
  double travel; /* the longest way of a centre from where it began, at the end of any step [m] */
  double size;   /* of the smallest body (world_size) [m] */
  bool points;   /* no body has a size: `size` is how far they may come by their speed or gravity */
} run_places;

/* Forgets what p holds, and begins with the world as it stands. BASE_ENOMEM. */
base_status run_places_open(run_places *p, const world *w, base_error *err);
/* A step has ended. */
void run_places_note(run_places *p, const world *w);
/* The scale of lengths [m]: the longest way, at least the size of the smallest body. Points that came anywhere have no scale but their way: what
 * gravity gives in free fall says nothing of one that bounces. */
double run_places_length(const run_places *p);
void run_places_close(run_places *p);
