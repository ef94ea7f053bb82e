/* harness/sequence/sequence_file.h - a sequence as a folder: manifest.json, and each problem with its answer as files that the
 * program reads one by one (dump.h). FORMATS 7 has the members. What is read back is the same to the bit: numbers, storage,
 * blocks, traits and names. */
#pragma once

#include "harness/sequence/sequence.h"

/* Does the folder hold a manifest? */
bool sequence_is_folder(const char *dir);

/* BASE_EINVAL: no file format holds one of the problems; then nothing is called a sequence, for the manifest comes last. */
base_status sequence_write(const sequence *q, const char *dir, base_error *err);

/* Owned by the caller, whatever is returned. BASE_EINVAL: a member is missing or wrong, a file is not the one that was written
 * (SHA-256), or an answer called verified does not pass the judge. */
base_status sequence_read(const char *dir, sequence *out, base_error *err);
