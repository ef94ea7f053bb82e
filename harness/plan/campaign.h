/* harness/plan/campaign.h - a campaign as written in its YAML file. docs/CAMPAIGNS.md has the keys with their
 * defaults and an example. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct text_list {
  int n, cap;
  char **item; /* owned */
} text_list;

base_status text_list_add(text_list *l, const char *text, base_error *err);
void text_list_free(text_list *l);

typedef struct campaign_limits {
  double time, grace; /* [s] */
  double memory;      /* [B]; 0: none */
} campaign_limits;

typedef struct campaign_sampling {
  int processes, samples, max_samples;
  double half_width; /* of the 95 % interval of the median, relative; stop when reached [1] */
  double budget;     /* [s] of measuring in one process */
  double inner;      /* [s] shortest bracket; shorter solves are looped */
  double doctor;     /* [s] noise floor measured before the first row; 0: not */
  bool abba;         /* solvers of a problem forth and back in turn, not at random */
  bool cold;         /* the caches are emptied before every sample */
} campaign_sampling;

#define CAMPAIGN_AXES(X)                                                                           \
  X(problems)                                                                                      \
  X(formulations)                                                                                  \
  X(solvers) X(steps) X(durations) X(tolerances) X(starts) X(effects) X(contact_orders) X(islands)
#define CAMPAIGN_AXIS_ENUM_(name) AXIS_##name,
enum campaign_axis { CAMPAIGN_AXES(CAMPAIGN_AXIS_ENUM_) AXIS_COUNT };
const char *campaign_axis_name(int axis);

typedef struct campaign_part {
  char name[48];
  char words[120];            /* what it asks, for a reader; may be empty */
  text_list axis[AXIS_COUNT]; /* as written, braces and patterns not expanded */
} campaign_part;

typedef struct campaign {
  char name[48];
  char title[200];
  char path[512];
  bool quick, solutions, trace;
  uint64_t seed;
  campaign_limits limits;
  campaign_sampling sampling;
  int n_part;
  campaign_part *part; /* owned */
} campaign;

/* NAME of a shipped campaign or path to a .yaml file. quick: the file's quick form. */
base_status campaign_read(const char *text, bool quick, campaign *out, base_error *err);
void campaign_free(campaign *c);

/* Directory of the shipped campaigns: $LCPBENCH_CAMPAIGNS, or the one installed beside the program, or that of the sources. */
const char *campaign_directory(void);
