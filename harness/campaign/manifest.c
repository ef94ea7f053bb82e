#include "harness/campaign/manifest.h"

#include "formulations/gsl_library.h"
#include "harness/campaign/account.h"
#include "harness/campaign/noise.h"
#include "harness/campaign/runner.h"
#include "harness/cell/machine.h"
#include "harness/choice/plugins.h"
#include "harness/util/folder.h"
#include "harness/util/json_file.h"
#include "harness/util/sha256.h"
#include "harness/util/version.h"
#include "harness/util/versions.h"
#include "lcp/base/input.h"
#include "lcp/base/nlopt_library.h"
#include "problems/import/hdf5_library.h"

#include <suitesparse/SuiteSparse_config.h>

#include <cblas.h>
#include <errno.h>
#include <gmp.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

static json_t *campaign_json(const campaign *c) {
  json_t *o = json_object();
  json_out_text(o, "name", c->name);
  json_out_text(o, "title", c->title);
  json_out_bool(o, "quick", c->quick);
  json_out_int(o, "seed", (long long)c->seed);
  json_out_real(o, "time_limit_s", c->limits.time);
  json_out_real(o, "grace_s", c->limits.grace);
  json_out_real(o, "memory_limit_B", c->limits.memory);
  json_out_int(o, "processes", c->sampling.processes);
  json_out_int(o, "samples", c->sampling.samples);
  json_out_int(o, "max_samples", c->sampling.max_samples);
  json_out_real(o, "half_width", c->sampling.half_width);
  json_out_real(o, "budget_s", c->sampling.budget);
  json_out_real(o, "inner_s", c->sampling.inner);
  json_out_real(o, "doctor_s", c->sampling.doctor);
  json_out_text(o, "order", c->sampling.abba ? "abba" : "random");
  json_out_text(o, "cache", c->sampling.cold ? "cold" : "warm");
  json_out_bool(o, "solutions", c->solutions);
  json_out_bool(o, "trace", c->trace);
  FILE *from;
  if (base_in_open(c->path, &from, NULL) == BASE_OK) {
    char *text = calloc(65536, 1);
    if (text != NULL && fread(text, 1, 65535, from) > 0) {
      json_out_text(o, "text", text);
    }
    free(text);
    (void)fclose(from);
  }
  return o;
}

static json_t *build_json(void) {
  json_t *o = json_object();
  json_out_text(o, "suite_version", harness_version());
  json_out_text(o, "commit", build_commit());
  if (build_dirty() >= 0) {
    json_out_bool(o, "dirty", build_dirty() == 1);
  }
  json_out_text(o, "build_hash", build_hash());
  json_out_text(o, "compiler", build_compiler());
  json_out_text(o, "options", build_options());
  return o;
}

static void put_proc(json_t *o, const char *name, const char *path, const char *key) {
  char value[512];
  machine_proc_value(path, key, value, sizeof value);
  json_out_text(o, name, value[0] != '\0' ? value : NULL);
}

static void put_file(json_t *o, const char *name, const char *path) {
  char line[256] = "";
  FILE *from = fopen(path, "r");
  if (from != NULL) {
    if (fgets(line, sizeof line, from) == NULL) {
      line[0] = '\0';
    }
    line[strcspn(line, "\n")] = '\0';
    (void)fclose(from);
  }
  json_out_text(o, name, line[0] != '\0' ? line : NULL);
}

static json_t *machine_json(void) {
  json_t *o = json_object();
  machine m;
  machine_read(&m);
  json_out_text(o, "host", m.host);
  json_out_text(o, "cpu", m.cpu_model);
  json_out_text(o, "host_class", m.host_class);
  json_out_int(o, "n_cpu", m.n_cpu);
  json_out_text(o, "kernel", m.kernel);
  double cost;
  double step;
  noise_clock(&cost, &step);
  json_out_real(o, "clock_cost_s", cost);
  json_out_real(o, "clock_step_s", step);
  json_out_text(o, "governor", m.governor[0] != '\0' ? m.governor : NULL);
  put_proc(o, "cpuinfo_MHz", "/proc/cpuinfo", "cpu MHz");
  put_proc(o, "microcode", "/proc/cpuinfo", "microcode");
  put_proc(o, "cpu_flags", "/proc/cpuinfo", "flags");
  put_proc(o, "memory", "/proc/meminfo", "MemTotal");
  const char *cpu = "/sys/devices/system/cpu/";
  const struct {
    const char *name, *file;
  } files[] = {{"cache_l1d", "cpu0/cache/index0/size"}, {"cache_l2", "cpu0/cache/index2/size"},
               {"cache_l3", "cpu0/cache/index3/size"},  {"smt", "smt/active"},
               {"no_turbo", "intel_pstate/no_turbo"},   {"boost", "cpufreq/boost"}};
  for (int i = 0; i < BASE_COUNT(files); i++) {
    char path[160];
    (void)snprintf(path, sizeof path, "%s%s", cpu, files[i].file);
    put_file(o, files[i].name, path);
  }
  put_file(o, "numa_nodes", "/sys/devices/system/node/online");
  put_file(o, "aslr", "/proc/sys/kernel/randomize_va_space");
  put_file(o, "hypervisor", "/sys/hypervisor/type");
  return o;
}

