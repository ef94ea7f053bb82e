#include "tests/support/check.h"

#include "tests/support/shapes_any.h"

static const spec_shape polygon5 = {
    .kind = SPEC_POLYGON,
    .n_vertex = 5,
    .vertex = {{-0.4, -0.3}, {0.5, -0.35}, {0.6, 0.1}, {0.1, 0.5}, {-0.5, 0.2}}};
static const spec_shape planar[] = {
    {.kind = SPEC_POINT},
    {.kind = SPEC_SPHERE, .r = 0.3},
    {.kind = SPEC_ROD, .half = {0.5}},
    {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
    {.kind = SPEC_BOX, .half = {0.5, 0.3}},
};
static const spec_shape spatial[] = {
    {.kind = SPEC_POINT},
    {.kind = SPEC_SPHERE, .r = 0.3},
    {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
    {.kind = SPEC_BOX, .half = {0.5, 0.3, 0.2}},
    {.kind = SPEC_DISC3D, .r = 0.4},
    {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 0.2}},
};
enum { N_PLANAR = BASE_COUNT(planar) + 1, N_SPATIAL = BASE_COUNT(spatial) };

static const spec_shape *planar_shape(int i) {
  return (i < BASE_COUNT(planar)) ? &planar[i] : &polygon5;
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
      any_shape(&a, (dim == 2) ? planar_shape(i / n) : &spatial[i / n], dim);
      any_shape(&b, (dim == 2) ? planar_shape(i % n) : &spatial[i % n], dim);
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
      any_shape(&a, (dim == 2) ? planar_shape((i / n) % n) : &spatial[(i / n) % n], dim);
      any_shape(&b, (dim == 2) ? planar_shape(i % n) : &spatial[i % n], dim);
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

static void half_space_lists_every_corner(void **state) {
  (void)state;
  const double up[3] = {0, 0, 1}, x[3] = {0, 0, 0.2}, q[4] = {1, 0, 0, 0};
  any_piece box;
  gap_point g[GAP_MAX];
  any_shape(&box, &spatial[3], 3);
  const pose at = any_pose(x, q);
  assert_int_equal(gap_halfspace(&box.p, &at, up, 0.0, 0.01, g), 4);
  for (int i = 0; i < 4; i++) {
    check_close(g[i].gap, 0.0, 1e-15);
    assert_int_equal(g[i].feature, i);
  }
  assert_int_equal(gap_halfspace(&box.p, &at, up, 0.0, 1.0, g), 8);
}

/* Lowest point of a tilted disc: centre height - r sin(tilt). */
static void tilted_disc_touches_at_its_lowest_rim_point(void **state) {
  (void)state;
  const double up[3] = {0, 0, 1}, x[3] = {0.1, 0.2, 0.5}, tilt = 0.4;
  const double q[4] = {cos(tilt / 2), sin(tilt / 2), 0, 0};
  any_piece disc;
  gap_point g[GAP_MAX];
  any_shape(&disc, &spatial[4], 3);
  const pose at = any_pose(x, q);
  assert_int_equal(gap_halfspace(&disc.p, &at, up, 0.0, 0.4, g), 1);
  check_close(g[0].gap, 0.5 - 0.4 * sin(tilt), 1e-14);
  check_close(g[0].x[0], 0.1, 1e-14);
  const double flat[4] = {1, 0, 0, 0};
  const pose lying = any_pose(x, flat);
  assert_int_equal(gap_halfspace(&disc.p, &lying, up, 0.0, 0.6, g), 6);
}

/* A box pushed along a floor box: ids must not change while the corners stay over it. */
static void ids_last_while_features_do(void **state) {
  (void)state;
  any_piece block, table;
  const spec_shape wide = {.kind = SPEC_BOX, .half = {3, 0.05}};
  any_shape(&block, &planar[4], 2);
  any_shape(&table, &wide, 2);
  const double q[4] = {1, 0, 0, 0}, origin[3] = {0, 0, 0};
  const pose down = any_pose(origin, q);
  for (int i = 0; i <= 100; i++) {
    const double x[3] = {-2.0 + 0.04 * i, 0.35 + 1e-12 * (i % 3 - 1), 0};
    const pose up = any_pose(x, q);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_planar(&block.p, &up, &table.p, &down, 1e-3, g), 2);
    assert_int_equal(g[0].feature + g[1].feature, 1); /* vertices 0 and 1 of the block */
    check_close(g[0].n[1], 1.0, 1e-12);
  }
}

static void equal_boxes_keep_two_points_at_every_rounding(void **state) {
  (void)state;
  any_piece box;
  any_shape(&box, &planar[4], 2);
  base_rng r = base_rng_seeded(5);
  const double origin[3] = {0, 0, 0};
  for (int i = 0; i < 1000; i++) {
    const double tilt = 1e-12 * base_rng_normal(&r);
    const double q0[4] = {1, 0, 0, 0}, q1[4] = {1, 0, 0, tilt};
    const double x[3] = {1e-12 * base_rng_normal(&r), 0.6 + 1e-13 * base_rng_normal(&r), 0};
    const pose low = any_pose(origin, q0), high = any_pose(x, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_planar(&box.p, &low, &box.p, &high, 1e-3, g), 2);
    assert_true(g[0].feature == SPEC_VERTICES && g[1].feature == SPEC_VERTICES + 1);
  }
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
    any_shape(&a, &spatial[(i / N_SPATIAL) % N_SPATIAL], 3);
    any_shape(&b, &spatial[i % N_SPATIAL], 3);
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

/* Four corners of a face are four points, also with equal outlines; ids do not depend on rounding. */
static void stacked_boxes_rest_on_four_points(void **state) {
  (void)state;
  any_piece box, wide;
  const spec_shape plate = {.kind = SPEC_BOX, .half = {2, 2, 0.1}};
  base_rng r = base_rng_seeded(15);
  any_shape(&box, &spatial[3], 3);
  any_shape(&wide, &plate, 3);
  for (int i = 0; i < 500; i++) {
    const double e = 1e-12;
    const double q0[4] = {1, 0, 0, 0};
    const double q1[4] = {1, e * base_rng_normal(&r), e * base_rng_normal(&r),
                          e * base_rng_normal(&r)};
    const double low[3] = {0, 0, 0}, mid[3] = {e, e, 0.4 + e * base_rng_normal(&r)};
    const double on_plate[3] = {0.3 + 0.001 * i, -0.2, 0.3 + e * base_rng_normal(&r)};
    const pose p0 = any_pose(low, q0), p1 = any_pose(mid, q1), p2 = any_pose(on_plate, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_spatial(&box.p, &p0, &box.p, &p1, 1e-3, g), 4);
    for (uint32_t k = 0; k < 4; k++) {
      assert_true(g[k].feature >= 8 && g[k].feature < 12); /* lower corners of the upper box */
      check_close(g[k].n[2], -1.0, 1e-11);
    }
    assert_int_equal(gap_spatial(&box.p, &p2, &wide.p, &p0, 1e-3, g), 4);
    for (uint32_t k = 0; k < 4; k++) {
      assert_true(g[k].feature < 4);
    }
  }
}

/* A capsule rolling about its own axis on a box keeps its two ids: its corners coincide. */
static void capsules_keep_their_ids_when_they_roll(void **state) {
  (void)state;
  any_piece rod, box;
  any_shape(&rod, &spatial[2], 3);
  any_shape(&box, &spatial[3], 3);
  uint32_t first[2] = {0, 0};
  for (int i = 0; i < 100; i++) {
    const double turn = 0.1 * i, low[3] = {0, 0, 0}, high[3] = {0, 0, 0.3 - 1e-4};
    const double q0[4] = {1, 0, 0, 0}, q1[4] = {cos(turn / 2), sin(turn / 2), 0, 0};
    const pose p0 = any_pose(low, q0), p1 = any_pose(high, q1);
    gap_point g[GAP_MAX];
    assert_int_equal(gap_spatial(&rod.p, &p1, &box.p, &p0, 1e-3, g), 2);
    for (int k = 0; k < 2; k++) {
      first[k] = (i == 0) ? g[k].feature : first[k];
      assert_int_equal(g[k].feature, first[k]);
      check_close(g[k].gap, -1e-4, 1e-12);
    }
  }
}

/* A square turned by 45 degrees on an equal square: an octagon of crossings. */
static void turned_square_rests_on_eight_crossings(void **state) {
  (void)state;
  any_piece cube;
  const spec_shape unit = {.kind = SPEC_BOX, .half = {0.5, 0.5, 0.5}};
  const double low[3] = {0, 0, 0}, high[3] = {0, 0, 1.0}, q0[4] = {1, 0, 0, 0};
  const double q1[4] = {cos(0.125 * 3.14159265358979), 0, 0, sin(0.125 * 3.14159265358979)};
  gap_point g[GAP_MAX];
  any_shape(&cube, &unit, 3);
  const pose p0 = any_pose(low, q0), p1 = any_pose(high, q1);
  assert_int_equal(gap_spatial(&cube.p, &p0, &cube.p, &p1, 1e-3, g), 8);
  for (int i = 0; i < 8; i++) {
    assert_true(g[i].feature >= 16);
    check_close(g[i].gap, 0.0, 1e-12);
    check_close(hypot(g[i].x[0], g[i].x[1]), 0.5 / cos(0.125 * 3.14159265358979), 1e-9);
    for (int k = 0; k < i; k++) {
      assert_true(g[i].feature != g[k].feature);
    }
  }
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
    any_shape(&a, &spatial[2 + i % 4], 3);
    any_shape(&b, &spatial[4 + i / 4 % 2], 3);
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

static int count_below(const gap_point *g, int n, double gap, double tol) {
  int count = 0;
  for (int k = 0; k < n; k++) {
    count += fabs(g[k].gap - gap) < tol;
  }
  return count;
}

/* Cylinders stand on six points and lie on two, on boxes and on each other. */
static void cylinders_stand_and_lie(void **state) {
  (void)state;
  static const spec_shape can = {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 0.2}};
  static const spec_shape table = {.kind = SPEC_BOX, .half = {1, 1, 0.1}};
  const double up[4] = {1, 0, 0, 0}, down[4] = {sqrt(0.5), sqrt(0.5), 0, 0};
  any_piece a, b, c;
  gap_point g[GAP_MAX];
  any_shape(&a, &can, 3);
  any_shape(&b, &table, 3);
  any_shape(&c, &can, 3);
  const pose floor_ = any_pose((const double[]){0, 0, -0.1}, up);
  const pose upright = any_pose((const double[]){0.2, 0.1, 0.2}, up);
  const pose lying = any_pose((const double[]){0.2, 0.1, 0.3}, down);
  const pose above = any_pose((const double[]){0.2, 0.1, 0.6}, up);
  const pose beside = any_pose((const double[]){0.8, 0.1, 0.3}, down);
  int n = gap_spatial(&a.p, &upright, &b.p, &floor_, 0.01, g);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 6);
  assert_int_equal(n, 6);
  for (int k = 0; k < n; k++) {
    check_close(g[k].n[2], 1.0, 1e-12);
  }
  n = gap_spatial(&a.p, &lying, &b.p, &floor_, 0.01, g);
  assert_int_equal(n, 2);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 2);
  n = gap_spatial(&c.p, &above, &a.p, &upright, 0.01, g);
  assert_int_equal(n, 6);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 6);
  n = gap_spatial(&c.p, &beside, &a.p, &lying, 0.01, g);
  assert_int_equal(n, 2);
  assert_int_equal(count_below(g, n, 0.0, 1e-12), 2);
  for (int k = 0; k < n; k++) {
    check_close(g[k].n[0], 1.0, 1e-12);
  }
}

