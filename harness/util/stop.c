#include "harness/util/stop.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t stop_signal;

static void on_signal(int number) {
  stop_signal = number;
}

void stop_catch_signals(void) {
  struct sigaction act = {.sa_handler = on_signal}; /* no SA_RESTART: poll must return */
  (void)sigemptyset(&act.sa_mask);
  (void)sigaction(SIGINT, &act, NULL);
  (void)sigaction(SIGTERM, &act, NULL);
}

int stop_requested(void) {
  return stop_signal;
}
