#include "harness/measure/machine.h"

#include "harness/util/args.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"

#include <linux/mempolicy.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

void machine_read(machine *m) {
  *m = (machine){0};
  struct utsname u;
  if (uname(&u) == 0) {
    (void)snprintf(m->host, sizeof m->host, "%.63s", u.nodename);
    (void)snprintf(m->kernel, sizeof m->kernel, "%.40s %.50s", u.sysname, u.release);
  }
  machine_proc_value("/proc/cpuinfo", "model name", m->cpu_model, sizeof m->cpu_model);
  m->n_cpu = (int)sysconf(_SC_NPROCESSORS_ONLN);
  first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", m->governor,
             sizeof m->governor);
}

double machine_load(void) {
  char line[128];
  first_line("/proc/loadavg", line, sizeof line);
  return (line[0] != '\0') ? strtod(line, NULL) : (double)NAN;
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

double machine_canary(void) {
  enum { N = 2048, ROUNDS = 2000 };
  double x[N];
  for (int i = 0; i < N; i++) {
    x[i] = 1.0 + 1e-3 * i;
  }
  const double from = base_seconds();
  double sum = 0.0;
  for (int k = 0; k < ROUNDS; k++) {
    for (int i = 0; i < N; i++) {
      sum += x[i] * 1e-6;
    }
    x[k] += 1e-9 * sum; /* carried on, so that no round can be left out */
  }
  volatile double kept = sum;
  (void)kept;
  return base_seconds() - from;
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
