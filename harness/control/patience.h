/* harness/control/patience.h - what did not come off is tried again after 2, 4, 8, 16 occasions. */
#pragma once

#include <stdbool.h>

typedef struct patience {
  long most, left; /* occasions to let pass, next time and yet */
} patience;

/* Nothing has failed yet. */
patience patience_untried(void);
/* It did not come off. */
void patience_lose(patience *p);
/* Is it time? Asked once an occasion. */
bool patience_again(patience *p);
