/* harness/cell/isolate.h - runs a piece of work in a child process with limits, so that a crash, a hang
 * or a flood ends that piece and nothing else.
 *
 * The child hands back fixed-size items over a pipe, each whole; its stdout and stderr are captured
 * and bounded. At the wall limit it gets SIGTERM, after the grace time SIGKILL. Core dumps are off. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

enum { ISOLATE_LOG = 4096 };

typedef struct isolate_limits {
  double wall;   /* [s] */
  double grace;  /* SIGTERM to SIGKILL [s] */
  double memory; /* address space [B]; 0: unlimited */
  double output; /* captured stdout + stderr [B] */
  int cpu;       /* pin to this logical CPU; -1: no pinning */
} isolate_limits;

typedef enum isolate_how {
  ISOLATE_DONE,        /* the body returned */
  ISOLATE_SIGNAL,      /* died by a signal of its own */
  ISOLATE_TIMEOUT,     /* killed at the wall limit */
  ISOLATE_FLOOD,       /* killed for too much output */
  ISOLATE_OOM,         /* killed by the kernel for memory */
  ISOLATE_EXIT,        /* called exit: no end of the work was announced */
  ISOLATE_INTERRUPTED, /* this process was asked to stop (stop_requested) */
} isolate_how;

typedef struct isolate_end {
  isolate_how how;
  int signal;       /* of the child's death, 0 if it exited */
  int exit_code;    /* if it exited */
  double wall, cpu; /* [s] */
  double rss_peak;  /* [B] */
  long ctx_invol, major_faults;
  char log[ISOLATE_LOG]; /* first bytes of the captured output, NUL-terminated */
} isolate_end;

/* Where the child's body puts its items; false when the parent is gone. */
typedef struct isolate_channel isolate_channel;
bool isolate_emit(isolate_channel *c, const void *item);

typedef struct isolate_work {
  size_t item_size;
  void (*body)(void *ctx, isolate_channel *c); /* in the child */
  void (*item)(void *ctx, const void *item);   /* in the parent, for every item; aligned */
  void *ctx;
} isolate_work;

base_status isolate_run(const isolate_work *w, const isolate_limits *limits, isolate_end *out,
                        base_error *err);