/* Cores that meet have no direction from one to the other: the normal is at right angles to both, and from the
 * axis of a long cylinder the way out is through its mantle. */
static void cores_that_meet_have_a_normal(void **state) {
  (void)state;
  static const spec_shape rod = {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
                          ball = {.kind = SPEC_SPHERE, .r = 0.1},
                          post = {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 2.0}};
  const double here[3] = {0}, plain[4] = {1, 0, 0, 0}, upright[4] = {sqrt(0.5), 0, -sqrt(0.5), 0},
               sideways[4] = {sqrt(0.5), 0, 0, sqrt(0.5)};
  const pose along = any_pose(here, plain), up = any_pose(here, upright),
             across = any_pose(here, sideways);
  any_piece a, b;
  gap_point g[GAP_MAX];
  any_shape(&a, &rod, 3);
  any_shape(&b, &rod, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &across, 0.0, g), 1);
  check_close(g[0].gap, -0.2, 1e-15);
  check_close(fabs(g[0].n[2]), 1.0, 1e-12);
  any_shape(&a, &ball, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &up, 0.0, g), 1);
  check_close(g[0].gap, -0.2, 1e-15);
  check_close(g[0].n[2], 0.0, 1e-12); /* the rod stands along z */
  any_shape(&b, &post, 3);
  assert_int_equal(gap_spatial(&a.p, &along, &b.p, &along, 0.0, g), 1);
  check_close(g[0].gap, -0.4, 1e-15);
  check_close(hypot(g[0].n[0], g[0].n[1]), 1.0, 1e-12);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(overlapping_round_shapes_leave_the_shortest_way),
      cmocka_unit_test(cores_that_meet_have_a_normal),
      cmocka_unit_test(cylinders_stand_and_lie),
      cmocka_unit_test(every_gap_changes_at_the_rate_of_its_jacobian),
      cmocka_unit_test(swapping_the_sides_flips_the_normals),
      cmocka_unit_test(separated_planar_shapes_report_their_distance),
      cmocka_unit_test(separated_spatial_shapes_report_their_distance),
      cmocka_unit_test(stacked_boxes_rest_on_four_points),
      cmocka_unit_test(capsules_keep_their_ids_when_they_roll),
      cmocka_unit_test(turned_square_rests_on_eight_crossings),
      cmocka_unit_test(half_space_lists_every_corner),
      cmocka_unit_test(tilted_disc_touches_at_its_lowest_rim_point),
      cmocka_unit_test(ids_last_while_features_do),
      cmocka_unit_test(equal_boxes_keep_two_points_at_every_rounding),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
