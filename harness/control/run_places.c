#include "harness/control/run_places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void run_places_close(run_places *p) {
  free(p->start);
  *p = (run_places){0};
}

base_status run_places_open(run_places *p, const world *w, base_error *err) {
  run_places_close(p);
  p->n = world_n_body(w);
  p->size = world_size(w);
  p->start = calloc(6 * (size_t)p->n + 1, sizeof *p->start);
  if (p->start == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the places of %d bodies", p->n);
  }
  p->end = p->start + 3 * (size_t)p->n;
  double quat[4];
  p->points = world_of_points(w);
  for (int i = 0; i < p->n; i++) {
    world_body_pose(w, i, p->start + 3 * (size_t)i, quat);
  }
  memcpy(p->end, p->start, 3 * (size_t)p->n * sizeof *p->end);
  return BASE_OK;
}

double run_places_length(const run_places *p) {
  static const double nowhere = 1e-6; /* of how far they may come: they rest */
  return (p->points && p->travel > nowhere * p->size) ? p->travel : fmax(p->travel, p->size);
}

void run_places_note(run_places *p, const world *w) {
  for (int i = 0; i < p->n; i++) {
    double quat[4];
    const double *from = p->start + 3 * (size_t)i;
    double *to = p->end + 3 * (size_t)i;
    world_body_pose(w, i, to, quat);
    p->travel = fmax(p->travel, sqrt(pow(to[0] - from[0], 2) + pow(to[1] - from[1], 2) +
                                     pow(to[2] - from[2], 2)));
  }
}
