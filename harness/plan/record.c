#include "harness/plan/record_column.h"
#include "harness/util/csv.h"
#include "lcp/base/fields.h"

#include <math.h>
#include <string.h>

#define COLUMN_TEXT_(name, len) {#name, COLUMN_TEXT, offsetof(record, name), len},
#define COLUMN_INT_(name)       {#name, COLUMN_INT, offsetof(record, name), sizeof(int64_t)},
#define COLUMN_REAL_(name)      {#name, COLUMN_REAL, offsetof(record, name), sizeof(double)},
#define COLUMN_BOOL_(name)      {#name, COLUMN_BOOL, offsetof(record, name), sizeof(int8_t)},
const column record_column_table[] = {
    RECORD_COLUMNS(COLUMN_TEXT_, COLUMN_INT_, COLUMN_REAL_, COLUMN_BOOL_)};

enum { COLUMNS = BASE_COUNT(record_column_table) };

int record_columns(void) {
  return COLUMNS;
}

const char *record_column(int i) {
  return record_column_table[i].name;
}

static const column *find_real(const char *name) {
  for (int i = 0; i < COLUMNS; i++) {
    if (record_column_table[i].kind == COLUMN_REAL &&
        strcmp(record_column_table[i].name, name) == 0) {
      return &record_column_table[i];
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
  for (int i = 0; i < COLUMNS; i++) {
    unsigned char *at = (unsigned char *)r + record_column_table[i].offset;
    const int64_t no_int = INT64_MIN;
    const double no_real = (double)NAN;
    const int8_t no_bool = -1;
    switch (record_column_table[i].kind) {
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

static void put_in_line(void *to, char c) {
  put_char(to, (char)((c == '\n' || c == '\r') ? ' ' : c));
}

/* Line breaks inside a cell become spaces, so that a row is a line. */
static void put_cell(sink *s, const char *text) {
  csv_cell(text, put_in_line, s);
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
  for (int i = 0; i < COLUMNS; i++) {
    if (i > 0) {
      put_char(&s, ',');
    }
    put_text(&s, record_column_table[i].name);
  }
  put_char(&s, '\n');
  return s.used;
}

// NOLINTNEXTLINE(readability-non-const-parameter): written through the sink
size_t record_row(const record *r, char *buf, size_t cap) {
  sink s = {buf, cap, 0};
  for (int i = 0; i < COLUMNS; i++) {
    if (i > 0) {
      put_char(&s, ',');
    }
    put_value(&s, r, &record_column_table[i]);
  }
  put_char(&s, '\n');
  return s.used;
}
