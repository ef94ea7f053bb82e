#include "harness/util/progress.h"

#include "lcp/base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void progress_begin(progress *p, int total, int skipped, bool quiet) {
  const char *no_colour = getenv("NO_COLOR");
  *p = (progress){.total = total, .skipped = skipped, .quiet = quiet};
  p->terminal = isatty(STDERR_FILENO) == 1;
  p->colour = p->terminal && (no_colour == NULL || no_colour[0] == '\0');
  p->started = base_seconds();
  p->done = skipped;
}

static void print_left(double seconds, char *buf, size_t cap) {
  const long s = (long)(seconds + 0.5);
  if (s >= 3600) {
    (void)snprintf(buf, cap, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  } else {
    (void)snprintf(buf, cap, "%02ld:%02ld", s / 60, s % 60);
  }
}

void progress_step(progress *p, const char *what, const char *status, double seconds) {
  p->done++;
  const double now = base_seconds();
  const int measured = p->done - p->skipped;
  const bool last = p->done == p->total;
  if (p->quiet || (!p->terminal && !last && now - p->last < 2.0)) {
    return;
  }
  p->last = now;
  char left[32];
  char line[200];
  print_left((now - p->started) / measured * (p->total - p->done), left, sizeof left);
  (void)snprintf(line, sizeof line, "[%d/%d] %.1f %% ETA %s %.90s", p->done, p->total,
                 100.0 * p->done / p->total, left, what);
  const bool good = strcmp(status, "ok") == 0;
  const char *paint = !p->colour ? "" : good ? "\033[32m" : "\033[33m";
  (void)fprintf(stderr, "%s%s %s%s%s %.3g s%s", p->terminal ? "\r\033[K" : "", line, paint, status,
                p->colour ? "\033[0m" : "", seconds, p->terminal ? "" : "\n");
  (void)fflush(stderr);
}

void progress_end(progress *p) {
  if (p->terminal && !p->quiet && p->done > p->skipped) {
    (void)fputc('\n', stderr);
  }
}
