/* Contacts on which nothing acts: a lattice of spheres in a box that stands oblique to the axes. Sideways nothing moves
 * and nothing presses, but for what rounding leaves of the other directions. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "tests/support/random_cones.h"
#include "tests/support/solve.h"

#include <string.h>

enum {
  SIDE = 3,
  LAYERS = 4,
  SPHERES = SIDE * SIDE * LAYERS,
  CONTACTS = 4 * SPHERES + 100,
  DOF = 6
};

typedef struct lattice {
  known_lcp k;
  lcp_csc csc;
  lcp_problem stored[2]; /* factored, CSC */
} lattice;

/* Orthonormal axes, the third one up. */
static void turn(base_rng *r, double axis[3][3]) {
  for (int i = 0; i < 3; i++) {
    for (int c = 0; c < 3; c++) {
      axis[i][c] = base_rng_normal(r);
    }
    for (int j = 0; j <= i; j++) {
      double dot = 0;
      for (int c = 0; c < 3; c++) {
        dot += axis[i][c] * axis[j][c];
      }
      for (int c = 0; c < 3; c++) {
        axis[i][c] = (j == i) ? axis[i][c] / sqrt(dot) : axis[i][c] - dot * axis[j][c];
      }
    }
  }
}

static void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

typedef struct writer {
  int *row_start, *body, *jac_start, count;
  double *jac, *q, (*axis)[3];
  const double *v;
  lcp_block *block;
} writer;

/* One contact of sphere `a` (radius 1) whose normal is sign axis[k], with sphere `b` (-1: the box). */
static void touch(writer *s, int a, int b, int k, double sign) {
  const int c = s->count++;
  const int body[2] = {a, b};
  double *jac = s->jac + s->jac_start[c];
  s->block[c] = (lcp_block){
      .start = 3 * c, .size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {0.3}};
  memcpy(s->body + 2 * (ptrdiff_t)c, body, sizeof body);
  for (int side = 0; side < 2 && body[side] >= 0; side++, jac += 3 * DOF) {
    for (int row = 0; row < 3; row++) {
      double *line = jac + row * DOF, arm[3], moment[3];
      const double *dir = s->axis[(k + row) % 3], way = (side == 0) ? 1.0 : -1.0;
      for (int i = 0; i < 3; i++) {
        arm[i] = -way * sign * s->axis[k][i];
      }
      cross(arm, dir, moment);
      for (int i = 0; i < 3; i++) {
        line[i] = way * ((row == 0) ? sign : 1.0) * dir[i];
        line[3 + i] = way * ((row == 0) ? sign : 1.0) * moment[i];
      }
      for (int i = 0; i < DOF; i++) {
        s->q[3 * c + row] += line[i] * s->v[DOF * body[side] + i];
      }
    }
  }
  s->row_start[c + 1] = 3 * c + 3;
  s->jac_start[c + 1] = (int)(jac - s->jac);
}

