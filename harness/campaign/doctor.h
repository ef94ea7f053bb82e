/* harness/campaign/doctor.h - doctor.json: can this machine be trusted with timings, and to how many per cent?
 * Stored with a campaign, read when its rows are compared. */
#pragma once

#include "harness/campaign/noise.h"
#include "harness/util/json_out.h"

json_t *doctor_json(const noise_report *n);                                  /* new reference */
base_status doctor_store(const json_t *o, const char *dir, base_error *err); /* DIR/doctor.json */

/* Is there no DIR/doctor.json of this class of machine? BASE_EINVAL: what is there is not JSON. */
base_status doctor_due(const char *dir, bool *due, base_error *err);

/* Measures and stores it where it is due; that of another class of machine is kept beside it. */
base_status doctor_visit(const char *dir, double seconds, base_error *err);

/* doctor.json, or doctor.HOST.json as doctor_visit keeps it. */
bool doctor_file(const char *name);

/* Noise floors by size; all negative at first (DOCTOR_UNKNOWN). */
typedef struct doctor_floor {
  int n;
  double up_to[NOISE_CLASSES]; /* [B] */
  double floor[NOISE_CLASSES]; /* |log ratio| [1] */
} doctor_floor;
#define DOCTOR_UNKNOWN ((doctor_floor){0, {0, 0, 0}, {-1, -1, -1}})

/* Raises the floors to those of DIR/doctor.json, if it is there, and of other machines that measured
 * there. BASE_EIO, BASE_EINVAL: no such folder, not JSON. */
base_status doctor_read(const char *dir, doctor_floor *f, base_error *err);

/* Floor for cells whose workspace is `bytes` (NaN: unknown, the largest); negative: not known. */
double doctor_floor_of(const doctor_floor *f, double bytes);
