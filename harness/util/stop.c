#include "harness/util/stop.h"

#include "lcp/base/clock.h"

#include <signal.h>
#include <stddef.h>

static const double at_once = 0.25; /* [s] */

static volatile sig_atomic_t stop_signal;
static double first_s; /* when it came; for the handler alone */

static void on_signal(int number) {
  stop_signal = number;
}

static void on_first_signal(int number) {
  if (stop_signal == 0) {
    first_s = base_seconds();
    stop_signal = number;
  } else if (base_seconds() - first_s > at_once) {
    (void)signal(number, SIG_DFL);
    (void)raise(number); /* comes when this handler returns */
  }
}

static void listen_with(void (*handler)(int)) {
  struct sigaction act = {.sa_handler = handler}; /* no SA_RESTART: poll must return */
  (void)sigemptyset(&act.sa_mask);
  (void)sigaddset(&act.sa_mask, SIGINT);
  (void)sigaddset(&act.sa_mask, SIGTERM);
  (void)sigaction(SIGINT, &act, NULL);
  (void)sigaction(SIGTERM, &act, NULL);
}

void stop_catch_signals(void) {
  listen_with(on_signal);
}

void stop_catch_first_signal(void) {
  listen_with(on_first_signal);
}

int stop_requested(void) {
  return stop_signal;
}

bool stop_due(double until) {
  return stop_signal != 0 || (until > 0.0 && base_seconds() >= until);
}
