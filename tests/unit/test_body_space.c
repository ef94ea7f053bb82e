/* Systems in the velocities of the bodies, some of which no row sees, against the rows themselves. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/linear/body_space.h"
#include "tests/support/random_cones.h"

#include <string.h>

enum { SEEDS = 40 };

typedef struct rig {
  known_lcp k;
  const lcp_factored *f;
  int n;
  double *L, *G, *scale, *right, *x, *y; /* of n, but for L and G */
  double *T, *Y; /* of every group, rows x rows by columns, before they are factored */
  unsigned char *member;
  int *most; /* n_body: velocities that some row in the system sees */
} rig;

static void *room(size_t count, size_t size) {
  void *mem = calloc(count + 1, size);
  assert_non_null(mem);
  return mem;
}

/* Rows of group g on one side lose what lies behind `seen` velocities. */
static void blind(rig *r, int g, int which, int seen) {
  const lin_side a = lin_side_of(r->f, r->G, g, which);
  for (int i = 0; i < r->f->row_start[g + 1] - r->f->row_start[g]; i++) {
    for (int c = seen; c < a.dof; c++) {
      r->G[(a.jac - r->G) + (ptrdiff_t)i * a.dof + c] = 0;
    }
  }
}

static void note_most(rig *r, int g, int which) {
  const lin_side a = lin_side_of(r->f, r->G, g, which);
  for (int i = r->f->row_start[g]; i < r->f->row_start[g + 1] && a.dof > 0; i++) {
    for (int c = r->most[a.body]; c < a.dof && r->member[i]; c++) {
      if (a.jac[(ptrdiff_t)(i - r->f->row_start[g]) * a.dof + c] != 0) {
        r->most[a.body] = c + 1;
      }
    }
  }
}

static void open_rig(rig *r, uint64_t seed) {
  base_error err = {0};
  base_rng rng = base_rng_seeded(seed);
  *r = (rig){.n = 0};
  check_ok(random_cones(&r->k, seed, &err), &err);
  const lcp_factored *f = r->f = r->k.p.M.factored;
  r->n = r->k.p.M.n;
  const size_t n = (size_t)r->n;
  r->L = room((size_t)f->weight_start[f->n_body], sizeof *r->L);
  r->G = room((size_t)f->jac_start[f->n_group], sizeof *r->G);
  r->T = room(n * LIN_GROUP_MAX, sizeof *r->T);
  r->Y = room(n * LIN_GROUP_MAX, sizeof *r->Y);
  double **const rows[] = {&r->scale, &r->right, &r->x, &r->y};
  for (int i = 0; i < BASE_COUNT(rows); i++) {
    *rows[i] = room(n, sizeof **rows[i]);
  }
  r->member = room(n, 1);
  r->most = room((size_t)f->n_body, sizeof *r->most);
  check_ok(lin_weigh_bodies(f, r->L, &err), &err);
  lin_weigh_rows(f, r->L, r->G);
  int *seen = room((size_t)f->n_body, sizeof *seen);
  for (int b = 0; b < f->n_body; b++) {
    seen[b] = (base_rng_uniform(&rng) < 0.3) ? LIN_BLOCK_MAX : (int)(7 * base_rng_uniform(&rng));
  }
  for (int i = 0; i < r->n; i++) {
    r->scale[i] = 0.5 + base_rng_uniform(&rng);
    r->right[i] = base_rng_normal(&rng);
    r->member[i] = base_rng_uniform(&rng) < 0.7;
  }
  for (int g = 0; g < f->n_group; g++) {
    for (int which = 0; which < 2; which++) {
      const int body = f->body[2 * g + which];
      if (body >= 0) {
        blind(r, g, which, seen[body]);
        note_most(r, g, which);
      }
    }
  }
  free(seen);
}

static void close_rig(rig *r) {
  void *const mem[] = {r->L, r->G, r->T, r->Y, r->scale, r->right, r->x, r->y, r->member, r->most};
  for (int i = 0; i < BASE_COUNT(mem); i++) {
    free(mem[i]);
  }
  known_lcp_free(&r->k);
}

/* Random T and Y of every group, kept. */
static void fill(rig *r, lin_body_space *s, bool symmetric, uint64_t seed) {
  base_rng rng = base_rng_seeded(seed);
  for (int g = 0; g < r->f->n_group; g++) {
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    double *T = s->T + s->at[g], *Y = s->Y + s->at[g];
    for (int i = 0; i < n; i++) {
      T[i + i * n] = 0.1 + base_rng_uniform(&rng);
      Y[i + i * n] = symmetric ? 1 : 0.5 + base_rng_uniform(&rng);
      for (int j = 0; j < i && !symmetric; j++) {
        T[i + j * n] = 0.02 * base_rng_normal(&rng);
        Y[j + i * n] = 0.02 * base_rng_normal(&rng);
      }
    }
    memcpy(r->T + s->at[g], T, (size_t)(n * n) * sizeof *T);
    memcpy(r->Y + s->at[g], Y, (size_t)(n * n) * sizeof *Y);
  }
}