/* Falls at 0.05 m/s onto the floor; `seed` turns the box, 0 leaves it upright. */
static void open_lattice(lattice *l, uint64_t seed) {
  base_rng r = base_rng_seeded(seed);
  base_error err = {0};
  known_lcp *k = &l->k;
  double axis[3][3] = {{0}};
  *l = (lattice){.k = {.answer = KNOWN_SOLVABLE}};
  if (seed == 0) {
    axis[0][0] = axis[1][1] = axis[2][2] = 1.0;
  } else {
    turn(&r, axis);
  }
  int *dof_start = KNOWN_ARRAY(k, int, SPHERES + 1),
      *weight_start = KNOWN_ARRAY(k, int, SPHERES + 1);
  double *weight = KNOWN_ARRAY(k, double, DOF *DOF *SPHERES),
         *v = KNOWN_ARRAY(k, double, DOF *SPHERES);
  lcp_factored *f = KNOWN_ARRAY(k, lcp_factored, 1);
  writer s = {.row_start = KNOWN_ARRAY(k, int, CONTACTS + 1),
              .body = KNOWN_ARRAY(k, int, 2 * CONTACTS),
              .jac_start = KNOWN_ARRAY(k, int, CONTACTS + 1),
              .jac = KNOWN_ARRAY(k, double, 2 * 3 * DOF * CONTACTS),
              .q = KNOWN_ARRAY(k, double, 3 * CONTACTS),
              .axis = axis,
              .v = v,
              .block = KNOWN_ARRAY(k, lcp_block, CONTACTS)};
  assert_true(k->n_owned == 11);
  for (int b = 0; b < SPHERES; b++) {
    dof_start[b + 1] = DOF * (b + 1);
    weight_start[b + 1] = DOF * DOF * (b + 1);
    for (int i = 0; i < DOF; i++) {
      weight[DOF * DOF * b + (DOF + 1) * i] = (i < 3) ? 1.0 : 2.5;
      v[DOF * b + i] = (i < 3) ? -0.05 * axis[2][i] : 0.0;
    }
  }
  static const int step[3] = {1, SIDE, SIDE * SIDE}, count[3] = {SIDE, SIDE, LAYERS};
  for (int b = 0; b < SPHERES; b++) {
    for (int d = 0; d < 3; d++) {
      const int place = b / step[d] % count[d];
      touch(&s, b, (place > 0) ? b - step[d] : -1, d, 1.0);
      if (d < 2 && place == count[d] - 1) {
        touch(&s, b, -1, d, -1.0);
      }
    }
  }
  assert_true(s.count <= CONTACTS);
  *f = (lcp_factored){SPHERES, dof_start,   weight_start, weight, s.count, s.row_start,
                      s.body,  s.jac_start, s.jac,        NULL,   NULL,    NULL};
  k->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = 3 * s.count, .factored = f},
                       .q = s.q,
                       .block = s.block,
                       .n_block = s.count,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
  check_ok(lcp_problem_check(&k->p, &err), &err);
  check_ok(lcp_matrix_to_csc(&k->p.M, &l->csc, &err), &err);
  l->stored[0] = l->stored[1] = k->p;
  l->stored[1].M = (lcp_matrix){.storage = LCP_CSC, .n = k->p.M.n, .csc = l->csc};
}

static void close_lattice(lattice *l) {
  lcp_csc_free(&l->csc);
  known_lcp_free(&l->k);
}

static const char *const solvers[] = {"cone_newton", "nsgs", "prox"};

/* In both storages, from zero and from an answer with noise; the claimed residual is the judge's, or above it. */
static void an_oblique_lattice_rests(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(21);
  for (uint64_t seed = 1; seed <= 3; seed++) {
    lattice l;
    open_lattice(&l, seed);
    const int n = l.k.p.M.n;
    double *z = calloc((size_t)n, sizeof *z);
    assert_non_null(z);
    for (int trial = 0; trial < 2 * BASE_COUNT(solvers); trial++) {
      const lcp_problem *p = &l.stored[trial % 2];
      lcp_result res;
      memset(z, 0, (size_t)n * sizeof *z);
      for (int again = 0; again < 2; again++) {
        res = solve_by(solvers[trial / 2], "tol=1e-10,max_iter=200", p, z);
        assert_string_equal(lcp_outcome_name(res.outcome), "ok");
        if (p->M.storage == LCP_FACTORED) { /* a bound where it is enough */
          assert_true(res.residual >= verdict_on(p, z).rho - 1e-13);
        } else {
          check_close(res.residual, verdict_on(p, z).rho, 1e-13);
        }
        assert_true(res.residual <= 1e-10);
        for (int i = 0; i < n; i++) {
          z[i] += 1e-17 * base_rng_normal(&r);
        }
      }
    }
    free(z);
    close_lattice(&l);
  }
}

/* A claim beside the answer, however near, is the judge's opinion as well; and it is made where the judge makes it. */
static void claims_are_those_of_the_judge(void **state) {
  (void)state;
  enum { TRIALS = 300 };
  base_rng r = base_rng_seeded(22);
  lattice l;
  lcp_result res;
  int yes = 0;
  open_lattice(&l, 4);
  const int n = l.k.p.M.n;
  double *answer = calloc((size_t)n, sizeof *answer), *z = calloc((size_t)n, sizeof *z);
  assert_true(answer != NULL && z != NULL);
  res = solve_by("cone_newton", "tol=1e-10,max_iter=200", &l.stored[0], answer);
  for (int trial = 0; trial < TRIALS; trial++) {
    const double off = pow(10.0, -base_rng_between(&r, 8.0, 14.0));
    const int at = (int)(base_rng_uniform(&r) * n);
    for (int i = 0; i < n; i++) {
      z[i] = answer[i] + ((i == at) ? off : 0.0);
    }
    const double true_rho = verdict_on(&l.stored[0], z).rho;
    res = solve_by("nsgs", "tol=1e-10,max_iter=1", &l.stored[0], z);
    if (res.work.sweeps == 0) { /* accepted as it came */
      assert_string_equal(lcp_outcome_name(res.outcome), "ok");
      assert_true(true_rho <= 1.000001e-10);
      yes++;
    } else {
      assert_true(true_rho > 1e-12); /* the test against the data may ask for more */
    }
  }
  print_message("%d of %d accepted\n", yes, TRIALS);
  assert_true(yes > TRIALS / 10 && yes < TRIALS - TRIALS / 10);
  free(answer);
  free(z);
  close_lattice(&l);
}

