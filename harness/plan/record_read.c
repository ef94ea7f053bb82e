/* Rows read back from a file, and tables of them. */
#include "harness/measure/verdict.h"
#include "harness/plan/record_column.h"
#include "harness/util/unpack.h"
#include "lcp/base/fields.h"
#include "lcp/base/output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading ----------------------------------------------------------------------------------*/

/* Copies the cell at *at into buf, moves behind its comma, and says whether there was one (false:
 * the row ends here). False in *good: malformed or too long. */
static bool take_cell(const char **at, char *buf, size_t cap, bool *good) {
  const char *c = *at;
  size_t used = 0;
  const bool quoted = *c == '"';
  c += quoted ? 1 : 0;
  while (*c != '\0' && used + 1 < cap) {
    if (quoted && *c == '"' && c[1] != '"') {
      c++;
      break;
    }
    if (!quoted && *c == ',') {
      break;
    }
    c += (quoted && *c == '"') ? 1 : 0; /* a doubled quote stands for one */
    buf[used++] = *c++;
  }
  buf[used] = '\0';
  const bool comma = *c == ',';
  *good = comma || *c == '\0';
  *at = c + (comma ? 1 : 0);
  return comma;
}

static bool set_value(record *r, const column *c, const char *text) {
  unsigned char *at = (unsigned char *)r + c->offset;
  if (c->kind == COLUMN_TEXT) {
    const size_t len = strlen(text);
    if (len >= c->size) {
      return false;
    }
    memcpy(at, text, len + 1);
    return true;
  }
  if (text[0] == '\0') {
    return true; /* not measured: already so */
  }
  if (c->kind == COLUMN_BOOL) {
    const int8_t b = (int8_t)(strcmp(text, "true") == 0);
    memcpy(at, &b, sizeof b);
    return b || strcmp(text, "false") == 0;
  }
  if (c->kind == COLUMN_REAL) {
    double x;
    const bool good = base_parse_real(text, &x);
    memcpy(at, &x, sizeof x);
    return good;
  }
  char *end;
  errno = 0;
  const int64_t i = strtoll(text, &end, 10);
  memcpy(at, &i, sizeof i);
  return *end == '\0' && errno == 0;
}

/* Which column stands at each position of a file; -1: one that this version does not know. */
enum { LAYOUT_MAX = 256 };
typedef struct layout {
  int n, column[LAYOUT_MAX];
} layout;

static base_status parse_row(const layout *l, const char *row, record *r, base_error *err) {
  char cell[2048];
  record_clear(r);
  for (int i = 0; i < l->n; i++) {
    bool good;
    const bool more = take_cell(&row, cell, sizeof cell, &good);
    const column *c = (l->column[i] >= 0) ? &record_column_table[l->column[i]] : NULL;
    if (!good || more != (i + 1 < l->n)) {
      return BASE_FAIL(err, BASE_EINVAL, "column %s: the row ends early or late",
                       c != NULL ? c->name : "of another version");
    }
    if (c != NULL && !set_value(r, c, cell)) {
      return BASE_FAIL(err, BASE_EINVAL, "column %s: '%.40s' does not belong here", c->name, cell);
    }
  }
  run_status known;
  if (!run_status_find(r->status, &known)) {
    return BASE_FAIL(err, BASE_EINVAL, "column status: '%.40s' is none of its words", r->status);
  }
  return BASE_OK;
}

static layout own_layout(void) {
  layout l = {.n = record_columns()};
  for (int i = 0; i < l.n; i++) {
    l.column[i] = i;
  }
  return l;
}

base_status record_parse(const char *row, record *r, base_error *err) {
  const layout l = own_layout();
  return parse_row(&l, row, r, err);
}

static int find_column(const char *name) {
  for (int i = 0; i < record_columns(); i++) {
    if (strcmp(record_column_table[i].name, name) == 0) {
      return i;
    }
  }
  return -1;
}

static bool holds(const layout *l, const char *name) {
  for (int i = 0; i < l->n; i++) {
    if (l->column[i] >= 0 && strcmp(record_column_table[l->column[i]].name, name) == 0) {
      return true;
    }
  }
  return false;
}

/* Without these a row says nothing. */
static bool is_complete(const layout *l) {
  static const char *const needed[] = {"schema",  "part",        "cell_id", "process", "rep",
                                       "problem", "formulation", "solver",  "status"};
  bool all = true;
  for (int i = 0; i < BASE_COUNT(needed); i++) {
    all = all && holds(l, needed[i]);
  }
  return all;
}

/* Reads a header line (with its newline). False: not a header of this suite. */
static bool read_layout(char *header, layout *l) {
  char name[64];
  bool good = true;
  bool more = true;
  const char *at = header;
  l->n = 0;
  header[strcspn(header, "\n")] = '\0';
  while (good && more && l->n < LAYOUT_MAX) {
    more = take_cell(&at, name, sizeof name, &good);
    l->column[l->n++] = find_column(name);
  }
  return good && !more && is_complete(l);
}

/* ---- tables -----------------------------------------------------------------------------------*/