static json_t *libraries_json(void) {
  json_t *o = json_object();
  char text[64];
  json_out_text(o, "openblas", openblas_get_config());
  json_out_int(o, "openblas_threads", openblas_get_num_threads());
  gsl_library gsl;
  nlopt_library nlopt;
  json_out_text(o, "gsl", gsl_open(&gsl, NULL) == BASE_OK ? *gsl.gsl_version : NULL);
  json_out_text(o, "gmp", gmp_version);
  json_out_text(o, "jansson", JANSSON_VERSION);
  json_out_text(o, "yaml", yaml_get_version_string());
  int version[3];
  const bool there = nlopt_open(&nlopt, NULL) == BASE_OK;
  if (there) {
    nlopt.nlopt_version(&version[0], &version[1], &version[2]);
    (void)snprintf(text, sizeof text, "%d.%d.%d", version[0], version[1], version[2]);
  }
  json_out_text(o, "nlopt", there ? text : NULL);
  (void)snprintf(text, sizeof text, "%d.%d.%d", SUITESPARSE_MAIN_VERSION, SUITESPARSE_SUB_VERSION,
                 SUITESPARSE_SUBSUB_VERSION);
  json_out_text(o, "suitesparse", text);
  (void)snprintf(text, sizeof text, "%d.%d.%d", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE);
  json_out_text(o, "hdf5", text);
  return o;
}

static json_t *plugins_json(void) {
  json_t *o = json_object();
  const plugin_file *f;
  for (int i = 0; (f = plugins_at(i)) != NULL; i++) {
    json_t *one = json_object();
    json_out_text(one, "file", f->path);
    json_out_text(one, "sha256", f->sha256);
    (void)json_object_set_new(o, f->solver->name, one);
  }
  return o;
}

static json_t *inputs_json(const plan *p) {
  json_t *o = json_object();
  for (int i = 0; i < p->n_cell; i++) {
    json_out_text(o, p->cell[i].problem, p->cell[i].problem_sha256);
  }
  return o;
}

static json_t *environment_json(void) {
  static const char *const names[] = {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "LC_ALL", "LANG",
                                      "LCPBENCH_SHARED"};
  json_t *o = json_object();
  for (int i = 0; i < BASE_COUNT(names); i++) {
    json_out_text(o, names[i], getenv(names[i]));
  }
  return o;
}

static json_t *filters_json(const plan_filter *f) {
  json_t *a = json_array();
  for (int i = 0; i < f->filter.count; i++) {
    (void)json_array_append_new(a, json_string(f->filter.item[i]));
  }
  return a;
}

base_status manifest_write(const char *dir, const plan *p, const plan_filter *f, const cover *order,
                           const bool *done, base_error *err) {
  char path[1100];
  char sum[SHA256_HEX] = "";
  char when[24];
  json_t *o = json_object();
  machine_utc(when, sizeof when);
  json_out_int(o, "schema", RECORD_SCHEMA);
  json_out_int(o, "metric_version", RECORD_METRIC);
  json_out_text(o, "written_utc", when);
  (void)json_object_set_new(o, "campaign", campaign_json(p->campaign));
  json_out_int(o, "n_cells", p->n_cell);
  json_out_int(o, "n_processes", p->n_unit);
  json_out_int(o, "shard", f->shard);
  json_out_int(o, "n_shards", f->n_shard);
  (void)json_object_set_new(o, "filters", filters_json(f));
  json_t *cut = account_json(p, order, done);
  if (cut != NULL) {
    (void)json_object_set_new(o, "cut", cut);
  }
  (void)json_object_set_new(o, "build", build_json());
  (void)json_object_set_new(o, "machine", machine_json());
  (void)json_object_set_new(o, "libraries", libraries_json());
  (void)json_object_set_new(o, "environment", environment_json());
  (void)json_object_set_new(o, "plugins", plugins_json());
  (void)json_object_set_new(o, "inputs_sha256", inputs_json(p));
  folder_file(dir, "results.csv", path, sizeof path);
  if (sha256_file(path, sum, NULL) == BASE_OK) {
    json_out_text(o, "results_sha256", sum);
  }
  const base_status written = json_file_write(o, dir, "manifest.json", err);
  json_decref(o);
  return written;
}
