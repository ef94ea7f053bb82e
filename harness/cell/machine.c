#include "harness/cell/machine.h"

#include "harness/util/args.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"

#include <cblas.h>
#include <linux/mempolicy.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

void machine_proc_value(const char *path, const char *key, char *buf, size_t cap) {
  char line[512];
  buf[0] = '\0';
  FILE *from = fopen(path, "r");
  while (from != NULL && buf[0] == '\0' && fgets(line, sizeof line, from) != NULL) {
    const char *colon = strchr(line, ':');
    if (colon != NULL && strncmp(line, key, strlen(key)) == 0) {
      colon += 1 + strspn(colon + 1, " \t");
      (void)snprintf(buf, cap, "%.*s", (int)strcspn(colon, "\n"), colon);
    }
  }
  if (from != NULL) {
    (void)fclose(from);
  }
}

static void first_line(const char *path, char *buf, size_t cap) {
  buf[0] = '\0';
  FILE *from = fopen(path, "r");
  if (from != NULL) {
    if (fgets(buf, (int)cap, from) == NULL) {
      buf[0] = '\0';
    }
    buf[strcspn(buf, "\n")] = '\0';
    (void)fclose(from);
  }
}

static const char *vectors(void) {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") ? "avx512"
         : __builtin_cpu_supports("avx2")  ? "avx2"
         : __builtin_cpu_supports("avx")   ? "avx"
                                           : "sse2";
#else
  return "generic";
#endif
}

void machine_class(const char *cpu_model, char *buf, size_t cap) {
  enum { LEVELS = 4 };
  char caches[64] = "";
  for (int i = 0; i < LEVELS; i++) {
    char path[80];
    char size[12];
    (void)snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/size", i);
    first_line(path, size, sizeof size);
    const size_t n = strlen(caches);
    (void)snprintf(caches + n, sizeof caches - n, "%s%s", size[0] != '\0' ? " " : "", size);
  }
  (void)snprintf(buf, cap, "%.80s; OpenBLAS %.20s; %s;%s", cpu_model, openblas_get_corename(),
                 vectors(), caches[0] != '\0' ? caches : " caches unknown");
}

void machine_read(machine *m) {
  *m = (machine){0};
  struct utsname u;
  if (uname(&u) == 0) {
    (void)snprintf(m->host, sizeof m->host, "%.63s", u.nodename);
    (void)snprintf(m->kernel, sizeof m->kernel, "%.40s %.50s", u.sysname, u.release);
  }
  machine_proc_value("/proc/cpuinfo", "model name", m->cpu_model, sizeof m->cpu_model);
  machine_class(m->cpu_model, m->host_class, sizeof m->host_class);
  m->n_cpu = (int)sysconf(_SC_NPROCESSORS_ONLN);
  first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", m->governor,
             sizeof m->governor);
}

double machine_load(void) {
  char line[128];
  first_line("/proc/loadavg", line, sizeof line);
  return (line[0] != '\0') ? strtod(line, NULL) : (double)NAN;
}

double machine_busy(void) {
  enum { IDLE = 3, IOWAIT = 4, STEAL = 7 };
  char line[256];
  first_line("/proc/stat", line,
             sizeof line); /* cpu user nice system idle iowait irq softirq steal */
  char *at = line + strcspn(line, " ");
  double ticks = 0.0;
  int n = 0;
  for (; n <= STEAL && *at != '\0'; n++) {
    char *end;
    const double value = strtod(at, &end);
    ticks += (n == IDLE || n == IOWAIT) ? 0.0 : value;
    if (end == at) {
      break;
    }
    at = end;
  }
  return (n > STEAL) ? ticks / (double)sysconf(_SC_CLK_TCK) : (double)NAN;
}

