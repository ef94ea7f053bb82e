/* Gaps of every pair of shapes: their rate of change, their symmetry, and distances of shapes apart. */
#include "tests/support/check.h"

#include "tests/support/shape_list.h"
#include "tests/support/shapes_any.h"

enum { N_PLANAR = BASE_COUNT(planar_shapes) + 1, N_SPATIAL = BASE_COUNT(spatial_shapes) };

static const spec_shape *planar_shape(int i) {
  return (i < BASE_COUNT(planar_shapes)) ? &planar_shapes[i] : &polygon5;
}

static int pair_of(int dim, const any_piece *a, const pose *pa, const any_piece *b, const pose *pb,
                   double margin, gap_point *out) {
  return (dim == 2) ? gap_planar(&a->p, pa, &b->p, pb, margin, out)
                    : gap_spatial(&a->p, pa, &b->p, pb, margin, out);
}

static const gap_point *find(const gap_point *g, int n, uint32_t feature) {
  for (int i = 0; i < n; i++) {
    if (g[i].feature == feature) {
      return &g[i];
    }
  }
  return NULL;
}

/* A crossing of two outlines inside a face manifold: its gap is measured along the face normal, so
 * the rate holds only for small tilts (shapes.h). */
static int outline_crossing(const any_piece *a, const pose *pa, const any_piece *b, const pose *pb,
                            const gap_point *g) {
  for (int k = 0; k < 6; k++) {
    const double *R = (k < 3) ? pa->R : pb->R;
    const double axis[3] = {R[k % 3], R[3 + k % 3], R[6 + k % 3]};
    const bool outlines = a->p.kind >= PIECE_SEGMENT && b->p.kind >= PIECE_SEGMENT;
    if (outlines && g->feature >= 16 && fabs(v3_dot(axis, g->n)) > 1.0 - 1e-12) {
      return 1;
    }
  }
  return 0;
}

/* Central difference of the gap of each point against n . relative velocity at the point. */
static int check_rates(int dim, const any_piece *a, const any_piece *b, base_rng *r) {
  const double dt = 1e-6;
  gap_point now[GAP_MAX], before[GAP_MAX], after[GAP_MAX];
  const mover ma = any_mover(r, dim, 0.6), mb = any_mover(r, dim, 0.6);
  const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
  const pose pa0 = mover_at(&ma, -dt), pb0 = mover_at(&mb, -dt);
  const pose pa1 = mover_at(&ma, dt), pb1 = mover_at(&mb, dt);
  const int n = pair_of(dim, a, &pa, b, &pb, 0.4, now);
  const int n0 = pair_of(dim, a, &pa0, b, &pb0, 0.41, before);
  const int n1 = pair_of(dim, a, &pa1, b, &pb1, 0.41, after);
  int checked = 0;
  for (int i = 0; i < n; i++) {
    const gap_point *g0 = find(before, n0, now[i].feature), *g1 = find(after, n1, now[i].feature);
    check_close(v3_norm(now[i].n), 1.0, 1e-12);
    if (g0 == NULL || g1 == NULL || v3_dot(g0->n, g1->n) < 0.999 || fabs(now[i].gap) < 1e-3 ||
        (dim == 3 && outline_crossing(a, &pa, b, &pb, &now[i]))) {
      continue; /* the feature changed within the difference */
    }
    const double rate = mover_rate(&ma, &mb, now[i].x, now[i].n);
    check_close((g1->gap - g0->gap) / (2 * dt), rate, 2e-6);
    checked++;
  }
  return checked;
}

static void every_gap_changes_at_the_rate_of_its_jacobian(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(11);
  for (int dim = 2; dim <= 3; dim++) {
    const int n = (dim == 2) ? N_PLANAR : N_SPATIAL;
    for (int i = 0; i < n * n; i++) {
      any_piece a, b;
      any_shape(&a, (dim == 2) ? planar_shape(i / n) : &spatial_shapes[i / n], dim);
      any_shape(&b, (dim == 2) ? planar_shape(i % n) : &spatial_shapes[i % n], dim);
      int checked = 0;
      for (int k = 0; k < 400; k++) {
        checked += check_rates(dim, &a, &b, &r);
      }
      assert_true(checked > 5);
    }
  }
}