base_status record_table_append(record_table *t, const record *r, base_error *err) {
  if (t->n == t->cap) {
    const int cap = (t->cap > 0) ? 2 * t->cap : 64;
    record *grown = realloc(t->row, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d rows", cap);
    }
    t->row = grown;
    t->cap = cap;
  }
  t->row[t->n++] = *r;
  return BASE_OK;
}

/* Rows of a process are written in one piece: those before a torn row that belong to the same
 * process go with it. A row torn before its process number takes the last process along. */
static void drop_torn(record_table *t, const char *torn) {
  char cell[2048];
  char id[sizeof t->row->cell_id] = "";
  int64_t process = -1;
  bool whole = true;
  for (int i = 0; whole && i < 5; i++) {
    bool good;
    whole = take_cell(&torn, cell, sizeof cell, &good) && good;
    if (whole && strcmp(record_column_table[i].name, "cell_id") == 0) {
      (void)snprintf(id, sizeof id, "%.*s", (int)sizeof id - 1, cell);
    } else if (whole && strcmp(record_column_table[i].name, "process") == 0) {
      process = strtoll(cell, NULL, 10);
    }
  }
  if (t->n > 0 && process < 0) {
    memcpy(id, t->row[t->n - 1].cell_id, sizeof id);
    process = t->row[t->n - 1].process;
  }
  while (t->n > 0 && t->row[t->n - 1].process == process &&
         strcmp(t->row[t->n - 1].cell_id, id) == 0) {
    t->n--;
  }
}

static base_status read_header(FILE *from, const char *path, layout *l, record_table *out,
                               base_error *err) {
  char line[RECORD_ROW];
  char own[RECORD_ROW];
  if (fgets(line, sizeof line, from) == NULL) {
    return BASE_OK;
  }
  (void)record_header(own, sizeof own);
  out->foreign = strcmp(line, own) != 0;
  if (strchr(line, '\n') == NULL) {
    out->torn = true; /* killed while writing the header */
    return BASE_OK;
  }
  return read_layout(line, l)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "%s:1: not a header of rows (columns missing)", path);
}

static base_status read_line(const layout *l, const char *line, const char *path, int number,
                             record_table *out, base_error *err) {
  record r;
  base_error why = {0};
  if (parse_row(l, line, &r, &why) != BASE_OK) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%d: %.300s", path, number, why.text);
  }
  if (r.schema != RECORD_SCHEMA) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%d: schema %lld; this version reads %d", path, number,
                     (long long)r.schema, RECORD_SCHEMA);
  }
  return record_table_append(out, &r, err);
}

static base_status read_lines(FILE *from, const char *path, record_table *out, base_error *err) {
  char line[RECORD_ROW];
  layout l = own_layout();
  BASE_TRY(read_header(from, path, &l, out, err));
  for (int number = 2; fgets(line, sizeof line, from) != NULL; number++) {
    const size_t len = strlen(line);
    if (len == 0 || line[len - 1] != '\n') {
      out->torn = true; /* only the last line can lack its end: rows are shorter than the buffer */
      drop_torn(out, line);
      return BASE_OK;
    }
    line[len - 1] = '\0';
    BASE_TRY(read_line(&l, line, path, number, out, err));
  }
  return ferror(from) ? BASE_FAIL(err, BASE_EIO, "%s: could not be read", path) : BASE_OK;
}

base_status record_table_read(const char *path, record_table *out, base_error *err) {
  *out = (record_table){0};
  FILE *from;
  BASE_TRY(unpack_text(path, &from, err));
  const base_status done = read_lines(from, path, out, err);
  (void)fclose(from);
  if (done != BASE_OK) {
    record_table_free(out);
  }
  return done;
}

base_status record_table_write(const char *path, const record_table *t, base_error *err) {
  base_out w;
  char line[RECORD_ROW];
  BASE_TRY(base_out_open(&w, path, err));
  (void)record_header(line, sizeof line);
  bool good = fputs(line, w.to) != EOF;
  for (int i = 0; good && i < t->n; i++) {
    (void)record_row(&t->row[i], line, sizeof line);
    good = fputs(line, w.to) != EOF;
  }
  return base_out_close(&w, true, err); /* a line that failed is known to the stream */
}

void record_table_free(record_table *t) {
  free(t->row);
  *t = (record_table){0};
}

/* ---- by cell ----------------------------------------------------------------------------------*/

static int by_cell(const void *a, const void *b) {
  const record *x = ((const row_ref *)a)->r;
  const record *y = ((const row_ref *)b)->r;
  const int order = strcmp(x->cell_id, y->cell_id);
  return (order != 0) ? order : (x > y) - (x < y);
}

base_status record_table_by_cell(const record_table *t, row_ref **out, base_error *err) {
  *out = calloc((size_t)t->n + 1, sizeof **out);
  if (*out == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to sort %d rows", t->n);
  }
  for (int i = 0; i < t->n; i++) {
    (*out)[i].r = &t->row[i];
  }
  qsort(*out, (size_t)t->n, sizeof **out, by_cell);
  return BASE_OK;
}

int record_same_cell(const row_ref *row, int n) {
  int same = 1;
  while (same < n && strcmp(row[same].r->cell_id, row[0].r->cell_id) == 0) {
    same++;
  }
  return same;
}
