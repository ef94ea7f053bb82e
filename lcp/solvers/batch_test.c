#include "lcp/solvers/batch_test.h"

#include "lcp/lcp_column.h"
#include "lcp/solvers/contact_batches.h"
#include "lcp/solvers/data_test.h"

static const double drift = 1e-11; /* of the body velocities, over the sizes of the terms of w */

/* w of the rows of group g, and in *size the largest sum of sizes of its terms, scaled. */
static void group_velocity(const lcp_loop *loop, const lcp_problem *p, const double *body, int g,
                           const double *z, double *w, double *size) {
  const lcp_factored *f = p->M.factored;
  const int first = f->row_start[g], rows = f->row_start[g + 1] - first;
  double room[LCP_MIXED_MAX];
  const double *side[2];
  lcp_contact_rows(f, g, rows, room, side);
  *size = 0.0;
  for (int i = 0; i < rows; i++) {
    double sum = p->q[first + i], terms = fabs(sum);
    for (int s = 0; s < 2; s++) {
      const double *v = (side[s] != NULL) ? body + 16 * (ptrdiff_t)f->body[2 * g + s] : NULL;
      for (int k = 0; v != NULL && k < 6; k++) {
        const double term = side[s][6 * i + k] * v[(k < 3) ? k : k + 1];
        sum += term;
        terms += fabs(term);
      }
    }
    w[first + i] = sum;
    *size = fmax(*size, loop->scale[first + i] * terms);
  }
  for (int j = first; j < first + rows && f->shift != NULL; j++) {
    lcp_column_add(lcp_column_of(&p->M, j), z[j], w);
  }
}

/* Group g, whose first block is *block: above the limit? Moves *block behind it. */
static bool misses(const lcp_batch_test *t, const lcp_problem *p, int g, int *block,
                   const double *z) {
  const int end = p->M.factored->row_start[g + 1];
  const lcp_loop *loop = t->loop;
  double size, worst = 0.0;
  group_velocity(loop, p, t->body, g, z, loop->stop.w, &size);
  for (; *block < p->n_block && p->block[*block].start < end; (*block)++) {
    worst = fmax(worst, lcp_data_miss(p, &p->block[*block], loop->scale, z, loop->stop.w));
  }
  return worst > lcp_data_limit(t->stop->tol, loop->q_size) + drift * size;
}

bool lcp_batch_test_fails(lcp_batch_test *t, const lcp_problem *p, const double *z) {
  const int n = p->M.factored->n_group;
  for (int k = 0, g = t->group, b = t->block; k < n; k++, g++) {
    if (g == n) {
      g = b = 0;
    }
    const int first = b;
    if (misses(t, p, g, &b, z)) {
      t->group = g;
      t->block = first;
      return true;
    }
  }
  return false;
}

bool lcp_batch_run(lcp_batch_test *t, const lcp_problem *p, double *z, lcp_result *res) {
  bool ended = false, again = true;
  while (again && !ended) {
    const long count = lcp_loop_until_test(t->loop, t->stop, res);
    t->sweeps(t->state, p, count, z);
    res->work.iterations += count;
    res->work.sweeps += count;
    again = !t->every && t->loop->budget == 0 && res->work.iterations < t->stop->max_iter &&
            lcp_batch_test_fails(t, p, z);
    ended = again && lcp_loop_put_off(t->loop, t->stop, p, z, res);
  }
  return ended;
}
