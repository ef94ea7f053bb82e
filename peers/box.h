/* box.h - a symmetric LCP in boxes as the codes from ODE take it: A x = b + w with lo <= x <= hi, so
 * b = -q, A by rows, and for every row the row whose x scales its bounds, here none. */
#ifndef LCPBENCH_PEERS_BOX_H
#define LCPBENCH_PEERS_BOX_H

#include <algorithm>
#include <lcpbench/lcp_plugin.h>
#include <vector>

struct peer_box {
  std::vector<double> a, b, lo, hi, x, w;
  std::vector<int> alone;

  /* x begins at z; rows of A are `row` numbers apart, of which the first n count. */
  peer_box(const lcp_plugin_problem *p, const double *z, size_t row)
      : a(static_cast<size_t>(p->n) * row), b(p->n), lo(p->lo, p->lo + p->n),
        hi(p->hi, p->hi + p->n), x(z, z + p->n), w(p->n), alone(p->n, -1) {
    const auto n = static_cast<size_t>(p->n);
    for (size_t i = 0; i < n; i++) {
      std::copy_n(p->dense + i * n, n, &a[i * row]); /* M is symmetric */
      b[i] = -p->q[i];
    }
  }

  /* ODE pads rows to multiples of four. */
  static size_t padded(int n) {
    return n > 1 ? ((static_cast<size_t>(n) - 1) | 3) + 1 : 1;
  }
};

#endif