/* y = s G G' s x over the rows in the system. */
static void product(rig *r, const double *scale, const double *x, double *y) {
  const lcp_factored *f = r->f;
  double *v = room((size_t)f->dof_start[f->n_body], sizeof *v);
  for (int pass = 0; pass < 2; pass++) {
    for (int g = 0; g < f->n_group; g++) {
      for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
        const double unit = (scale != NULL) ? scale[i] : 1;
        y[i] = (pass == 0) ? 0 : y[i];
        for (int which = 0; which < 2 && r->member[i]; which++) {
          const lin_side a = lin_side_of(f, r->G, g, which);
          const double *G = a.jac + (ptrdiff_t)(i - f->row_start[g]) * a.dof;
          for (int c = 0; c < a.dof; c++) {
            double *own = &v[f->dof_start[a.body] + c];
            *own += (pass == 0) ? unit * G[c] * x[i] : 0;
            y[i] += (pass == 1) ? unit * G[c] * *own : 0;
          }
        }
      }
    }
  }
  free(v);
}

/* The largest entry of T x + Y s G G' s x - right over the rows in the system. */
static double left_over(rig *r, lin_body_space *s, const double *scale) {
  double most = 0;
  product(r, scale, r->x, r->y);
  for (int g = 0; g < r->f->n_group; g++) {
    const int *row;
    const int n = lin_body_space_rows(s, g, &row);
    for (int i = 0; i < n; i++) {
      double sum = -r->right[row[i]];
      for (int j = 0; j < n; j++) {
        const size_t at = s->at[g] + (size_t)(i + j * n);
        sum += r->T[at] * r->x[row[j]] + r->Y[at] * r->y[row[j]];
      }
      most = fmax(most, fabs(sum));
    }
  }
  return most;
}

/* The system has the velocities that its rows see where those are half of a body's at most, and one where they see none; its
 * solution is that of all. */
static void what_no_row_sees_is_left_out(void **state) {
  (void)state;
  int fewer = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    rig r;
    base_error err = {0};
    lin_body_space s = {0};
    open_rig(&r, seed);
    const lcp_factored *f = r.f;
    for (int kind = 0; kind < 4; kind++) {
      const bool symmetric = kind % 2 == 0;
      const double *scale = (kind / 2 == 0) ? NULL : r.scale;
      bool regular;
      check_ok(lin_body_space_begin(&s, f, r.G, false, scale, r.member, &err), &err);
      for (int b = 0; b < f->n_body; b++) {
        const int dof = f->dof_start[b + 1] - f->dof_start[b], most = r.most[b];
        const int kept = (2 * most > dof) ? dof : (most > 0) ? most : 1;
        assert_int_equal(s.seen[b + 1] - s.seen[b], kept);
        fewer += kept < dof;
      }
      fill(&r, &s, symmetric, seed);
      check_ok(lin_body_space_factor(&s, symmetric, &regular, &err), &err);
      assert_true(regular);
      lin_body_space_solve(&s, r.right, r.x);
      assert_true(left_over(&r, &s, scale) <= 1e-10);
    }
    lin_body_space_close(&s);
    close_rig(&r);
  }
  assert_true(fewer > SEEDS);
}

/* Rows less rank, where all rows of a body see one velocity alone: of each body one row is not too many. */
static void rank_is_that_of_what_is_seen(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    rig r;
    base_error err = {0};
    lin_body_space s = {0};
    bool regular;
    int deficit, rows = 0, met = 0;
    open_rig(&r, seed);
    const lcp_factored *f = r.f;
    for (int g = 0; g < f->n_group; g++) { /* one side alone, and of it one velocity */
      blind(&r, g, 0, 1);
      if (f->body[2 * g] >= 0 && f->body[2 * g + 1] >= 0) {
        blind(&r, g, 1, 0);
      } else {
        blind(&r, g, 1, 1);
      }
    }
    memset(r.most, 0, (size_t)f->n_body * sizeof *r.most);
    for (int g = 0; g < f->n_group; g++) {
      note_most(&r, g, 0);
      note_most(&r, g, 1);
    }
    for (int b = 0; b < f->n_body; b++) {
      met += r.most[b] > 0;
    }
    check_ok(lin_body_space_begin(&s, f, r.G, false, NULL, r.member, &err), &err);
    for (int g = 0; g < f->n_group; g++) {
      const int *row;
      const int n = lin_body_space_rows(&s, g, &row);
      for (int i = 0; i < n; i++) {
        s.T[s.at[g] + (size_t)(i + i * n)] = 1e-9;
        s.Y[s.at[g] + (size_t)(i + i * n)] = 1;
      }
      rows += n;
    }
    check_ok(lin_body_space_factor(&s, true, &regular, &err), &err);
    assert_true(regular);
    check_ok(lin_body_space_deficit(&s, &deficit, &err), &err);
    assert_int_equal(deficit, rows - met);
    lin_body_space_close(&s);
    close_rig(&r);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_no_row_sees_is_left_out),
      cmocka_unit_test(rank_is_that_of_what_is_seen),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
