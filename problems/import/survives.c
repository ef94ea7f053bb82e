#include "problems/import/survives.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__has_feature) /* clang */
#if __has_feature(address_sanitizer)
#define SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define SANITIZED
#endif

static const rlim_t CPU_SECONDS = 60;

/* The child: quiet, limited, and dead at once where the library fails. */
static void run_child(void (*body)(void *ctx), void *ctx) {
  static const int deadly[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL};
  const struct rlimit cpu = {CPU_SECONDS, CPU_SECONDS}, core = {0, 0};
  for (int i = 0; i < BASE_COUNT(deadly); i++) {
    (void)signal(deadly[i], SIG_DFL); /* no handler of the caller's reports it as its own crash */
  }
  (void)setrlimit(RLIMIT_CPU, &cpu);
  (void)setrlimit(RLIMIT_CORE, &core);
  (void)close(STDOUT_FILENO);
  (void)close(STDERR_FILENO);
  body(ctx);
  _exit(0);
}

base_status survives(void (*body)(void *ctx), void *ctx, bool *survived, base_error *err) {
  const pid_t child = fork();
  if (child < 0) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "no process to try a file in: %s", strerror(errno));
  }
  if (child == 0) {
    run_child(body, ctx);
  }
  int status = 0;
  pid_t done;
  do {
    done = waitpid(child, &status, 0);
  } while (done < 0 && errno == EINTR);
  if (done != child) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "a child process was lost: %s", strerror(errno));
  }
  *survived = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return BASE_OK;
}

/* Address space of the process [B]; 0 where it is not known, or means nothing (a sanitizer reserves
 * terabytes). */
static size_t address_space(void) {
  unsigned long pages = 0;
#ifndef SANITIZED
  char text[128] = "";
  FILE *f = fopen("/proc/self/statm", "r");
  if (f != NULL) {
    pages = (fgets(text, sizeof text, f) != NULL) ? strtoul(text, NULL, 10) : 0;
    (void)fclose(f);
  }
#endif
  return pages * (size_t)sysconf(_SC_PAGESIZE);
}

void survives_within(size_t bytes, void (*body)(void *ctx), void *ctx) {
  const size_t now = address_space();
  struct rlimit old = {0, 0};
  const bool limited = now > 0 && getrlimit(RLIMIT_AS, &old) == 0 &&
                       (old.rlim_cur == RLIM_INFINITY || old.rlim_cur > now + bytes);
  if (limited) {
    const struct rlimit new = {now + bytes, old.rlim_max};
    (void)setrlimit(RLIMIT_AS, &new);
  }
  body(ctx);
  if (limited) {
    (void)setrlimit(RLIMIT_AS, &old);
  }
}
