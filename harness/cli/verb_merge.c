/* lcpbench merge: shards of a campaign into one folder. */
#include "harness/campaign/merge_files.h"
#include "harness/campaign/runner.h"
#include "harness/cli/cli.h"
#include "harness/util/args.h"
#include "harness/util/folder.h"
#include "harness/util/json_file.h"
#include "harness/util/sha256.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MERGE_MAX = 4096 };

typedef struct merge_options {
  const char *out;
  bool mixed, duplicates;
} merge_options;

static int by_key(const void *a, const void *b) {
  const record *x = a;
  const record *y = b;
  const int order = strcmp(x->cell_id, y->cell_id);
  if (order != 0) {
    return order;
  }
  if (x->process != y->process) {
    return (x->process < y->process) ? -1 : 1;
  }
  return (x->rep > y->rep) - (x->rep < y->rep);
}

/* Rows of one measurement: two of them are a cell measured twice. */
static bool same_key(const record *a, const record *b) {
  return by_key(a, b) == 0;
}

static base_status check_rows(record_table *t, const merge_options *o, base_error *err) {
  for (int i = 1; i < t->n && !o->mixed; i++) {
    if (strcmp(t->row[i].build_hash, t->row[0].build_hash) != 0 ||
        strcmp(t->row[i].suite_commit, t->row[0].suite_commit) != 0) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "merge: rows of commit %s build %s and of commit %s build %s; allow it by "
                       "--allow-mixed",
                       t->row[0].suite_commit, t->row[0].build_hash, t->row[i].suite_commit,
                       t->row[i].build_hash);
    }
  }
  if (t->n == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "merge: the folders hold no rows");
  }
  qsort(t->row, (size_t)t->n, sizeof *t->row, by_key);
  for (int i = 1; i < t->n && !o->duplicates; i++) {
    if (same_key(&t->row[i], &t->row[i - 1])) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "merge: cell %s process %lld was measured twice; allow it by "
                       "--allow-duplicates",
                       t->row[i].cell_id, (long long)t->row[i].process);
    }
  }
  return BASE_OK;
}

static base_status take_folder(const char *dir, record_table *all, base_error *err) {
  record_table one;
  BASE_TRY(runner_read_rows(dir, &one, err));
  base_status done = BASE_OK;
  if (one.torn) {
    done = BASE_FAIL(err, BASE_EINVAL, "%s: the last row is torn; run that shard to its end", dir);
  }
  for (int i = 0; done == BASE_OK && i < one.n; i++) {
    done = record_table_append(all, &one.row[i], err);
  }
  record_table_free(&one);
  return done;
}

/* OUT takes rows once, from other folders: what a second merge left out or measured again would
 * stand beside what the first one put there. */
static base_status check_out(const char *const *dir, int n, const char *out, base_error *err) {
  char path[1100];
  struct stat of_out;
  struct stat of_dir;
  const bool exists = stat(out, &of_out) == 0;
  for (int i = 0; exists && i < n; i++) {
    if (stat(dir[i], &of_dir) == 0 && of_dir.st_dev == of_out.st_dev &&
        of_dir.st_ino == of_out.st_ino) {
      return BASE_FAIL(err, BASE_EINVAL, "merge: --out %s is one of the folders to be merged", out);
    }
  }
  folder_file(out, "results.csv", path, sizeof path);
  return (access(path, F_OK) != 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL,
                         "merge: %s holds rows already; merge into a folder without, or remove it",
                         path);
}

/* The first shard's manifest, as that of the whole, with the list of all. */
static base_status write_manifest(json_t *o, const char *const *dir, int n, const char *out,
                                  base_error *err) {
  char path[1100];
  char sum[SHA256_HEX];
  json_t *shards = json_array();
  for (int i = 0; i < n; i++) {
    (void)json_array_append_new(shards, json_string(dir[i]));
  }
  json_out_int(o, "shard", 0);
  json_out_int(o, "n_shards", 0);
  (void)json_object_set_new(o, "merged_from", shards);
  folder_file(out, "results.csv", path, sizeof path);
  BASE_TRY(sha256_file(path, sum, err));
  json_out_text(o, "results_sha256", sum);
  return json_file_write(o, out, "manifest.json", err);
}

/* The rows come last: a merge that fails before can be begun again. */
static base_status write_all(const char *const *dir, int n, const char *out, json_t *manifest,
                             const record_table *all, base_error *err) {
  BASE_TRY(folder_make(out, err));
  BASE_TRY(merge_files(dir, n, out, err));
  BASE_TRY(runner_write_rows(out, all, err));
  const base_status done = write_manifest(manifest, dir, n, out, err);
  if (done != BASE_OK) {
    char path[1100];
    folder_file(out, "results.csv", path, sizeof path);
    (void)unlink(path);
  }
  return done;
}

static base_status merge(const char *const *dir, int n, const merge_options *o, record_table *all,
                         base_error *err) {
  json_t *manifest;
  BASE_TRY(check_out(dir, n, o->out, err));
  for (int i = 0; i < n; i++) {
    BASE_TRY(take_folder(dir[i], all, err));
  }
  BASE_TRY(check_rows(all, o, err));
  BASE_TRY(json_file_read(dir[0], "manifest.json", &manifest, err));
  if (manifest == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%s/manifest.json: no such file", dir[0]);
  }
  const base_status done = write_all(dir, n, o->out, manifest, all, err);
  json_decref(manifest);
  return done;
}

static const arg_option options[] = {
    ARG(merge_options, out, "--out", ARG_TEXT, "DIR", "folder to be written", .needed = true),
    ARG(merge_options, mixed, "--allow-mixed", ARG_FLAG, NULL, "joins rows of different builds"),
    ARG(merge_options, duplicates, "--allow-duplicates", ARG_FLAG, NULL,
        "keeps cells that were measured twice"),
};
static const arg_table args = {options,  BASE_COUNT(options), 1, MERGE_MAX,
                               "DIR...", "folders of shards"};

static int run(int argc, char **argv) {
  merge_options o = {0};
  const char *dir[MERGE_MAX];
  int n;
  base_error err = {0};
  record_table all = {0};
  base_status done = args_parse(&args, &o, argc, argv, dir, &n, &err);
  if (done == BASE_OK) {
    done = merge(dir, n, &o, &all, &err);
  }
  if (done == BASE_OK) {
    (void)printf("%s/results.csv: %d rows from %d folders\n", o.out, all.n, n);
  }
  record_table_free(&all);
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_merge;
const cli_verb verb_merge = {
    .name = "merge",
    .args = &args,
    .help = "joins shards; refuses mixed builds and cells measured twice unless told",
    .run = run,
};
