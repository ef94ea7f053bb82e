/* harness/doctor.h - doctor.json: can this machine be trusted with timings, and to how many per cent?
 * Stored with a campaign, read when its rows are compared. */
#pragma once

#include "harness/json_out.h"
#include "harness/noise.h"

json_t *doctor_json(const noise_report *n);                                 /* new reference */
base_status doctor_store(json_t *o, const char *dir, base_error *err);      /* DIR/doctor.json */
base_status doctor_visit(const char *dir, double seconds, base_error *err); /* unless it is there */

/* Noise floors by size; all negative at first (DOCTOR_UNKNOWN). */
typedef struct doctor_floor {
  int n;
  double up_to[NOISE_CLASSES]; /* [B] */
  double floor[NOISE_CLASSES]; /* |log ratio| [1] */
} doctor_floor;
#define DOCTOR_UNKNOWN ((doctor_floor){0, {0, 0, 0}, {-1, -1, -1}})

/* Raises the floors to those of DIR/doctor.json, if it is there. */
void doctor_read(const char *dir, doctor_floor *f);

/* Floor for cells whose workspace is `bytes` (NaN: unknown, the largest); negative: not known. */
double doctor_floor_of(const doctor_floor *f, double bytes);
