#include "lcp/solvers/batch_waves.h"

#include "lcp/base/crew.h"

#include <sched.h>
#include <stdatomic.h>

enum { LOOKS = 200, SHARE = 16 }; /* before a thread yields; stretches of a part */

/* Stretches that a sweep has left, counted through all sweeps; one a cache line. */
typedef struct mark {
  _Alignas(64) atomic_long left;
} mark;

typedef struct waves {
  const lcp_batches *in;
  lcp_wave sweep;
  void *context;
  int under_way; /* sweeps k and k + under_way are never under way at one time */
  mark mark[BASE_THREADS_MAX + 1];
} waves;

static int stretches(const lcp_batches *s) {
  return (s->n_batch + LCP_STRETCH - 1) / LCP_STRETCH;
}

/* Batches from `first` on to the end of `count` stretches. */
static int batches_of(const lcp_batches *s, int first, int count) {
  const int most = count * LCP_STRETCH;
  return (s->n_batch - first < most) ? s->n_batch - first : most;
}

static long wait_for(const mark *m, long least) {
  long left = atomic_load_explicit(&m->left, memory_order_acquire);
  for (int looks = 0; left < least; looks++) {
    if (looks >= LOOKS) {
      (void)sched_yield();
    }
    left = atomic_load_explicit(&m->left, memory_order_acquire);
  }
  return left;
}

static void follow(void *of, int k, int hand) {
  waves *w = of;
  const lcp_batches *s = w->in;
  const long n = stretches(s), begun = k * n;
  mark *own = &w->mark[k % w->under_way];
  const mark *before = &w->mark[(k + w->under_way - 1) % w->under_way];
  long left = (k > 0) ? 0 : begun + n;
  (void)hand;
  for (int c = 0; c < n; c++) {
    const long least = begun - n + s->until[c] + 1;
    if (left < least) {
      left = wait_for(before, least);
    }
    w->sweep(w->context, c * LCP_STRETCH, batches_of(s, c * LCP_STRETCH, 1));
    atomic_store_explicit(&own->left, begun + c + 1, memory_order_release);
  }
}

void lcp_batch_waves(const lcp_batches *s, long sweeps, lcp_wave sweep, void *context) {
  if (!s->shared || base_crew_size() == 1) {
    for (long k = 0; k < sweeps; k++) {
      sweep(context, 0, s->n_batch);
    }
    return;
  }
  waves w = {.in = s, .sweep = sweep, .context = context, .under_way = base_crew_size() + 1};
  base_share((int)sweeps, follow, &w);
}

typedef struct shares {
  const lcp_batches *in;
  lcp_wave work;
  void *context;
} shares;

static void take_share(void *of, int k, int hand) {
  const shares *w = of;
  const int first = k * SHARE * LCP_STRETCH;
  (void)hand;
  w->work(w->context, first, batches_of(w->in, first, SHARE));
}

void lcp_batch_shares(const lcp_batches *s, lcp_wave work, void *context) {
  shares w = {s, work, context};
  base_share(base_parts(stretches(s), SHARE), take_share, &w);
}
