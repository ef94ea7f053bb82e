#include "harness/record.h"

#include "harness/verdict.h"
#include "lcp/base/fields.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef enum column_kind { COLUMN_TEXT, COLUMN_INT, COLUMN_REAL, COLUMN_BOOL } column_kind;

typedef struct column {
  const char *name;
  column_kind kind;
  size_t offset, size;
} column;

#define COLUMN_TEXT_(name, len) {#name, COLUMN_TEXT, offsetof(record, name), len},
#define COLUMN_INT_(name)       {#name, COLUMN_INT, offsetof(record, name), sizeof(int64_t)},
#define COLUMN_REAL_(name)      {#name, COLUMN_REAL, offsetof(record, name), sizeof(double)},
#define COLUMN_BOOL_(name)      {#name, COLUMN_BOOL, offsetof(record, name), sizeof(int8_t)},
static const column columns[] = {
    RECORD_COLUMNS(COLUMN_TEXT_, COLUMN_INT_, COLUMN_REAL_, COLUMN_BOOL_)};

int record_columns(void) {
  return BASE_COUNT(columns);
}

const char *record_column(int i) {
  return columns[i].name;
}

static const column *find_real(const char *name) {
  for (int i = 0; i < BASE_COUNT(columns); i++) {
    if (columns[i].kind == COLUMN_REAL && strcmp(columns[i].name, name) == 0) {
      return &columns[i];
    }
  }
  return NULL;
}

bool record_has_real(const char *name) {
  return find_real(name) != NULL;
}

double record_real(const record *r, const char *name) {
  const column *c = find_real(name);
  double x = (double)NAN;
  if (c != NULL) {
    memcpy(&x, (const unsigned char *)r + c->offset, sizeof x);
  }
  return x;
}

void record_clear(record *r) {
  memset(r, 0, sizeof *r);
  for (int i = 0; i < BASE_COUNT(columns); i++) {
    unsigned char *at = (unsigned char *)r + columns[i].offset;
    const int64_t no_int = INT64_MIN;
    const double no_real = (double)NAN;
    const int8_t no_bool = -1;
    switch (columns[i].kind) {
    case COLUMN_TEXT:
      break;
    case COLUMN_INT:
      memcpy(at, &no_int, sizeof no_int);
      break;
    case COLUMN_REAL:
      memcpy(at, &no_real, sizeof no_real);
      break;
    case COLUMN_BOOL:
      memcpy(at, &no_bool, sizeof no_bool);
      break;
    }
  }
}

bool record_has_flag(const record *r, const char *word) {
  const size_t len = strlen(word);
  const char *at = r->flags;
  while (*at != '\0') {
    const size_t n = strcspn(at, " ");
    if (n == len && strncmp(at, word, len) == 0) {
      return true;
    }
    at += n + strspn(at + n, " ");
  }
  return false;
}

void record_flag(record *r, const char *word) {
  const size_t used = strlen(r->flags);
  if (!record_has_flag(r, word)) {
    (void)snprintf(r->flags + used, sizeof r->flags - used, "%s%s", used > 0 ? " " : "", word);
  }
}

/* ---- writing ----------------------------------------------------------------------------------*/

typedef struct sink {
  char *buf;
  size_t cap, used;
} sink;

static void put_char(sink *s, char c) {
  if (s->used + 1 < s->cap) {
    s->buf[s->used] = c;
    s->buf[s->used + 1] = '\0';
  }
  s->used++;
}

static void put_text(sink *s, const char *text) {
  for (; *text != '\0'; text++) {
    put_char(s, *text);
  }
}

/* RFC 4180; line breaks inside a cell become spaces, so that a row is a line. */
static void put_cell(sink *s, const char *text) {
  if (strpbrk(text, ",\"\n\r") == NULL) {
    put_text(s, text);
    return;
  }
  put_char(s, '"');
  for (; *text != '\0'; text++) {
    if (*text == '"') {
      put_char(s, '"');
    }
    put_char(s, (char)((*text == '\n' || *text == '\r') ? ' ' : *text));
  }
  put_char(s, '"');
}

static void put_value(sink *s, const record *r, const column *c) {
  const unsigned char *at = (const unsigned char *)r + c->offset;
  char number[32] = "";
  int64_t i;
  double x;
  int8_t b;
  switch (c->kind) {
  case COLUMN_TEXT:
    put_cell(s, (const char *)at);
    return;
  case COLUMN_INT:
    memcpy(&i, at, sizeof i);
    if (i != INT64_MIN) {
      (void)snprintf(number, sizeof number, "%lld", (long long)i);
    }
    break;
  case COLUMN_REAL:
    memcpy(&x, at, sizeof x);
    if (isfinite(x)) {
      base_real_print(x, number, sizeof number);
    }
    break;
  case COLUMN_BOOL:
    memcpy(&b, at, sizeof b);
    (void)snprintf(number, sizeof number, "%s", b < 0 ? "" : (b != 0) ? "true" : "false");
    break;
  }
  put_text(s, number);
}

// NOLINTNEXTLINE(readability-non-const-parameter): written through the sink
size_t record_header(char *buf, size_t cap) {
  sink s = {buf, cap, 0};
  for (int i = 0; i < BASE_COUNT(columns); i++) {
    if (i > 0) {
      put_char(&s, ',');
    }
    put_text(&s, columns[i].name);
  }
  put_char(&s, '\n');
  return s.used;
}

// NOLINTNEXTLINE(readability-non-const-parameter): written through the sink
size_t record_row(const record *r, char *buf, size_t cap) {
  sink s = {buf, cap, 0};
  for (int i = 0; i < BASE_COUNT(columns); i++) {
    if (i > 0) {
      put_char(&s, ',');
    }
    put_value(&s, r, &columns[i]);
  }
  put_char(&s, '\n');
  return s.used;
}

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
    const column *c = (l->column[i] >= 0) ? &columns[l->column[i]] : NULL;
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
  layout l = {.n = BASE_COUNT(columns)};
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
  for (int i = 0; i < BASE_COUNT(columns); i++) {
    if (strcmp(columns[i].name, name) == 0) {
      return i;
    }
  }
  return -1;
}

static bool holds(const layout *l, const char *name) {
  for (int i = 0; i < l->n; i++) {
    if (l->column[i] >= 0 && strcmp(columns[l->column[i]].name, name) == 0) {
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
    if (whole && strcmp(columns[i].name, "cell_id") == 0) {
      (void)snprintf(id, sizeof id, "%.*s", (int)sizeof id - 1, cell);
    } else if (whole && strcmp(columns[i].name, "process") == 0) {
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
  FILE *from = fopen(path, "r");
  if (from == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  const base_status done = read_lines(from, path, out, err);
  (void)fclose(from);
  if (done != BASE_OK) {
    record_table_free(out);
  }
  return done;
}

base_status record_table_write(const char *path, const record_table *t, base_error *err) {
  char temporary[1100];
  char line[RECORD_ROW];
  (void)snprintf(temporary, sizeof temporary, "%.1024s.tmp", path);
  FILE *to = fopen(temporary, "w");
  if (to == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", temporary, strerror(errno));
  }
  (void)record_header(line, sizeof line);
  bool good = fputs(line, to) != EOF;
  for (int i = 0; good && i < t->n; i++) {
    (void)record_row(&t->row[i], line, sizeof line);
    good = fputs(line, to) != EOF;
  }
  good = fclose(to) == 0 && good;
  if (!good || rename(temporary, path) != 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: could not be written", path);
  }
  return BASE_OK;
}

void record_table_free(record_table *t) {
  free(t->row);
  *t = (record_table){0};
}
