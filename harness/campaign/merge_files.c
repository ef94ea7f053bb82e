#include "harness/campaign/merge_files.h"

#include "harness/campaign/doctor.h"
#include "harness/campaign/runner.h"
#include "harness/util/folder.h"
#include "harness/util/json_file.h"
#include "lcp/base/input.h"
#include "lcp/base/output.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static base_status failed(const char *path, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

/* Lines of `from` behind those that are in `to`; both have the header, which stands once. */
static base_status add_lines(const char *from, FILE *to, char *header, size_t cap,
                             base_error *err) {
  FILE *in;
  const base_status opened = base_in_open(from, &in, err);
  if (opened != BASE_OK) {
    return (errno == ENOENT) ? BASE_OK : opened;
  }
  char chunk[8192];
  base_status done = BASE_OK;
  if (fgets(chunk, sizeof chunk, in) != NULL && header[0] == '\0') {
    (void)snprintf(header, cap, "%s", chunk);
    (void)fputs(chunk, to);
  } else if (strcmp(chunk, header) != 0) {
    done = BASE_FAIL(err, BASE_EINVAL, "%s: other columns than in the first folder", from);
  }
  while (done == BASE_OK && fgets(chunk, sizeof chunk, in) != NULL) {
    (void)fputs(chunk, to); /* a line that failed is known to the stream */
  }
  if (done == BASE_OK && ferror(in)) {
    done = failed(from, err);
  }
  (void)fclose(in);
  return done;
}

/* DIR/name of all folders, one after the other, as OUT/name. */
static base_status join(const char *const *dir, int n, const char *name, const char *out,
                        base_error *err) {
  char path[1100];
  char header[8192] = "";
  base_out w;
  folder_file(out, name, path, sizeof path);
  BASE_TRY(base_out_open(&w, path, err));
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < n; i++) {
    folder_file(dir[i], name, path, sizeof path);
    done = add_lines(path, w.to, header, sizeof header, err);
  }
  const base_status closed = base_out_close(&w, done == BASE_OK && header[0] != '\0', err);
  return (done != BASE_OK) ? done : closed;
}

static base_status copy_file(const char *from, const char *to, base_error *err) {
  char chunk[65536];
  base_out w;
  size_t n;
  FILE *in;
  BASE_TRY(base_in_open(from, &in, err));
  base_status done = base_out_open(&w, to, err);
  while (done == BASE_OK && (n = fread(chunk, 1, sizeof chunk, in)) > 0) {
    (void)fwrite(chunk, 1, n, w.to);
  }
  const base_status closed = base_out_close(&w, done == BASE_OK && ferror(in) == 0, err);
  if (done == BASE_OK && ferror(in)) {
    done = failed(from, err);
  }
  (void)fclose(in);
  return (done != BASE_OK) ? done : closed;
}

static base_status take_file(const char *from, const char *to, base_error *err) {
  if (link(from, to) == 0 || errno == EEXIST) {
    return BASE_OK;
  }
  return copy_file(from, to, err);
}

/* Every file of DIR/sub but its index. */
static base_status take_entries(DIR *d, const char *dir, const char *out, base_error *err) {
  const struct dirent *e;
  while ((e = readdir(d)) != NULL) {
    char from[1400];
    char to[1400];
    const size_t n = strlen(e->d_name);
    if (e->d_name[0] == '.' || strcmp(e->d_name, "index.csv") == 0 ||
        (n > 4 && strcmp(e->d_name + n - 4, ".tmp") == 0)) {
      continue;
    }
    (void)snprintf(from, sizeof from, "%s/%s", dir, e->d_name);
    (void)snprintf(to, sizeof to, "%s/%s", out, e->d_name);
    BASE_TRY(take_file(from, to, err));
  }
  return BASE_OK;
}

static base_status take_folder(const char *dir, const char *sub, const char *out, base_error *err) {
  char from[1100];
  char to[1100];
  folder_file(dir, sub, from, sizeof from);
  folder_file(out, sub, to, sizeof to);
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
  folder_file(out, "doctor.json", to, sizeof to);
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
  char traces[1100];
  BASE_TRY(join(dir, n, "canary.csv", out, err));
  for (int i = 0; i < n; i++) {
    BASE_TRY(take_folder(dir[i], "solutions", out, err));
    BASE_TRY(take_folder(dir[i], "traces", out, err));
    BASE_TRY(take_doctors(dir[i], out, err));
  }
  folder_file(out, "traces", traces, sizeof traces);
  return (access(traces, F_OK) == 0) ? join(dir, n, "traces/index.csv", out, err) : BASE_OK;
}
