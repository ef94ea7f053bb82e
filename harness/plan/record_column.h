/* harness/plan/record_column.h - the columns of a row as a table. Private to record*.c. */
#pragma once

#include "harness/plan/record.h"

#include <stddef.h>

typedef enum column_kind { COLUMN_TEXT, COLUMN_INT, COLUMN_REAL, COLUMN_BOOL } column_kind;

typedef struct column {
  const char *name;
  column_kind kind;
  size_t offset, size;
} column;

/* record_columns() of them, in the order of the header. */
extern const column record_column_table[];
