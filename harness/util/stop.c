#include "harness/util/stop.h"

#include "lcp/base/clock.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t stop_signal;

static void on_signal(int number) {
  stop_signal = number;
}

static void raise_flag(int flags) {
  struct sigaction act = {.sa_handler = on_signal, .sa_flags = flags};
  (void)sigemptyset(&act.sa_mask);
  (void)sigaction(SIGINT, &act, NULL);
  (void)sigaction(SIGTERM, &act, NULL);
}

void stop_catch_signals(void) {
  raise_flag(0); /* no SA_RESTART: poll must return */
}

void stop_catch_first_signal(void) {
  raise_flag((int)SA_RESETHAND);
}

int stop_requested(void) {
  return stop_signal;
}

bool stop_due(double until) {
  return stop_signal != 0 || (until > 0.0 && base_seconds() >= until);
}
