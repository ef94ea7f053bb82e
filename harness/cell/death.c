#include "harness/cell/death.h"

#include <stdio.h>
#include <string.h>

run_status death_word(const isolate_end *end, double wall, char *note, size_t cap) {
  switch (end->how) {
  case ISOLATE_TIMEOUT:
    (void)snprintf(note, cap, "killed after %g s", wall);
    return RUN_TIMEOUT;
  case ISOLATE_FLOOD:
    (void)snprintf(note, cap, "killed for flooding its output");
    return RUN_FLOOD;
  case ISOLATE_OOM:
    (void)snprintf(note, cap, "killed by SIGKILL: by the kernel for memory, if not from outside");
    return RUN_OOM;
  case ISOLATE_SIGNAL:
    (void)snprintf(note, cap, "signal %d %s: %.180s", end->signal, strsignal(end->signal),
                   end->log);
    return RUN_CRASH;
  case ISOLATE_EXIT:
  case ISOLATE_DONE:
  case ISOLATE_INTERRUPTED:
    break;
  }
  (void)snprintf(note, cap, "exit(%d) without a result: %.180s", end->exit_code, end->log);
  return RUN_NO_OUTPUT;
}
