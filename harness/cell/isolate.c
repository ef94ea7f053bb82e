#include "harness/cell/isolate.h"

#include "harness/util/stop.h"
#include "lcp/base/clock.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* ---- child ------------------------------------------------------------------------------------*/

struct isolate_channel {
  int fd;
  size_t item_size;
};

enum { TAG_ITEM = 1, TAG_END = 2 };

static bool write_all(int fd, const void *data, size_t n) {
  const unsigned char *at = data;
  while (n > 0) {
    const ssize_t wrote = write(fd, at, n);
    if (wrote < 0 && errno == EINTR) {
      continue;
    }
    if (wrote <= 0) {
      return false;
    }
    at += wrote;
    n -= (size_t)wrote;
  }
  return true;
}

bool isolate_emit(isolate_channel *c, const void *item) {
  const unsigned char tag = TAG_ITEM;
  return write_all(c->fd, &tag, 1) && write_all(c->fd, item, c->item_size);
}

static void limit_child(const isolate_limits *l) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL); /* nobody measures on after the parent was killed */
  const struct rlimit none = {0, 0};
  (void)setrlimit(RLIMIT_CORE, &none);
#ifndef __SANITIZE_ADDRESS__                 /* whose shadow memory is far larger than any limit */
  if (l->memory > 0 && l->memory < 0x1p62) { /* beyond that: no limit */
    const struct rlimit space = {(rlim_t)l->memory, (rlim_t)l->memory};
    (void)setrlimit(RLIMIT_AS, &space);
  }
#endif
  if (l->cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)l->cpu, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
  }
}

static _Noreturn void child(const isolate_work *w, const isolate_limits *l, int item_fd,
                            int log_fd) {
  (void)setpgid(0, 0);
  (void)signal(SIGINT, SIG_DFL);
  (void)signal(SIGTERM, SIG_DFL);
  (void)dup2(log_fd, STDOUT_FILENO);
  (void)dup2(log_fd, STDERR_FILENO);
  const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
  (void)dup2(null, STDIN_FILENO);
  limit_child(l);
  isolate_channel c = {item_fd, w->item_size};
  w->body(w->ctx, &c);
  const unsigned char tag = TAG_END;
  (void)write_all(item_fd, &tag, 1);
  _exit(0);
}

/* ---- parent -----------------------------------------------------------------------------------*/

typedef struct watch {
  const isolate_work *work;
  const isolate_limits *limits;
  isolate_end *out;
  pid_t pid;
  int item_fd, log_fd; /* -1 once closed */
  unsigned char *item; /* 1 + item_size */
  size_t filled;
  double log_bytes;
  bool ended; /* the end tag arrived */
  bool term_sent;
  double deadline;    /* of the next signal [s] */
  isolate_how reason; /* why it is being killed */
} watch;

static void take_items(watch *w) {
  const size_t whole = 1 + w->work->item_size;
  for (;;) {
    const ssize_t got = read(w->item_fd, w->item + w->filled, whole - w->filled);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) {
      return;
    }
    if (got <= 0) {
      (void)close(w->item_fd);
      w->item_fd = -1;
      return;
    }
    w->filled += (size_t)got;
    if (w->item[0] == TAG_END) {
      w->ended = true;
      w->filled = 0;
    } else if (w->filled == whole) {
      memmove(w->item, w->item + 1, w->work->item_size); /* behind its tag it is not aligned */
      w->work->item(w->work->ctx, w->item);
      w->filled = 0;
    }
  }
}

static void begin_kill(watch *w, isolate_how reason) {
  w->reason = reason;
  w->term_sent = true;
  w->deadline = base_seconds() + w->limits->grace;
  (void)kill(-w->pid, SIGTERM);
  (void)kill(w->pid, SIGTERM);
}

static void take_log(watch *w) {
  char chunk[16384];
  const ssize_t got = read(w->log_fd, chunk, sizeof chunk);
  if (got < 0 && (errno == EINTR || errno == EAGAIN)) {
    return;
  }
  if (got <= 0) {
    (void)close(w->log_fd);
    w->log_fd = -1;
    return;
  }
  const size_t have = (w->log_bytes < ISOLATE_LOG - 1) ? (size_t)w->log_bytes : ISOLATE_LOG - 1;
  const size_t room = ISOLATE_LOG - 1 - have;
  memcpy(w->out->log + have, chunk, ((size_t)got < room) ? (size_t)got : room);
  w->log_bytes += (double)got;
  if (w->log_bytes > w->limits->output && !w->term_sent) {
    begin_kill(w, ISOLATE_FLOOD);
  }
}