static double cpu_time(int who) {
  struct rusage u;
  (void)getrusage(who, &u);
  return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

double machine_own(void) {
  return cpu_time(RUSAGE_SELF) + cpu_time(RUSAGE_CHILDREN);
}

double machine_frequency_in(const char *folder, int cpu) {
  char path[160];
  char line[64];
  double kilohertz;
  (void)snprintf(path, sizeof path, "%.100s/cpu%d/cpufreq/scaling_cur_freq", folder, cpu);
  first_line(path, line, sizeof line);
  return base_parse_real(line, &kilohertz) ? 1e-3 * kilohertz : (double)NAN;
}

double machine_frequency(int cpu) {
  return machine_frequency_in("/sys/devices/system/cpu", cpu);
}

int machine_last_cpu(void) {
  cpu_set_t set;
  int last = -1;
  if (sched_getaffinity(0, sizeof set, &set) == 0) {
    for (int i = 0; i < CPU_SETSIZE; i++) {
      last = CPU_ISSET((size_t)i, &set) ? i : last;
    }
  }
  return last;
}

void machine_pin(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (cpu >= 0) {
    CPU_SET((size_t)cpu, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
  }
}

bool machine_pin_for_now(int cpu, cpu_set_t *before) {
  const bool known = sched_getaffinity(0, sizeof *before, before) == 0;
  machine_pin(known ? cpu : -1);
  return known;
}

void machine_pin_back(const cpu_set_t *before) {
  (void)sched_setaffinity(0, sizeof *before, before);
}

int machine_bind_memory(void) {
  enum { BITS = 1024, WORD = 8 * sizeof(unsigned long) };
  unsigned long mask[BITS / WORD] = {0};
  unsigned cpu;
  unsigned node;
  if (syscall(SYS_getcpu, &cpu, &node, NULL) != 0 || node >= BITS) {
    return -1;
  }
  mask[node / WORD] = 1ul << node % WORD;
  return (syscall(SYS_set_mempolicy, MPOL_BIND, mask, BITS + 1ul) == 0) ? (int)node : -1;
}

void machine_utc(char *buf, size_t cap) {
  const time_t now = time(NULL);
  struct tm utc;
  if (gmtime_r(&now, &utc) == NULL || strftime(buf, cap, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0) {
    buf[0] = '\0';
  }
}

enum { CANARY_N = 2048, CANARY_PASSES = 2000, CANARY_ROUNDS = 15 };

/* Seconds that one round of the canary's work takes. */
static double canary_round(double x[CANARY_N]) {
  const double from = base_seconds();
  double sum = 0.0;
  for (int k = 0; k < CANARY_PASSES; k++) {
    for (int i = 0; i < CANARY_N; i++) {
      sum += x[i] * 1e-6;
    }
    x[k] += 1e-9 * sum; /* carried on, so that no pass can be left out */
  }
  volatile double kept = sum;
  (void)kept;
  return base_seconds() - from;
}

double machine_canary(void) {
  double x[CANARY_N];
  double seconds[CANARY_ROUNDS]; /* sorted, the first `done` of them */
  for (int i = 0; i < CANARY_N; i++) {
    x[i] = 1.0 + 1e-3 * i;
  }
  for (int done = 0; done < CANARY_ROUNDS; done++) {
    const double took = canary_round(x);
    int at = done;
    for (; at > 0 && seconds[at - 1] > took; at--) {
      seconds[at] = seconds[at - 1];
    }
    seconds[at] = took;
  }
  return seconds[CANARY_ROUNDS / 2];
}

size_t machine_sweep_length(void) {
  char line[64];
  double bytes = 0.0;
  first_line("/sys/devices/system/cpu/cpu0/cache/index3/size", line, sizeof line);
  const bool known = args_bytes(line, &bytes) && bytes > 0.0;
  return (size_t)(2.0 * (known ? bytes : 32.0 * 1048576.0) / sizeof(double));
}

void machine_sweep(double *x, size_t n) {
  double sum = 0.0;
  for (size_t i = 0; i < n; i += 8) { /* one double of each 64-byte line */
    x[i] += 1.0;
    sum += x[i];
  }
  volatile double kept = sum;
  (void)kept;
}

long machine_throttles(int cpu) {
  char path[120];
  char line[64];
  (void)snprintf(path, sizeof path,
                 "/sys/devices/system/cpu/cpu%d/thermal_throttle/core_throttle_count", cpu);
  first_line(path, line, sizeof line);
  return (line[0] != '\0') ? strtol(line, NULL, 10) : -1;
}