static void swapping_the_sides_flips_the_normals(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(12);
  for (int dim = 2; dim <= 3; dim++) {
    const int n = (dim == 2) ? N_PLANAR : N_SPATIAL;
    for (int i = 0; i < 400 * n * n; i++) {
      any_piece a, b;
      gap_point ab[GAP_MAX], ba[GAP_MAX];
      any_shape(&a, (dim == 2) ? planar_shape((i / n) % n) : &spatial_shapes[(i / n) % n], dim);
      any_shape(&b, (dim == 2) ? planar_shape(i % n) : &spatial_shapes[i % n], dim);
      const mover ma = any_mover(&r, dim, 0.6), mb = any_mover(&r, dim, 0.6);
      const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
      const int m = pair_of(dim, &a, &pa, &b, &pb, 0.2, ab);
      assert_int_equal(m, pair_of(dim, &b, &pb, &a, &pa, 0.2, ba));
      for (int k = 0; k < m; k++) { /* the same points, perhaps in another order */
        double best = HUGE_VAL;
        for (int l = 0; l < m; l++) {
          assert_true(k == l || ab[k].feature != ab[l].feature);
          double d[3], s[3];
          v3_sub(ab[k].x, ba[l].x, d);
          v3_add_scaled(ab[k].n, 1.0, ba[l].n, s);
          best = fmin(best, v3_norm(d) + v3_norm(s) + fabs(ab[k].gap - ba[l].gap));
        }
        check_close(best, 0.0, 1e-9);
      }
    }
  }
}

/* Brute force, vertex against edge: exact for separated polygons, whose closest pair of points
 * contains a vertex. */
static double outline_distance(const any_piece *a, const pose *pa, const any_piece *b,
                               const pose *pb) {
  double best = HUGE_VAL;
  for (int swap = 0; swap < 2; swap++) {
    const any_piece *u = swap ? b : a, *v = swap ? a : b;
    const pose *pu = swap ? pb : pa, *pv = swap ? pa : pb;
    for (int i = 0; i < u->p.n_vertex; i++) {
      for (int j = 0; j < v->p.n_vertex; j++) {
        double x[3], e0[3], e1[3], on_x[3], on_e[3], d[3];
        const int j1 = (j + 1) % v->p.n_vertex;
        m3_mul_vec(pu->R, u->p.vertex + 3 * i, x);
        v3_add_scaled(pu->x, 1.0, x, x);
        m3_mul_vec(pv->R, v->p.vertex + 3 * j, e0);
        v3_add_scaled(pv->x, 1.0, e0, e0);
        m3_mul_vec(pv->R, v->p.vertex + 3 * j1, e1);
        v3_add_scaled(pv->x, 1.0, e1, e1);
        segment_closest(x, x, e0, e1, on_x, on_e);
        v3_sub(on_x, on_e, d);
        best = fmin(best, v3_norm(d));
      }
    }
  }
  return best - a->p.r - b->p.r;
}

static void separated_planar_shapes_report_their_distance(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(13);
  int seen = 0;
  for (int i = 0; i < 20000; i++) {
    any_piece a, b;
    gap_point g[GAP_MAX];
    any_shape(&a, planar_shape((i / N_PLANAR) % N_PLANAR), 2);
    any_shape(&b, planar_shape(i % N_PLANAR), 2);
    const mover ma = any_mover(&r, 2, 1.0), mb = any_mover(&r, 2, 1.0);
    const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
    const int n = gap_planar(&a.p, &pa, &b.p, &pb, HUGE_VAL, g);
    assert_true(n >= 1);
    double least = HUGE_VAL;
    for (int k = 0; k < n; k++) {
      least = fmin(least, g[k].gap);
    }
    if (least + a.p.r + b.p.r > 1e-6) { /* cores apart */
      check_close(least, outline_distance(&a, &pa, &b, &pb), 1e-9);
      seen++;
    }
  }
  assert_true(seen > 5000);
}

/* Distance of two separated convex sets by alternating projections (von Neumann; Cheney &
 * Goldstein 1959): knows nothing of features. Projection on a box or segment by clamping. */
