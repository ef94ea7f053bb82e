#include "harness/merge_files.h"

#include "harness/doctor.h"
#include "harness/folder.h"
#include "harness/json_file.h"
#include "harness/runner.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static base_status failed(const char *path, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

/* Appends `from` to `to`; skip_first: without its first line where `to` has one already. */
static base_status append_file(const char *from, const char *to, bool skip_first, base_error *err) {
  FILE *in = fopen(from, "r");
  if (in == NULL) {
    return failed(from, err);
  }
  FILE *out = fopen(to, "a");
  bool good = out != NULL;
  bool skip = good && skip_first && ftell(out) > 0;
  char chunk[8192];
  while (good && fgets(chunk, sizeof chunk, in) != NULL) {
    good = skip || fputs(chunk, out) != EOF;
    skip = false;
  }
  good = good && ferror(in) == 0;
  good = (out == NULL || fclose(out) == 0) && good;
  (void)fclose(in);
  return good ? BASE_OK : failed(to, err);
}

static base_status copy_file(const char *from, const char *to, base_error *err) {
  FILE *in = fopen(from, "rb");
  if (in == NULL) {
    return failed(from, err);
  }
  FILE *out = fopen(to, "wb");
  bool good = out != NULL;
  char chunk[65536];
  size_t n;
  while (good && (n = fread(chunk, 1, sizeof chunk, in)) > 0) {
    good = fwrite(chunk, 1, n, out) == n;
  }
  good = good && ferror(in) == 0;
  good = (out == NULL || fclose(out) == 0) && good;
  (void)fclose(in);
  return good ? BASE_OK : failed(to, err);
}

static base_status take_file(const char *from, const char *to, base_error *err) {
  if (link(from, to) == 0 || errno == EEXIST) {
    return BASE_OK;
  }
  return copy_file(from, to, err);
}

/* Every file of DIR/sub; index files are put one after the other. */
static base_status take_entries(DIR *d, const char *dir, const char *out, base_error *err) {
  const struct dirent *e;
  while ((e = readdir(d)) != NULL) {
    char from[1400];
    char to[1400];
    const size_t n = strlen(e->d_name);
    if (e->d_name[0] == '.' || (n > 4 && strcmp(e->d_name + n - 4, ".tmp") == 0)) {
      continue;
    }
    (void)snprintf(from, sizeof from, "%s/%s", dir, e->d_name);
    (void)snprintf(to, sizeof to, "%s/%s", out, e->d_name);
    BASE_TRY(strcmp(e->d_name, "index.csv") == 0 ? append_file(from, to, true, err)
                                                 : take_file(from, to, err));
  }
  return BASE_OK;
}

static base_status take_folder(const char *dir, const char *sub, const char *out, base_error *err) {
  char from[1100];
  char to[1100];
  runner_path(dir, sub, from, sizeof from);
  runner_path(out, sub, to, sizeof to);
  DIR *d = opendir(from);
  if (d == NULL) {
    return (errno == ENOENT) ? BASE_OK : failed(from, err);
  }
  base_status done = folder_make(to, err);
  if (done == BASE_OK) {
    done = take_entries(d, from, to, err);
  }
  (void)closedir(d);
  return done;
}

static base_status floor_in(const char *dir, const char *name, double *floor, base_error *err) {
  json_t *o;
  BASE_TRY(json_file_read(dir, name, &o, err));
  const json_t *found = json_object_get(o, "noise_floor");
  *floor = json_is_number(found) ? json_number_value(found) : -1.0;
  json_decref(o);
  return BASE_OK;
}

/* The noisiest of several machines speaks for all. */
static base_status take_doctor(const char *dir, const char *name, const char *out,
                               base_error *err) {
  char from[1400];
  char to[1100];
  double here;
  double there;
  BASE_TRY(floor_in(dir, name, &here, err));
  BASE_TRY(floor_in(out, "doctor.json", &there, err));
  (void)snprintf(from, sizeof from, "%s/%s", dir, name);
  runner_path(out, "doctor.json", to, sizeof to);
  return (here > there) ? copy_file(from, to, err) : BASE_OK;
}

static base_status take_doctors(const char *dir, const char *out, base_error *err) {
  base_status done = BASE_OK;
  DIR *d = opendir(dir);
  const struct dirent *e;
  if (d == NULL) {
    return failed(dir, err);
  }
  while (done == BASE_OK && (e = readdir(d)) != NULL) {
    done = doctor_file(e->d_name) ? take_doctor(dir, e->d_name, out, err) : BASE_OK;
  }
  (void)closedir(d);
  return done;
}

base_status merge_files(const char *const *dir, int n, const char *out, base_error *err) {
  for (int i = 0; i < n; i++) {
    char from[1100];
    char to[1100];
    runner_path(dir[i], "canary.csv", from, sizeof from);
    runner_path(out, "canary.csv", to, sizeof to);
    if (access(from, F_OK) == 0) {
      BASE_TRY(append_file(from, to, true, err));
    }
    BASE_TRY(take_folder(dir[i], "solutions", out, err));
    BASE_TRY(take_folder(dir[i], "traces", out, err));
    BASE_TRY(take_doctors(dir[i], out, err));
  }
  return BASE_OK;
}
