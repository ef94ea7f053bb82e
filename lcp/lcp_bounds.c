#include "lcp/lcp_bounds.h"

lcp_set lcp_bounds_set(double lo, double hi) {
  const bool above = hi == HUGE_VAL;
  return (lo == 0.0 && above) ? LCP_ORTHANT : (lo == -HUGE_VAL && above) ? LCP_FREE : LCP_BOX;
}

int lcp_bounds_blocks(int n, const double *lo, const double *hi, lcp_block *block) {
  int count = 0;
  for (int i = 0; i < n; i++) {
    const lcp_set set = lcp_bounds_set(lo != NULL ? lo[i] : 0.0, hi != NULL ? hi[i] : HUGE_VAL);
    if (count > 0 && block[count - 1].set == set) {
      block[count - 1].size++;
    } else {
      block[count++] = (lcp_block){.start = i, .size = 1, .set = set};
    }
  }
  return count;
}
