#include "harness/control/patience.h"

patience patience_untried(void) {
  return (patience){.most = 1};
}

void patience_lose(patience *p) {
  p->most = (p->most < 16) ? 2 * p->most : p->most;
  p->left = p->most;
}

bool patience_again(patience *p) {
  return p->left-- <= 0;
}