static void project(const any_piece *a, const pose *at, const double *x, double *y) {
  double d[3], s[3], h[3] = {a->p.half[0], a->p.half[1], a->p.half[2]};
  if (a->p.kind == PIECE_SEGMENT) {
    h[1] = h[2] = 0.0;
  } else if (a->p.kind == PIECE_POINT) {
    h[0] = h[1] = h[2] = 0.0;
  }
  v3_sub(x, at->x, d);
  m3_tmul_vec(at->R, d, s);
  const double rho = hypot(s[0], s[1]);
  for (int k = 0; k < 3; k++) {
    s[k] = (a->p.kind == PIECE_DISC && k < 2) ? s[k] * fmin(1.0, a->p.r / rho)
                                              : fmin(fmax(s[k], -h[k]), h[k]);
  }
  m3_mul_vec(at->R, s, y);
  v3_add_scaled(at->x, 1.0, y, y);
}

static double projected_distance(const any_piece *a, const pose *pa, const any_piece *b,
                                 const pose *pb) {
  double p[3], q[3], d[3], before = HUGE_VAL;
  v3_copy(pb->x, q);
  for (int i = 1; i <= 200000; i++) { /* round pieces close in slowly */
    project(a, pa, q, p);
    project(b, pb, p, q);
    if (i % 3000 == 0) {
      v3_sub(p, q, d);
      if (before - v3_norm(d) < 1e-8) {
        break;
      }
      before = v3_norm(d);
    }
  }
  v3_sub(p, q, d);
  return v3_norm(d);
}

static double core_radius(const any_piece *a) {
  return (a->p.kind == PIECE_DISC) ? 0.0 : a->p.r;
}

static void separated_spatial_shapes_report_their_distance(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(14);
  int seen = 0;
  for (int i = 0; i < 3600; i++) {
    any_piece a, b;
    gap_point g[GAP_MAX];
    any_shape(&a, &spatial_shapes[(i / N_SPATIAL) % N_SPATIAL], 3);
    any_shape(&b, &spatial_shapes[i % N_SPATIAL], 3);
    const mover ma = any_mover(&r, 3, 0.8), mb = any_mover(&r, 3, 0.8);
    const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
    const int n = gap_spatial(&a.p, &pa, &b.p, &pb, HUGE_VAL, g);
    double least = HUGE_VAL;
    assert_true(n >= 1);
    for (int k = 0; k < n; k++) {
      least = fmin(least, g[k].gap);
    }
    const double radii = core_radius(&a) + core_radius(&b);
    if (least + radii > 0.01) { /* alternating projections are slow near touching */
      check_close(least + radii, projected_distance(&a, &pa, &b, &pb), 2e-5);
      seen++;
    }
  }
  assert_true(seen > 1000);
}

/* Support function of the core of a piece about its centre. */
static double support_of(const any_piece *a, const pose *at, const double *n) {
  double local[3];
  m3_tmul_vec(at->R, n, local);
  if (a->p.kind == PIECE_DISC) {
    return a->p.r * hypot(local[0], local[1]) + a->p.half[2] * fabs(local[2]);
  }
  if (a->p.kind == PIECE_SEGMENT) {
    return a->vertex[3] * fabs(local[0]);
  }
  return a->p.half[0] * fabs(local[0]) + a->p.half[1] * fabs(local[1]) +
         a->p.half[2] * fabs(local[2]);
}

/* Overlap of the cores: no direction separates them more than the gap says, by trying 4000. */
static void overlapping_round_shapes_leave_the_shortest_way(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(21);
  int seen = 0;
  for (int i = 0; i < 400; i++) {
    any_piece a, b;
    gap_point g[GAP_MAX];
    any_shape(&a, &spatial_shapes[2 + i % 4], 3);
    any_shape(&b, &spatial_shapes[4 + i / 4 % 2], 3);
    const mover ma = any_mover(&r, 3, 0.25), mb = any_mover(&r, 3, 0.25);
    const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
    const int n = gap_spatial(&a.p, &pa, &b.p, &pb, HUGE_VAL, g);
    double least = HUGE_VAL, best = -HUGE_VAL, d[3];
    for (int k = 0; k < n; k++) {
      least = fmin(least, g[k].gap);
    }
    v3_sub(pa.x, pb.x, d);
    for (int k = 0; k < 4000; k++) {
      double m[3] = {base_rng_normal(&r), base_rng_normal(&r), base_rng_normal(&r)};
      v3_scale(1.0 / v3_norm(m), m, m);
      best = fmax(best, v3_dot(m, d) - support_of(&a, &pa, m) - support_of(&b, &pb, m));
    }
    const double core = least + core_radius(&a) + core_radius(&b);
    if (core < 0.0) {
      assert_true(core >= best - 1e-6 - 1e-9); /* points of a manifold may lie 1e-6 deeper */
      check_close(core, best, 0.05);           /* 4000 directions come that near */
      seen++;
    }
  }
  assert_true(seen > 100);
}

