/* bench_world.c - time and memory of building a sphere pile, detecting its contacts and assembling
 * their rows, against the number of contacts. Run by `meson test --benchmark`. */
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"
#include "lcp/base/rng.h"
#include "problems/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

/* n x n columns of spheres, n high, on a floor, touching within a thousandth of their radius. */
static base_status pile(scene_spec *s, int n, base_error *err) {
  const double r = 0.05, up[3] = {0, 0, 1};
  base_rng rng = base_rng_seeded(1);
  spec_init(s);
  s->dim = 3;
  s->gravity[2] = -9.81;
  s->duration = 1.0;
  s->friction.dflt = 0.5;
  spec_static *floor_;
  BASE_TRY(spec_add_static(s, "floor", up, 0.0, &floor_, err));
  for (int i = 0; i < n * n * n; i++) {
    char name[SPEC_NAME];
    spec_body *b;
    (void)snprintf(name, sizeof name, "s%d", i);
    BASE_TRY(spec_add_body(s, name, &b, err));
    b->shape.kind = SPEC_SPHERE;
    b->shape.r = r;
    b->mass = 1.0;
    b->inertia[0] = b->inertia[1] = b->inertia[2] = 0.4 * r * r;
    b->quat[0] = 1.0;
    const int at[3] = {i % n, i / n % n, i / (n * n)};
    for (int k = 0; k < 3; k++) {
      b->pos[k] = r + 2.0 * r * at[k] + 1e-3 * r * base_rng_uniform(&rng);
    }
  }
  return BASE_OK;
}

static double peak_bytes(void) {
  struct rusage u;
  (void)getrusage(RUSAGE_SELF, &u);
  return 1024.0 * (double)u.ru_maxrss;
}

static base_status measure(int n, base_error *err) {
  scene_spec s;
  world *w;
  contact_set c;
  BASE_TRY(pile(&s, n, err));
  const double before = peak_bytes(), t0 = base_seconds();
  BASE_TRY(world_open(&w, &s, ~0u, err));
  const double t1 = base_seconds();
  BASE_TRY(world_contacts(w, 1e-3, 0.0, &c, err));
  double best = HUGE_VAL;
  for (int k = 0; k < 7; k++) {
    const double start = base_seconds();
    BASE_TRY(world_contacts(w, 1e-3, -1.0, &c, err));
    best = fmin(best, base_seconds() - start);
  }
  printf("%d,%d,%d,%.4f,%.4f,%.1f,%.0f\n", s.n_body, c.n_contact, c.n_row, t1 - t0, best,
         1e9 * best / c.n_contact, (peak_bytes() - before) / c.n_contact);
  world_close(w);
  spec_free(&s);
  return BASE_OK;
}

/* bench_world [N]: only the pile of N^3 spheres (for counting instructions). */
int main(int argc, char **argv) {
  int sizes[] = {7, 15, 32}; /* about 1e3, 1e4 and 1e5 contacts */
  int first = 0;
  if (argc > 1 && base_parse_int(argv[1], &sizes[2])) {
    first = 2;
  }
  printf("n_body,n_contact,n_row,open_s,contacts_s,contact_ns,contact_B\n");
  for (int i = first; i < BASE_COUNT(sizes); i++) {
    base_error err = {0};
    if (measure(sizes[i], &err) != BASE_OK) {
      fprintf(stderr, "%s: %s\n", err.where, err.text);
      return 1;
    }
  }
  return 0;
}
