/* bench_world.c - time and memory of building a sphere pile, detecting its contacts with their rows,
 * and posing the problem of one step in a formulation, against the number of contacts.
 *
 * bench_world N [FORMULATION]: the pile of N^3 spheres; one CSV line. Run by scripts/bench_world. */
#include "harness/measure/registry.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"
#include "lcp/base/rng.h"
#include "problems/world/world.h"

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

/* Seconds, least of several times. */
typedef struct timing {
  double open, contacts, assemble;
} timing;

static base_status pose(formulation_run *f, const contact_set *c, int *dim, base_error *err) {
  lcp_problem p;
  const double *z0;
  bool pending;
  BASE_TRY(formulation_begin(f, c, FORM_COLD, err));
  BASE_TRY(formulation_assemble(f, &p, &z0, &pending, err));
  *dim = pending ? p.M.n : 0;
  return BASE_OK;
}

static base_status step(world *w, formulation_run *f, timing *t, contact_set *c, int *dim,
                        base_error *err) {
  for (int k = 0; k < 5; k++) {
    const double start = base_seconds();
    BASE_TRY(world_contacts(w, 1e-3, -1.0, c, err));
    const double middle = base_seconds();
    BASE_TRY(pose(f, c, dim, err));
    t->contacts = fmin(t->contacts, middle - start);
    t->assemble = fmin(t->assemble, base_seconds() - middle);
  }
  return BASE_OK;
}

static base_status measure(int n, const formulation_choice *form, base_error *err) {
  scene_spec s;
  world *w;
  formulation_run *f;
  contact_set c;
  timing t = {0.0, HUGE_VAL, HUGE_VAL};
  int dim = 0;
  BASE_TRY(pile(&s, n, err));
  const double before = peak_bytes(), start = base_seconds();
  BASE_TRY(world_open(
      &w, &s, EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION | EFFECT_SPATIAL,
      err));
  t.open = base_seconds() - start;
  BASE_TRY(formulation_open(&f, form->form, form->opt, err));
  BASE_TRY(step(w, f, &t, &c, &dim, err));
  printf("%s,%d,%d,%d,%d,%.6f,%.6f,%.6f,%.0f\n", form->form->name, s.n_body, c.n_contact, c.n_row,
         dim, t.open, t.contacts, t.assemble, peak_bytes() - before);
  formulation_close(f);
  world_close(w);
  spec_free(&s);
  return BASE_OK;
}

int main(int argc, char **argv) {
  int n = 0;
  formulation_choice form;
  base_error err = {0};
  if (argc < 2 || !base_parse_int(argv[1], &n) || n < 1 || n > 100) {
    fprintf(stderr, "bench_world N [FORMULATION]: need N in 1..100\n");
    return 2;
  }
  if (formulation_choose(argc > 2 ? argv[2] : "coulomb", &form, &err) != BASE_OK ||
      measure(n, &form, &err) != BASE_OK) {
    fprintf(stderr, "%s: %s\n", err.where, err.text);
    return 1;
  }
  formulation_choice_free(&form);
  return 0;
}