/* Signals that are due now. */
static void keep_time(watch *w) {
  if (stop_requested() != 0 && !w->term_sent) {
    begin_kill(w, ISOLATE_INTERRUPTED);
  }
  if (base_seconds() < w->deadline) {
    return;
  }
  if (!w->term_sent) {
    begin_kill(w, ISOLATE_TIMEOUT);
  } else {
    (void)kill(-w->pid, SIGKILL);
    (void)kill(w->pid, SIGKILL);
    w->deadline = HUGE_VAL;
  }
}

/* Until the child has gone; items of a child that forked on are not waited for. */
static int attend(watch *w, struct rusage *usage) {
  int status = 0;
  bool gone = false;
  while (!gone) {
    struct pollfd fds[2] = {{w->item_fd, POLLIN, 0}, {w->log_fd, POLLIN, 0}};
    const bool open_fds = w->item_fd >= 0 || w->log_fd >= 0;
    const double left = w->deadline - base_seconds();
    const double wait = open_fds ? fmax(0.0, fmin(left + 1e-3, 0.2)) : 5e-5; /* it is about to go */
    const struct timespec timeout = {.tv_nsec = lrint(wait * 1e9)};
    if (ppoll(fds, 2, &timeout, NULL) > 0) {
      if (fds[0].revents != 0) {
        take_items(w);
      }
      if (fds[1].revents != 0) {
        take_log(w);
      }
    }
    keep_time(w);
    if (!open_fds || w->ended || w->term_sent || w->item_fd < 0) {
      gone = wait4(w->pid, &status, WNOHANG, usage) == w->pid;
    }
  }
  if (w->item_fd >= 0) {
    take_items(w);
  }
  if (w->log_fd >= 0 && !w->term_sent) {
    take_log(w); /* its last words */
  }
  return status;
}

static void conclude(watch *w, int status, const struct rusage *u) {
  isolate_end *out = w->out;
  out->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  out->exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  out->cpu = (double)u->ru_utime.tv_sec + 1e-6 * (double)u->ru_utime.tv_usec +
             (double)u->ru_stime.tv_sec + 1e-6 * (double)u->ru_stime.tv_usec;
  out->rss_peak = 1024.0 * (double)u->ru_maxrss;
  out->ctx_invol = u->ru_nivcsw;
  out->major_faults = u->ru_majflt;
  if (w->term_sent && !(w->ended && w->reason == ISOLATE_TIMEOUT)) {
    out->how = w->reason;
  } else if (out->signal == SIGKILL) {
    out->how = ISOLATE_OOM;
  } else if (out->signal != 0) {
    out->how = ISOLATE_SIGNAL;
  } else {
    out->how = w->ended ? ISOLATE_DONE : ISOLATE_EXIT;
  }
}

static void close_pair(const int fd[2]) {
  (void)close(fd[0]);
  (void)close(fd[1]);
}

static base_status watch_child(watch *w, const int items[2], const int log[2], base_error *err) {
  const double from = base_seconds();
  w->pid = fork();
  if (w->pid < 0) {
    close_pair(items);
    close_pair(log);
    return BASE_FAIL(err, BASE_EEXTERNAL, "fork: %s", strerror(errno));
  }
  if (w->pid == 0) {
    child(w->work, w->limits, items[1], log[1]);
  }
  (void)setpgid(w->pid, w->pid);
  (void)close(items[1]);
  (void)close(log[1]);
  (void)fcntl(items[0], F_SETFL, O_NONBLOCK);
  (void)fcntl(log[0], F_SETFL, O_NONBLOCK);
  w->item_fd = items[0];
  w->log_fd = log[0];
  w->deadline = from + w->limits->wall;
  struct rusage usage = {0};
  const int status = attend(w, &usage);
  w->out->wall = base_seconds() - from;
  (void)kill(-w->pid, SIGKILL); /* whatever the child left running */
  if (w->item_fd >= 0) {
    (void)close(w->item_fd);
  }
  if (w->log_fd >= 0) {
    (void)close(w->log_fd);
  }
  conclude(w, status, &usage);
  return BASE_OK;
}

base_status isolate_run(const isolate_work *work, const isolate_limits *limits, isolate_end *out,
                        base_error *err) {
  *out = (isolate_end){0};
  int items[2];
  int log[2];
  if (pipe2(items, O_CLOEXEC) != 0) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "pipe: %s", strerror(errno));
  }
  if (pipe2(log, O_CLOEXEC) != 0) {
    close_pair(items);
    return BASE_FAIL(err, BASE_EEXTERNAL, "pipe: %s", strerror(errno));
  }
  watch w = {.work = work, .limits = limits, .out = out, .item = malloc(1 + work->item_size)};
  if (w.item == NULL) {
    close_pair(items);
    close_pair(log);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for items of a child process");
  }
  const base_status done = watch_child(&w, items, log, err);
  free(w.item);
  return done;
}