/* Speeds of 1e-22 m/s are no smaller than those of 1 m/s where nothing is faster. */
static void no_scale_makes_zero_a_solution(void **state) {
  (void)state;
  static const double scales[] = {1e-20, 1e-100, 1e20};
  lattice l;
  open_lattice(&l, 5);
  const int n = l.k.p.M.n;
  double *q = calloc((size_t)n, sizeof *q), *z = calloc((size_t)n, sizeof *z);
  assert_true(q != NULL && z != NULL);
  const double plain = verdict_on(&l.stored[0], z).rho;
  assert_true(plain > 0.1);
  for (int k = 0; k < 2 * BASE_COUNT(scales); k++) {
    lcp_problem p = l.stored[k % 2];
    lcp_result res;
    for (int i = 0; i < n; i++) {
      q[i] = scales[k / 2] * p.q[i];
    }
    p.q = q;
    memset(z, 0, (size_t)n * sizeof *z);
    check_close(verdict_on(&p, z).rho, plain, 1e-12);
    for (int i = 0; i < BASE_COUNT(solvers); i++) {
      memset(z, 0, (size_t)n * sizeof *z);
      res = solve_by(solvers[i], "tol=1e-10,max_iter=1", &p, z);
      assert_string_equal(lcp_outcome_name(res.outcome), "max_iter");
      memset(z, 0, (size_t)n * sizeof *z);
      res = solve_by(solvers[i], "tol=1e-10,max_iter=200", &p, z);
      assert_string_equal(lcp_outcome_name(res.outcome), "ok");
      assert_true(verdict_on(&p, z).rho <= 1e-10);
    }
  }
  free(q);
  free(z);
  close_lattice(&l);
}

/* Walls close at `speed`: of an upright box two that face each other, of an oblique one all, and the floor. */
static void squeeze(const lattice *l, bool upright, double speed, double *q) {
  const lcp_factored *f = l->k.p.M.factored;
  memcpy(q, l->k.p.q, (size_t)l->k.p.M.n * sizeof *q);
  for (int c = 0; c < f->n_group; c++) {
    const bool wall = f->body[2 * c + 1] < 0;
    q[3 * c] -= (wall && (!upright || f->jac[f->jac_start[c]] != 0.0)) ? speed : 0.0;
  }
}

/* Proved where the numbers allow it, never claimed solved, and not proved of walls that part. */
static void closing_walls_are_proved_infeasible(void **state) {
  (void)state;
  for (uint64_t seed = 0; seed < 3; seed++) {
    lattice l;
    open_lattice(&l, seed);
    const int n = l.k.p.M.n;
    double *q = calloc((size_t)n, sizeof *q), *z = calloc((size_t)n, sizeof *z);
    assert_true(q != NULL && z != NULL);
    for (int trial = 0; trial < 4; trial++) {
      lcp_problem p = l.stored[trial % 2];
      lcp_result res;
      p.q = q;
      squeeze(&l, seed == 0, (trial < 2) ? 0.1 : -0.1, q);
      memset(z, 0, (size_t)n * sizeof *z);
      res = solve_by("cone_newton", "tol=1e-10,max_iter=200", &p, z);
      if (trial >= 2) {
        assert_string_equal(lcp_outcome_name(res.outcome), "ok");
      } else if (seed == 0) {
        assert_string_equal(lcp_outcome_name(res.outcome), "infeasible");
      } else {
        assert_true(res.outcome != LCP_SOLVED && res.outcome != LCP_INFEASIBLE);
      }
    }
    free(q);
    free(z);
    close_lattice(&l);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_oblique_lattice_rests),
      cmocka_unit_test(claims_are_those_of_the_judge),
      cmocka_unit_test(no_scale_makes_zero_a_solution),
      cmocka_unit_test(closing_walls_are_proved_infeasible),
  };
  return cmocka_run_group_tests_name("cone_rest", tests, NULL, NULL);
}
