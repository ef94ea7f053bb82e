/* harness/cell/machine.h - the machine a row was measured on. */
#pragma once

#include "lcp/base/status.h"

#include <sched.h>
#include <stdbool.h>

typedef struct machine {
  char host[64];
  char cpu_model[96];
  char host_class[160]; /* machine_class: times and bits are compared within one class only */
  int n_cpu;
  char kernel[96], governor[32];
} machine;

void machine_read(machine *m);

/* Processor model, kernel that the BLAS chose for it, widest vector instructions and cache sizes:
 * one model in two virtual machines may differ in any of the others, and then in times and bits. */
void machine_class(const char *cpu_model, char *buf, size_t cap);

double machine_load(void);  /* 1 minute load average; NaN if unknown */
double machine_busy(void);  /* since boot, over all CPUs, stolen time too; NaN if unknown [s] */
double machine_own(void);   /* CPU time of this process and of its ended children [s] */
int machine_last_cpu(void); /* the highest CPU this process may use */
void machine_pin(int cpu);  /* this process, if the system permits; cpu < 0: nothing */
void machine_utc(char *buf, size_t cap); /* 2024-01-31T12:00:00Z */

/* Frequency of a logical CPU now, as cpufreq measures it; NaN where the system has no such file
 * [MHz]. The number in /proc/cpuinfo is not taken for it: on many machines it is a constant. */
double machine_frequency(int cpu);
double machine_frequency_in(const char *folder, int cpu); /* the same below another folder */

/* Pins this process until machine_pin_back; false: its affinity is not known and was left alone. */
bool machine_pin_for_now(int cpu, cpu_set_t *before);
void machine_pin_back(const cpu_set_t *before);

/* Memory of this process comes from the node of the CPU it runs on (MPOL_BIND) from now on: that
 * node, or -1 where the system does not permit or know it. */
int machine_bind_memory(void);

/* Fixed work of about 3 ms (multiply-add over an array in cache), the median of 15 rounds: the canary
 * of a campaign. One interruption moves a round, not the median. A drift of more than 3 % between two
 * canaries marks what was measured between them. [s] */
double machine_canary(void);

/* Doubles to stream so that twice the last-level cache has passed (32 MB where its size is unknown),
 * and the streaming: every line is read and written, so that nothing useful is left in any cache. */
size_t machine_sweep_length(void);
void machine_sweep(double *x, size_t n);

/* How often the CPU was slowed down for its temperature; -1: the system does not tell. */
long machine_throttles(int cpu);

/* Copies the value of "key : value" from a /proc style file, "" if absent. */
void machine_proc_value(const char *path, const char *key, char *buf, size_t cap);
