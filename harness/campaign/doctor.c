#include "harness/campaign/doctor.h"

#include "harness/campaign/runner.h"
#include "harness/cell/machine.h"
#include "harness/util/folder.h"
#include "harness/util/json_file.h"
#include "harness/util/versions.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <string.h>

static json_t *advice(const machine *m, const noise_report *n, double load) {
  json_t *a = json_array();
  if (m->governor[0] != '\0' && strcmp(m->governor, "performance") != 0) {
    (void)json_array_append_new(a, json_string("the governor is not 'performance'"));
  }
  if (load > 0.5) {
    (void)json_array_append_new(a, json_string("other work is running (load above 0.5)"));
  }
  if (n->floor > 0.05) {
    (void)json_array_append_new(a, json_string("differences below 5 % cannot be seen here"));
  }
  if (strcmp(build_options(), "") != 0 && strstr(build_options(), "buildtype=release") == NULL) {
    (void)json_array_append_new(a, json_string("this is not a release build"));
  }
  return a;
}

json_t *doctor_json(const noise_report *n) {
  machine m;
  char when[24];
  machine_read(&m);
  machine_utc(when, sizeof when);
  const double load = machine_load();
  json_t *o = json_object();
  json_out_text(o, "written_utc", when);
  json_out_text(o, "host", m.host);
  json_out_text(o, "cpu", m.cpu_model);
  json_out_text(o, "host_class", m.host_class);
  json_out_int(o, "n_cpu", m.n_cpu);
  json_out_text(o, "governor", m.governor[0] != '\0' ? m.governor : NULL);
  json_out_real(o, "freq_MHz", machine_frequency(machine_last_cpu()));
  json_out_int(o, "pinned_to", machine_last_cpu());
  json_out_real(o, "load1", load);
  json_out_real(o, "canary_s", machine_canary());
  json_out_real(o, "clock_cost_s", n->clock_cost);
  json_out_real(o, "clock_step_s", n->clock_step);
  json_out_real(o, "bandwidth_B_s", n->bandwidth);
  json_t *classes = json_array();
  for (int i = 0; i < NOISE_CLASSES; i++) {
    json_t *c = json_object();
    json_out_text(c, "size", n->size[i].name);
    json_out_real(c, "up_to_B", n->size[i].up_to);
    json_out_real(c, "sample_s", n->size[i].seconds);
    json_out_real(c, "noise_floor", n->size[i].floor);
    json_out_real(c, "spread", n->size[i].spread);
    (void)json_array_append_new(classes, c);
  }
  (void)json_object_set_new(o, "classes", classes);
  json_out_real(o, "noise_floor", n->floor);
  (void)json_object_set_new(o, "advice", advice(&m, n, load));
  return o;
}

base_status doctor_store(const json_t *o, const char *dir, base_error *err) {
  BASE_TRY(folder_make(dir, err));
  return json_file_write(o, dir, "doctor.json", err);
}

/* Of the machine that would measure now? */
static bool is_ours(const json_t *o) {
  machine m;
  machine_read(&m);
  const char *class = json_string_value(json_object_get(o, "host_class"));
  return class != NULL && strcmp(class, m.host_class) == 0;
}

base_status doctor_due(const char *dir, bool *due, base_error *err) {
  json_t *o;
  BASE_TRY(json_file_read(dir, "doctor.json", &o, err));
  *due = !is_ours(o);
  json_decref(o);
  return BASE_OK;
}

/* What another class of machine left stays, as doctor.HOST.json: its rows are here too. */
static base_status keep_other(const char *dir, base_error *err) {
  json_t *o;
  char name[128];
  BASE_TRY(json_file_read(dir, "doctor.json", &o, err));
  if (o == NULL) {
    return BASE_OK;
  }
  const char *host = json_string_value(json_object_get(o, "host"));
  (void)snprintf(name, sizeof name, "doctor.%.60s.json", host != NULL ? host : "unknown");
  for (char *c = name; *c != '\0'; c++) {
    *c = (char)(*c == '/' ? '_' : *c);
  }
  const base_status done = json_file_write(o, dir, name, err);
  json_decref(o);
  return done;
}

base_status doctor_visit(const char *dir, double seconds, base_error *err) {
  bool due;
  BASE_TRY(doctor_due(dir, &due, err));
  if (!due) {
    return BASE_OK;
  }
  BASE_TRY(keep_other(dir, err));
  noise_report report;
  cpu_set_t before;
  const bool pinned = machine_pin_for_now(machine_last_cpu(), &before);
  noise_measure(seconds, 1, &report);
  if (pinned) {
    machine_pin_back(&before);
  }
  json_t *o = doctor_json(&report);
  const base_status done = doctor_store(o, dir, err);
  json_decref(o);
  return done;
}

/* ---- reading ----------------------------------------------------------------------------------*/

bool doctor_file(const char *name) {
  const size_t n = strlen(name);
  return strncmp(name, "doctor.", 7) == 0 && n >= 11 && strcmp(name + n - 5, ".json") == 0;
}

static void raise_floors(const json_t *o, doctor_floor *f) {
  const json_t *classes = json_object_get(o, "classes");
  for (size_t i = 0; i < json_array_size(classes) && i < NOISE_CLASSES; i++) {
    const json_t *c = json_array_get(classes, i);
    const json_t *up_to = json_object_get(c, "up_to_B");
    const json_t *floor = json_object_get(c, "noise_floor");
    f->up_to[i] = json_is_number(up_to) ? json_number_value(up_to) : HUGE_VAL;
    f->floor[i] = fmax(f->floor[i], json_is_number(floor) ? json_number_value(floor) : -1.0);
    f->n = (int)i + 1;
  }
}

base_status doctor_read(const char *dir, doctor_floor *f, base_error *err) {
  base_status done = BASE_OK;
  DIR *d = opendir(dir);
  const struct dirent *e;
  if (d == NULL && errno == ENOTDIR) {
    return BASE_OK; /* a file of rows has none */
  }
  if (d == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", dir, strerror(errno));
  }
  while (done == BASE_OK && (e = readdir(d)) != NULL) {
    json_t *o = NULL;
    if (doctor_file(e->d_name)) {
      done = json_file_read(dir, e->d_name, &o, err);
      raise_floors(o, f);
      json_decref(o);
    }
  }
  (void)closedir(d);
  return done;
}

double doctor_floor_of(const doctor_floor *f, double bytes) {
  double floor = -1.0;
  for (int i = f->n; i-- > 0;) {
    if (!(bytes > f->up_to[i])) { /* unknown sizes: the largest floor of all */
      floor = (bytes == bytes) ? f->floor[i] : fmax(floor, f->floor[i]);
    }
  }
  return floor;
}
