/* Untimed twins, whose convergence histories go to traces/. traces/index.csv has a line for each: one
 * that died is not run again for every process of its cell, nor by the next session. */
#include "harness/campaign/runner_state.h"
#include "harness/cell/isolate.h"
#include "harness/measure/verdict.h"
#include "harness/util/folder.h"
#include "harness/util/versions.h"
#include "lcp/base/input.h"
#include "lcp/base/output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char header[] = "cell_id,solver,status,flags,solution_hash,base_hash\n";
static const char index_name[] = "traces/index.csv";

/* ---- the index --------------------------------------------------------------------------------*/

/* The words of a line, cut in place at its commas. */
enum { WORD_ID, WORD_SOLVER, WORD_STATUS, WORD_FLAGS, WORD_HASH, WORD_BASE, WORDS };

static bool split(char *line, char *word[WORDS]) {
  int n = 0;
  line[strcspn(line, "\n")] = '\0';
  for (char *at = line; at != NULL && n < WORDS; n++) {
    word[n] = at;
    at = strchr(at, ',');
    if (at != NULL) {
      *at++ = '\0';
    }
  }
  return n == WORDS;
}

static int index_of(const plan *p, const char *id) {
  for (int i = 0; i < p->n_cell; i++) {
    if (strcmp(p->cell[i].id, id) == 0) {
      return i;
    }
  }
  return -1;
}

static bool is_forgotten(const runner *r, const char *id) {
  for (int i = 0; i < r->forgotten.n; i++) {
    if (strcmp(r->forgotten.item[i], id) == 0) {
      return true;
    }
  }
  return false;
}

/* Ended with a verdict, and so with a history? */
static bool left_history(const char *status) {
  run_status s;
  return run_status_find(status, &s) && s != RUN_TIMEOUT && s != RUN_OOM && s != RUN_CRASH &&
         s != RUN_NO_OUTPUT && s != RUN_FLOOD && s != RUN_ERROR;
}

/* A line of an earlier session is kept where it is a twin of rows that are kept. */
static void take_line(runner *r, const char *line, FILE *kept) {
  char text[512];
  char path[1100];
  char *word[WORDS];
  (void)snprintf(text, sizeof text, "%s", line);
  if (!split(text, word) || is_forgotten(r, word[WORD_ID])) {
    return;
  }
  if (strcmp(word[WORD_BASE], build_base()) != 0) {
    runner_trace_path(r, word[WORD_ID], path, sizeof path);
    (void)unlink(path);
    return;
  }
  (void)fputs(line, kept); /* a line that failed is known to the stream */
  const int i = index_of(r->plan, word[WORD_ID]);
  if (i >= 0) {
    r->twin[i].dead = !left_history(word[WORD_STATUS]);
    (void)snprintf(r->twin[i].hash, sizeof r->twin[i].hash, "%.23s", word[WORD_HASH]);
  }
}

base_status runner_twins_open(runner *r, base_error *err) {
  char path[1100];
  char line[512];
  base_out w;
  folder_file(r->o->out, index_name, path, sizeof path);
  FILE *from;
  const base_status opened = base_in_open(path, &from, err);
  if (opened != BASE_OK) {
    return (errno == ENOENT) ? BASE_OK : opened;
  }
  base_status done = base_out_open(&w, path, err);
  if (done == BASE_OK) {
    (void)fputs(header, w.to);
    while (fgets(line, sizeof line, from) != NULL) {
      if (strncmp(line, header, strcspn(header, ",")) != 0 && strchr(line, '\n') != NULL) {
        take_line(r, line, w.to);
      }
    }
    done = base_out_close(&w, true, err);
  }
  (void)fclose(from);
  return done;
}

/* What the twin ended with, beside the rows it is the twin of. */
static base_status index_twin(const runner *r, const record *row, base_error *err) {
  char path[1100];
  folder_file(r->o->out, index_name, path, sizeof path);
  FILE *to = fopen(path, "a");
  bool good = to != NULL && (ftell(to) > 0 || fputs(header, to) != EOF);
  good = good && fprintf(to, "%s,%s,%s,%s,%s,%s\n", row->cell_id, row->solver, row->status,
                         row->flags, row->solution_hash, build_base()) > 0;
  good = to != NULL && fclose(to) == 0 && good;
  return good ? BASE_OK : BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

/* ---- one twin ---------------------------------------------------------------------------------*/

base_status runner_twin(runner *r, int index, base_error *err) {
  char path[1100];
  isolate_end end;
  bool whole;
  const cell *c = &r->plan->cell[index];
  twin *t = &r->twin[index];
  runner_trace_path(r, c->id, path, sizeof path);
  if (t->dead || access(path, F_OK) == 0) {
    return BASE_OK;
  }
  r->job = (cell_job){
      .campaign = r->plan->campaign, .cell = c, .mem_node = -1, .canary = r->canary, .trace = path};
  BASE_TRY(runner_measure(r, 0, &end, &whole, err));
  if (!whole) {
    return BASE_OK;
  }
  const record *row = &r->unit_rows.row[0];
  t->dead = !left_history(row->status);
  (void)snprintf(t->hash, sizeof t->hash, "%s", row->solution_hash);
  return index_twin(r, row, err);
}

void runner_twin_check(runner *r, int index) {
  const twin *t = &r->twin[index];
  for (int i = 0; t->hash[0] != '\0' && i < r->unit_rows.n; i++) {
    if (strcmp(r->unit_rows.row[i].solution_hash, t->hash) != 0) {
      record_flag(&r->unit_rows.row[i], "twin_differs");
    }
  }
}