/* Largest n . x over the core, from its centre. */
static double reach(const any_piece *a, const pose *at, const double *n) {
  double local[3], most = -HUGE_VAL;
  if (a->p.kind == PIECE_BOX || a->p.kind == PIECE_DISC) {
    return support_of(a, at, n);
  }
  m3_tmul_vec(at->R, n, local);
  for (int i = 0; i < a->p.n_vertex; i++) {
    most = fmax(most, v3_dot(local, a->vertex + (ptrdiff_t)3 * i));
  }
  return most;
}

/* Greatest separation of the cores over all directions: 1000 tried, and 1000 ever nearer to the best. */
static double way_out(base_rng *r, int dim, const any_piece *a, const pose *pa, const any_piece *b,
                      const pose *pb) {
  double d[3], best[3] = {0}, most = -HUGE_VAL;
  v3_sub(pa->x, pb->x, d);
  for (int k = 0; k < 2000; k++) {
    const double near = (k < 1000) ? 1.0 : pow(10.0, -6.0 * (k - 1000) / 1000.0);
    double n[3], back[3];
    for (int c = 0; c < 3; c++) {
      n[c] = (k < 1000 ? 0.0 : best[c]) + ((c < dim) ? near * base_rng_normal(r) : 0.0);
    }
    v3_scale(1.0 / v3_norm(n), n, n);
    v3_scale(-1.0, n, back);
    const double apart = v3_dot(n, d) - reach(a, pa, back) - reach(b, pb, n);
    if (apart > most) {
      most = apart;
      v3_copy(n, best);
    }
  }
  return most;
}

/* However deep two shapes overlap, the deepest point is as deep as the shortest way out is long. */
static void deep_overlaps_are_measured_from_the_shapes(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(23);
  int deep = 0;
  for (int i = 0; i < 36 * 40; i++) {
    const int dim = 2 + i % 2;
    any_piece a, b;
    gap_point g[GAP_MAX];
    any_shape(&a, dim == 2 ? planar_shape(i / 2 % 6) : &spatial_shapes[i / 2 % 6], dim);
    any_shape(&b, dim == 2 ? planar_shape(i / 12 % 6) : &spatial_shapes[i / 12 % 6], dim);
    const mover ma = any_mover(&r, dim, 0.3), mb = any_mover(&r, dim, 0.3);
    const pose pa = mover_at(&ma, 0), pb = mover_at(&mb, 0);
    const int n = pair_of(dim, &a, &pa, &b, &pb, HUGE_VAL, g);
    const double expected = way_out(&r, dim, &a, &pa, &b, &pb) - core_radius(&a) - core_radius(&b);
    double least = HUGE_VAL;
    for (int k = 0; k < n; k++) {
      least = fmin(least, g[k].gap);
    }
    if (expected < -0.01) {
      assert_true(least >= expected - 2e-6); /* of all directions none is better */
      check_close(least / expected, 1.0,
                  dim == 2 ? 1e-3 : 0.05); /* in space they are tried more thinly */
      deep++;
    }
  }
  assert_true(deep > 700);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(overlapping_round_shapes_leave_the_shortest_way),
      cmocka_unit_test(deep_overlaps_are_measured_from_the_shapes),
      cmocka_unit_test(every_gap_changes_at_the_rate_of_its_jacobian),
      cmocka_unit_test(swapping_the_sides_flips_the_normals),
      cmocka_unit_test(separated_planar_shapes_report_their_distance),
      cmocka_unit_test(separated_spatial_shapes_report_their_distance),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
